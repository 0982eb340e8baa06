"""Evaluations whose bits are kept: what `test_kept_bits.py` looks at, and how its values are made.

    python tests/kept.py > tests/kept.json      # where bits change for a reason, which CHANGELOG.md tells
"""

import dataclasses
import json
import sys
from pathlib import Path

import numpy as np
from evodevo_sim.genetics.genome_file import UNSAID
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.worlds import with_world
from genomes import beating, dividing, pulsing, ring

from evodevo_sim import evaluate, load_genome, random_genome, read_genome

ROOT = Path(__file__).resolve().parents[1]
NOISE = {"noise.concentrations": 0.01, "noise.actuation": 0.05}
SHORT = {"control_steps": 400}
VARIANT_A = {"development.variant": "graph_at_end"}
LAW = {f"development.{name}": value for name, value in UNSAID.items()}  # by which the champions were bred


def genome(name):
    """A genome by name: of a shipped champion, a recorded run, a hand-made one, or `random N`."""
    made = {"beating": beating, "dividing": dividing, "pulsing": pulsing, "ring": ring}
    if name in made:
        return made[name]()
    if name.startswith("random "):
        return random_genome(np.random.default_rng(int(name.split()[1])))
    folder = ROOT / "bags" / name
    return load_genome(folder / "champion.yaml" if folder.is_dir() else ROOT / "src/evodevo_sim/champions" / f"{name}.yaml")


def law(name):
    """By which a genome of that name was bred."""
    folder = ROOT / "bags" / name
    return read_genome(folder / "champion.yaml").growth if folder.is_dir() else LAW


def swim(**settings):
    return with_settings(default_task("swim"), LAW | settings)


def walk(world="flat", **settings):
    return with_world(with_settings(default_task("walk"), {"starts": 2, **LAW, **SHORT, **settings}), world)


def chemotaxis(**settings):
    return with_settings(default_task("chemotaxis"), LAW | settings)


def cases():
    """(name, genome, task, seed) of each."""
    cells = "development.max_cells"
    for name in ("undulator", "ribbon", "peristalsis", "jellyfish", "sample-swim"):
        yield f"swim {name}", genome(name), swim(**law(name)), 0
    yield "swim undulator of 64 cells", genome("undulator"), swim(**{cells: 64}), 0
    yield "swim pulsing of 8 cells", pulsing(), swim(**{cells: 8}), 0
    yield "swim pulsing of 16 cells", pulsing(), swim(**{cells: 16}), 0
    yield "swim ring rests in no step", ring(), swim(**SHORT), 0
    yield "swim beating in high drag", beating(), swim(**{"scene.drag_normal": 400.0, "scene.drag_tangential": 2.0}), 0
    yield "swim ribbon in low drag", genome("ribbon"), swim(**{"scene.drag_normal": 10.0, "scene.drag_tangential": 0.05}), 0
    yield "swim stiff", genome("undulator"), swim(**{"material.stiffness": 4000.0, **SHORT}), 0
    yield "swim with noise", genome("peristalsis"), swim(**NOISE), 3
    for k in range(6):
        yield f"swim random {k}", genome(f"random {k}"), swim(), 0
    yield "swim dividing rests", dividing(), swim(), 0
    yield "swim of two cells has no chamber", dividing(), swim(**{cells: 2}), 0
    yield "swim too stiff", genome("undulator"), swim(**{"material.stiffness": 1e9, "material.mass": 1e-6}), 0
    yield "swim inverts", genome("jellyfish"), swim(**{"material.pressure": 0.0}), 0
    yield "variant A pulsing", pulsing(), swim(**VARIANT_A), 0
    yield "variant A ring of 12 cells", ring(), swim(**VARIANT_A, **{cells: 12}), 0
    yield "variant A dividing of 64 cells", dividing(), swim(**VARIANT_A, **{cells: 64}), 0
    yield "variant A walk", pulsing(), walk(**VARIANT_A), 5
    for name in ("walker", "jumper", "sample-walk"):
        yield f"walk {name}", genome(name), walk(**law(name)), 1
    yield "walk with noise", genome("walker"), walk(**NOISE), 4
    yield "walk over steps", genome("jumper"), walk("steps"), 2
    yield "walk over rough ground", genome("walker"), walk("rough"), 3
    yield "walk of 64 cells", genome("walker"), walk(**{cells: 64}), 0
    yield "walk inverts", genome("jumper"), walk(**{"material.pressure": 0.0}), 0
    yield "walk never settles", pulsing(), walk(settling_limit=5), 0
    yield "walk without room", dividing(), low_ceiling(walk()), 0
    for name in ("seeker", "sample-chemotaxis"):
        yield f"chemotaxis {name}", genome(name), chemotaxis(**law(name)), 0
    yield "chemotaxis with noise", genome("seeker"), chemotaxis(**NOISE, **{"noise.sensing": 0.2}), 2
    yield "chemotaxis random 2", genome("random 2"), chemotaxis(), 0


def low_ceiling(task):
    """A task below a ceiling under which no body stands."""
    scene = dataclasses.replace(task.scene, ceiling_x=(-100.0, 100.0), ceiling_y=(1.5, 1.5))
    return dataclasses.replace(task, scene=scene)


def bits(evaluation):
    """An evaluation as text: fitness and distance to the last bit, status by name, size of the body."""
    m = evaluation.metrics
    return [float(evaluation.fitness).hex(), float(m.distance).hex(), evaluation.status.name, m.cells, m.springs, m.chambers]


if __name__ == "__main__":
    table = {name: bits(evaluate(animal, task, seed)) for name, animal, task, seed in cases()}
    rows = ",\n".join(f"{json.dumps(name)}: {json.dumps(row)}" for name, row in table.items())
    sys.stdout.write("{\n" + rows + "\n}\n")
