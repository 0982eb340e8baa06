#!/usr/bin/env python
"""All benchmarks of docs/reference/benchmarks.md, one after the other: `make bench`.

    python benchmarks/run.py [--quick] [--out DIR] [--only PART ...]

Writes CSV and PNG, the whole table as summary.csv among them.  Each part also runs alone: benchmarks/PART.py.
"""

from __future__ import annotations

import importlib
import platform
import sys
import time

from common import FULL, QUICK, options, show, write_csv
from evodevo_sim.tasks.evaluation import prepare
from tqdm import tqdm

PARTS = ("work_precision", "stability_maps", "cost", "evaluation", "skipping", "workers", "peers")


def run(effort, out, parts=PARTS):
    """Figures of the parts; a part that fails leaves the others' results, and says why."""
    figures, failed = [], []
    with tqdm(parts, desc="benchmarks", unit="part") as bar:
        for name in bar:
            bar.set_postfix_str(name)
            began = time.perf_counter()
            try:
                found = importlib.import_module(name).run(effort, out)
            except AssertionError as error:
                failed.append(str(error))
                continue
            tqdm.write(f"{name}: {time.perf_counter() - began:.0f} s", file=sys.stderr)
            figures += found
            write_csv(out / "summary.csv", [{**one._asdict(), "machine": platform.machine()} for one in figures])
    return figures, failed


def main():
    parser = options(__doc__)
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS, metavar="PART", help=f"of {', '.join(PARTS)}")
    given = parser.parse_args()
    prepare()
    figures, failed = run(QUICK if given.quick else FULL, given.out, given.only)
    show(figures)
    missed = sum(one.met is False for one in figures)
    print(f"{missed} figures miss what is asked of them.  CSV and PNG are in {given.out}; docs/reference/benchmarks.md explains them.")
    for cause in failed:
        print(f"FAILED: {cause}", file=sys.stderr)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
