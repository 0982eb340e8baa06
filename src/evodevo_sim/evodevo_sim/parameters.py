"""Every number of the model that the paper leaves open, with its unit, default and range.

The dataclasses mirror the messages of the same names in `evodevo_msgs`.  What was chosen, and the measurement that made us
choose it, stands in `docs/reference/model.md`.
"""

from __future__ import annotations

import dataclasses
import math
from collections import namedtuple
from dataclasses import dataclass, field
from typing import Any

from .inputs import InputError, decimal, nearest, shown
from .profiles import fault
from .task_kinds import TaskKind, kind_of, names

VARIANTS = ("continual_graph", "graph_at_end")
FITNESSES = ("sustained", "distance")
PROFILES = ("ground_x", "ground_y", "ceiling_x", "ceiling_y")
MOST_CELLS = 4096
MOST_WAIT = 1000  # control steps that a rig may be late
FINEST = 1e-9  # a resolution of a rig below it is none


class ParameterError(InputError, ValueError):
    """A setting that cannot work; the message names it, its value and what would."""


def parameter(default: Any, low: float, high: float, unit: str, meaning: str) -> Any:
    """A documented number of a parameter class, refused outside [low, high]."""
    return field(default=default, metadata={"range": (low, high), "unit": unit, "meaning": meaning})


def cells(meaning: str) -> Any:
    """A documented list of cells of a parameter class, empty by default."""
    return field(default=(), metadata={"cells": True, "unit": "", "meaning": meaning})


def cells_of(value: Any, where: str) -> tuple[int, ...]:
    """Numbers of cells, of a list or of text such as 3,7.  Raises ParameterError."""
    given = [decimal(word.strip()) for word in value.split(",") if word.strip()] if isinstance(value, str) else value
    try:
        numbers = list(given)
    except TypeError:
        raise ParameterError(f"{where} is {shown(value)}: give the numbers of cells, e.g. 3,7") from None
    for k, one in enumerate(numbers):
        if isinstance(one, bool) or not isinstance(one, int) or not 0 <= one < MOST_CELLS:
            raise ParameterError(f"{where} is {shown(value)}: give numbers of cells, each from 0 to {MOST_CELLS - 1}, e.g. 3,7")
        if one in numbers[:k]:
            raise ParameterError(f"{where} has {one} twice: give each cell once")
    return tuple(map(int, numbers))


class Checked:
    """Gives every field its declared type and checks its range, so that kernels are compiled for one set of types only."""

    def __post_init__(self):
        for item in dataclasses.fields(self):
            if "range" not in item.metadata:
                continue
            value = getattr(self, item.name)
            low, high = item.metadata["range"]
            where = f"{type(self).__name__.lower()}.{item.name}"
            number = int if isinstance(item.default, int) else float
            try:
                converted, finite = number(value), math.isfinite(float(value)) and not isinstance(value, bool)
            except (TypeError, ValueError, OverflowError):
                raise ParameterError(f"{where} is {shown(value)}: give a number from {low:g} to {high:g}") from None
            if not finite or converted != value or not low <= converted <= high:
                kind = "a whole number" if number is int else "a number"
                raise ParameterError(f"{where} is {shown(value)}: give {kind} from {low:g} to {high:g} {item.metadata['unit']}".rstrip())
            object.__setattr__(self, item.name, converted)

    def arguments(self) -> Any:
        """The numeric fields as the named tuple that kernels take."""
        names = ARGUMENTS[type(self)]._fields
        return ARGUMENTS[type(self)](*(getattr(self, name) for name in names))


