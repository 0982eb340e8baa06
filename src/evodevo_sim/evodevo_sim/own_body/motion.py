"""`simulate_body(own, scene, duration)`: a body of your own moves by the laws of every other body.

    from evodevo_sim import load_body, simulate_body
    motion = simulate_body(load_body("body.yaml"), "swim", duration=10.0)
    motion.time, motion.position, motion.velocity

swim   fluid drag; no gravity                                         (paper section 4.2)
walk   gravity and flat ground at y = 0 with Coulomb friction; no drag           (section 4.1)
free   no ground, and of the other terms those alone that the file's scene names: by default nothing
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..inputs import shown
from ..parameters import Material, ParameterError, Scene, Task
from ..physics.bounds import bounds
from ..physics.forces import Law
from ..physics.integrators import State, System, make_system, make_work
from ..physics.replayed_motion import Frames, Method, follow
from ..physics.soundness import INVERTED, SOUND
from ..physics.step_size import ADAPTIVE, EULER, INTEGRATORS, choose_steps, longest_step
from ..physics.terrain import FLAT, clearance, make_terrain, profile
from ..worlds import with_world
from .body_file import BodyError, OwnBody
from .planar import rounding

SCENES = ("swim", "walk", "free")
FRAME = 1 / 60  # s between frames where no step is given
GRAVITY, FRICTION = 9.81, 0.8  # m/s^2 and Coulomb's coefficient of the walk scene, where the file has none
TOLERANCE = 1e-9
_FINER = {"swim": 8.0, "walk": 4.0, "free": 8.0}  # than stable: errors near 1e-7 m for the smooth scenes
_BOUND_SLACK = 1.5  # the bound of the frequency lies up to so much above the truth
_MOST_VALUES = 20_000_000  # frames times cells
_MOST_STEPS = 10_000  # a frame, before they are made finer
_TOUCH = 1e-9  # m below the ground, or above the ceiling, that are a rounding of what stands on it
_CHUNK = 256  # frames between looks at whether the user wants to stop
_CAUSE = {True: "a chamber turned inside out or a spring collapsed", False: "the physics blew up"}


@dataclass(frozen=True, eq=False)
class Motion:
    """What a body did.

    Attributes:
        time (T,) s; position (T, N, 2) m, velocity (T, N, 2) m/s, activation (T, N) of e - c: at every step where one was
            given, or else every 1/60 s, and at the end; as far as it went.
        cause: why it ended early, or nothing; world: ground and all of the walk scene, or None.
        integrator: its name; system: see `integrators.System`.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    activation: np.ndarray
    cause: str
    integrator: str
    system: System
    world: Scene | None = None


def simulate_body(own: OwnBody, scene: str = "swim", duration: float = 10.0, *, dt: float | None = None,
                  tolerance: float | None = None, integrator: str | None = None, world: str | None = None) -> Motion:
    """Simulate a body from its file's state.

    Args:
        scene: one of SCENES; duration: s.
        dt: s of a step, exactly; by default steps follow from the body's stiffness, damping, drag and muscles.
        tolerance: most error of an adaptive step, in m for coordinates and in m/s for speeds.
        integrator: one of `step_size.INTEGRATORS`; by default rk4, adaptive where a tolerance is given, euler in walk.
        world: of the walk scene, a name or a file: see `worlds`; by default flat ground.

    Raises: ParameterError or BodyError that names what is wrong and the mend.
    """
    system = make_scene(own, scene, world)
    method = _method(scene, integrator, dt, tolerance)
    time = _frames(duration, dt, len(own.velocity))
    bound = bounds(system)
    position, velocity = own.body.position.T.copy(), own.velocity.T.copy()
    if scene == "walk":  # a rounding below the ground is lifted onto it
        position[1] += max(0.0, -clearance(system.terrain, own.body.outline, *position)[0])
    if dt is not None:
        longest = longest_step(method, *bound)
        if dt > _BOUND_SLACK * longest:
            raise ParameterError(f"dt is {dt:g} s: {INTEGRATORS[method]} is stable for this body up to about {longest:.2g} s")
    elif method != ADAPTIVE and choose_steps(system, method, bound, position, velocity, FRAME) > _MOST_STEPS:
        raise BodyError(
            f"stiffness, damping or pressure: the body needs more than {_MOST_STEPS * 60} steps a second: lower them, raise "
            "mass, or widen needle-shaped chambers"
        )
    cells, frames = len(own.velocity), len(time)
    track = Frames(time, np.empty((frames, cells, 2)), np.empty((frames, cells, 2)))
    track.position[0], track.velocity[0] = position.T, own.velocity
    state, way = State(position, velocity, np.empty(0)), Method(method, 1 if dt is not None else 0, _FINER[scene], tolerance or TOLERANCE)
    work, cause, done, h = make_work(own.body), "", 0, 0.0
    try:
        while done < frames - 1 and not cause:
            outcome, done, h = follow(system, way, bound, h, (done, min(done + _CHUNK, frames - 1)), state, work, track)
            if outcome != SOUND:
                cause = f"{_CAUSE[outcome == INVERTED]} at {time[done]:.6g} s, in {_steps_and_mend(outcome, method, scene, dt)}"
    except KeyboardInterrupt:
        cause = f"stopped by you at {time[done]:.6g} s"
    time = time[: done + 1]
    activation = own.amplitude * np.sin(2 * np.pi * own.frequency * time[:, None] + own.phase)
    terrain = make_world(own, world) if scene == "walk" else None
    return Motion(time, track.position[: done + 1], track.velocity[: done + 1], activation, cause, INTEGRATORS[method], system, terrain)


