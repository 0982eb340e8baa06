"""`ros2 run evodevo_sim simulate`: a body of your own, from its file into a recording and an NPZ file."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..parameters import ParameterError
from ..ros.command_line import Parser, real_number, say_if_compiling, see_it
from ..ros.environment import need_no_graph, without_ros
from ..whole_file import written_whole

if TYPE_CHECKING:
    from ..own_body.body_file import OwnBody
    from ..own_body.motion import Motion

_EPILOG = """\
examples:
  ros2 run evodevo_sim simulate examples/body.yaml --scene swim --duration 10 --out bags/mine
      in steps that follow from the body; the NPZ file, if any, has a frame every 1/60 s
  ros2 run evodevo_sim simulate body.yaml --scene free --duration 10 --dt 0.001 --integrator verlet --out bags/mine --npz mine.npz
      in steps of exactly 1 ms, each of which is a frame of the NPZ file
  ros2 run evodevo_sim simulate body.yaml --scene swim --duration 10 --tolerance 1e-10 --out bags/mine

scenes:
  swim   fluid drag; no gravity
  walk   gravity and ground with Coulomb friction, flat at y = 0 unless --world says otherwise; no drag. Gravity is the Earth's,
         9.81 m/s^2; that of evolve --task walk is 5: write scene: {gravity: 5} into the body file to live as its walkers do
  free   no ground, and of the other terms those alone that the file's scene names

The NPZ file holds time (T,), position (T, N, 2) and velocity (T, N, 2), float64. The recording holds about 60 frames a second.
Exit code: 0; 1 where the physics failed, and what came before is kept; 2 for bad input. docs/guide/body.md tells the file's keys.
"""


def main(arguments: list[str] | None = None) -> int:
    parser = Parser("simulate", "Simulate a soft body of your own.", _EPILOG)
    parser.add_argument("body", metavar="BODY", help="a body file, YAML or JSON")
    parser.add_argument("--scene", default="swim", metavar="NAME", help="swim, walk, free (default %(default)s)")
    worlds = "walk: flat, slope, steps, rough, obstacles, gap, or a file (docs/guide/walk.md; default flat)"
    parser.add_argument("--world", metavar="NAME|FILE", help=worlds)
    parser.add_argument("--duration", required=True, type=real_number, metavar="S", help="simulated seconds")
    parser.add_argument("--dt", type=real_number, metavar="S", help="seconds of a step, exactly")
    parser.add_argument("--tolerance", type=real_number, metavar="M", help="most error of an adaptive step, in m and m/s")
    parser.add_argument("--integrator", metavar="NAME", help="euler, verlet, rk4, adaptive (default euler in walk, or else rk4)")
    parser.add_argument("--out", required=True, metavar="BAG", help="directory of the recording, made anew")
    parser.add_argument("--npz", metavar="FILE", help="a file for every frame, made anew")
    given = parser.parse_args(without_ros(sys.argv[1:] if arguments is None else arguments))
    need_no_graph()
    from ..own_body.body_file import BodyError, load_body
    from ..own_body.motion import simulate_body
    from ..recording import RecordingError
    from ..recording.guarded import GuardedRecorder

    try:
        _refuse_existing(given)
        own = load_body(given.body)
        say_if_compiling("replayed_motion.follow")
        motion = simulate_body(
            own, given.scene, given.duration, dt=given.dt, tolerance=given.tolerance, integrator=given.integrator,
            world=given.world,
        )
        with GuardedRecorder(given.out) as recorder:
            record_motion(recorder, own, motion, time.time_ns())
        if given.npz:
            save_motion(given.npz, motion)
    except (BodyError, ParameterError, RecordingError) as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
    law = motion.system.law
    print(
        f"{motion.time[-1]:g} s of {given.scene} by {motion.integrator} with drag_normal {law.drag_normal:g}, drag_tangential "
        f"{law.drag_tangential:g}, gravity {motion.system.gravity:g}, friction {motion.system.friction:g}.\n"
        f"{see_it(given.out)}"
    )
    if motion.cause:
        print(f"simulate: {motion.cause}; what came before is kept", file=sys.stderr)
        return 1
    return 0


def _refuse_existing(given):
    from ..recording import RecordingError

    for name in filter(None, (given.out, given.npz)):
        if os.path.lexists(name):
            raise RecordingError(f"{name} exists already and is never overwritten: choose another name")
    if given.npz and not os.path.isdir(Path(given.npz).absolute().parent):
        raise RecordingError(f"{given.npz}: its directory does not exist: make it, or choose another name")


def record_motion(recorder: Any, own: OwnBody, motion: Motion, stamp: int) -> None:
    """Write a motion to a `Recorder` from `stamp` ns on, in about 60 frames a second."""
    from ..own_body.motion import FRAME
    from ..ros.messages import body_message, cell_states_message, scene_message
    from ..ros.topics import BODY, CELL_STATES, SCENE

    recorder.write(BODY.name, body_message(own.body), stamp)
    if motion.world is not None:
        recorder.write(SCENE.name, scene_message(motion.world), stamp)
    every = max(1, round(FRAME / (motion.time[1] - motion.time[0]))) if len(motion.time) > 1 else 1
    frames = range(0, len(motion.time), every)
    for k in (*frames, *({len(motion.time) - 1} - {frames[-1]})):
        seconds = float(motion.time[k])
        message = cell_states_message(motion.position[k], motion.velocity[k], motion.activation[k], k, seconds)
        recorder.write(CELL_STATES.name, message, stamp + round(seconds * 1e9))


def save_motion(path: str | os.PathLike, motion: Motion) -> None:
    """Write an NPZ file of time (T,) s, position (T, N, 2) m, velocity (T, N, 2) m/s, float64; whole or not at all."""
    import numpy as np

    from ..recording import RecordingError

    try:
        with written_whole(path, ".npz") as name:
            np.savez(name, time=motion.time, position=motion.position, velocity=motion.velocity)
    except OSError as error:
        raise RecordingError(f"{path} cannot be written ({error.strerror}): choose another name") from None


if __name__ == "__main__":
    from .entry import simulate as entry

    sys.exit(entry())
