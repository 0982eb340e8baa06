"""What precision costs: the error of a champion's swim, by the same muscles, for more and more steps of each method.

The error is the root mean square distance of the centre of mass from that of the adaptive method of order 5 at a tolerance of 1e-11,
at the ends of sixteen equal parts of the swim.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...parameters import ParameterError
from ...physics.soundness import SOUND
from ...physics.step_size import ADAPTIVE, EULER, LAWSON, RK4, VERLET
from ...recording.champion import Champion
from ...tasks.evaluation import perform
from ...tasks.repetition import Way, repeat_motion
from .sheet import Sheet, stroke

METHODS = {"symplectic Euler": EULER, "Verlet": VERLET, "RK4": RK4, "Lawson": LAWSON}
_COST = {EULER: 1, VERLET: 1, RK4: 4, LAWSON: 6}  # force evaluations of a step
_EFFORTS = (1, 2, 4, 8, 16, 32)  # steps of RK4 and Lawson's method in a control step of a body at rest; of the others, four times as many
_REFERENCE = 1e-11
_POINTS = 16
_TALL, _GAP = 58.0, 8.0  # mm
_LEAST = 1e-12  # m: less is rounding


def draw(sources: Sequence[Champion], sheet: Sheet) -> None:
    found = []
    for one in sources:
        if one.task.has_ground:
            why = "a walk in finer steps is another walk, since contacts are chaotic"
            raise ParameterError(f"{one.name} walks, and {why}: audit it, or draw gait, traces or fitness of it instead")
        found.append((one.name, *curves(one)))
    sheet.begin(len(found) * (_TALL + _GAP))
    for k, (name, errors, own) in enumerate(found):
        top = k * (_TALL + _GAP)
        sheet.label(k, len(found), 2, top + 1.5, name, sheet.width - 4)
        axes = sheet.axes(15, top + 11, sheet.width - 18, _TALL - 15)
        for number, (method, points) in enumerate(errors.items()):
            if points:
                axes.loglog(*np.array(points).T, marker="o^sD"[number], ms=3, label=method, **stroke(number))
        axes.axvline(own, color="0.4", linewidth=0.7, linestyle=":", zorder=1)
        axes.text(own, 0.03, " as evolved", transform=axes.get_xaxis_transform(), fontsize=6, va="bottom")
        axes.set(xlabel="force evaluations in a control step, of a body at rest", ylabel="RMS error of the way, m")
        axes.set_xlim(3.0, 1.3 * 6 * _EFFORTS[-1])
        spaces = {"borderaxespad": 0.2, "handlelength": 2.0, "handletextpad": 0.5, "columnspacing": 0.7}
        axes.legend(ncols=4, loc="lower left", bbox_to_anchor=(-0.1, 1.0), **spaces)


def curves(one: Champion) -> tuple[dict[str, list[tuple[float, float]]], float]:
    """(work, error in m) of each method; and the work as evolved.  Raises ParameterError where nothing swims."""
    first = perform(one.genome, one.task, one.seed)
    if first.evaluation.cause:
        raise ParameterError(f"{one.name} fails: {first.evaluation.cause}: draw growth or fitness instead")
    points = min(_POINTS, one.task.control_steps)

    def path(method: int, steps: int, tolerance: float = 0.0):
        way = Way("", method, 1.0, tolerance, False, False)
        return repeat_motion(first.body, one.task, steps, first.position[0], first.activation, way, points)

    exact = path(ADAPTIVE, 1, _REFERENCE).path
    found: dict[str, list[tuple[float, float]]] = {}
    for name, method in METHODS.items():
        found[name] = []
        for effort in _EFFORTS:
            steps = effort if method == LAWSON else 4 * effort // _COST[method]
            motion = path(method, steps)
            error = float(np.sqrt(np.mean(np.sum((motion.path - exact) ** 2, axis=1))))
            if motion.outcome == SOUND and np.isfinite(error):
                found[name].append((float(_COST[method] * steps), max(error, _LEAST)))
    return found, float(_COST[LAWSON]) * first.evaluation.metrics.substeps
