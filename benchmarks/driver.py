"""The time from a state of the body to the command that answers it, on the wire, and what a watchdog missed.

    python benchmarks/driver.py [--seconds S] [--cells N]

A body of N cells is emulated in a process of its own, at 60 Hz on a pseudo-terminal; a network of N cells drives it here.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from evodevo_sim.hardware.calibration import load_calibration
from evodevo_sim.hardware.serial_body import SerialBody
from evodevo_sim.hardware.trial import living

from evodevo_sim import read_genome


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--cells", type=int, default=64)
    given = parser.parse_args()
    genome_file = Path(__file__).with_name("swimmer.yaml")
    file = read_genome(genome_file)
    task = file.task(settings={"development.max_cells": given.cells})
    with tempfile.TemporaryDirectory() as directory:
        link, calibration = Path(directory, "body"), Path(directory, "body.yaml")
        emulator = subprocess.Popen(
            [sys.executable, "-m", "evodevo_sim.commands.emulate", genome_file, "--link", link, "--calibration", calibration,
             "--set", f"development.max_cells={given.cells}"], stdout=subprocess.PIPE, text=True,
        )
        while not link.is_symlink():
            if emulator.poll() is not None:
                sys.exit(2)
            time.sleep(0.05)
        body = SerialBody(str(link), load_calibration(calibration))
        animat = living(file.genome, task, 0, body)
        end = time.monotonic() + given.seconds
        while time.monotonic() < end:
            animat.step()
        latency = 1e3 * np.array(body.latency)
        counts = body.counts
        body.close()
        emulator.terminate()
        said, _ = emulator.communicate()
    silence = said.count("silence")
    print(f"{animat.steps} control steps of {body.calibration.cells} cells in {given.seconds:g} s")
    print(f"state to command: median {np.median(latency):.2f} ms, 99 % {np.percentile(latency, 99):.2f} ms, most {latency.max():.2f} ms")
    print(f"states lost: {counts.lost}; times that the watchdog vented: {silence}")


if __name__ == "__main__":
    main()
