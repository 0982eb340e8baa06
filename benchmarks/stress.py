"""Stress: random bodies x muscles x parameters, each of which must end sound or with a named outcome.

    python benchmarks/stress.py [--count 100000] [--beyond 1000] [--seed 0] [--workers 2] [--out stress.csv]
    python benchmarks/stress.py --only 4711        # one case again, with all that was seen

Each case lives twice: as a swimmer does (choose_substeps and advance), and as a body of your own does (follow, with any integrator
and scene).  Parameters lie in the documented ranges; those of the further cases, beyond them.  Faults, of which there must be none:

    nan          in a state that was called sound
    energy       that nothing put in: more than 1 % of what went through in control steps of a swimmer, RK4 and the adaptive pair
                 (there also what its tolerance allows); Euler and Verlet, whose energy swings with the step, 30 % and 10 %
    momentum     lost or gained by a body that nothing outside acts on
    error        an exception

Exit code: 0 without a fault, 1 with one.  Ctrl-C ends it early and keeps what was done.
"""

from __future__ import annotations

import argparse
import csv
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor

import numba
import numpy as np
from evodevo_sim.own_body.motion import _FINER
from evodevo_sim.physics.bounds import bounds
from evodevo_sim.physics.control_step import advance, relax
from evodevo_sim.physics.energy import stored_energy
from evodevo_sim.physics.forces import Law, Ramp, make_scratch, set_rest_lengths
from evodevo_sim.physics.integrators import State, carry_adaptively, make_system, make_work
from evodevo_sim.physics.ladder import MOST_DOUBLINGS, Ladder
from evodevo_sim.physics.replayed_motion import MOST_STEPS, Frames, Method, carry_soundly, follow
from evodevo_sim.physics.soundness import INVERTED, SOUND, UNSTABLE
from evodevo_sim.physics.step_size import (
    ADAPTIVE,
    EULER,
    INTEGRATORS,
    MOST_SUBSTEPS,
    RK4,
    VERLET,
    choose_steps,
    choose_substeps,
    substeps_in_drag,
)
from random_bodies import random_body, random_muscles, random_parameters
from tqdm import tqdm

CONTROL_STEPS, FRAMES, ADAPTIVE_FRAMES = 20, 8, 2
MOST_WORK = 1000  # steps of physics in half a case, but for one control step or frame
SETTLE = 100  # steps
MOST_ENERGY = {EULER: 0.3, VERLET: 0.1, RK4: 0.01, ADAPTIVE: 0.01}  # of what went through, that may come from nowhere
MOST_MOMENTUM = 1e-9
ROUNDING = 1e-24  # of the energy of springs and chambers stretched by as much as the body is wide, that is rounding
NAMES = {SOUND: "sound", UNSTABLE: "unstable", INVERTED: "inverted"}
COLUMNS = (
    "case", "beyond", "cells", "chambers", "swim", "swim_created", "scene", "integrator", "own", "own_created", "own_gap", "momentum",
    "faults", "seconds",
)
_CHUNK = 50


def stress(seed: int, case: int, beyond: bool) -> dict:
    """One case.  Returns: a row of COLUMNS."""
    rng = np.random.default_rng((seed, case, beyond))
    began = time.perf_counter()
    row = dict.fromkeys(COLUMNS, "") | {"case": case, "beyond": int(beyond)}
    faults = []
    try:
        material, scene, step = random_parameters(rng, beyond)
        body = random_body(rng, mass=material["mass"])
        if body is None:
            row["swim"] = row["own"] = "coincident cells"
        else:
            row |= {"cells": len(body.position), "chambers": len(body.triangle_area) + len(body.polygon_area)}
            law = Law(material["stiffness"], material["damping"], material["pressure"], scene["drag_normal"], scene["drag_tangential"], 0.2)
            row |= swim(rng, body, law, step, faults)
            row |= own(rng, body, law, step, faults)
    except Exception as error:  # any is a fault of the library, and the others go on
        faults.append(f"error {type(error).__name__}: {error}")
    return row | {"faults": "; ".join(faults), "seconds": round(time.perf_counter() - began, 4)}


