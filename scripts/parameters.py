"""Writes docs/reference/parameters.md: every number of the model and of the search, from the code, with its origin.

    python scripts/parameters.py [FILE]

Defaults, ranges, units and meanings are those of the dataclasses.  ORIGINS says where a value comes from and why.
"""

from __future__ import annotations

import dataclasses
import math
import re
import sys
from pathlib import Path

from evodevo_ga.schemes import SCHEMES
from evodevo_ga.settings import UNLIMITED, Settings
from evodevo_sim.parameters import FITNESSES, PRESETS, VARIANTS, Chemotaxis, Development, Material, Noise, Rig, Scene, Task
from evodevo_sim.task_kinds import kind_of

PAGE = Path(__file__).resolve().parents[1] / "docs" / "reference" / "parameters.md"
MINUS = "\N{MINUS SIGN}"
TASKS = ("swim", "walk", "chemotaxis")

# Title, prefix of the names, class, how to set one.
TABLES = (
    ("Development (2.2)", "development.", Development),
    ("Material (2.3)", "material.", Material),
    ("Scene (4.1, 4.2)", "scene.", Scene),
    ("Task (4)", "", Task),
    ("Chemotaxis (4.3)", "chemotaxis.", Chemotaxis),
    ("Noise", "noise.", Noise),
    ("Rig", "rig.", Rig),
    ("Genetic algorithm (3)", "settings.", Settings),
)
CHOICES = {"development.variant": VARIANTS, "fitness": FITNESSES, "name": TASKS}