@dataclass(frozen=True)
class Development(Checked):
    """Growth of the embryo (paper section 2.2)."""

    variant: str = "continual_graph"
    max_cells: int = parameter(32, 1, MOST_CELLS, "", "hard limit on cells")
    steps: int = parameter(400, 1, 100_000, "", "regulation steps of growth")
    regulation_rate: float = parameter(0.3, 1e-6, 1.0, "", "share of the way to its target that a concentration goes in a step")
    division_threshold: float = parameter(0.5, 0.01, 1.0, "", "division factor above which a cell divides")
    division_turn: float = parameter(0.1, -math.pi, math.pi, "rad", "turn of the axis at each division")
    axis_turn: float = parameter(math.pi, -math.tau, math.tau, "rad", "further turn for a full axis factor")
    division_room: float = parameter(
        0.0, 0.0, 10.0, "m", "a cell waits to divide while its daughter would come nearer than that to another; 0: none waits"
    )
    division_neighbours: int = parameter(0, 0, 64, "", "a cell with as many neighbours or more waits to divide; 0: none waits")
    waiting_turn: float = parameter(0.0, -math.pi, math.pi, "rad", "turn of the axis in each step in which a cell waits for room")
    maternal_length: float = parameter(4.0, 1e-3, 1e6, "m", "distance over which a maternal signal goes from 1/2 to 3/4")
    relaxations: int = parameter(6, 1, 100, "", "mechanical relaxations in a regulation step")
    repulsion: float = parameter(0.3, 0.0, 0.5, "", "share of an overlap undone in one relaxation")
    adhesion: float = parameter(0.1, 0.0, 0.5, "", "share of a gap closed in one relaxation")
    adhesion_range: float = parameter(1.5, 1.0, 100.0, "m", "variant B: distance beyond which neighbours do not hold each other")
    neighbour_radius: float = parameter(1.2, 1.0, 1.5, "m", "variant A: distance within which cells are neighbours")
    morphogen_range: float = parameter(1.0, 1e-3, 1e6, "m", "variant A: distance over which a morphogen falls to a half")
    morphogen_speed: float = parameter(1.0, 0.05, 1e6, "m/step", "variant A: speed at which morphogens travel")

    def __post_init__(self):
        super().__post_init__()
        if self.variant not in VARIANTS:
            raise ParameterError(f"development.variant is {shown(self.variant)}: choose one of {', '.join(VARIANTS)}")


@dataclass(frozen=True)
class Material(Checked):
    """The stuff of the body (paper section 2.3).  Lengths are in cell diameters, called metres; a cell weighs 1 kg."""

    mass: float = parameter(1.0, 1e-6, 1e6, "kg", "mass of a cell")
    stiffness: float = parameter(400.0, 1e-6, 1e9, "N/m", "of a spring, k")
    damping: float = parameter(10.0, 0.0, 1e6, "N s/m", "of a spring, c_s")
    pressure: float = parameter(400.0, 0.0, 1e9, "N/m", "chamber coefficient, c_p")
    muscle_range: float = parameter(0.2, 0.0, 0.49, "", "share of its rest length that a spring grows by for each e - c of 1 at an end")


@dataclass(frozen=True)
class Scene(Checked):
    """The world around the body.  A coefficient of 0 removes its term from the physics."""

    drag_normal: float = parameter(40.0, 0.0, 1e6, "kg/m^2", "drag across an outline edge, d_N")
    drag_tangential: float = parameter(0.2, 0.0, 1e6, "kg/m^2", "drag along an outline edge, d_T")
    gravity: float = parameter(0.0, 0.0, 1e4, "m/s^2", "downward; of the walk task alone")
    friction: float = parameter(0.0, 0.0, 1e3, "", "Coulomb's coefficient on ground and ceiling, static and kinetic")
    ground_x: tuple[float, ...] = ()  # m, ascending; with ground_y: the ground's profile (see `terrain`); none: flat at y = 0
    ground_y: tuple[float, ...] = ()
    ceiling_x: tuple[float, ...] = ()  # likewise the ceiling's; none: no ceiling
    ceiling_y: tuple[float, ...] = ()

    def __post_init__(self):
        super().__post_init__()
        for name in PROFILES:
            value = getattr(self, name)
            try:
                object.__setattr__(self, name, tuple(float(item) for item in (value if not isinstance(value, str) else None)))
            except (TypeError, ValueError, OverflowError):
                raise ParameterError(f"scene.{name} is {shown(value)}: give a world, by --world, which is made of points") from None
        wrong = fault(*(getattr(self, name) for name in PROFILES))
        if wrong:
            raise ParameterError(f"scene: {wrong}")