def swim(rng, body, law, step, faults):
    """Live as a swimmer does: settle, then control steps of `advance`."""
    substeps = choose_substeps(body, law, step)
    if substeps > MOST_SUBSTEPS:
        return {"swim": "too stiff"}
    count = int(min(CONTROL_STEPS, max(1, MOST_WORK // substeps)))
    muscle = random_muscles(rng, len(body.position), count)
    position, velocity = body.position.T.copy(), np.zeros(body.position.T.shape)
    outcome, through, created = _swim(body, law, step, substeps, muscle, position, velocity, body.rest_length.copy(), make_scratch(body))
    if outcome != SOUND:
        return {"swim": NAMES[outcome]}
    if not (np.isfinite(position).all() and np.isfinite(velocity).all() and np.isfinite(created)):
        faults.append("nan swim")
    share = created / (through + _rounding(body, law))
    if share > MOST_ENERGY[RK4]:
        faults.append(f"energy swim {share:.2g}")
    return {"swim": "sound", "swim_created": share}


def _rounding(body, law) -> float:
    return ROUNDING * (law.stiffness + law.pressure) * np.ptp(body.position) ** 2 * len(body.position) + 1e-300


@numba.njit(error_model="numpy")
def _swim(body, law, step, substeps, muscle, position, velocity, rest, scratch):
    """(outcome; energy that was there or that muscles put in and out; energy that came from nowhere), J.

    Muscles jump, harder than in a life, so that what they do is known exactly."""
    set_rest_lengths(body, law, muscle[0], rest)
    relax(body, law, rest, position, velocity, 1e-3, SETTLE, scratch)
    now = sum(stored_energy(body, law, rest, 0.0, position, velocity))
    through, created = now, 0.0
    for k in range(muscle.shape[0] - 1):
        set_rest_lengths(body, law, muscle[k + 1], rest)
        pushed = sum(stored_energy(body, law, rest, 0.0, position, velocity))
        through += abs(pushed - now)
        many = substeps_in_drag(body, law, position, velocity, step, substeps, scratch)
        outcome = advance(body, law, Ramp(rest, rest, 0.0), position, velocity, step, many, scratch)
        if outcome != SOUND:
            return outcome, through, created
        now = sum(stored_energy(body, law, rest, 0.0, position, velocity))
        created += max(0.0, now - pushed)
    return SOUND, through, created


def own(rng, body, law, step, faults):
    """Live as a body of one's own does: any scene and integrator, driven by sines; then the same with a ledger."""
    scene = rng.choice(["swim", "free", "walk"])
    method = EULER if scene == "walk" else int(rng.integers(4))
    cells, row = len(body.position), {"scene": scene, "integrator": INTEGRATORS[method]}
    if scene != "swim":
        law = law._replace(drag_normal=0.0, drag_tangential=0.0)
    if scene == "walk":
        body = body._replace(position=body.position - [0.0, body.position[:, 1].min() - rng.choice([0.0, 0.5])])
    drive = rng.uniform(0, 1, cells), np.full(cells, 10 ** rng.uniform(-1, 1)), rng.uniform(0, 6, cells)
    system = make_system(body, law, 9.81 if scene == "walk" else 0.0, 0.8, scene == "walk", drive if rng.random() < 0.7 else None)
    position = body.position.T.copy()
    velocity = rng.choice([0.0, 0.01, 1.0]) * body.shortest * rng.standard_normal(position.shape)
    bound, work, seconds = bounds(system), make_work(body), min(step, 1 / 60)
    finer, tolerance = _FINER[scene], float(10 ** rng.uniform(-8, -4))
    steps = (1 if method == ADAPTIVE else finer) * choose_steps(
        system, RK4 if method == ADAPTIVE else method, bound, position, velocity, seconds
    )
    if MOST_WORK < steps <= 100_000:
        return row | {"own": "not run: many steps"}
    frames = int(min(ADAPTIVE_FRAMES if method == ADAPTIVE else FRAMES, max(1, MOST_WORK // steps)))
    time_ = np.arange(frames + 1) * seconds
    p, v = position.copy(), velocity.copy()
    track = np.full((2, frames + 1, cells, 2), np.nan)
    outcome, reached, _ = follow(
        system, Method(method, 0, finer, tolerance), bound, 0.0, (0, frames), State(p, v, np.empty(0)), work, Frames(time_, *track)
    )
    if outcome != SOUND:
        return row | {"own": "too many steps" if steps > 100_000 else NAMES[outcome]}
    if reached != frames or not np.isfinite(track[:, 1:]).all():
        faults.append("nan own")
    return row | {"own": "sound"} | _ledger(system, method, bound, finer, tolerance, time_, position, velocity, (p, v), faults)


def _ledger(system, method, bound, finer, tolerance, time_, position, velocity, end, faults):
    """The same once more with its energies, and with the momentum of a body that nothing outside acts on."""
    body, law, work, ledger, h = system.body, system.law, make_work(system.body), np.zeros(4), 0.0
    mass, state = 1.0 / body.inverse_mass, State(position, velocity, ledger)

    def energy(t):
        if len(system.amplitude):
            set_rest_lengths(body, law, system.amplitude * np.sin(2 * np.pi * system.frequency * t + system.phase), system.rest)
        return sum(stored_energy(body, law, system.rest, system.gravity, position, velocity))

    begin, pushed = energy(0.0), (mass * velocity).sum(1)
    most, used, slack = begin, 0, _rounding(body, law)
    for k in range(len(time_) - 1):
        seconds = time_[k + 1] - time_[k]
        if method == ADAPTIVE:
            h = h or seconds / choose_steps(system, RK4, bound, position, velocity, seconds)
            _, h, evaluations = carry_adaptively(system, time_[k], seconds, tolerance, h, state, work)
            used += evaluations
        else:
            count = int(np.ceil(finer * choose_steps(system, method, bound, position, velocity, seconds)))
            carry_soundly(system, method, time_[k], seconds, count, Ladder(MOST_DOUBLINGS, MOST_STEPS), state, work)
        most = max(most, energy(time_[k + 1]))
    gap = energy(time_[-1]) - begin - ledger.sum()
    if method == ADAPTIVE:  # each step may be wrong by the tolerance in every place and speed
        stiff = mass.sum() * bound[0] ** 2
        slack += used / 6 * tolerance * (np.sqrt(2 * most) * (np.sqrt(mass.sum()) + np.sqrt(stiff)) + (mass.sum() + stiff) * tolerance)
    if system.ground:  # a cell may land a step early or late
        fastest = system.gravity * time_[-1] + np.abs(velocity).max()
        slack += mass.sum() * system.gravity * (time_[-1] - time_[-2]) / count * fastest * (len(time_) - 1)
    through = max(abs(begin), most) + np.abs(ledger).sum()
    row = {"own_gap": gap / (through + slack), "own_created": max(0.0, gap - slack) / (through + slack)}
    if not (np.array_equal(position, end[0]) and np.array_equal(velocity, end[1])) and method != ADAPTIVE:
        faults.append("ledger changes the motion")
    if row["own_created"] > MOST_ENERGY[method]:
        faults.append(f"energy own {row['own_created']:.2g}")
    if not (law.drag_normal or law.drag_tangential or system.ground or system.gravity):
        scale = np.sqrt(2 * mass.sum() * most) + np.abs(mass * velocity).sum()
        row["momentum"] = float(np.abs((mass * velocity).sum(1) - pushed).max() / scale) if scale > 0.0 else 0.0
        if row["momentum"] > MOST_MOMENTUM:
            faults.append(f"momentum {row['momentum']:.2g}")
    return row


def _chunk(arguments):
    seed, first, last, beyond = arguments
    with np.errstate(all="ignore"):
        return [stress(seed, case, beyond) for case in range(first, last)]


def run(seed, count, beyond, workers, keep):
    """Live all cases, in order, and `keep` each row as it comes; Ctrl-C ends it early.  Returns: the rows."""
    chunks = [(seed, k, min(k + _CHUNK, total), far) for total, far in ((beyond, True), (count, False)) for k in range(0, total, _CHUNK)]
    rows = []
    with tqdm(total=count + beyond, unit="case") as bar, ProcessPoolExecutor(workers) as pool:
        try:
            for some in pool.map(_chunk, chunks):
                for row in some:
                    keep(row)
                rows.extend(some)
                bar.set_postfix_str(f"{sum(bool(r['faults']) for r in rows)} faults", refresh=False)
                bar.update(len(some))
        except KeyboardInterrupt:
            pool.shutdown(wait=False, cancel_futures=True)
    return rows


def table(rows) -> str:
    """Outcomes by how the body lived, within and beyond the ranges."""
    lines = [f"{'':30}{'within':>10}{'beyond':>10}"]
    kinds = [("swim", "", lambda r: r["swim"])] + [
        (f"{scene} {name}", "own", lambda r, s=scene, n=name: r["own"] if (r["scene"], r["integrator"]) == (s, n) else "")
        for scene in ("swim", "free", "walk") for name in (INTEGRATORS if scene != "walk" else INTEGRATORS[:1])
    ]
    for label, how, of in kinds:
        counts = [Counter(of(r) for r in rows if r["beyond"] == far) for far in (0, 1)]
        for outcome in sorted({*counts[0], *counts[1]} - {""}, key=lambda o: (o != "sound", o)):
            lines.append(f"{how or 'task':5}{label:14}{outcome:>20}{counts[0][outcome]:>10}{counts[1][outcome]:>10}"[:60])
    for column in ("swim_created", "own_gap", "momentum", "seconds"):
        values = np.abs([r[column] for r in rows if r[column] != "" and not r["beyond"]])
        if len(values):
            some = " ".join(f"{q:.2g}" for q in np.nanquantile(values, (0.5, 0.9, 0.99, 1.0)))
            lines.append(f"{column}, median, 90 %, 99 %, most of {len(values)}: {some}")
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=100_000, help="cases within the documented ranges (default %(default)s)")
    parser.add_argument("--beyond", type=int, default=1000, help="cases beyond them (default %(default)s)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=2, help="processes (default %(default)s)")
    parser.add_argument("--out", default="stress.csv", help="a row for every case (default %(default)s)")
    parser.add_argument("--only", type=int, metavar="CASE", help="one case within the ranges alone (with --beyond 0) or beyond them")
    given = parser.parse_args()
    if given.only is not None:
        print(*(f"{k}: {v}" for k, v in stress(given.seed, given.only, given.beyond != 0).items()), sep="\n")
        return 0
    with open(given.out, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        rows = run(given.seed, given.count, given.beyond, given.workers, writer.writerow)
    print(table(rows))
    faulty = [r for r in rows if r["faults"]]
    for r in faulty[:20]:
        print(f"case {r['case']}{' beyond' if r['beyond'] else ''}: {r['faults']}")
    print(f"{len(rows)} cases, {len(faulty)} with faults; rows in {given.out}")
    return 1 if faulty else 0


if __name__ == "__main__":
    sys.exit(main())