ORIGINS = {
    "development.variant": "paper: the more recent version",
    "development.max_cells": "paper",
    "development.steps": "paper",
    "development.regulation_rate": (
        "measured: [settings](../results/settings.md). The paper says only that changes are gradual; the saves fit 0.1"
    ),
    "development.division_threshold": "start: of random genomes (12 units, extent 2) 10.7 % grow to 16 cells; at 0.8, 2.9 % do",
    "development.division_turn": "measured: makes longer bodies, which can swim farther: [shape](../results/shape.md)",
    "development.axis_turn": "start",
    "development.division_room": "off, as the champions of the package grew; 0.6 measured: [growth](../results/growth.md)",
    "development.division_neighbours": "off, as the champions of the package grew; 4 measured: [growth](../results/growth.md)",
    "development.waiting_turn": "measured: [growth](../results/growth.md). Of no effect without `division_room`",
    "development.maternal_length": "start: the radius of a body of 32 cells is about 3 m",
    "development.relaxations": "start: 2 at a regulation rate of 0.1, times the threefold rate of divisions at 0.3",
    "development.repulsion": "start: cells end 0.7 m apart or more",
    "development.adhesion": "start",
    "development.adhesion_range": "start",
    "development.neighbour_radius": "start",
    "development.morphogen_range": "start",
    "development.morphogen_speed": "start",
    "material.mass": "the unit of mass",
    "material.stiffness": "saves: they fit 100 to 500. k = c_p = 100 made no better champions: [settings](../results/settings.md)",
    "material.damping": "start",
    "material.pressure": "measured: at c_p ≥ k chambers hardly ever turn inside out: [chambers](../results/chambers.md)",
    "material.muscle_range": "paper, equation (1); below a half no spring shrinks to nothing",
    "scene.drag_normal": "measured: [settings](../results/settings.md), [yardstick](../results/yardstick.md)",
    "scene.drag_tangential": "paper: d_N = 200 d_T. Change both together",
    "scene.gravity": "walk: measured: at 9.81 more bodies fold up while they settle: [walking](walking.md#fitness)",
    "scene.friction": "walk: start",
    "scene.ground_x": "flat at y = 0 where it is empty; made by `--world`",
    "scene.ground_y": "the same",
    "scene.ceiling_x": "no ceiling where it is empty; made by `--world`",
    "scene.ceiling_y": "the same",
    "name": "paper: its three tasks",
    "fitness": "sustained: closes what plain distance, the paper's, lets through: [swimming](swimming.md)",
    "control_steps": "paper: of the order of 2,000",
    "control_step": "start",
    "windows": "start: one of them holds 14 periods of a typical champion",
    "full_activity": "start: the least oscillation that counts as one",
    "activity_bonus": "start: leads from oscillation to motion; later it is a twentieth of a champion's fitness",
    "starts": "measured: [starts](../results/starts.md)",
    "settling_limit": "start",
    "settling_drag": "measured: [yardstick of walkers](../results/yardstick-walk.md)",
    "settled_speed": "start",
    "chemotaxis.scent_peak": "paper: scents are 0 to 10",
    "chemotaxis.scent_reach": "measured: all targets can be smelt; steep scents are found more often: [scent](../results/scent.md)",
    "chemotaxis.distance": "measured: more than a body length, and near enough to turn and arrive: [scent](../results/scent.md)",
    "chemotaxis.angle": "start: straight ahead comes no nearer, so that neither stopping at the best smell nor speed pays",
    "chemotaxis.pairs": "measured: one pair is learnt by heart: [shorter runs](../results/seekers-short.md)",
    "chemotaxis.spread": "start: targets at 63° and 10.4 m, and at 117° and 5.6 m",
    "chemotaxis.least_distance": "start: what swims less has nothing to steer",
    "chemotaxis.turning_weight": "measured: [scent](../results/scent.md)",
    "chemotaxis.approach_weight": "start: arriving is worth more than turning and passing by",
    "noise.sensing": "off. Refused where there is no scent",
    "noise.concentrations": "off",
    "noise.actuation": "off",
    "rig.lag": "off. [The law](plant.md#actuators-and-sensors)",
    "rig.dead_time": "off",
    "rig.rate": "off",
    "rig.resolution": "off",
    "rig.dead_cells": "none",
    "rig.failing_cells": "none",
    "rig.failures": "none",
    "rig.fail_at": "at once, where any fail",
    "rig.sensor_noise": "off. Of no effect where there is no scent, as of all `rig.sensor_*`",
    "rig.sensor_delay": "off",
    "rig.sensor_resolution": "off",
    "rig.sensor_lost": "off",
    "settings.population": "paper",
    "settings.generations": "start: chosen for short runs. The paper has no limit but patience",
    "settings.patience": "paper",
    "settings.elite": "saves",
    "settings.tournament": "start: chosen for short runs, not tested alone. The saves fit 2, the better guess for thousands of generations",
    "settings.layers": "start: 1 is one population in which all compete",
    "settings.age_gap": "start: oscillation is there after a few generations, motion after some ten",
    "settings.niches": "start: 1 is one population in which all compete",
    "settings.founders": "start: random genomes cost little, since three in four do not grow",
    "settings.elongations": "start: 1 is no archive; bodies of random genomes and mutants fill some fifty of the default 72 cells",
    "settings.fillings": "start: the same",
    "settings.redraws": "start: of a champion's mutants one in four keeps its shape",
    "settings.crossover": "paper",
    "settings.point_mutation": "measured: the saves' 0.1 breaks most of what it touches: [mutants](../results/mutants.md)",
    "settings.point_scale": "measured: the saves' 3 breaks most of what it touches: [mutants](../results/mutants.md)",
    "settings.point_decades": "start: [mutants](../results/mutants.md)",
    "settings.duplication": "saves",
    "settings.deletion": "saves",
    "settings.run_length": "saves; lengths are geometric",
    "settings.flip": "start: about 0 in the saves",
    "settings.units": "measured: [oscillation](../results/oscillation.md). Each unit has 1 or 2 regulatory elements and 1 or 2 genes",
    "settings.extent": "measured: [oscillation](../results/oscillation.md)",
    "settings.apart": "start: beyond the reach of affinity, 5, and the extents of both networks",
    "settings.scent_extent": "chemotaxis: measured: [scent](../results/scent.md)",
    "settings.scent_mutation": "chemotaxis: start: one point of some 70 decides: [chemotaxis](chemotaxis.md#where-evolution-begins)",
    "settings.start_share": "start",
}

