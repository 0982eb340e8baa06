"""Work against precision: what each integrator's error costs, swimming, for a soft and a stiff body.

    python benchmarks/physics.py [--quick] [--out DIR]

Error: root mean square over cells of the distance, in cell diameters, from DOP853 at 1e-12 on the same right-hand side after the
same muscles.  Work: force evaluations (the same on every machine) and time (best of rounds that take turns).
Writes work_precision.csv and work_precision.png.
"""

from __future__ import annotations

import argparse
import csv
import time
from pathlib import Path

import matplotlib
import numpy as np
from evodevo_sim.body import build_body
from evodevo_sim.gabriel import adjacency, gabriel_graph
from evodevo_sim.integrators import carry, carry_adaptively, make_system, make_work, set_muscles
from evodevo_sim.physics import Law, accelerations, make_scratch
from evodevo_sim.stability import ADAPTIVE, EULER, INTEGRATORS, RK4, VERLET, bounds
from scipy.integrate import solve_ivp
from tqdm import tqdm

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

STEP = 1 / 60  # s, of control
STUFF = {"soft": (400.0, 10.0), "stiff": (6000.0, 10.0)}  # stiffness and pressure N/m, damping N s/m
COLOURS = dict(zip(INTEGRATORS, ("#d1495b", "#edae49", "#00798c", "#30638e")))
WORK = {"evaluations": "force evaluations per control step", "milliseconds": "ms per simulated second"}
NOTHING = np.zeros(0)


def swimmer(columns, rows, stuff):
    """A slab of cells that a wave runs along."""
    shake = np.random.default_rng(0).normal(0, 0.06, (columns * rows, 2))
    position = np.array([(x + 0.5 * (y % 2), 0.87 * y) for y in range(rows) for x in range(columns)]) + shake
    edges = gabriel_graph(position)
    start, neighbour = np.zeros(len(position) + 1, np.int64), np.empty(2 * len(edges), np.uint32)
    adjacency(edges, len(edges), len(position), start, neighbour)
    body = build_body(position, edges, start, neighbour, 1.0)
    stiffness, damping = stuff
    ones = np.ones(len(position))
    return make_system(
        body, Law(stiffness, damping, stiffness, 100.0, 0.5), drive=(0.4 * ones, ones, -position[:, 0])
    )


def reference(system, seconds):
    cells, scratch = len(system.body.position), make_scratch(system.body)

    def slope(t, y):
        p, v = y.reshape(2, 2, cells)
        out = np.empty((2, cells))
        set_muscles(system, t)
        accelerations(system.body, system.law, system.rest, p, v, scratch, out)
        return np.concatenate((v.ravel(), out.ravel()))

    start = np.concatenate((system.body.position.T.ravel(), np.zeros(2 * cells)))
    return solve_ivp(slope, (0, seconds), start, "DOP853", rtol=1e-12, atol=1e-12).y[: 2 * cells, -1].reshape(2, cells)


def run(system, method, effort, intervals):
    """(position, force evaluations a control step, seconds).  Args: effort: steps in a control step, or the tolerance."""
    p = system.body.position.T.copy()
    v, work, h, evaluations = np.zeros_like(p), make_work(system.body), STEP / 8, 0
    began = time.perf_counter()
    for k in range(intervals):
        if method == ADAPTIVE:
            _, h, used = carry_adaptively(system, k * STEP, STEP, effort, h, p, v, work, NOTHING)
            evaluations += used
        else:
            carry(system, method, k * STEP, STEP, effort, p, v, work, NOTHING)
    seconds = time.perf_counter() - began
    fixed = {EULER: effort, VERLET: effort + 1, RK4: 4 * effort}
    return p, fixed.get(method, evaluations / intervals), seconds


def measure(system, intervals, rounds):
    """Rows of (integrator, effort, evaluations a control step, RMS error, seconds): those that came out finite."""
    exact = reference(system, intervals * STEP)
    efforts = [(m, steps) for m in range(3) for steps in (1, 2, 4, 8, 16, 32, 64)]
    efforts += [(ADAPTIVE, 10.0**-k) for k in range(2, 11)]
    results, best = {}, {}
    for _ in range(rounds):
        for key in tqdm(efforts, leave=False):
            p, evaluations, seconds = run(system, *key, intervals)
            results[key] = evaluations, float(np.sqrt(((p - exact) ** 2).sum(0).mean()))
            best[key] = min(seconds, best.get(key, np.inf))
    return [(INTEGRATORS[m], e, *results[m, e], best[m, e]) for m, e in efforts if results[m, e][1] < 1.0]


def draw(rows, path):
    figure, axes = plt.subplots(2, len(STUFF), figsize=(11, 8), sharey=True, constrained_layout=True)
    for column, name in enumerate(STUFF):
        for row, (quantity, label) in enumerate(WORK.items()):
            axis = axes[row, column]
            for integrator in INTEGRATORS:
                points = [r for r in rows if r["body"] == name and r["integrator"] == integrator]
                x, y = [r[quantity] for r in points], [r["error"] for r in points]
                axis.loglog(x, y, "o-", ms=4, color=COLOURS[integrator], label=integrator)
            axis.set_xlabel(label)
            axis.grid(True, which="major", alpha=0.3)
            if not column:
                axis.set_ylabel("RMS error, cell diameters")
            if not row:
                axis.set_title(f"{name}: h·ω = {next(r['h_omega'] for r in rows if r['body'] == name):.2g} by the bound")
                axis.legend()
    figure.savefig(path, dpi=120)


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--quick", action="store_true", help="a smaller body for a shorter time: half a minute")
    parser.add_argument("--out", default="benchmarks/results", metavar="DIR", help="(default %(default)s)")
    given = parser.parse_args()
    columns, rows, intervals, rounds = (6, 4, 120, 2) if given.quick else (16, 4, 1000, 3)
    table = []
    for name, stuff in STUFF.items():
        system = swimmer(columns, rows, stuff)
        run(system, RK4, 1, 1), run(system, ADAPTIVE, 1e-3, 1)  # compiled
        for integrator, effort, evaluations, error, seconds in measure(system, intervals, rounds):
            table.append({
                "body": name, "cells": columns * rows, "h_omega": STEP * bounds(system)[0], "integrator": integrator,
                "effort": effort, "evaluations": evaluations, "error": error, "milliseconds": 1e3 * seconds / (intervals * STEP),
            })
    out = Path(given.out)
    out.mkdir(parents=True, exist_ok=True)
    with open(out / "work_precision.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, table[0].keys())
        writer.writeheader()
        writer.writerows(table)
    draw(table, out / "work_precision.png")
    for name in STUFF:
        print(f"{name}: least force evaluations a control step for an error of")
        for most in (1e-2, 5e-3, 1e-3, 1e-4, 1e-6):
            good = [r for r in table if r["body"] == name and r["error"] <= most]
            if good:
                best = min(good, key=lambda r: r["evaluations"])
                print(f"  {most:g}: {best['evaluations']:.3g} by {best['integrator']}")
    print(f"Wrote {out / 'work_precision.csv'} and {out / 'work_precision.png'}")


if __name__ == "__main__":
    main()
