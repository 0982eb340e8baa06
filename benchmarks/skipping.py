#!/usr/bin/env python
"""Scenes pay only for what they contain: time against the same kernels with every term computed, at the same bits.

    python benchmarks/skipping.py [--quick] [--out DIR]

A term is computed and changes no bit where its coefficient is 1e-200 in place of 0: what it gives is far below the last digit of
any force (and far above the denormal numbers, which are slow).  Every pair of runs must end in the same bits, or the benchmark
fails.  Units of a network that locomotion reads nothing from are kept by a weight of 1e-200 to the division factor.  Only the
early exit of a life in which all rests is not exact, and its difference is given.
"""

from __future__ import annotations

import numpy as np
from common import FULL, QUICK, STEP, TINY, Figure, best, champion, champion_task, default_law, main, race, slab, write_csv
from evodevo_sim.genetics.regulation import DIVISION, express, prune
from evodevo_sim.kernels.lanes import aligned
from evodevo_sim.physics.integrators import make_system, make_work
from evodevo_sim.physics.step_size import EULER, RK4
from evodevo_sim.tasks.ends import OK
from evodevo_sim.tasks.life import birth
from evodevo_sim.tasks.swim.fitness import kernel_arguments
from kernels import live_on, travel

from evodevo_sim import Status, evaluate, random_genome

PART = "skipping"
NEAR_NOTHING = 1e-200
STEPS = {EULER: 8, RK4: 2}  # in a control step


def compare(name, kind, lean, full, rounds, outcome):
    """A row: time of `full` over that of `lean`, which must end alike.  Args: both: action -> arrays."""
    a, b = lean(), full()
    if not all(np.array_equal(x, y) for x, y in zip(a, b, strict=True)):
        raise AssertionError(f"{name}: other bits than with every term computed")
    if not all(np.isfinite(x).all() for x in a):
        raise AssertionError(f"{name}: not finite")
    seconds = best(race({"lean": lean, "full": full}, rounds, f"skipping: {name}"))
    return {"what": name, "kind": kind, "lean_ms": 1e3 * seconds["lean"], "full_ms": 1e3 * seconds["full"],
            "ratio": seconds["full"] / seconds["lean"], "same_bits": True, "outcome": outcome}


def moved(body, law, method, intervals, **more):
    """An action: the state after some control steps of a body that a wave runs along."""
    ones = np.ones(len(body.position))
    system = make_system(body, law, **{"drive": (0.4 * ones, ones, -body.position[:, 0]), **more})
    work = make_work(body)

    def action():
        p = body.position.T.copy()
        v = 0.01 * np.random.default_rng(0).standard_normal(p.shape)
        travel(system, method, float(STEPS[method]), STEP, intervals, p, v, work)
        return p, v

    return action


def scenes(body, intervals, rounds):
    """Rows: each scene against the kernel with all terms, and each term that may be missing alone."""
    full = default_law()
    no_drag = {"drag_normal": 0.0, "drag_tangential": 0.0}
    little_drag = dict.fromkeys(no_drag, NEAR_NOTHING)
    walk = {"gravity": 9.81, "friction": 0.8, "ground": True}
    still = {"drive": None}, {"drive": tuple(np.zeros((3, len(body.position))))}
    springs = {**no_drag, "pressure": 0.0, "damping": 0.0}, {**little_drag, "pressure": NEAR_NOTHING, "damping": NEAR_NOTHING}
    on_ground = body._replace(position=body.position - [0.0, body.position[:, 1].min()])
    # name, kind, body, method, (changes of the law, of the system) as the scene has them, and the same with every term computed
    cases = [
        ("swim, without gravity", "scene", body, RK4, ({}, {}), ({}, {"gravity": NEAR_NOTHING})),
        ("walk, without drag", "scene", on_ground, EULER, (no_drag, walk), (little_drag, walk)),
        ("free, without drag and gravity", "scene", body, RK4, (no_drag, {}), (little_drag, {"gravity": NEAR_NOTHING})),
        ("free, of springs alone, muscles held", "scene", body, RK4, (springs[0], still[0]),
         (springs[1], {"gravity": NEAR_NOTHING, **still[1]})),
        ("drag", "term", body, RK4, (no_drag, {}), (little_drag, {})),
        ("chambers", "term", body, RK4, ({"pressure": 0.0}, {}), ({"pressure": NEAR_NOTHING}, {})),
        ("damping", "term", body, RK4, ({"damping": 0.0}, {}), ({"damping": NEAR_NOTHING}, {})),
        ("gravity", "term", body, RK4, ({}, {}), ({}, {"gravity": NEAR_NOTHING})),
        ("muscles", "term", body, RK4, ({}, still[0]), ({}, still[1])),
    ]
    return [
        compare(name, kind, *(moved(where, full._replace(**law), method, intervals, **more) for law, more in ways), rounds,
                f"{intervals} control steps")
        for name, kind, where, method, *ways in cases
    ]


