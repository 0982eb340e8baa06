"""The linter and the type checker find nothing, nothing is kept from them without a reason, and they hold the edge."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest
from evodevo_sim.kernels.jit import kernel_sources

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


def public_functions(body, prefix="", inside=False):
    """(dotted name, function, whether its first argument is the object) of a module or class, those with a leading underscore left out."""
    for node in body:
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            yield from public_functions(node.body, f"{prefix}{node.name}.", True)
        elif isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) and (node.name == "__init__" or not node.name.startswith("_")):
            static = any(isinstance(one, ast.Name) and one.id == "staticmethod" for one in node.decorator_list)
            yield prefix + node.name, node, inside and not static


def untyped(node, inside):
    taken = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs][inside:]
    taken += [one for one in (node.args.vararg, node.args.kwarg) if one]
    return [one.arg for one in taken if one.annotation is None] + ["return"] * (node.returns is None and node.name != "__init__")


def test_public_functions_outside_of_compiled_code_have_types():
    compiled = {Path(source).resolve() for source in kernel_sources()}
    files = [file for file in ROOT.glob("src/evodevo_*/evodevo_*/**/*.py") if file.resolve() not in compiled]
    found = [(file, *one) for file in files for one in public_functions(ast.parse(file.read_text()).body)]
    assert len(files) > 100 and len(found) > 300
    assert not [f"{file}: {name}: {lacks}" for file, name, node, inside in found if (lacks := untyped(node, inside))]


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
