"""`ros2 run evodevo_sim emulate GENOME`: plays the firmware, the muscles and the camera of a body, on a pseudo-terminal."""

from __future__ import annotations

import dataclasses
import sys
import threading
from pathlib import Path

from ..command_process import heeded
from ..parameters import ParameterError, Rig, default_task, with_settings
from ..ros.command_line import Parser, pairs
from ..ros.environment import need_no_graph, without_ros

_EPILOG = """\
examples:
  ros2 run evodevo_sim emulate bags/sample-swim --link /tmp/eel --calibration eel.yaml
      the body of a run's champion, at /tmp/eel; eel.yaml is written where it is not there
  ros2 run evodevo_sim emulate champion.yaml --link /tmp/eel --calibration eel.yaml --rig plant.yaml
      with the lag, the noise and the faults of plant.yaml (docs/guide/hardware.md); without --rig, with those that a run was bred with

A line of input lets something happen at once: unplug 0.5, restart, silence 0.3, garbage 1, pressure, stop, or fail and the numbers of
cells.

Exit code: 0 when a signal ended it, 1 where its physics could not be carried on, 2 for bad input.
"""


def main(arguments: list[str]) -> int:
    parser = Parser("emulate", "Emulate a body of rubber and air on a pseudo-terminal.", _EPILOG)
    parser.add_argument("genome", metavar="GENOME|BAG", help="a genome file, or the recording of a run: the body that it grows")
    parser.add_argument("--link", required=True, metavar="PATH", help="a path that will lead to the terminal")
    parser.add_argument("--calibration", required=True, metavar="FILE", help="its calibration; written where there is none")
    parser.add_argument("--rig", metavar="FILE", help="what actuators, sensors and line do, and what happens when")
    sets = "a number of the model, e.g. material.stiffness=300"
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help=sets)
    given = parser.parse_args(without_ros(arguments))
    need_no_graph()
    from ..genetics.genome import GenomeError
    from ..hardware.calibration import CalibrationError
    from ..hardware.emulator import BodyFailed
    from ..hardware.rig import RigError
    from ..live.animat import NotViable
    from ..recording import RecordingError

    stop = threading.Event()
    try:
        emulator = _emulator(given)
        print(f"emulating at {given.link}: Ctrl-C ends it", flush=True)
        threading.Thread(target=_hear, args=(emulator,), daemon=True).start()
        with heeded(lambda _: stop.set()):
            emulator.run(stop.is_set)
    except (GenomeError, ParameterError, CalibrationError, RigError, RecordingError, NotViable, OSError) as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return 2
    except BodyFailed as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return 1
    return 0


def _emulator(given):
    from ..hardware.calibration import calibration_of, load_calibration, save_calibration
    from ..hardware.emulator import EmulatedBody, Emulator
    from ..hardware.firmware import Firmware
    from ..hardware.rig import load_rig, rig_of
    from ..live.animat import Animat, NotViable
    from ..recording.champion import champion_of
    from ..ros.command_line import warn
    from ..whole_file import written_whole

    link = Path(given.link)
    if link.exists() and not link.is_symlink():
        raise ParameterError(f"--link {given.link} is there already, and no link: give a path that is free")
    champion = champion_of(given.genome, pairs(given.set), "swim", warn("emulate"))
    task = champion.task if champion.task.name == "swim" else with_settings(default_task("swim"), {})
    bred, task = task.rig, dataclasses.replace(task, rig=Rig())  # or else the body would have them twice
    animat = Animat(champion.genome, task)
    animat.step()  # whatever has to be compiled is, before the firmware must answer in time
    animat.reset()
    path = Path(given.calibration)
    if not path.exists():
        with written_whole(path) as name, open(name, "w", encoding="utf-8") as file:
            save_calibration(calibration_of(animat.body.position, champion.name[:60] or "body"), file)
    calibration = load_calibration(path)
    rig = load_rig(given.rig, calibration.cells) if given.rig else rig_of(bred)
    if fault := calibration.why_not(animat.body.position):
        raise NotViable(f"{given.genome}: {fault}: give the calibration of its own body")
    body = EmulatedBody(animat.plant, calibration, rig, task.control_step)
    firmware = Firmware(calibration.by_channel(calibration.vent), calibration.most_pressure, calibration.name, log=_say)
    return Emulator(body, firmware, rig, task.control_step, link, _say)


def _hear(emulator) -> None:
    """In a thread of its own: what is typed happens."""
    from ..hardware.rig import RigError, event_of_line

    for line in sys.stdin:
        try:
            emulator.happen(event_of_line(line, emulator.cells))
        except RigError as error:
            print(error, file=sys.stderr, flush=True)


def _say(line: str) -> None:
    print(line, flush=True)



if __name__ == "__main__":
    from .entry import emulate as entry

    sys.exit(entry())
