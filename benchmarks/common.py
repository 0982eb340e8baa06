"""What the parts of `make bench` share: their command line, clocks that take turns, bodies, tables and pictures."""

from __future__ import annotations

import argparse
import csv
import io
import platform
import time
from collections import namedtuple
from pathlib import Path

import matplotlib
import numpy as np
from evodevo_sim.development.body import build_body
from evodevo_sim.development.gabriel import adjacency, gabriel_graph
from evodevo_sim.physics.forces import Law, make_law
from PIL import Image
from rich.console import Console
from rich.table import Table
from tqdm import tqdm

from evodevo_sim import Material, Scene, Task, read_genome

matplotlib.use("Agg")
import matplotlib.pyplot as plt

CHAMPION = Path(__file__).resolve().with_name("swimmer.yaml")  # seed 3 after 50 generations of one population; it grows to any limit
STEP = 1 / 60  # s, of control
TINY, QUICK, FULL = range(3)  # tests; --quick; the figures of docs/results/benchmarks.md

# What a part found.  measured: text; asked: text, or nothing; met: True, False, or None where nothing is asked.
Figure = namedtuple("Figure", "part what measured asked met", defaults=("", None))


def champion():
    return read_genome(CHAMPION).genome


def champion_task(**settings) -> Task:
    """To swim, with growth as the champion was bred with."""
    return read_genome(CHAMPION).task(settings=settings)


def default_law() -> Law:
    material, scene = Material(), Scene()
    return make_law(material.arguments(), scene.arguments())


def body_of(position, mass=1.0):
    """The body of the Gabriel graph of cells at position (N, 2)."""
    edges = gabriel_graph(position)
    start, neighbour = np.zeros(len(position) + 1, np.int64), np.empty(2 * len(edges), np.uint32)
    adjacency(edges, len(edges), len(position), start, neighbour)
    return build_body(position, edges, start, neighbour, mass)


def scattered(columns, rows, seed=0):
    """Positions (N, 2) like those that growth leaves: a hexagonal slab, shaken a little."""
    shake = np.random.default_rng(seed).normal(0, 0.06, (columns * rows, 2))
    return np.array([(x + 0.5 * (y % 2), 0.87 * y) for y in range(rows) for x in range(columns)]) + shake


def slab(columns, rows, seed=0):
    return body_of(scattered(columns, rows, seed))


def blob(cells, seed=0):
    """The body of a slab that is about as long as wide.  Args: cells: a power of 2."""
    rows = 2 ** (int(cells).bit_length() // 2)
    return slab(cells // rows, rows, seed)


def moving(body, seed=0):
    """(position, velocity (2, N), rest lengths (E,)) of a body in the middle of a swim, so to say."""
    rng = np.random.default_rng(seed)
    position = body.position.T + 0.02 * rng.standard_normal(body.position.T.shape)
    velocity = 0.1 * rng.standard_normal(position.shape)
    return position, velocity, body.rest_length * rng.uniform(0.9, 1.1, body.rest_length.size)


def race(actions: dict, rounds: int, note: str) -> dict:
    """CPU seconds of every action in every round, {name: (rounds,)}: they take turns, in both orders, after one go to warm up.

    CPU time of this thread: what else the machine does disturbs it less.  Compare by `best`, or round by round.
    """
    for action in actions.values():
        action()
    seconds = {name: [] for name in actions}
    for k in tqdm(range(rounds), desc=note, leave=False):
        for name in list(actions)[:: 1 if k % 2 else -1]:
            began = time.thread_time()
            actions[name]()
            seconds[name].append(time.thread_time() - began)
    return {name: np.array(values) for name, values in seconds.items()}


def best(seconds: dict) -> dict:
    return {name: float(values.min()) for name, values in seconds.items()}


def slope(sizes, values) -> float:
    """The exponent of a power law through the values, by least squares of logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(values), 1)[0])


def write_csv(path: Path, rows: list[dict]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, dict.fromkeys(name for row in rows for name in row))
        writer.writeheader()
        writer.writerows(rows)


def save(figure, path: Path) -> None:
    """Write a PNG of few colours, which is small enough for a repository."""
    path.parent.mkdir(parents=True, exist_ok=True)
    picture = io.BytesIO()
    figure.savefig(picture, dpi=90)
    plt.close(figure)
    Image.open(picture).convert("RGB").quantize(128).save(path, optimize=True)


def show(figures: list[Figure]) -> None:
    table = Table(title=f"Measured on {platform.processor() or platform.machine()}, one core unless said")
    for column in ("part", "what", "measured", "asked"):
        table.add_column(column, overflow="fold")
    for one in figures:
        mark = {True: "[green]met[/green] ", False: "[red]not met[/red] ", None: ""}[one.met]
        table.add_row(one.part, one.what, one.measured, mark + one.asked)
    Console().print(table)


def options(description: str):
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="smaller sizes, fewer repeats: for a look, not for figures")
    parser.add_argument("--out", type=Path, default=Path("benchmarks/results"), metavar="DIR", help="(default %(default)s)")
    return parser


def main(run, description: str) -> None:
    """A part as a script.  Args: run: (effort, directory) -> figures."""
    given = options(description).parse_args()
    show(run(QUICK if given.quick else FULL, given.out))
    print(f"Wrote CSV and PNG to {given.out}")
