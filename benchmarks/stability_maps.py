#!/usr/bin/env python
"""Stability maps: which steps let a small displacement grow, run and predicted, for stiffness, damping and pressure.

    python benchmarks/stability_maps.py [--quick] [--out DIR]

Every point is a run of a small body at rest, displaced by 1e-7 m, in one method: it is unstable where that grows ten thousand
times.  Lines: the step at which an eigenvalue of the linearised step leaves the unit circle (theory), and the longest step that
`evodevo_sim.physics.step_size` allows by its bounds, before its safety factor.
"""

from __future__ import annotations

import numpy as np
from common import TINY, Figure, body_of, main, plt, save, scattered, write_csv
from evodevo_sim.physics.bounds import bounds
from evodevo_sim.physics.forces import Law, accelerations, make_scratch
from evodevo_sim.physics.integrators import make_system, make_work
from evodevo_sim.physics.step_size import EULER, INTEGRATORS, RK4, VERLET, longest_step
from kernels import grows
from tqdm import tqdm

PART = "stability"
BASE = {"stiffness": 400.0, "damping": 1.0, "pressure": 400.0}
AXES = {"stiffness": (20.0, 2e4), "damping": (0.1, 300.0), "pressure": (20.0, 2e4)}  # N/m, N s/m, N/m
STEPS = (2e-3, 0.2)  # s
PUSH, MOST = 1e-7, 1e-3  # m: displaced, and grown
CHUNK = 50  # steps between looks, where Verlet starts anew
SLACK = 1e-4  # of the spectral radius, for the eigenvalues of 1 of free motion, which come in Jordan blocks


def system_of(body, **changes):
    values = {**BASE, **changes}
    return make_system(body, Law(values["stiffness"], values["damping"], values["pressure"], 0.0, 0.0, 0.2))


