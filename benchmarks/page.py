#!/usr/bin/env python
"""Put the figures and pictures of a run of `make bench` into docs/results/benchmarks.md: between its marks, nothing else.

    python benchmarks/page.py [DIR]
"""

from __future__ import annotations

import argparse
import csv
import re
import shutil
import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parents[1] / "docs"
PICTURES = ("work_precision", "stability", "cost", "evaluation")
MARKS = re.compile(r"(<!-- figures: ([\w-]+) -->\n).*?(<!-- end -->)", re.DOTALL)


def table(rows, with_asked):
    """Markdown of some figures."""
    lines = ["| what | measured |" + (" asked | |" if with_asked else ""), "|---|---|" + ("---|---|" if with_asked else "")]
    for row in rows:
        line = f"| {row['what']} | {row['measured']} |"
        if with_asked:
            line += f" {row['asked']} | {'met' if row['met'] == 'True' else '**not met**'} |"
        lines.append(line)
    return "\n".join(lines) + "\n"


def fill(text: str, figures: list[dict]) -> str:
    """The page with new figures.  Marks name a part, or `aims`: all that something is asked of."""

    def one(mark):
        name = mark[2]
        if name == "aims":
            rows = [{**row, "what": f"{row['part']}: {row['what']}"} for row in figures if row["asked"]]
        else:
            rows = [row for row in figures if row["part"] == name]
        return mark[1] + table(rows, name == "aims") + mark[3] if rows else mark[0]

    return MARKS.sub(one, text)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", nargs="?", type=Path, default=Path("benchmarks/results"), metavar="DIR")
    results = parser.parse_args().results
    try:
        with open(results / "summary.csv", newline="", encoding="utf-8") as file:
            figures = list(csv.DictReader(file))
    except OSError as error:
        sys.exit(f"{results}: {error.strerror}: run make bench first, or give its --out directory")
    page = DOCS / "results" / "benchmarks.md"
    page.write_text(fill(page.read_text(encoding="utf-8"), figures), encoding="utf-8")
    for name in PICTURES:
        if (results / f"{name}.png").exists():
            shutil.copy(results / f"{name}.png", DOCS / "images" / f"bench-{name.replace('_', '-')}.png")
    print(f"Wrote {page} from {len(figures)} figures")


if __name__ == "__main__":
    main()
