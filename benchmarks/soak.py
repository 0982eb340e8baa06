#!/usr/bin/env python
"""A long run: whether memory and descriptors of `evolve` and its simulators stay as they are.

    python benchmarks/soak.py [--minutes 30] [--kill-every 0] [--simulators 1] [--threads 2]

A sample of each process is taken every two seconds.  Said are the medians of the second tenth of the time, when all is loaded, and of the
last tenth.  With --kill-every S a simulator is killed every S seconds: the lives of one place among the simulators count as one then.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from pathlib import Path

import psutil
from faults import POPULATION, Watched
from rich.console import Console
from rich.table import Table

EVERY = 2.0  # s
MOST = 0.05  # of memory, that it may grow


def sample(run):
    """{name: (MB of memory, descriptors)} of the processes that are there."""
    found, others = {}, {f"simulator {k}": one for k, one in enumerate(run.simulators())}
    for name, process in {"evolve": psutil.Process(run.process.pid), **others}.items():
        try:
            found[name] = process.memory_info().rss / 2**20, process.num_fds()
        except psutil.Error:
            continue
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--kill-every", type=float, default=0.0)
    parser.add_argument("--simulators", type=int, default=1)
    parser.add_argument("--threads", type=int, default=2)
    given = parser.parse_args()
    arguments = ["--generations", "1000000", "--patience", "1000000", "--population", str(POPULATION), "--scheme", "panmictic"]
    arguments += ["--simulators", str(given.simulators), "--threads", str(given.threads)]
    samples = []
    with tempfile.TemporaryDirectory() as directory, Watched(*arguments, out=Path(directory, "run")) as run:
        run.more(3)
        began = killed = time.monotonic()
        while (now := time.monotonic()) < began + 60.0 * given.minutes:
            samples.append(sample(run))
            until = now + EVERY
            while time.monotonic() < until:
                run.executor.spin_once(timeout_sec=0.1)
            if given.kill_every and now > killed + given.kill_every and run.simulators():
                run.simulators()[0].kill()
                killed = now
        generations = run.generation
        run.end()
    tenth = max(1, len(samples) // 10)
    shown = Table("process", title=f"{generations} generations of {POPULATION} in {given.minutes:g} minutes")
    for column in ("MB early", "MB late", "growth", "descriptors early", "late"):
        shown.add_column(column, justify="right")
    flat = True
    for name in sorted({name for one in samples for name in one}):
        early, late = ([one[name] for one in part if name in one] for part in (samples[tenth : 2 * tenth], samples[-tenth:]))
        if early and late:
            (m0, d0), (m1, d1) = ([statistics.median(value[k] for value in part) for k in (0, 1)] for part in (early, late))
            flat &= m1 <= m0 * (1 + MOST) and d1 <= d0
            shown.add_row(name, f"{m0:.1f}", f"{m1:.1f}", f"{100 * (m1 / m0 - 1):+.1f} %", f"{d0:.0f}", f"{d1:.0f}")
    Console().print(shown)
    print("flat" if flat else f"not flat: more than {100 * MOST:.0f} % of memory, or more descriptors")


if __name__ == "__main__":
    main()
