"""The sections of a report, each about one run; what a run does not hold has no section, or a line that says so."""

from __future__ import annotations

import itertools
import math
import shlex
from collections import Counter

import numpy as np
from evodevo_sim.analysis.gait.table import headline
from evodevo_sim.analysis.stretches import holes
from evodevo_sim.genetics.genome_file import genome_text
from evodevo_sim.parameters import Development
from evodevo_sim.recording.life import contrasting_cells, period_of
from evodevo_sim.ros.messages import genome_from_message
from evodevo_sim.task_kinds import kind_of
from evodevo_sim.tasks.outcome import Status

from ..schemes import default_scheme
from .charts import Curve, chart
from .differences import command, differences, world_of, world_text
from .runs import Run
from .tables import commands, download, number, paragraph, table

_PERIODS = 6.0  # of the muscles that traces show
_MOST_GENOMES = 24  # to begin from, that a page holds
_BEGINNINGS = ("given", "random", "scatter")  # what makes a genome without parents
_MOST_CHAMPIONS = 15  # in a table


def settings_section(run: Run) -> str:
    """What was run, and what differs from the defaults."""
    told = run.told
    last = run.recording.statistics[-1]
    ended = "the end of the recording is missing" if run.recording.truncated else (
        "its champion's life is recorded" if len(run.life.time) else "it was ended before its champion's life was recorded")
    facts = [
        ("task", told.task.name), ("search", told.scheme or "not recorded"), ("seed", told.seed), ("population", told.population),
        ("generations", f"{last.generation + 1} of at most {told.generations}" if told.generations < 10**9 else last.generation + 1),
        ("evaluations", f"{last.evaluations:,}"), ("version", told.version or "not recorded"), ("state", ended),
    ]
    parts = [table("What was run", ["", "value"], facts, shown=False)]
    if run.task is None or run.settings is None:
        return "".join(parts)
    found = differences(run.task, run.settings, told.scheme)
    if found:
        rows = [(one.name, one.value, one.default, one.meaning) for one in found]
        usual = f"Settings that differ from the defaults of `evolve --task {run.task.name}` ({default_scheme(run.task.name)})"
        parts.append(table(usual.replace("`", ""), ["setting", "here", "default", "meaning"], rows))
    else:
        parts.append(paragraph(f"All settings are the defaults of evolve --task {run.task.name}."))
    return "".join(parts)


def curves_section(run: Run) -> str:
    """Fitness, diversity, genomes and failures by generation."""
    statistics = run.recording.statistics
    x = [float(one.generation) for one in statistics]
    best, median = [one.best for one in statistics], [one.median for one in statistics]
    floor = -0.05 * max(best) if max(best) > 0 else None  # failures lie far below, and would press everything else flat
    failed = [100.0 * sum(list(one.status_count)[1:]) / max(1, sum(one.status_count)) for one in statistics]
    made = [
        chart("Fitness, m", "generation", [Curve("best", x, best), Curve("median", x, median)], floor),
        chart("Diversity of genomes", "generation", [Curve("mean distance, 0 to 1", x, [one.diversity for one in statistics])], 0.0),
        chart("Genetic elements, median", "generation", [Curve("elements", x, [one.median_elements for one in statistics])]),
        chart("Individuals that fail or come to rest, %", "generation", [Curve("share", x, failed)], 0.0),
    ]
    causes: Counter[str] = Counter()
    for one in statistics:
        causes.update({Status(k).name.lower().replace("_", " "): int(n) for k, n in enumerate(one.status_count) if k in list(Status)})
    total = sum(causes.values())
    said = ", ".join(f"{100 * count / total:.1f} % {name}" for name, count in causes.most_common() if count) if total else ""
    return f'<div class="charts">{"".join(made)}</div>' + (paragraph(f"All individuals of the run: {said}.", "about") if said else "")


