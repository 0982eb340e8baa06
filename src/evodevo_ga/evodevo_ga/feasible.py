"""Settings that are each in range, and yet together leave nothing to evolve: refused before a run begins."""

from __future__ import annotations

import math
from collections.abc import Sequence

from evodevo_sim.parameters import setting_of
from evodevo_sim.physics.step_size import ACCURATE_REST, MOST_SUBSTEPS

from evodevo_sim import Genome, ParameterError, Task

from .settings import Settings

_LEAST_CELLS = 3  # of a body with a chamber


def check(task: Task, settings: Settings, start: Sequence[Genome] = ()) -> None:
    """Raises ParameterError where no genome could score, or no child differ from its parents."""
    _check_growth(task)
    _check_physics(task)
    _check_scene(task)
    _check_search(task, settings, start)
    _check_archive(task, settings)


def check_rig(task: Task, start: Sequence[Genome]) -> None:
    """Raises ParameterError where a run cannot go on hardware."""
    if task.name != "swim":
        raise ParameterError(f"--task is {task.name}: give swim with --rig, where nobody carries a body back to where it started")
    if not start:
        raise ParameterError("--rig is given without --start: give a genome that grows the body of the rig")


def _check_growth(task: Task) -> None:
    d = task.development
    if d.max_cells < _LEAST_CELLS:
        raise ParameterError(
            f"development.max_cells is {d.max_cells}: give {_LEAST_CELLS} or more, a body without a chamber scores nothing"
        )
    # The division factor starts at 0 and goes a share of the way to its target, which is below 1, in each step.
    most = 1.0 - (1.0 - d.regulation_rate) ** d.steps
    if most <= d.division_threshold:
        raise ParameterError(
            f"development.division_threshold is {d.division_threshold:g}: give less than {most:.3g}, which no cell can pass in "
            f"{d.steps} steps at a regulation_rate of {d.regulation_rate:g}"
        )


def _check_physics(task: Task) -> None:
    """Whether even the body that asks for the fewest physics steps asks for too many.

    By the bounds of `rates.frequency_bound`: a cell of a chamber has two springs, whose directions make a matrix with an
    eigenvalue of 1 or more; a convex chamber with up to n corners has one that gives 2 tan(pi / n) or, of a triangle, sqrt(3).
    """
    m = task.material
    corner = min(math.sqrt(3.0), 2.0 * math.tan(math.pi / max(4, task.development.max_cells)))
    frequency = math.sqrt((2.0 * m.stiffness + corner * m.pressure) / m.mass)
    need = task.control_step * max(frequency, 2.0 * m.damping / m.mass) / ACCURATE_REST
    if need > MOST_SUBSTEPS:
        raise ParameterError(
            f"task.control_step is {task.control_step:g}: give less than {task.control_step * MOST_SUBSTEPS / need:.3g} s, "
            f"or lower material.stiffness, damping or pressure: every body would need more than {MOST_SUBSTEPS} physics steps in each"
        )


def _check_scene(task: Task) -> None:
    needed = task.kind.needed
    if needed and not any(setting_of(task, name) for name in needed):
        are, give = ("is", "more") if len(needed) == 1 else ("are", "one of them more")
        raise ParameterError(f"{' and '.join(needed)} {are} 0: give {give}, {task.kind.needed_because}")


def _check_archive(task: Task, settings: Settings) -> None:
    """Raises ParameterError where an archive has parts that no body can be in."""
    s, cells = settings, task.development.max_cells
    shares = {chambers / (2 * n - 5) for n in range(_LEAST_CELLS, cells + 1) for chambers in range(1, 2 * n - 4)}
    for name, most, what in (
        ("fillings", len(shares), "bodies have no more shares of chambers than that"),
        ("elongations", cells**2, "bodies have no more shapes to tell apart than that"),
    ):
        if getattr(s, name) > most:
            raise ParameterError(f"settings.{name} is {getattr(s, name)}: give {most} or less, {what} with max_cells at {cells}")


def _check_search(task: Task, settings: Settings, start: Sequence[Genome]) -> None:
    s = settings
    if s.units == 0 and not start:
        raise ParameterError("settings.units is 0: give 1 or more, or genomes by --start: without units no muscle can oscillate")
    moves = (s.point_mutation or (s.scent_mutation and task.has_target)) and s.point_scale
    if not (moves or s.crossover or s.duplication or s.deletion or s.flip):
        raise ParameterError(
            "settings.point_mutation is 0, and so is every other operator: give one of them more, or no child differs from its parent"
        )