@dataclass(frozen=True)
class Noise(Checked):
    """Standard deviations of what is added at each control step; 0 takes no time and changes no bit."""

    sensing: float = parameter(0.0, 0.0, 100.0, "", "of each cell's scent, which stays between 0 and its peak")
    concentrations: float = parameter(0.0, 0.0, 1.0, "", "of each cell's concentrations, which stay in [0, 1]")
    actuation: float = parameter(0.0, 0.0, 2.0, "", "of each muscle's e - c as the body gets it, which stays in [-1, 1]")


@dataclass(frozen=True)
class Rig(Checked):
    """Actuators between brain and muscles, and sensors between cells and brain (docs/reference/plant.md); what is 0 or empty does nothing,
    takes no time and changes no bit."""

    lag: float = parameter(0.0, 0.0, 60.0, "s", "time constant of the approach to what is asked, of first order")
    dead_time: float = parameter(0.0, 0.0, 10.0, "s", "time before a change begins to act")
    rate: float = parameter(0.0, 0.0, 1e6, "1/s", "most change of e - c in a second; 0: no limit")
    resolution: float = parameter(0.0, 0.0, 2.0, "", "step of e - c that a valve can set; 0: none")
    dead_cells: tuple[int, ...] = cells("cells whose actuators do nothing")
    failing_cells: tuple[int, ...] = cells("cells whose actuators do nothing from fail_at on")
    failures: int = parameter(0, 0, MOST_CELLS, "", "so many cells more, drawn by the seed, that do nothing from fail_at on")
    fail_at: float = parameter(0.0, 0.0, 1e6, "s", "when cells fail, since the network woke")
    sensor_noise: float = parameter(0.0, 0.0, 1e3, "m", "standard deviation of each coordinate of a cell as it is seen")
    sensor_delay: float = parameter(0.0, 0.0, 10.0, "s", "age of what is seen")
    sensor_resolution: float = parameter(0.0, 0.0, 1e3, "m", "step of a coordinate; 0: none")
    sensor_lost: float = parameter(0.0, 0.0, 1.0, "", "probability of a cell, in each control step, not to be seen")

    def __post_init__(self):
        super().__post_init__()
        for name in ("dead_cells", "failing_cells"):
            object.__setattr__(self, name, cells_of(getattr(self, name), f"rig.{name}"))

    @staticmethod
    def steps(seconds: float, control_step: float) -> int:
        """A delay in whole control steps, the nearest."""
        return round(seconds / control_step)

    @staticmethod
    def fine(resolution: float) -> float:
        """A resolution, or 0 where it is too fine to be one."""
        return resolution if resolution > FINEST else 0.0

    def share(self, control_step: float) -> float:
        """Of the way to what is asked, that a muscle goes in a control step."""
        return -math.expm1(-control_step / self.lag) if self.lag > 0.0 else 1.0


@dataclass(frozen=True)
class Chemotaxis(Checked):
    """The scent of a target, and the tests of chemotaxis (paper section 4.3)."""

    scent_peak: float = parameter(10.0, 0.0, 1e3, "", "scent at the target")
    scent_reach: float = parameter(14.0, 1e-3, 1e6, "m", "distance at which the scent has fallen to 0; swimming farther than that pays no more")
    distance: float = parameter(8.0, 1e-3, 1e6, "m", "of the targets from the centre of mass at birth")
    angle: float = parameter(math.pi / 2, 0.0, math.pi, "rad", "of the targets from the way that it swims without one, to either side")
    pairs: int = parameter(2, 1, 100, "", "of targets, one on the left and one on the right each")
    spread: float = parameter(0.3, 0.0, 0.9, "", "of pairs: share by which the last stands more aside and nearer, the first less and farther")
    least_distance: float = parameter(1.0, 0.0, 1e6, "m", "to swim without a target, before it is tested with targets")
    turning_weight: float = parameter(4.0, 0.0, 1e6, "", "of metres that turning has brought it nearer to both targets")
    approach_weight: float = parameter(8.0, 0.0, 1e6, "", "of metres that it is nearer to both targets than at birth")


