#!/usr/bin/env python
"""What a force evaluation and a Gabriel graph cost, by the number of cells, against plain C and against SciPy.

    python benchmarks/cost.py [--quick] [--out DIR]

Forces: springs, damping, chambers and drag, float64, against the same loop in C (forces.c), compiled here without fast-math in two
ways of writing and two sets of flags, of which the fastest counts.  Graphs: from nothing, kept up to date while all cells move 2 mm a
step, which is what most steps of growth do, and by SciPy's Delaunay triangulation.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from c_forces import caller, compiled
from common import TINY, Figure, best, blob, default_law, main, moving, plt, race, save, slope, write_csv
from evodevo_sim.development.gabriel import gabriel_graph
from evodevo_sim.physics.forces import make_scratch
from kernels import many_accelerations, many_graphs
from scipy.spatial import Delaunay, cKDTree

PART = "cost"
ASKED_RATE, ASKED_RATIO = 700_000, 1.5
MOVE = 2e-3  # m
LARGE = 256  # cells, from which on the growth of a graph's cost is judged
FOLLOWED = 1024  # cells of the largest graph that is followed here: what is kept grows as their square
VARIED = 20_000  # cells of the bodies whose graphs are made in a turn of the clock
BATCH = 200_000  # cell updates in a turn of the clock
COLOURS = {"evodevo": "#d1495b", "cc -O3": "#8d99ae", "cc -O3 -march=native": "#00798c"}


def force_costs(sizes, rounds, libraries):
    """Rows of nanoseconds per force evaluation, by cells; the C versions must give the same accelerations."""
    law, table = default_law(), []
    for cells in sizes:
        body = blob(cells)
        position, velocity, rest = moving(body)
        calls = max(10, BATCH // cells)
        out, scratch = np.empty_like(position), make_scratch(body)
        actions = {"evodevo": lambda: many_accelerations(body, law, rest, position, velocity, scratch, out, calls)}  # noqa: B023  (called within its round)
        outs = {}
        for flags, library in libraries.items():
            for way in ("plain", "passes"):
                name = f"{flags}, {way}"
                actions[name], outs[name] = caller(library, way == "passes", body, law, rest, position, velocity, calls)
        seconds = best(race(actions, rounds, f"forces of {cells} cells"))
        for name, other in outs.items():
            if not np.allclose(other, out, rtol=1e-12, atol=1e-10):
                raise AssertionError(f"{name}: other accelerations than evodevo_sim's")
        row = {"cells": cells, "springs": rest.size, "chambers": body.triangle_area.size + body.polygon_area.size}
        row |= {f"{name}, ns": 1e9 * value / calls for name, value in seconds.items()}
        row |= {"same bits as C in passes": all(np.array_equal(outs[n], out) for n in outs if n.endswith("passes"))} if outs else {}
        if outs:
            row["ratio"] = seconds["evodevo"] / min(seconds[name] for name in outs)
        table.append(row)
    return table


def delaunay_gabriel(position):
    """Edges (E, 2) of the Gabriel graph, i < j, ascending: those of SciPy's triangulation whose circle is empty."""
    faces = Delaunay(position).simplices
    edges = np.unique(np.sort(np.vstack((faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]])), axis=1), axis=0)
    ends = position[edges]
    radius = 0.5 * np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)
    nearest = cKDTree(position).query(ends.mean(axis=1), k=3)[0][:, 2]  # the two ends are the others
    return edges[nearest > radius * (1 + 1e-12)]


