#!/usr/bin/env python
"""Work against precision: what each integrator's error costs, in every scene.

    python benchmarks/work_precision.py [--quick] [--out DIR]

Error: root mean square over cells of the distance, in cell diameters, from a reference after the same muscles.  Reference of swim
and free: DOP853 at 1e-12 on the same right-hand side.  Of walk, whose contacts are not smooth and which symplectic Euler alone
integrates: the same method in many more steps, over a horizon too short for chaos.  Work: force evaluations (the same on every
machine) and time (best of rounds that take turns).  SciPy's RK23, BDF and Radau are there to show why they are not in the library:
their evaluations only, since their time is Python's; an LU counts as the evaluations that it takes as long as.
"""

from __future__ import annotations

import numpy as np
from common import FULL, STEP, TINY, Figure, best, main, plt, race, save, slab, write_csv
from evodevo_sim.physics.bounds import bounds
from evodevo_sim.physics.forces import Law
from evodevo_sim.physics.integrators import make_system, make_work
from evodevo_sim.physics.step_size import ADAPTIVE, EULER, INTEGRATORS, LAWSON, RK4, VERLET
from kernels import travel
from matplotlib.ticker import NullFormatter
from outsiders import OUTSIDERS, outside, reference
from tqdm import tqdm

PART = "work-precision"
# (stiffness and pressure N/m, damping N s/m, drag across and along kg/m^2); gravity 9.81 m/s^2 and friction 0.8 in walk
SCENES = {
    "swim": (400.0, 10.0, 40.0, 0.2), "swim, stiff": (6000.0, 10.0, 40.0, 0.2), "free": (400.0, 10.0, 0.0, 0.0),
    "walk": (400.0, 10.0, 0.0, 0.0),
}
STEPS = (1, 2, 4, 8, 16, 32, 64)
OURS = (*INTEGRATORS, "lawson")  # the last is that of swimmers
COLOURS = dict(zip((*OURS, *OUTSIDERS), ("#d1495b", "#edae49", "#00798c", "#30638e", "#2a9d4e", "#999999", "#b07aa1", "#9c755f")))
WORST = 0.5  # cell diameters: an error beyond says no more than that it is wrong


def make_scene(name, columns, rows):
    """A slab of cells that a wave runs along, in its scene."""
    body, (stiffness, damping, across, along) = slab(columns, rows), SCENES[name]
    if name == "walk":  # its lowest cell touches the ground
        body.position[:, 1] -= body.position[:, 1].min()
    ones = np.ones(len(body.position))
    drive = 0.4 * ones, ones, -body.position[:, 0]
    walks = {"gravity": 9.81, "friction": 0.8, "ground": True} if name == "walk" else {}
    return make_system(body, Law(stiffness, damping, stiffness, across, along, 0.2), drive=drive, **walks)