@dataclass(frozen=True)
class Task(Checked):
    """What a genome is evaluated for: growth, then locomotion in a scene (paper section 4)."""

    name: str = "swim"
    fitness: str = "sustained"  # one of FITNESSES; the empty text of a message that does not say is the default
    development: Development = Development()
    material: Material = Material()
    scene: Scene = Scene()
    noise: Noise = Noise()
    rig: Rig = Rig()
    chemotaxis: Chemotaxis = Chemotaxis()
    control_steps: int = parameter(2000, 1, 10_000_000, "", "of locomotion, one regulation step each")
    control_step: float = parameter(1 / 60, 1e-9, 1.0, "s", "duration of a control step")
    windows: int = parameter(4, 2, 1000, "", "equal parts of the run, an even number, of which the slowest counts")
    full_activity: float = parameter(0.1, 1e-9, 1.0, "", "amplitude of e - c from which on a cell counts as active in full")
    activity_bonus: float = parameter(0.5, 0.0, 1e6, "m", "fitness for full activity of all cells alone")
    starts: int = parameter(4, 1, 1000, "", "walk: orientations at birth, evenly spread, of which the worse half counts")
    settling_limit: int = parameter(1800, 1, 10_000_000, "", "walk: control steps within which a body must come to rest")
    settling_drag: float = parameter(1.5, 0.0, 1e3, "1/s", "walk: rate at which speeds decay while it comes to rest")
    settled_speed: float = parameter(0.01, 1e-9, 1e3, "m/s", "walk: speed below which a cell rests")

    def __post_init__(self):
        super().__post_init__()
        kind = known_kind(self.name)
        object.__setattr__(self, "fitness", self.fitness or FITNESSES[0])
        if self.fitness not in FITNESSES:
            raise ParameterError(f"task.fitness is {shown(self.fitness)}: choose one of {', '.join(FITNESSES)}")
        if self.fitness not in kind.fitnesses:
            why = ", which is scored by tests with targets" if kind.has_target else ""
            raise ParameterError(f"task.fitness is {self.fitness!r}: leave it at {kind.fitnesses[0]!r} where the task is {self.name}{why}")
        if self.windows % 2:
            raise ParameterError(f"task.windows is {self.windows}: give an even number, so that the run has two halves")
        for setting, why in kind.unused.items():
            if value := setting_of(self, setting):
                raise ParameterError(f"{setting} is {value:g}: leave it at 0 where the task is {self.name}, {why}")
        for name in ("dead_time", "sensor_delay"):
            late = self.rig.steps(getattr(self.rig, name), self.control_step)
            if late > MOST_WAIT:
                most = f"at most {MOST_WAIT * self.control_step:g} s, {MOST_WAIT} control steps"
                raise ParameterError(f"rig.{name} is {getattr(self.rig, name):g}: give {most}, or a longer control step")
        if self.control_steps % self.windows:
            raise ParameterError(f"task.control_steps is {self.control_steps}: give a multiple of the {self.windows} windows")

    @property
    def has_target(self) -> bool:
        """Whether the scene has a target, whose scent reaches the network."""
        return self.kind.has_target

    @property
    def has_ground(self) -> bool:
        """Whether it happens on the ground of its scene."""
        return self.kind.has_ground

    @property
    def kind(self) -> TaskKind:
        """What the task is: its functions and facts."""
        return known_kind(self.name)