def graph_costs(sizes, rounds):
    """Rows of microseconds per Gabriel graph, by cells."""
    table = []
    for cells in sizes:
        position = blob(cells).position
        if not np.array_equal(gabriel_graph(position), delaunay_gabriel(position)):
            raise AssertionError(f"{cells} cells: another Gabriel graph by SciPy")
        calls = max(200, 20_000 // cells)
        angle = np.random.default_rng(cells).uniform(0, 2 * np.pi, (50, cells))
        moves = MOVE * np.stack((np.cos(angle), np.sin(angle)), axis=2)
        edges, spare = np.empty((3 * cells + 1, 2), np.int64), np.empty((3 * cells + 1, 2), np.int64)
        kept = np.empty(cells), np.zeros((min(cells, FOLLOWED),) * 2, np.int32), edges, spare
        few = max(4, VARIED // cells)
        # Of one body alone the processor would learn every turn that its search takes, the better the smaller it is.
        varied = position + np.random.default_rng(0).normal(0.0, 0.1, (few, cells, 2))

        def fresh():
            for one in varied:  # noqa: B023  (called within its round)
                gabriel_graph(one)

        actions = {
            "from nothing": (few, fresh),
            "followed": (calls, lambda: many_graphs(position.copy(), moves, *kept, calls)),  # noqa: B023  (called within its round)
            "SciPy Delaunay": (1, lambda: delaunay_gabriel(position)),  # noqa: B023  (called within its round)
        }
        if cells > FOLLOWED:
            del actions["followed"]
        seconds = best(race({name: action for name, (_, action) in actions.items()}, rounds, f"graphs of {cells} cells"))
        table.append({"cells": cells} | {f"{name}, us": 1e6 * seconds[name] / actions[name][0] for name in actions})
    return table


def run(effort, out):
    sizes = ((8, 64), (8, 64, 256, 1024), (8, 16, 32, 64, 128, 256, 512, 1024))[effort]
    rounds = (2, 7, 25)[effort]
    with tempfile.TemporaryDirectory() as directory:
        libraries = compiled(Path(directory))
        forces = force_costs(sizes, rounds, libraries)
    graphs = graph_costs((*sizes, 2048, 4096) if effort > TINY else sizes, (1, 3, 5)[effort])
    write_csv(out / "force_cost.csv", forces)
    write_csv(out / "graph_cost.csv", graphs)
    if effort > TINY:
        draw(forces, graphs, out / "cost.png")
    return conclusions(forces, graphs, bool(libraries))


def conclusions(forces, graphs, with_c):
    at = next(row for row in forces if row["cells"] == 64)
    rate = 1e9 / at["evodevo, ns"]
    figures = []
    if with_c:
        fastest = min((name for name in at if name.startswith("cc ") and name.endswith(", ns")), key=at.get)
        ratios, same = [row["ratio"] for row in forces], at["same bits as C in passes"]
        what = f"64 cells, {at['springs']} springs: time of our force evaluation over the fastest C's ({fastest.removesuffix(', ns')})"
        figures.append(Figure(
            PART, what, f"{at['ratio']:.2f} times; same bits as C in passes: {same}", f"<= {ASKED_RATIO}", at["ratio"] <= ASKED_RATIO,
        ))
        figures.append(Figure(PART, "all sizes: the same", f"{min(ratios):.2f} to {max(ratios):.2f} times"))
    else:
        figures.append(Figure(PART, "C yardstick", "no cc here, skipped: apt install gcc"))
    text = f"{rate:,.0f} a second" + (f"; C: {1e9 / at[fastest]:,.0f}" if with_c else "")
    figures.append(Figure(PART, "64 cells: force evaluations on this machine", text, f">= {ASKED_RATE:,}", rate >= ASKED_RATE))
    large = [row for row in forces if row["cells"] >= 32]
    if len(large) > 2:
        power = slope([r["cells"] for r in large], [r["evodevo, ns"] for r in large])
        figures.append(Figure(PART, "force evaluation: grows as N to the power of", f"{power:.2f}", "<= 1.1", power <= 1.1))
        for name, asked in (("from nothing", True), ("SciPy Delaunay", False)):
            rows = [row for row in graphs if row["cells"] >= LARGE]
            power = slope([r["cells"] * np.log(r["cells"]) for r in rows], [r[f"{name}, us"] for r in rows])
            what = f"Gabriel graph, {name}, of {LARGE} cells and more: grows as N log N to the power of"
            figures.append(Figure(PART, what, f"{power:.2f}", *(("<= 1.1", power <= 1.1) if asked else ())))
        rows = [row for row in graphs if LARGE <= row["cells"] <= FOLLOWED]
        power = slope([r["cells"] for r in rows], [r["followed, us"] for r in rows])
        figures.append(Figure(PART, f"Gabriel graph, followed, of {LARGE} to {FOLLOWED} cells: grows as N to the power of", f"{power:.2f}"))
    for cells in (64, 1024):
        for row in graphs:
            if row["cells"] == cells:
                gain = row["SciPy Delaunay, us"] / row["from nothing, us"]
                kept = row["SciPy Delaunay, us"] / row["followed, us"]
                text = f"{gain:.3g} from nothing, {kept:.3g} followed: {row['from nothing, us']:.3g} and {row['followed, us']:.3g} µs"
                figures.append(Figure(PART, f"{cells} cells: SciPy's time for a graph over ours", text))
    return figures


def draw(forces, graphs, path):
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.5), constrained_layout=True)
    cells = [row["cells"] for row in forces]
    for name in [key for key in forces[0] if key.endswith(", ns")]:
        colour = next(COLOURS[key] for key in reversed(COLOURS) if name.startswith(key))
        line, each = "o:" if "plain" in name else "o-", [row[name] / row["cells"] for row in forces]
        left.loglog(cells, each, line, color=colour, ms=4, label=name.removesuffix(", ns"))
    left.set(xlabel="cells", ylabel="ns per force evaluation and cell", title="Forces: level where O(N)", ylim=(5, 100))
    for name, colour in zip([key for key in graphs[0] if key != "cells"], ("#d1495b", "#edae49", "#30638e")):
        rows = [row for row in graphs if name in row]
        right.loglog([row["cells"] for row in rows], [row[name] for row in rows], "o-", ms=4, color=colour, label=name.removesuffix(", us"))
    large, most = np.array([LARGE, graphs[-1]["cells"]]), graphs[-1]["cells"]
    for name in ("SciPy Delaunay, us", "from nothing, us"):
        scale = graphs[-1][name] / (most * np.log(most))
        right.loglog(large, scale * large * np.log(large), "k:", lw=1, label="N log N" if name.startswith("SciPy") else None)
    right.loglog(large, graphs[-1]["from nothing, us"] * (large / most) ** 2, "k--", lw=1, label="N²")
    right.set(xlabel="cells", ylabel="µs per graph", title="Gabriel graph")
    for axis in (left, right):
        axis.grid(True, which="major", alpha=0.3)
        axis.legend(fontsize=8)
    save(figure, path)


if __name__ == "__main__":
    main(run, __doc__)
