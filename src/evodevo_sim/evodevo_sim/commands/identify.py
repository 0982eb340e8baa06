"""`ros2 run evodevo_sim identify BAG ...`: the numbers of a body, from recordings of it."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..parameters import ParameterError, default_task, with_settings
from ..ros.command_line import Parser, pairs, say_if_compiling, warn
from ..ros.environment import need_no_graph, without_ros

if TYPE_CHECKING:
    from ..identification import Fit

_EPILOG = """\
examples:
  ros2 run evodevo_sim identify bags/sample-swim --fit stiffness drag_normal
      of a simulated swim, the numbers that it was simulated with
  ros2 run evodevo_sim identify bags/eel bags/ray bags/ribbon
      stiffness, damping, drag and lag with which the simulator does what these bodies did
  ros2 run evodevo_sim identify bags/eel bags/ray --others bags/ribbon -o plant.yaml
      and how far it is then from a body that it was not fitted to; actuators and sensors into a file for evolve --plant
  ros2 run evodevo_sim identify bags/eel --fit stiffness lag delay --rig plant.yaml
      these alone; what plant.yaml says of actuators is known

A recording is that of a driver: `ros2 bag record /eel/body /eel/cell_states`, 10 s or more of a life in which all cells work. Bodies of
several shapes, made of one stuff, tell more than one. A cell weighs `material.mass`: all else follows from that.
Exit code: 0; 2 for bad input.
"""


def main(arguments: list[str] | None = None) -> int:
    parser = Parser("identify", "Find the numbers of a body by fitting the simulator to recordings of it.", _EPILOG)
    parser.add_argument("recordings", nargs="+", type=Path, metavar="BAG", help="recordings of bodies of one stuff")
    parser.add_argument("--others", nargs="+", default=[], type=Path, metavar="BAG", help="others, which are predicted alone")
    what = "of stiffness, damping, pressure, drag_normal, drag_tangential, lag, delay (default: all but pressure and delay)"
    parser.add_argument("--fit", nargs="+", metavar="NUMBER", help=what)
    parser.add_argument("--rig", metavar="FILE", help="what is known of actuators, and where the fit of lag begins")
    sets = "a number of the model that is known, or where the fit begins, e.g. material.mass=0.8"
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help=sets)
    written = "write actuators and sensors for evolve --plant and emulate, made anew"
    parser.add_argument("-o", "--out", type=Path, metavar="FILE.yaml", help=written)
    given = parser.parse_args(without_ros(sys.argv[1:] if arguments is None else arguments))
    need_no_graph()
    from ..hardware.rig import RigError
    from ..identification import ObservationError, fit
    from ..identification.fitting import USUAL
    from ..recording import RecordingError

    try:
        if given.out and given.out.exists():
            raise ParameterError(f"{given.out} exists already and is never overwritten: choose another name")
        names = tuple(dict.fromkeys(given.fit or USUAL))
        seen, model, rig = _read(given, warn(parser.prog))
        say_if_compiling("kernel.swim")
        found = fit(seen[: len(given.recordings)], model, names, warn(parser.prog))
        print(table(found))
        for path, one in zip(given.others, seen[len(given.recordings) :]):
            print(f"{path}: {_tried(one, found)}")
        print(_use(found, given.out))
        if given.out:
            _write(given.out, found, rig)
            print(f"Saved {given.out}")
    except (ObservationError, ParameterError, RecordingError, RigError, OSError) as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
    return 0


def _read(given: Any, say: Any) -> tuple[list, Any, Any]:
    """(observations, the model that the fit begins with, the rig of the file)."""
    from ..hardware.rig import Rig, load_rig
    from ..identification import ObservationError
    from ..identification.prediction import Model
    from ..recording.observed import control_step_of, observation_of

    rig = load_rig(given.rig) if given.rig else Rig()
    read = [observation_of(path, say) for path in (*given.recordings, *given.others)]
    steps = [control_step_of(one, step) for one, step, _ in read]
    for path, step in zip((*given.recordings, *given.others), steps):
        if abs(step / steps[0] - 1.0) > 0.01:
            raise ObservationError(f"{path} has control steps of {step:.4g} s, {given.recordings[0]} of {steps[0]:.4g} s: give equal ones")
    task = with_settings(read[0][2] or default_task("swim"), dict(pairs(given.set)))
    nominal = task.control_step if abs(steps[0] / task.control_step - 1.0) < 0.01 else steps[0]
    return [one for one, _, _ in read], Model(task.material, task.scene, rig.actuators, rig.sensors.delay, nominal), rig


def _tried(one: Any, found: Fit) -> str:
    from ..identification import predicted, tracking

    track = predicted(one, found.model)
    if track is None:
        return "the physics cannot be carried on"
    error = tracking(one.time, one.position, track, one.length, 0.25)
    return f"off by {error.rms:.4f} m, {100 * error.relative:.2f} % of its length, over {error.time[-1] - error.time[0]:.3g} s"


def table(found: Fit) -> str:
    """What was found, a line for each number."""
    seconds = ("lag", "delay")
    rows = [("", "found", "+-")]
    for name, value in found.numbers.items():
        spread = found.spread[name] * (1.0 if name in seconds else value)
        rows.append((name, f"{value:.5g}{' s' * (name in seconds)}", f"{spread:.2g}"))
    widths = [max(map(len, column)) for column in zip(*rows)]
    lines = [f"{row[0]:<{widths[0]}}  {row[1]:>{widths[1]}}  {row[2]:>{widths[2]}}" for row in rows]
    return "\n".join([*lines, f"rms of all cells seen: {found.rms:.4f} m; {found.simulations} simulations"])


def _settings(found: Fit) -> list[str]:
    """What of the numbers is a setting of a task, as --set takes it."""
    parts = {"stiffness": "material", "damping": "material", "pressure": "material", "drag_normal": "scene", "drag_tangential": "scene"}
    return [f"{parts[name]}.{name}={value:.5g}" for name, value in found.numbers.items() if name in parts]


def _use(found: Fit, out: Path | None) -> str:
    plant = [f"--plant {shlex.quote(str(out))}"] if out else []
    words = plant + [f"--set {shlex.quote(one)}" for one in _settings(found)]
    return f"Use it:   ros2 run evodevo_ga evolve {' '.join(words)}" if words else "Use it:   with -o FILE, by evolve --plant"


def _write(path: Path, found: Fit, rig: Any) -> None:
    """The rig's file with what was found of actuators and sensors; what is a setting of a task in a remark."""
    import dataclasses

    import yaml

    from ..whole_file import written_whole

    document: dict[str, Any] = {}
    for name, default in (("actuators", type(rig.actuators)()), ("sensors", type(rig.sensors)())):
        part = found.model.actuators if name == "actuators" else dataclasses.replace(rig.sensors, delay=found.model.delay)
        own = {key: value for key, value in dataclasses.asdict(part).items() if value != getattr(default, key)}
        document[name] = {key: list(value) if isinstance(value, tuple) else float(f"{value:.6g}") for key, value in own.items()}
    with written_whole(path) as name, open(name, "w", encoding="utf-8") as file:
        file.write("".join(f"# {one}\n" for one in _settings(found)))
        yaml.safe_dump({key: value for key, value in document.items() if value}, file, sort_keys=False, default_flow_style=None)


if __name__ == "__main__":
    from .entry import identify as entry

    sys.exit(entry())
