#!/usr/bin/env python
"""What one evaluation costs, what the time goes to, and how accurate it is.

    python benchmarks/evaluation.py [--quick] [--out DIR]

The genome is that of benchmarks/swimmer.yaml, grown to several limits of cells: its muscles never rest, so no run ends early.
Parts are timed alone on the same body and network: growth; birth (body and rest before the swim); regulation; forces, each term by
leaving it out; checks of every substep; the last two for as many substeps as that swim takes in the mean.  What they do not explain,
the arithmetic of the integrator most of all, is "rest".
Accuracy: root mean square over cells of the distance, in cell diameters, from the same life in 32 times the substeps.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
from common import FULL, TINY, Figure, best, champion, champion_task, main, plt, race, save, write_csv
from evodevo_sim.brain.scent import make_signals
from evodevo_sim.tasks.life import birth, develop
from evodevo_sim.tasks.swim.fitness import kernel_arguments
from evodevo_sim.tasks.swim.kernel import swim
from kernels import many_accelerations, many_checks, many_regulations, mean_substeps

from evodevo_sim import Development, Status, Task, evaluate, perform, random_genome, read_genome

PART = "evaluation"
NOBODY = np.empty((0, 0, 0)), np.empty((0, 0)), np.empty((0, 0, 0), np.int64)
NO_TRACK = np.empty((0, 0, 0)), np.empty((0, 0))
CALLS = 1000
TERMS = {"damping": {"damping": 0.0}, "chambers": {"pressure": 0.0}, "drag": {"drag_normal": 0.0, "drag_tangential": 0.0}}
SHARES = ("growth", "birth", "regulation", "springs", "damping", "chambers", "drag", "checks", "rest")
HORIZON = 1000  # control steps, after which errors are taken
LIMITS = ((5e-3, 20.0), (1e-4, 32.0))  # cell diameters; ms at 64 cells
FINEST = 32
CHAMPIONS = Path(__file__).resolve().parents[1] / "src/evodevo_sim/champions"
# What is timed; file of the genome; task; settings; ms that are asked.
OTHERS = (
    ("64 cells: a walker's evaluation from one start, settling included", "walker", "walk",
     {"starts": 1, "development.max_cells": 64}, 28.0),
    ("32 cells: a seeker's evaluation of three swims", "seeker", "chemotaxis", {"chemotaxis.pairs": 1}, 36.0),
)


def life_of(genome, task, finer=1):
    return birth(*kernel_arguments(genome, task), float(finer))[1]


def measure(cells, genome, rounds):
    """One row: milliseconds of an evaluation, and its shares in per cent."""
    task = champion_task(**{"development.max_cells": cells})
    genes, model = kernel_arguments(genome, task)
    substeps = mean_substeps(life_of(genome, task), task.control_steps, task.control_step, model.development, model.continual)
    brain, state = life_of(genome, task)
    state.velocity[:] = 0.1 * np.random.default_rng(0).standard_normal(state.velocity.shape)
    out = np.empty_like(state.velocity)

    def forces(law):
        return lambda: many_accelerations(state.body, law, state.rest, state.position, state.velocity, state.scratch, out, CALLS)

    network = brain.network, brain.table, brain.drive, brain.start, brain.neighbour, brain.spread
    born = brain.table.copy()

    def regulation():  # a whole life from birth: what decays gets denormal after 1,500 steps, and slow
        brain.table[:] = born
        many_regulations(*network, task.development.regulation_rate, cells, task.control_steps)

    seconds = best(race({
        "whole": lambda: evaluate(genome, task),
        "growth": lambda: develop(genes, model, *NOBODY),
        "birth": lambda: birth(genes, model, 1.0),
        "regulation": regulation,
        "checks": lambda: many_checks(state.body, state.position, state.velocity, 1e-3, state.scratch, CALLS),
        "forces": forces(state.law),
        **{f"without {term}": forces(state.law._replace(**changes)) for term, changes in TERMS.items()},
    }, rounds, f"evaluations at {cells} cells"))
    steps = substeps * task.control_steps
    calls = 4 * steps
    force = seconds["forces"] / CALLS
    part = {"growth": seconds["growth"], "birth": max(seconds["birth"] - seconds["growth"], 0.0)}
    part |= {"regulation": seconds["regulation"], "checks": seconds["checks"] / CALLS * steps}
    part |= {term: max(force - seconds[f"without {term}"] / CALLS, 0.0) * calls for term in TERMS}
    part["springs"] = force * calls - sum(part[term] for term in TERMS)
    part["rest"] = seconds["whole"] - sum(part.values())
    about = {"cells": cells, "substeps": substeps, "nodes": brain.network.nodes.size, "milliseconds": 1e3 * seconds["whole"]}
    return about | {f"{name}, %": 100 * part[name] / seconds["whole"] for name in SHARES}


def errors_of(genome, task, finer, horizon, finest):
    """Errors after `horizon` control steps in some times the substeps, and the substeps of a control step in the mean: a list of each."""
    short = dataclasses.replace(task, control_steps=horizon)
    exact = perform(genome, short, finer=finest).position[-1]
    positions = (perform(genome, short, finer=f).position[-1] for f in finer)
    errors = [float(np.sqrt(((position - exact) ** 2).sum(-1).mean())) for position in positions]
    model = kernel_arguments(genome, task)[1]
    return errors, [mean_substeps(life_of(genome, task, f), horizon, task.control_step, model.development, model.continual) for f in finer]


def accuracy(genome, cells, rounds, horizon, finest):
    """Rows: milliseconds of an evaluation, and its error after `horizon` control steps, in more and more substeps."""
    task = champion_task(**{"development.max_cells": cells})
    finer = [1, 1.25] + [2**k for k in range(1, int(np.log2(finest)) - 1)]
    arguments = kernel_arguments(genome, task)
    seconds = best(race({f: lambda f=f: swim(*arguments, float(f), make_signals(), *NO_TRACK) for f in finer}, rounds, "accuracy"))
    errors, substeps = errors_of(genome, task, finer, horizon, finest)
    return [
        {"cells": cells, "finer": f, "substeps": mean, "error": error, "milliseconds": 1e3 * seconds[f]}
        for f, mean, error in zip(finer, substeps, errors)
    ]


def crowd(cells, count, rounds):
    """The same in the default steps for random genomes that never rest, a row for each."""
    task = Task(development=Development(max_cells=cells))
    genomes = lively(task, count)
    seconds = best(race({k: lambda genome=genome: evaluate(genome, task) for k, genome in enumerate(genomes)}, rounds, "random genomes"))
    rows = []
    for k, genome in enumerate(genomes):
        (error,), (substeps,) = errors_of(genome, task, (1,), HORIZON, FINEST)
        rows.append({"genome": k, "substeps": substeps, "error": error, "milliseconds": 1e3 * seconds[k]})
    return rows


def lively(task, count):
    """The first random genomes that fill the limit of cells and never rest."""
    found, seed = [], 0
    while len(found) < count:
        genome = random_genome(np.random.default_rng(seed))
        seed += 1
        evaluation = evaluate(genome, task)
        full = evaluation.metrics.cells == task.development.max_cells
        if full and evaluation.status == Status.OK and evaluation.metrics.activation_amplitude > 1e-9:
            found.append(genome)
    return found


def others(rounds):
    """Figures of what else is asked for a number of milliseconds."""
    lives = {}
    for what, genome, task, settings, _ in OTHERS:
        file = read_genome(CHAMPIONS / f"{genome}.yaml")
        lives[what] = file.genome, file.task(task, settings)
    seconds = best(race({what: lambda life=life: evaluate(*life) for what, life in lives.items()}, 3 * rounds, "walker and seeker"))
    return [
        Figure(PART, what, f"{1e3 * seconds[what]:.1f} ms", f"<= {most:g} ms", 1e3 * seconds[what] <= most) for what, *_, most in OTHERS
    ]


def run(effort, out):
    sizes, rounds = (((8,), 2), ((32, 64), 5), ((8, 16, 32, 48, 64), 10))[effort]
    genome = champion()
    table = [measure(cells, genome, rounds) for cells in sizes]
    write_csv(out / "evaluation.csv", table)
    errors = []
    for cells in sizes if effort == TINY else (32, 64):
        errors += accuracy(genome, cells, max(2, rounds // 2), *((100, 8) if effort == TINY else (HORIZON, FINEST)))
    write_csv(out / "evaluation_error.csv", errors)
    figures = []
    draw(table, out / "evaluation.png")
    for row in table:
        if row["cells"] in (32, 64):
            text = ", ".join(f"{name} {row[f'{name}, %']:.0f}" for name in SHARES)
            figures.append(Figure(PART, f"{row['cells']} cells: shares of an evaluation, %", text))
            took, most = row["milliseconds"], row["cells"] / 2
            figures.append(
                Figure(PART, f"{row['cells']} cells: the champion's evaluation", f"{took:.1f} ms", f"<= {most:g} ms", took <= most)
            )
    for cells in dict.fromkeys(row["cells"] for row in errors):
        mine = [row for row in errors if row["cells"] == cells]
        error, substeps = mine[0]["error"], mine[0]["substeps"]
        what = f"{cells} cells: the champion's error in the default {substeps:.1f} substeps"
        figures.append(Figure(PART, what, f"{error:.1e}", "<= 5e-3", error <= 5e-3))
        for most, milliseconds in LIMITS:
            row = next((row for row in mine if row["error"] <= most), None)
            if row:
                text = f"{row['milliseconds']:.1f} ms at {row['error']:.1e}, in {row['substeps']:.1f} substeps"
                asked = (f"<= {milliseconds:g} ms", row["milliseconds"] <= milliseconds) if cells == 64 else ()
                figures.append(Figure(PART, f"{cells} cells: the champion's evaluation with an error <= {most:g}", text, *asked))
    if effort == FULL:
        figures += others(rounds)
        rows = crowd(64, 10, 7)
        write_csv(out / "evaluation_random.csv", rows)
        times, worst = np.array([row["milliseconds"] for row in rows]), max(row["error"] for row in rows)
        text = f"{np.median(times):.1f} ms in the median, {times.min():.1f} to {times.max():.1f}, at {worst:.1e} and less"
        (most, asked), _ = LIMITS
        met = bool(np.median(times) <= asked and worst <= most)
        what = f"64 cells: {len(rows)} random genomes that never rest, error <= {most:g}"
        figures.append(Figure(PART, what, text, f"<= {asked:g} ms", met))
    return figures


def draw(table, path):
    figure, axis = plt.subplots(figsize=(8, 4), constrained_layout=True)
    base = np.zeros(len(table))
    for name, colour in zip(SHARES, plt.get_cmap("tab10").colors):
        share = np.array([row[f"{name}, %"] for row in table])
        axis.barh([str(row["cells"]) for row in table], share, left=base, color=colour, label=name)
        base += share
    axis.set(xlabel="% of an evaluation", ylabel="cells", xlim=(0, 100))
    axis.legend(loc="upper center", bbox_to_anchor=(0.5, 1.2), ncols=len(SHARES), fontsize=8, columnspacing=1.0, handlelength=1.0)
    save(figure, path)


if __name__ == "__main__":
    main(run, __doc__)