def born(genome, task, reads, inputs, unused):
    """A life at birth, its network pruned by what is read, the inputs that there are, and whether unused units are dropped."""
    genes, model = kernel_arguments(genome, task)
    life, given = birth(genes, model, 1.0)[1], model.given_inputs
    weights, units = express(*genes)
    if unused:
        needed = prune(weights, units, np.array([False, False, True, True]), given, life.brain.activation.size).nodes
        weights[units + DIVISION, np.setdiff1d(np.arange(units), needed)] = NEAR_NOTHING
    signals = given if inputs is None else np.ones(given.size, bool)
    network = prune(weights, units, np.array(reads), signals, life.brain.activation.size)
    return life._replace(brain=life.brain._replace(network=network, drive=aligned(network.nodes.size, life.brain.activation.size)))


def lives(life, task):
    """An action: the state after all control steps of a life, which stays as it is for the next time."""
    changed = *(getattr(life.state, name) for name in ("position", "velocity", "rest")), life.brain.activation, life.brain.table
    born_with = [array.copy() for array in changed]
    development, continual = task.development.arguments(), task.development.variant == "continual_graph"

    def action():
        for array, value in zip(changed, born_with):
            array[:] = value
        live_on(life, task.control_steps, task.control_step, development, continual)
        return life.state.position.copy(), life.state.velocity.copy(), life.brain.activation.copy()

    return action


def networks(task, rounds):
    """Rows: locomotion with the network that it needs, against one with outputs, inputs and units that nothing reads."""
    genome, two, all_outputs = champion(), (False, False, True, True), (True, True, True, True)
    lean = born(genome, task, two, None, False)
    cases = {
        "outputs that nothing reads": born(genome, task, all_outputs, None, False),
        "inputs that the scene lacks": born(genome, task, two, "all", False),
        "units that feed nothing": born(genome, task, all_outputs, None, True),
        "swim, its network: outputs, inputs and units": born(genome, task, all_outputs, "all", True),
    }
    live_lean = lives(lean, task)
    return [
        compare(name, "scene" if name.startswith("swim") else "regulation", live_lean, lives(full, task), rounds,
                f"{lean.brain.network.nodes.size} of {full.brain.network.nodes.size} nodes, "
                f"{lean.brain.network.weight.size} of {full.brain.network.weight.size} weights")
        for name, full in cases.items()
    ]


def resting(task, genomes):
    """The exit where all rests, over the first random genomes that grow a body: time of locomotion without it over with it."""
    rows, seed = [], 0
    development, continual = task.development.arguments(), task.development.variant == "continual_graph"
    while len(rows) < genomes:
        genome = random_genome(np.random.default_rng(seed))
        seed += 1
        evaluation = evaluate(genome, task)
        if evaluation.cause:
            continue
        genes, model = kernel_arguments(genome, task)

        def alive():
            status, life = birth(genes, model, 1.0)  # noqa: B023  (called within its round)
            assert status == OK
            return life

        lived = alive()
        rested = live_on(lived, task.control_steps, task.control_step, development, continual)[1]
        until = rested if rested > 0 else task.control_steps
        short = alive()
        live_on(short, until, task.control_step, development, continual)
        apart = float(np.abs(lived.state.position - short.state.position).max()) if rested > 0 else 0.0
        seconds = best(race({
            "birth": alive,
            "exit": lambda: evaluate(genome, task),  # noqa: B023  (called within its round)
            "full": lambda: live_on(alive(), task.control_steps, task.control_step, development, continual),
        }, 2, "resting"))
        rows.append({"seed": seed - 1, "rests": evaluation.status == Status.RESTING, "at_step": rested, "moved_after_m": apart,
                     **{f"{name}_ms": 1e3 * value for name, value in seconds.items()}})
    return rows


def run(effort, out):
    task = champion_task() if effort > TINY else champion_task(control_steps=100)
    rounds, intervals = {TINY: (1, 20), QUICK: (5, 300), FULL: (9, 1000)}[effort]
    table = scenes(slab(*((4, 3) if effort == TINY else (16, 4))), intervals, rounds) + networks(task, rounds)
    rest = resting(task, {TINY: 2, QUICK: 5, FULL: 25}[effort])
    write_csv(out / "skipping.csv", table)
    write_csv(out / "resting.csv", rest)
    figures = [
        Figure(PART, f"{row['kind']}: {row['what']} ({row['outcome']})",
               f"{row['ratio']:.2f} times as long with all computed, same bits")
        for row in table
    ]
    share = sum(row["rests"] for row in rest) / len(rest)
    saved = sum(row["full_ms"] for row in rest) / sum(row["exit_ms"] for row in rest)
    text = f"{saved:.1f} times; {100 * share:.0f} % rest; they would move by {max(row['moved_after_m'] for row in rest):.1e} m more"
    figures.append(Figure(PART, f"exit at rest, {len(rest)} random genomes with a body: time without it", text))
    return figures


if __name__ == "__main__":
    main(run, __doc__)