def gait_section(run: Run) -> str:
    """The gait by name and in numbers, with the traces of two muscles."""
    gait, life = run.gait, run.life
    if gait is None:
        return paragraph("The run holds no motion whose gait could be named.")
    said = headline(gait) if gait.why in headline(gait) else f"{headline(gait)}; {gait.why}"
    parts = [paragraph(f"{said[:1].upper()}{said[1:]}.")]
    if len(life.time) > 2:
        cells, seconds = contrasting_cells(life.activation), life.time - life.time[0]
        late = seconds >= seconds[-1] - _PERIODS * period_of(life, cells)
        gaps = holes(seconds[late]) + 1
        x = np.insert(seconds[late], gaps, np.nan).tolist()
        curves = [Curve(f"cell {cell}", x, np.insert(life.activation[late, cell], gaps, np.nan).tolist()) for cell in cells]
        way = Curve("from birth", seconds.tolist(), life.distance.tolist())
        aims = [Curve("to the target", seconds.tolist(), life.target_distance.tolist())] if len(life.target) else []
        parts.append(f'<div class="charts">{chart("Muscles e − c of two cells", "time since birth, s", curves)}'
                     f'{chart("Distance, m", "time since birth, s", [way, *aims], 0.0)}</div>')
    rows = [
        ("frequency of the muscles, Hz", gait.frequency), ("amplitude of e − c", gait.amplitude), ("speed, m/s", gait.speed),
        ("stroke, m per period", gait.stroke), ("phase along the body, rad/m", gait.gradient_along),
        ("sides apart, degrees", math.degrees(gait.lateral_shift)), ("synchrony, 0 to 1", gait.synchrony),
        ("time in the air, share", gait.flight), ("duty factor of a foot", gait.duty),
    ]
    return "".join(parts) + table("The gait in numbers", ["", "value"], [(name, number(value)) for name, value in rows if value == value])


def energy_section(run: Run) -> str:
    """Work done on the body, and what the audits could not explain."""
    gait = run.gait
    if gait is None or not math.isfinite(gait.muscle_work):
        return paragraph("Not known: it takes the motion of a body with its rest lengths, which this run did not record.")
    rows = [("muscles put in", gait.muscle_work), ("drag took", -gait.drag_work), ("damping took", -gait.damping_work)]
    if math.isfinite(gait.ground_work):
        rows.append(("the ground took", -gait.ground_work))
    share = gait.muscle_work or math.nan
    told = [(name, number(value), f"{100 * value / share:.0f} %") for name, value in rows]
    parts = [table("Work in the second half of the life", ["", "J", "of the muscles'"], told)]
    parts.append(paragraph(f"Cost of transport: {number(gait.cost_of_transport, 3)} J/(kg m). Drag and damping are integrals over recorded "
                           "frames, within 3 and 10 % of the audit's ledger.", "about"))
    return "".join(parts)


def audit_section(run: Run) -> str:
    """Whether the champion's fitness stands, and of how many champions it did."""
    champion, audits = run.champion, run.recording.audits
    if champion is None:
        return paragraph("There is no champion.")
    own = run.audit_of(champion.generation)
    if own is None:
        kind = kind_of(run.told.task.name)
        why = "tasks of this kind have no audit" if kind is not None and kind.audit is None else "the recording holds none of it"
        parts = [paragraph(f"The last champion was not audited: {why}.")]
    else:
        verdict = "The fitness stands." if own.stands else f"The fitness does not stand: {'; '.join(own.faults)}."
        parts = [paragraph(verdict, "good" if own.stands else "bad")]
        rows = [(one.name, number(one.fitness, 6), _percent(one.change), _percent(one.unexplained), one.cause or "-") for one in own.runs]
        head = ["life", "fitness, m", "change", "energy unexplained", "failed by"]
        parts.append(table("The last champion, lived again in other ways", head, rows))
    if audits:
        failed = sorted({one.generation for one in audits if not one.stands})
        which = f"those of generations {', '.join(map(str, failed))} failed" if failed else "all stand"
        parts.append(paragraph(f"{len({one.generation for one in audits})} champions of the run were audited: {which}.", "about"))
    return "".join(parts)


def _percent(value: float) -> str:
    return f"{100 * value:+.2g} %" if math.isfinite(value) else "-"


