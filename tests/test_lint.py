"""The linter and the type checker find nothing, nothing is kept from them without a reason, and they hold the edge."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("src", "tests", "benchmarks", "scripts", "examples")
SILENCED = re.compile(r"#\s*(?:noqa|type:\s*ignore)\b.*")
REASONED = re.compile(r"# (?:noqa: [A-Z]+\d+(?:, [A-Z]+\d+)*|type: ignore\[[\w, -]+\])  \(.+\)$")


def test_ruff_and_mypy_find_nothing():
    found = subprocess.run([ROOT / "scripts/run.sh", ROOT / "scripts/lint.sh"], capture_output=True, text=True, timeout=240)
    assert found.returncode == 0, found.stdout[-4000:] + found.stderr[-1000:]


def test_whatever_is_silenced_says_what_and_why():
    files = [file for folder in FOLDERS for file in (ROOT / folder).rglob("*.py") if file != Path(__file__)]
    silenced = [(file, match[0]) for file in files for line in file.read_text().splitlines() if (match := SILENCED.search(line))]
    assert len(files) > 200 and len(silenced) > 5
    assert not [f"{file}: {text}" for file, text in silenced if not REASONED.search(text)]


@pytest.mark.parametrize("place, allowed", [
    ("evodevo_sim/evodevo_sim/physics", False), ("evodevo_sim/evodevo_sim/live", False), ("evodevo_sim/evodevo_sim/recording", True),
])
@pytest.mark.parametrize("name", ["rclpy.node", "evodevo_msgs.msg", "mcap.reader", "rerun"])
def test_ros_mcap_and_rerun_are_refused_below_the_edge(place, allowed, name):
    told = subprocess.run(
        [sys.executable, "-m", "ruff", "check", "--select", "TID251", "--output-format", "concise", "--stdin-filename",
         f"src/{place}/another.py", "-"],
        input=f"import {name}\n", capture_output=True, text=True, timeout=30, cwd=ROOT,
    )
    assert ("TID251" not in told.stdout) == allowed, told.stdout + told.stderr
