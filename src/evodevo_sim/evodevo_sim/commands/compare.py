"""`ros2 run evodevo_sim compare SIMULATED PLANT`: how far a simulated life is from that of a plant."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from ..ros.command_line import Parser, warn
from ..ros.environment import need_no_graph, without_ros

if TYPE_CHECKING:
    import numpy as np

    from ..identification import Observation, Tracking

_EPILOG = """\
examples:
  ros2 run evodevo_sim compare bags/sample-swim bags/sample-swim
      the last life of each, laid on each other at its begin, from control step to control step; of one and the same, nothing
  ros2 run evodevo_sim compare bags/simulated bags/plant --csv error.csv
      the error at each moment too

A recording is a directory that `evolve` or `ros2 bag record` made, with body and cell_states; both of one body, and of one genome.
Exit code: 0; 2 for bad input.
"""


def main(arguments: list[str] | None = None) -> int:
    parser = Parser("compare", "Tell how far a simulated life is from that of a plant.", _EPILOG)
    parser.add_argument("simulated", type=Path, metavar="SIM_BAG", help="recording of the simulator")
    parser.add_argument("plant", type=Path, metavar="PLANT_BAG", help="recording of the plant, or of another simulator")
    parser.add_argument("--csv", type=Path, metavar="FILE.csv", help="save the error at each moment")
    given = parser.parse_args(without_ros(sys.argv[1:] if arguments is None else arguments))
    need_no_graph()
    import numpy as np

    from ..identification import ObservationError, tracking
    from ..recording import RecordingError
    from ..recording.observed import observation_of
    from ..view import files

    try:
        if given.csv:
            files.check(given.csv, ".csv")
        (one, step, _), (other, other_step, _) = (observation_of(path, warn(parser.prog)) for path in (given.simulated, given.plant))
        if one.cells != other.cells:
            raise ObservationError(f"{given.simulated} has {one.cells} cells and {given.plant} {other.cells}: give two lives of one body")
        if not np.array_equal(_springs(one), _springs(other)):
            raise ObservationError(f"{given.simulated} and {given.plant} have other springs: give two lives of one body")
        _, own, others = np.intersect1d(step, other_step, return_indices=True)
        if len(own) < 2:
            raise ObservationError(f"{given.simulated} and {given.plant} have no control steps in common: record both from birth on")
        time = other.time[others] - other.time[others][0]
        found = tracking(time, other.position[others], one.position[own], other.length, 0.25)
        print(table(found, _way(one.position[own]), _way(other.position[others])))
        if given.csv:
            with files.whole(given.csv, ".csv") as file:
                rows = zip(found.time, found.cells, found.centre, found.shape)
                Path(file).write_text("time,cells,centre,shape\n" + "".join(",".join(f"{x:.9g}" for x in row) + "\n" for row in rows))
    except (ObservationError, RecordingError, files.OutputError) as error:
        parser.exit(2, f"{parser.prog}: {error}\n")
    return 0


def _springs(one: Observation) -> np.ndarray:
    import numpy as np

    return np.column_stack((one.body.spring_a, one.body.spring_b))


def _way(position: np.ndarray) -> float:
    """m: from the first to the last moment, mean over the cells that are seen at both."""
    import numpy as np

    moved = position[-1] - position[0]
    moved = moved[np.isfinite(moved).all(axis=1)]
    return float(np.hypot(*moved.mean(axis=0))) if len(moved) else float("nan")


def table(found: Tracking, simulated: float, plant: float) -> str:
    """A tracking error in words.  Args: simulated, plant: m, that either has swum."""
    import numpy as np

    rows = [("", "rms m", "of a length", "at the end m")]
    for name, values in (("cells", found.cells), ("centre", found.centre), ("shape", found.shape)):
        rms = float(np.sqrt(np.mean(values**2)))
        rows.append((name, f"{rms:.4f}", f"{100 * rms / found.length:.2f} %", f"{values[-1]:.4f}"))
    widths = [max(map(len, column)) for column in zip(*rows)]
    lines = ["  ".join(f"{cell:>{width}}" for cell, width in zip(row, widths)) for row in rows]
    share = f", {100 * plant / simulated:.0f} %" if simulated > 0.0 else ""
    seconds = found.time[-1] - found.time[0]
    lines.append(f"over {seconds:.3g} s, {len(found.time)} moments, of a body of {found.length:.2f} m")
    lines.append(f"it went {simulated:.3f} m in simulation and {plant:.3f} m on the plant{share}")
    return "\n".join(lines)


if __name__ == "__main__":
    from .entry import compare as entry

    sys.exit(entry())
