"""The page of a report: an overview, champions as films side by side, then each run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from evodevo_sim.parameters import ParameterError
from evodevo_sim.ros.messages import genome_from_message
from evodevo_sim.tasks.evaluation import perform
from evodevo_sim.view.film.packing import BUDGET, pack
from evodevo_sim.view.film.page import asset, film_figure, whole_page
from evodevo_sim.view.sources import life_of_performance

from .charts import Curve, chart
from .runs import Run
from .sections import (
    audit_section,
    commands_section,
    curves_section,
    descent_section,
    energy_section,
    gait_section,
    settings_section,
)
from .tables import number, paragraph, table, text
from .unlike import archive_section

_ALL_FILMS = 3_000_000  # bytes of the numbers of all films of a page
_OF_ONE = 3  # champions of a single run that are shown
_SECTIONS: tuple[tuple[str, Callable[[Run], str]], ...] = (
    ("What was run", settings_section), ("Curves", curves_section), ("Gait", gait_section), ("Energy", energy_section),
    ("Audit", audit_section), ("Archive", archive_section), ("Descent", descent_section), ("Commands", commands_section),
)


def report_page(runs: Sequence[Run], palette: str = "safe", say: Callable[[str], None] = lambda line: None) -> str:
    """The whole page.  Args: palette: of cells; say: called with what takes long before it begins."""
    title = f"Report of {runs[0].name}" if len(runs) == 1 else f"Report of {len(runs)} runs"
    names = named(runs)
    parts = ['<a class="skip" href="#content">To the content</a>', f"<header><h1>{text(title)}</h1>{_navigation(names)}</header>"]
    parts.append('<main id="content">')
    parts.append(f'<section id="overview"><h2>Overview</h2>{_overview(runs, names)}</section>')
    films = _films(runs, names, palette, say)
    if films:
        parts.append(f'<section id="champions"><h2>Champions</h2><div class="films">{"".join(films)}</div></section>')
    for number_, (run, name) in enumerate(zip(runs, names)):
        parts.append(f'<section id="run-{number_}" class="run"><h2>{text(name)}</h2>')
        parts += [paragraph(f"{note}.", "note") for note in run.notes]
        parts += [f"<h3>{heading}</h3>{made}" for heading, make in _SECTIONS if (made := make(run))]
        parts.append("</section>")
    parts.append("</main>")
    own = Path(__file__).with_name("report.css").read_text(encoding="utf-8")
    return whole_page(title, "\n".join(parts), [asset("page.css"), asset("player.css"), own], [asset("picture.js"), asset("player.js")])


def named(runs: Sequence[Run]) -> list[str]:
    """Names of runs, with their paths where two have the same."""
    names = [run.name for run in runs]
    return [f"{name} ({run.path})" if names.count(name) > 1 else name for name, run in zip(names, runs)]


def _navigation(names: Sequence[str]) -> str:
    links = [("overview", "Overview"), ("champions", "Champions"), *((f"run-{k}", name) for k, name in enumerate(names))]
    return f'<nav aria-label="sections"><ul>{"".join(f"<li><a href=#{place}>{text(name)}</a></li>" for place, name in links)}</ul></nav>'


def _overview(runs: Sequence[Run], names: Sequence[str]) -> str:
    rows = []
    for run, name in zip(runs, names):
        champion, told, last = run.champion, run.told, run.recording.statistics[-1]
        audit = None if champion is None else run.audit_of(champion.generation)
        rows.append((
            name, told.task.name, told.scheme or "-", told.seed, last.generation + 1, f"{last.evaluations:,}",
            "-" if champion is None else number(champion.evaluation.fitness),
            "-" if champion is None else champion.evaluation.metrics.cells, "-" if run.gait is None else run.gait.name,
            "none" if audit is None else "stands" if audit.stands else "fails",
        ))
    head = ["run", "task", "search", "seed", "generations", "evaluations", "fitness, m", "cells", "gait", "audit"]
    made = [table("The runs and their last champions", head, rows, shown=False)]
    if len(runs) > 1:
        tasks: dict[str, list[Curve]] = {}  # what one task earns says nothing of another
        for run, name in zip(runs, names):
            statistics = run.recording.statistics
            curve = Curve(name, [float(one.generation) for one in statistics], [one.best for one in statistics])
            tasks.setdefault(run.told.task.name, []).append(curve)
        charts = [
            chart(f"Best fitness in {task}, m", "generation", curves[first : first + 4], 0.0)
            for task, curves in tasks.items() for first in range(0, len(curves), 4)
        ]
        made.append(f'<div class="charts">{"".join(charts)}</div>')
    return "".join(made)


def _films(runs: Sequence[Run], names: Sequence[str], palette: str, say: Callable[[str], None]) -> list[str]:
    """The last champion of each run; of a single run, some of its earlier ones before it, which live anew."""
    shown = []  # (title, about, life)
    for run, name in zip(runs, names):
        earlier = _earlier(run) if len(runs) == 1 else []
        latest = run.champion
        anew = [*earlier, *([latest] if latest is not None and not len(run.life.time) and run.task is not None else [])]
        if anew:
            say("champions live anew")
        for champion in anew:
            assert run.task is not None  # or nothing lives anew
            try:
                performance = perform(genome_from_message(champion.genome), run.task, run.told.seed)
            except (ParameterError, ValueError) as error:
                run.notes.append(f"the champion of generation {champion.generation} cannot live here: {error}")
                continue
            shown.append((f"{name}, generation {champion.generation}", _about(champion), life_of_performance(performance, run.task)))
        if len(run.life.time):
            where = name if latest is None else f"{name}, generation {latest.generation}"
            shown.append((where, "" if latest is None else _about(latest), run.life))
    budget = min(BUDGET, _ALL_FILMS // max(1, len(shown)))
    return [film_figure(pack(life, palette, budget), title, about, level=3) for title, about, life in shown]


def _earlier(run: Run) -> list:
    """Champions before the last one: the first that lived, and the one that came half as far."""
    if run.task is None:
        return []
    lived = [one for one in run.recording.champions[:-1] if not one.evaluation.cause]
    if not lived or run.champion is None:
        return []
    half = next((one for one in lived[1:] if one.evaluation.fitness >= 0.5 * run.champion.evaluation.fitness), None)
    return [one for one in (lived[0], half) if one is not None][: _OF_ONE - 1]


def _about(champion) -> str:
    e = champion.evaluation
    way = f"fitness {e.fitness:.3f} m, {e.metrics.cells} cells, {e.metrics.distance:.2f} cell diameters"
    return f"{way}; failed: {e.cause}" if e.cause else way