def _steps_and_mend(outcome, method, scene, dt) -> str:
    if dt is not None:
        return f"steps of {dt:g} s: give a shorter dt, or none"
    if method == ADAPTIVE or scene == "walk" or outcome == INVERTED:
        return "the finest steps"
    return "the finest steps: give a tolerance (--tolerance 1e-6), by which steps are chosen from the error"


def make_scene(own: OwnBody, scene: str, world: str | None = None) -> System:
    """The body in its world."""
    if scene not in SCENES:
        raise ParameterError(f"scene {shown(scene)} is unknown: choose one of {', '.join(SCENES)}")
    if world is not None and scene != "walk":
        raise ParameterError(f"world {shown(world)} is for the scene walk: {scene} has no ground")
    given = own.scene
    drag, gravity, friction, terrain = (0.0, 0.0), 0.0, 0.0, FLAT
    if scene != "walk":
        default = Scene() if scene == "swim" else Scene(0.0, 0.0)
        drag = given.get("drag_normal", default.drag_normal), given.get("drag_tangential", default.drag_tangential)
    if scene == "free":
        gravity = given.get("gravity", 0.0)
    if scene == "walk":
        there = make_world(own, world)
        gravity, friction, terrain = there.gravity, there.friction, make_terrain(there)
        _refuse_inside(own.body.position, there)
        if min(clearance(terrain, own.body.outline, *own.body.position.T)) < -_slack(own.body.position):
            raise BodyError("position: an edge of the outline passes through a tip of the world: start the body outside of it")
    drive = (own.amplitude, own.frequency, own.phase) if own.amplitude.any() else None
    law = Law(*own.stuff, *drag, muscle_range=Material.muscle_range)
    return make_system(own.body, law, gravity, friction, scene == "walk", drive, terrain)


def make_world(own: OwnBody, world: str | None) -> Scene:
    """The scene of a world's name or file, with what the body's own file says of it."""
    there = with_world(Task("walk", scene=Scene(0.0, 0.0, GRAVITY, FRICTION)), world or "flat").scene
    return replace(there, gravity=own.scene.get("gravity", there.gravity), friction=own.scene.get("friction", there.friction))


def _refuse_inside(position, scene: Scene):
    x, y = position.T
    ground = profile(scene.ground_x, scene.ground_y, x)
    slack = _slack(position)
    below = np.flatnonzero(y < ground - slack)
    if len(below):
        k = below[0]
        raise BodyError(f"position[{k}][1] is {y[k]:g}: walk has ground at y = {ground[k]:g}, start no cell below it")
    ceiling = profile(scene.ceiling_x, scene.ceiling_y, x) if scene.ceiling_x else np.full(len(x), np.inf)
    above = np.flatnonzero(y > ceiling + slack)
    if len(above):
        k = above[0]
        raise BodyError(f"position[{k}][1] is {y[k]:g}: the world's ceiling is at y = {ceiling[k]:g}, start no cell above it")


def _slack(position) -> float:
    return _TOUCH + 2.0 * rounding(position)


def _method(scene, integrator, dt, tolerance):
    if integrator is not None and integrator not in INTEGRATORS:
        raise ParameterError(f"integrator {shown(integrator)} is unknown: choose one of {', '.join(INTEGRATORS)}")
    if dt is not None and tolerance is not None:
        raise ParameterError("dt and tolerance are both given: choose one of them")
    if tolerance is not None and not 1e-13 <= tolerance <= 0.1:
        raise ParameterError(f"tolerance is {tolerance!r}: give a number from 1e-13 to 0.1 m")
    default = "euler" if scene == "walk" else "adaptive" if tolerance is not None else "rk4"
    method = INTEGRATORS.index(integrator or default)
    if scene == "walk" and (method != EULER or tolerance is not None):
        raise ParameterError("walk meets its ground by integrator euler alone, in steps that dt sets: leave out the others")
    if tolerance is not None and method != ADAPTIVE:
        raise ParameterError(f"tolerance is for integrator adaptive, not {INTEGRATORS[method]}: give dt, or no integrator")
    if dt is not None and method == ADAPTIVE:
        raise ParameterError("integrator adaptive chooses its own steps: give tolerance in place of dt")
    return method


def _frames(duration, dt, cells):
    if not 1e-6 <= duration <= 1e6:
        raise ParameterError(f"duration is {duration!r}: give a number from 1e-6 to 1e6 s")
    if dt is not None and not (1e-7 <= dt <= 1.0 and dt <= duration):
        raise ParameterError(f"dt is {dt!r}: give a number from 1e-7 to 1 s, not above the duration")
    step = FRAME if dt is None else dt
    count = max(1, int(np.ceil(duration / step * (1 - 1e-12))))
    if (count + 1) * cells > _MOST_VALUES:
        raise ParameterError(
            f"{count + 1} frames of {cells} cells do not fit in memory: shorten the duration{', or lengthen dt' if dt else ''}"
        )
    time = np.arange(count + 1) * step
    time[-1] = duration
    return time
