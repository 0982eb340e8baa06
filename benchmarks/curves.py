#!/usr/bin/env python
"""Curves of searches: the best so far against evaluations, median and range over seeds, from what `search.py --curves` wrote.

    python benchmarks/curves.py alps.csv paper.csv random.csv --out curves.png
    python benchmarks/curves.py all.csv --of distance --yardstick 39.2 --out curves.png

Prints, too, what each search has reached after a tenth, a half and all of the evaluations that its shortest run had, and the
diversity in which its runs ended.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections import defaultdict
from pathlib import Path

import matplotlib
import numpy as np
from evodevo_sim.view.figure_file import save_figure
from evodevo_sim.view.files import PICTURES, OutputError, check, whole
from rich.console import Console
from rich.table import Table

matplotlib.use("Agg")
import matplotlib.pyplot as plt

OF = {
    "fitness": "best fitness so far, m", "distance": "way of the fittest so far, m",
    "second_half": "way of the fittest so far in its second half, m", "diversity": "diversity of the population",
}
NEEDED = ("search", "seed", "evaluations")


class CurvesError(ValueError):
    """Files that hold no curves; the message says which, and why."""


def read(paths: list[str], of: str) -> dict[str, list[np.ndarray]]:
    """The curves by search: for each run (points, 2) of evaluations and value.  Settings are in the name where they differ."""
    runs = defaultdict(list)
    for path in paths:
        try:
            with open(path, newline="", encoding="utf-8") as file:
                rows = list(csv.DictReader(file))
        except (OSError, UnicodeDecodeError) as error:
            raise CurvesError(f"{path}: {getattr(error, 'strerror', None) or 'not a text file'}") from None
        missing = [name for name in (*NEEDED, of) if not rows or name not in rows[0]]
        if missing:
            raise CurvesError(f"{path} has no {', '.join(missing)}: give what search.py --curves wrote")
        for line, row in enumerate(rows, 2):
            try:
                point = int(row["evaluations"]), float(row[of])
            except (TypeError, ValueError):
                raise CurvesError(f"{path}, line {line}: evaluations or {of} is no number") from None
            runs[row["search"], row.get("settings", ""), path, row["seed"]].append(point)
    common = set.intersection(*(set(settings.split()) for _, settings, _, _ in runs))
    curves = defaultdict(list)
    for (search, settings, _, _), points in runs.items():
        name = " ".join([search, *(one for one in settings.split() if one not in common)])
        # A seed that was run again into the same file begins again at few evaluations: the last one counts.
        begin = max(k for k in range(len(points)) if k == 0 or points[k][0] < points[k - 1][0])
        curves[name].append(np.array(points[begin:], float))
    return dict(curves)


def spread(runs: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Evaluations (K,) that all runs have had, and the values of each run there (runs, K), each the last one known."""
    first, last = max(run[0, 0] for run in runs), min(run[-1, 0] for run in runs)
    grid = np.unique(np.concatenate([run[:, 0] for run in runs] + [[first, last]]))
    grid = grid[(grid >= first) & (grid <= last)]
    return grid, np.array([run[np.searchsorted(run[:, 0], grid, "right") - 1, 1] for run in runs])


def draw(curves: dict, of: str, out: str, yardstick: float | None, logarithmic: bool) -> None:
    figure, axes = plt.subplots(figsize=(8, 4.8), layout="constrained")
    for k, (name, runs) in enumerate(curves.items()):
        evaluations, values = spread(runs)
        colour = f"C{k}"
        seeds = f"{len(runs)} seed{'s' if len(runs) > 1 else ''}"
        axes.step(evaluations, np.median(values, 0), where="post", color=colour, label=f"{name}, {seeds}")
        axes.fill_between(evaluations, values.min(0), values.max(0), step="post", color=colour, alpha=0.15, linewidth=0)
    if yardstick is not None:
        axes.axhline(yardstick, color="grey", linestyle=":", label=f"yardstick, {yardstick:g} m")
    axes.set(xlabel="evaluations", ylabel=OF[of])
    axes.set_xscale("log" if logarithmic else "linear")
    axes.set_ylim(bottom=0)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, title="median and range", loc="upper left", bbox_to_anchor=(1.0, 1.0))  # beside: curves end anywhere
    with whole(Path(out), *PICTURES) as file:
        save_figure(figure, file, dpi=120)
    plt.close(figure)


def table(curves: dict, of: str, diversities: dict) -> Table:
    shown = Table("search", "seeds", title=f"{OF[of]}: median (range)", title_justify="left")
    for head in ("a tenth", "a half", "all", "evaluations", "diversity"):
        shown.add_column(head, justify="right", no_wrap=True)
    for name, runs in curves.items():
        evaluations, values = spread(runs)
        at = [np.searchsorted(evaluations, share * evaluations[-1], "right") - 1 for share in (0.1, 0.5, 1.0)]
        cells = [middle(values[:, k]) if k >= 0 else "" for k in at]
        shown.add_row(name, str(len(runs)), *cells, f"{evaluations[-1]:.0f}", middle([run[-1, 1] for run in diversities[name]]))
    return shown


def middle(values) -> str:
    """Median and range."""
    text = f"{np.median(values):.2f}"
    return text if len(values) == 1 else f"{text} ({np.min(values):.2f}-{np.max(values):.2f})"


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", metavar="CSV", help="of search.py --curves")
    parser.add_argument("--of", default="second_half", choices=OF, help="what to draw (default %(default)s)")
    says = "a picture, as its ending .png, .svg or .pdf says (default %(default)s)"
    parser.add_argument("--out", default="curves.png", metavar="FILE", help=says)
    parser.add_argument("--yardstick", type=float, metavar="M", help="draw a line there")
    parser.add_argument("--log", action="store_true", help="a logarithmic axis of evaluations")
    given = parser.parse_args(arguments)
    try:
        check(Path(given.out), *PICTURES)
        curves, diversities = read(given.files, given.of), read(given.files, "diversity")
    except (CurvesError, OutputError) as error:
        parser.exit(2, f"curves.py: {error}\n")
    draw(curves, given.of, given.out, given.yardstick, given.log)
    Console(width=None if sys.stdout.isatty() else 120).print(table(curves, given.of, diversities))
    return 0


if __name__ == "__main__":
    sys.exit(main())