# Named sets of settings: fluids, for any task that has drag, and growth in which crowded cells wait, for any task.
PRESETS: dict[str, dict[str, object]] = {
    "low_drag": {"scene.drag_normal": 10.0, "scene.drag_tangential": 0.05},
    "high_drag": {"scene.drag_normal": 400.0, "scene.drag_tangential": 2.0},
    "contact_inhibition": {"development.division_room": 0.6, "development.division_neighbours": 4, "development.waiting_turn": 0.02},
}


def preset(name: str) -> dict[str, object]:
    """The settings of a preset, for `with_settings`.  Raises ParameterError where there is none of that name."""
    if name not in PRESETS:
        raise ParameterError(f"preset {shown(name)} is unknown: choose one of {', '.join(PRESETS)}")
    return PRESETS[name]


def default_task(name: str) -> Task:
    """The task of a name with its own defaults.  Raises ParameterError where there is none."""
    return with_settings(Task(), {"name": name, **known_kind(name).defaults})


def known_kind(name: str) -> TaskKind:
    """The kind of task of a name.  Raises ParameterError that names those that exist."""
    kind = kind_of(name)
    if kind is None:
        raise ParameterError(f"task {shown(name)} is unknown: choose one of {', '.join(names())}")
    return kind


def setting_of(task: Task, name: str) -> float:
    """A number of a task by its name, e.g. `noise.sensing`."""
    part, _, field_name = name.rpartition(".")
    return getattr(getattr(task, part) if part else task, field_name)


def with_settings(task: Task, values: dict[str, object]) -> Task:
    """A task with some numbers changed, by name, e.g. `{"development.max_cells": 64}`.

    Values may be text, as from a command line.  Raises ParameterError that names the setting and the nearest known one.
    """
    changes: dict[str, dict[str, object]] = {}  # by part, so that what belongs together is checked together
    for name, value in values.items():
        name = name.removeprefix("task.")
        part, _, field_name = name.rpartition(".")
        target = getattr(task, part, None) if part else task
        known = {f"{part}.".lstrip(".") + f.name: f for f in dataclasses.fields(target)} if isinstance(target, Checked) else {}
        if name not in known or isinstance(getattr(target, field_name), Checked):
            every = [f.name for f in dataclasses.fields(Task)] + [
                f"{f.name}.{g.name}" for f in dataclasses.fields(Task) if dataclasses.is_dataclass(f.default) for g in dataclasses.fields(f.default)
            ]
            raise ParameterError(f"setting {shown(name)} is unknown: did you mean {nearest(name, every)!r}?")
        if isinstance(value, str) and "range" in known[name].metadata:
            number = decimal(value.strip())
            if number is None:
                raise ParameterError(f"{name} is {shown(value)}: give a number in decimal digits, e.g. 300 or 1e-5")
            value = number
        changes.setdefault(part, {})[field_name] = value
    own = changes.pop("", {})
    return dataclasses.replace(task, **own, **{part: dataclasses.replace(getattr(task, part), **given) for part, given in changes.items()})


def _argument_type(cls):
    return namedtuple(f"{cls.__name__}Arguments", [f.name for f in dataclasses.fields(cls) if "range" in f.metadata])


# At module level and by name, so that numba's disk cache finds the same types in every process.
DevelopmentArguments = _argument_type(Development)
MaterialArguments = _argument_type(Material)
SceneArguments = _argument_type(Scene)
TaskArguments = _argument_type(Task)
NoiseArguments = _argument_type(Noise)
RigArguments = _argument_type(Rig)
ChemotaxisArguments = _argument_type(Chemotaxis)
ARGUMENTS = {Development: DevelopmentArguments, Material: MaterialArguments, Scene: SceneArguments, Task: TaskArguments}
ARGUMENTS |= {Noise: NoiseArguments, Rig: RigArguments, Chemotaxis: ChemotaxisArguments}