def linearised(system):
    """(K, C), (2 N, 2 N) each, of x'' = -K x - C x' about rest, by central differences."""
    body, size = system.body, 2 * len(system.body.position)
    scratch, rest, still = make_scratch(body), body.position.T.copy(), np.zeros((2, size // 2))
    matrices = []
    for of_velocity in (False, True):
        columns = []
        for k in range(size):
            push = np.zeros(size)
            push[k] = 1e-6
            push = push.reshape(2, -1)
            ends = []
            for sign in (1, -1):
                out = np.empty_like(still)
                p, v = (rest, still + sign * push) if of_velocity else (rest + sign * push, still)
                accelerations(body, system.law, system.rest, p, v, scratch, out)
                ends.append(out.ravel())
            columns.append((ends[1] - ends[0]) / 2e-6)
        matrices.append(np.array(columns).T)
    return matrices


def radius(method, k, c, h):
    """Spectral radius of one step of h seconds, as a linear map of (x, v), for Verlet of (x, v, a)."""
    one, nil = np.eye(len(k)), np.zeros_like(k)
    if method == EULER:
        v = np.hstack((-h * k, one - h * c))
        step = np.vstack((np.hstack((one, nil)) + h * v, v))
    elif method == VERLET:
        x = np.hstack((one, h * one, 0.5 * h * h * one))
        a = -k @ x - c @ np.hstack((nil, one, h * one))
        step = np.vstack((x, np.hstack((nil, one, 0.5 * h * one)) + 0.5 * h * a, a))
    else:
        z = np.linalg.eigvals(h * np.block([[nil, one], [-k, -c]]))
        return abs(1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24).max()
    return abs(np.linalg.eigvals(step)).max()


def limit(method, k, c, low, high):
    """The step, s, at which theory's radius leaves 1, between two of which only the first is stable."""
    while high / low > 1.001:
        middle = np.sqrt(low * high)
        if radius(method, k, c, middle) > 1 + SLACK:
            high = middle
        else:
            low = middle
    return low


def measure(body, name, method, values, steps, chunks, bar):
    """Rows of one map, and of its lines."""
    push = PUSH * np.random.default_rng(1).standard_normal(body.position.T.shape)
    points, lines = [], []
    for value in values:
        system = system_of(body, **{name: value})
        work = make_work(body)
        k, c = linearised(system)
        bound = longest_step(method, *bounds(system))
        lines.append((value, limit(method, k, c, 0.5 * bound, 4 * bound), bound))
        for h in steps:
            unstable = grows(system, method, h, chunks, CHUNK, body.position.T + push, MOST, work)
            points.append({"of": name, "value": value, "integrator": INTEGRATORS[method], "step": h, "unstable": unstable,
                           "theory": lines[-1][1], "bound": bound})
        bar.update()
    return points, lines


def run(effort, out):
    rows, columns, chunks = ((2, 5, 10), (12, 20, 12), (30, 45, 20))[effort]
    body, steps = body_of(scattered(4, 3)), np.geomspace(*STEPS, columns)
    table, lines = [], {}
    with tqdm(total=9 * rows, desc="stability maps", leave=False) as bar:
        for method in (EULER, VERLET, RK4):
            for name, ends in AXES.items():
                points, lines[name, method] = measure(body, name, method, np.geomspace(*ends, rows), steps, chunks, bar)
                table += points
    write_csv(out / "stability.csv", table)
    if effort > TINY:
        draw(table, lines, rows, columns, out / "stability.png")
    figures = []
    for method in (EULER, VERLET, RK4):
        mine = [r for r in table if r["integrator"] == INTEGRATORS[method]]
        wrong = [r for r in mine if r["unstable"] != (r["step"] > r["theory"])]
        farthest = max((abs(np.log(r["step"] / r["theory"])) for r in wrong), default=0.0)
        text = f"{len(wrong)} of {len(mine)}, at most {100 * np.expm1(farthest):.1f} % in step from the line"
        figures.append(Figure(PART, f"{INTEGRATORS[method]}: runs on the other side of theory's line", text))
        unsafe = sum(r["unstable"] for r in mine if r["step"] <= r["bound"])
        spare = [theory / bound for key in lines if key[1] == method for _, theory, bound in lines[key]]
        text = f"{unsafe} grew; theory allows {min(spare):.2f} to {max(spare):.2f} times the bound's step"
        figures.append(Figure(PART, f"{INTEGRATORS[method]}: runs within the bound", text, "none grows", unsafe == 0))
    return figures


def draw(table, lines, rows, columns, path):
    figure, axes = plt.subplots(3, 3, figsize=(11, 9), constrained_layout=True, sharex=True)
    for row, name in enumerate(AXES):
        for column, method in enumerate((EULER, VERLET, RK4)):
            axis = axes[row, column]
            mine = [r for r in table if r["of"] == name and r["integrator"] == INTEGRATORS[method]]
            steps, values = [1e3 * r["step"] for r in mine[:columns]], [r["value"] for r in mine[::columns]]
            grown = np.reshape([r["unstable"] for r in mine], (rows, columns))
            axis.pcolormesh(steps, values, grown, cmap="RdYlGn_r", vmin=-0.3, vmax=1.3, shading="nearest", rasterized=True)
            value, theory, bound = np.array(lines[name, method]).T
            axis.plot(1e3 * theory, value, "k-", label="theory: eigenvalues")
            axis.plot(1e3 * bound, value, "k--", label="bound of the library")
            axis.set(xscale="log", yscale="log", xlim=(1e3 * STEPS[0], 1e3 * STEPS[1]))
            if not row:
                axis.set_title(INTEGRATORS[method])
            if row == 2:
                axis.set_xlabel("step, ms")
            if not column:
                axis.set_ylabel(f"{name}, {'N s/m' if name == 'damping' else 'N/m'}")
    axes[0, 0].legend(fontsize=8)
    figure.suptitle("Green: a small displacement stays small; red: it grows", fontsize=10)
    save(figure, path)


if __name__ == "__main__":
    main(run, __doc__)