def descent_section(run: Run) -> str:
    """The champions one after another; and the line of the last one, where the run has a history."""
    champions = run.recording.champions
    kept = champions if len(champions) <= _MOST_CHAMPIONS else [champions[0], *champions[1 - _MOST_CHAMPIONS :]]
    rows = []
    for one in kept:
        audit, m = run.audit_of(one.generation), one.evaluation.metrics
        verdict = "-" if audit is None else "stands" if audit.stands else "fails"
        rows.append((one.generation, number(one.evaluation.fitness), m.cells, m.chambers, len(one.genome.kind), verdict))
    left = len(champions) - len(kept)
    title = f"Champions, each better than all before it{f'; {left} after the first one are left out' if left else ''}"
    parts = [table(title, ["generation", "fitness, m", "cells", "chambers", "elements", "audit"], rows)]
    line = run.ancestors
    if not line:
        parts.append(paragraph("The run has no history of its individuals, so their parents are not known.", "about"))
        return "".join(parts)
    operators = Counter(name for one in line for name in one.operators if name not in _BEGINNINGS)
    told = ", ".join(f"{count} by {name}" for name, count in operators.most_common())
    parts.append(paragraph(f"The champion, number {line[0].number}, has {len(line) - 1} ancestors in the line of fitter parents, back "
                           f"to number {line[-1].number} of generation {line[-1].generation}. Changes in that line: {told or 'none'}."))
    back = line[::-1]
    parts.append(f'''<div class="charts">{chart(
        "Fitness in the line of the champion, m", "generation of birth",
        [Curve("ancestor", [float(one.generation) for one in back], [one.fitness for one in back])], -1.0)}</div>''')
    jumps = [(new, new.fitness - old.fitness) for old, new in itertools.pairwise(back)]
    best = sorted(sorted(jumps, key=lambda pair: -pair[1])[:8], key=lambda pair: pair[0].generation)
    gains = [
        (one.generation, one.number, ", ".join(map(str, one.parents)), ", ".join(one.operators) or "copied", number(one.fitness),
         f"{gain:+.3g}") for one, gain in best if gain > 0
    ]
    if gains:
        head = ["born in", "number", "parents", "made by", "fitness, m", "gain, m"]
        parts.append(table("The steps in that line that gained most", head, gains))
    return "".join(parts)


def commands_section(run: Run) -> str:
    """What to type to repeat the run, and to look at it; genomes and worlds as files."""
    told, parts, files = run.told, [], {}
    law = Development() if run.task is None else run.task.development
    links = []
    if run.task is not None and run.settings is not None:
        if not world_of(run.task):
            files["world"] = f"{run.name}-world.yaml"
            links.append(download(files["world"], world_text(run.task)))
        genomes = list(told.start)
        if 0 < len(genomes) <= _MOST_GENOMES:
            names = [f"{run.name}-start-{k}.yaml".replace(" ", "-") for k in range(len(genomes))]
            files["start"] = " ".join(names)
            links += [download(name, genome_text(genome_from_message(one), None, law)) for name, one in zip(names, genomes)]
        elif genomes:
            parts.append(paragraph(f"It began from {len(genomes)} genomes, which the recording holds and this page does not.", "about"))
        parts.append(commands([command(run.task, run.settings, told.seed, told.scheme, files)]))
    if run.champion is not None:
        about = {"task": told.task.name, "generation": run.champion.generation, "fitness": repr(run.champion.evaluation.fitness)}
        links.insert(0, download(f"{run.name}-champion.yaml", genome_text(genome_from_message(run.champion.genome), about, law)))
    path = shlex.quote(str(run.path))
    look = [f"ros2 run evodevo_sim replay {path}", f"ros2 run evodevo_sim film {path} -o film.html"]
    if run.champion is not None:
        kind = kind_of(told.task.name)
        look.append(f"ros2 run evodevo_sim gait {path} --out gait.png")
        look += [f"ros2 run evodevo_sim audit {path}"] if kind is not None and kind.audit is not None else []
        look += [f"ros2 run evodevo_sim turning {path} --out turning.png"] if kind is not None and kind.has_target else []
    parts.append(commands(look))
    if links:
        parts.append(f'<p class="about">Files in this page: {", ".join(links)}.</p>')
    return "".join(parts)
