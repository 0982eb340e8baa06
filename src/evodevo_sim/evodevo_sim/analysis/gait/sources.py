"""Tracks of the library's own objects: performances and motions."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...parameters import Scene, Task
from ...physics.terrain import Ground
from ...tasks.evaluation import Performance
from .track import GaitError, Surroundings, Track


def world_of_task(task: Task) -> Surroundings:
    """The constants of a task's material and scene."""
    known = {**vars(task.material), **vars(task.scene)}
    return Surroundings(**{name: known[name] for name in Surroundings.__dataclass_fields__ if name in known})


def world_of_scene(scene: Scene | None) -> Surroundings:
    """What a recorded scene says of the world; of the body's material nothing is known."""
    return Surroundings() if scene is None else Surroundings(
        drag_normal=scene.drag_normal, drag_tangential=scene.drag_tangential, gravity=scene.gravity
    )


def ground_of_task(task: Task) -> Ground | None:
    """A walker's ground; None for swimmers."""
    return ground_of_scene(task.scene) if task.has_ground else None


def ground_of_scene(scene: Scene) -> Ground:
    """The ground of a world."""
    return Ground(tuple(scene.ground_x), tuple(scene.ground_y))


def parts_of_body(body: Any) -> dict:
    """What a track takes of a `body.Body`."""
    polygons = np.split(body.polygon_cell, body.polygon_start[1:-1].astype(int)) if len(body.polygon_area) else []
    return {
        "springs": np.column_stack((body.spring_a, body.spring_b)).astype(int), "rest_length": body.rest_length,
        "outline": body.outline.astype(int), "chambers": tuple(np.asarray(c, int) for c in (*body.triangle, *polygons)),
        "chamber_area": np.concatenate((body.triangle_area, body.polygon_area)),
    }


def track_of_performance(performance: Performance, task: Task = Task(), ground: Ground | None = None) -> Track:
    """The track of a life.  Args: ground: as in `Track`, by default that of the task.  Raises GaitError where nothing lived."""
    if performance.body is None or performance.evaluation.cause:
        raise GaitError(f"nothing moved: {performance.evaluation.cause or 'the egg never divided'}: give a genome that lives")
    return Track(
        performance.time, performance.position, performance.activation, velocity=performance.velocity, world=world_of_task(task),
        ground=ground or ground_of_task(task), held=task.has_ground, **parts_of_body(performance.body),
    )


def track_of_motion(own: Any, motion: Any, ground: Ground | None = None) -> Track:
    """The track of `simulate_body`'s motion of an `OwnBody`.  Args: ground: as in `Track`; by default flat where the motion has
    ground at all."""
    system = motion.system
    world = Surroundings(
        float(1.0 / own.body.inverse_mass.mean()), **own.stuff._asdict(), drag_normal=system.law.drag_normal,
        drag_tangential=system.law.drag_tangential, gravity=system.gravity,
        muscle_range=system.law.muscle_range,
    )
    return Track(
        motion.time, motion.position, motion.activation, velocity=motion.velocity, world=world,
        ground=ground or (Ground() if system.ground else None), held=False, **parts_of_body(own.body),
    )