HEAD = """# Parameters

Every number of the model and of the search, with its default, range, unit and origin. `scripts/parameters.py` writes this page from
`src/evodevo_sim/evodevo_sim/parameters.py` and `src/evodevo_ga/evodevo_ga/settings.py`, and a test holds it against them.

**Set one** by its name: `evolve --set scene.drag_normal=100`, or `with_settings(Task(), {"scene.drag_normal": 100})` in Python. Numbers of
the genetic algorithm are flags, `evolve --tournament 2`, or fields of `Settings`. Messages of the same names carry all of them.

**Origin**: *paper*: the paper says so; *saves*: read in public save files of GReaNs, the paper's system; *measured*: chosen by a study,
which is linked; *start*: a plausible value that nothing has tested, yours to move.
"""


def number(value: object) -> str:
    """A value as people write it, with π where it is a simple part of it."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return f"`{value}`" if value else "empty"
    if value == UNLIMITED and isinstance(value, int):
        return "no limit"
    for name, whole in (("2π", math.tau), ("π", math.pi), ("π/2", math.pi / 2)):
        if abs(value) == whole:
            return MINUS * (value < 0) + name
    if value == 1 / 60:
        return "1/60"
    text = f"{value:,}" if isinstance(value, int) or (value >= 1000 and value == int(value)) else f"{value:g}"
    return re.sub(r"e([+-])0*", lambda sign: "e" + sign[1].strip("+"), text.removesuffix(".0"))


def row(name: str, item: dataclasses.Field) -> str:
    """One line of a table."""
    if "range" in item.metadata:
        low, high = item.metadata["range"]
        limits, unit, meaning = f"{number(low)} to {number(high)}", item.metadata["unit"], item.metadata["meaning"]
    elif "cells" in item.metadata:
        limits, unit, meaning = "0 to 4095 each, as 3,7", "", item.metadata["meaning"]
    else:
        choices = CHOICES.get(name)
        limits = ", ".join(f"`{choice}`" for choice in choices) if choices else "ascending" if name.endswith("_x") else "as many"
        unit, meaning = "" if choices else "m", "" if choices else "points of a profile"
    return f"| `{name}` | {number(item.default)} | {limits} | {unit} | {meaning} | {ORIGINS[name]} |"


def table(prefix: str, cls: type) -> str:
    """Markdown of one class."""
    lines = ["| parameter | default | range | unit | meaning | origin |", "|---|---|---|---|---|---|"]
    lines += [row(prefix + item.name, item) for item in dataclasses.fields(cls) if not dataclasses.is_dataclass(item.default)]
    return "\n".join(lines) + "\n"


def sets() -> str:
    """Named sets of numbers: of tasks, presets and schemes."""
    lines = ["| set | by | numbers |", "|---|---|---|"]

    def line(name: str, by: str, values: dict[str, object]) -> str:
        return f"| `{name}` | `{by}` | " + (", ".join(f"`{key}` {number(value)}" for key, value in values.items()) or "the defaults") + " |"

    for name in TASKS:
        kind = kind_of(name)
        assert kind is not None
        searched = {f"settings.{key}": value for key, value in kind.search.items()}
        lines.append(line(name, f"--task {name}", dict(kind.defaults) | searched))
    lines += [line(name, f"--preset {name}", values) for name, values in PRESETS.items()]
    lines += [
        line(name, f"--scheme {name}", {f"settings.{key}": value for key, value in one.settings.items()}) for name, one in SCHEMES.items()
    ]
    return "\n".join(lines) + "\n"


def page() -> str:
    """The whole page."""
    parts = [HEAD] + [f"## {title}\n\n{table(prefix, cls)}" for title, prefix, cls in TABLES]
    parts.append("## Named sets\n\nWhat a task, a preset or a scheme changes; what is given on its own goes over it.\n\n" + sets())
    return "\n".join(parts)


if __name__ == "__main__":
    Path(sys.argv[1] if len(sys.argv) > 1 else PAGE).write_text(page(), encoding="utf-8")