def run(effort, out):
    columns, rows, seconds, rounds = ((4, 3, 0.2, 1), (8, 4, 2.0, 2), (16, 4, 1000 * STEP, 2))[effort]
    table, figures = [], []
    for name in SCENES:
        system = make_scene(name, columns, rows)
        walks = name == "walk"
        intervals = min(60, round(seconds / STEP)) if walks else round(seconds / STEP)
        efforts = [(m, steps) for m in ((EULER,) if walks else (EULER, VERLET, RK4, LAWSON)) for steps in STEPS]
        efforts += [] if walks else [(ADAPTIVE, 10.0**-k) for k in range(2, 11)]
        if walks:
            most = 64 * STEPS[-1] if effort == FULL else 8 * STEPS[-1]
            exact = go(system, EULER, most, intervals)[0]
            apart = rms(go(system, EULER, most // 2, intervals)[0], exact)
            figures.append(Figure(PART, "walk: the reference, and the same in half its steps, differ by", f"{apart:.1e} m"))
        else:
            exact = reference(system, intervals * STEP)
        found = {key: go(system, *key, intervals) for key in tqdm(efforts, desc=f"{name}: errors", leave=False)}
        errors = {key: rms(p, exact) for key, (p, _) in found.items()}
        good = [key for key in efforts if errors[key] < WORST]
        seconds_of = best(race({key: timer(system, *key, intervals) for key in good}, rounds, f"{name}: times"))
        about = {"scene": name, "cells": columns * rows, "control_steps": intervals, "h_omega": STEP * bounds(system)[0]}
        table += [
            {**about, "integrator": OURS[m], "effort": e, "evaluations": found[m, e][1] / intervals, "error": errors[m, e],
             "milliseconds": 1e3 * seconds_of[m, e] / (intervals * STEP)}
            for m, e in good
        ]
        if name.startswith("swim"):
            for one in outside(system, intervals, effort, f"{name}: outsiders"):
                error = rms(one.pop("position"), exact)
                if error < WORST:
                    table.append({**about, **one, "error": error, "milliseconds": ""})
        figures += conclusions(table, name)
    write_csv(out / "work_precision.csv", table)
    if effort > TINY:
        draw(table, out / "work_precision.png")
    return figures


def go(system, method, effort, intervals):
    """(position, force evaluations).  Args: effort: steps in a control step, or the tolerance."""
    p = system.body.position.T.copy()
    used = travel(system, method, float(effort), STEP, intervals, p, np.zeros_like(p), make_work(system.body))
    each = {EULER: effort, VERLET: effort + 1, RK4: 4 * effort, LAWSON: 6 * effort}.get(method, 0)
    if system.ground:
        each += 2  # velocities are shifted to the middle of a step, and back
    return p, used + each * intervals


def timer(system, method, effort, intervals):
    return lambda: go(system, method, effort, intervals)


def rms(position, exact):
    """m, or infinity where the run blew up."""
    error = np.sqrt(((position - exact) ** 2).sum(0).mean())
    return float(error) if np.isfinite(error) else np.inf


def conclusions(table, name):
    """The least work for some errors, ours against the others'."""
    figures = []
    for most in (5e-3, 1e-4, 1e-6):
        good = [r for r in table if r["scene"] == name and r["error"] <= most]
        ours = min((r for r in good if r["integrator"] in OURS), key=lambda r: r["evaluations"], default=None)
        if ours:
            text = f"{ours['evaluations']:.3g} by {ours['integrator']}"
            others = []
            for outsider in (*OUTSIDERS, *(f"{one} across" for one in OUTSIDERS)):
                least = min((r["evaluations"] for r in good if r["integrator"] == outsider), default=None)
                others += [f"{outsider} {least / ours['evaluations']:.3g}"] if least else []
            text += f"; times as many: {', '.join(others)}" if others else ""
            figures.append(Figure(PART, f"{name}: least force evaluations a control step for an error of {most:g}", text))
    return figures


def draw(table, path):
    work = {"evaluations": "force evaluations per control step", "milliseconds": "ms per simulated second"}
    figure, axes = plt.subplots(2, len(SCENES), figsize=(15, 7.5), sharey=True, constrained_layout=True)
    for column, name in enumerate(SCENES):
        mine = [r for r in table if r["scene"] == name]
        for row, (quantity, label) in enumerate(work.items()):
            axis = axes[row, column]
            for integrator in (*OURS, *OUTSIDERS, *(f"{one} across" for one in OUTSIDERS)):
                points = [r for r in mine if r["integrator"] == integrator and r[quantity] != ""]
                line = "o:" if integrator.endswith("across") else "o--" if integrator in OUTSIDERS else "o-"
                x, y = [r[quantity] for r in points], [r["error"] for r in points]
                if not points:
                    continue
                axis.loglog(x, y, line, ms=3.5, lw=1.2, color=COLOURS[integrator.removesuffix(" across")], label=integrator)
            axis.set_xlabel(label)
            if name == "walk":
                axis.xaxis.set_minor_formatter(NullFormatter())
            axis.grid(True, which="major", alpha=0.3)
            if not row and mine:
                axis.set_title(f"{name}: {mine[0]['control_steps']} control steps, h·ω = {mine[0]['h_omega']:.2g}", fontsize=10)
        axes[0, column].legend(fontsize=7)
    for axis in axes[:, 0]:
        axis.set_ylabel("RMS error, cell diameters")
    save(figure, path)


if __name__ == "__main__":
    main(run, __doc__)
