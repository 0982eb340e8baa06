"""The structure: imports between rooms point one way, and the lower rooms know nothing of ROS, MCAP and Rerun."""

import ast
import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
_spec = importlib.util.spec_from_file_location("architecture", ROOT / "scripts" / "architecture.py")
architecture = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(architecture)

EDGE_LIBRARIES = {
    "ament_index_python", "builtin_interfaces", "evodevo_msgs", "geometry_msgs", "mcap", "mcap_ros2", "rcl_interfaces", "rclpy", "rerun",
    "rosbags", "sensor_msgs", "std_msgs", "std_srvs", "visualization_msgs",
}


def test_every_room_has_its_place_and_no_import_points_back():
    assert architecture.faults() == []


def test_a_wrong_arrow_is_seen(monkeypatch):
    monkeypatch.setattr(architecture, "imports", lambda: [("physics.forces", "tasks.evaluation")])
    assert architecture.faults() == ["physics.forces imports tasks.evaluation, which stands below it"]


def test_rooms_below_the_edge_import_nothing_of_ros():
    order = [name for name, _, _ in architecture.ROOMS]
    pure = set(order[: order.index(architecture.EDGE)]) | {""}
    for module, file in architecture.modules().items():
        if architecture.room_of(module) in pure:
            tree = ast.parse(file.read_text(encoding="utf-8"))
            names = {name.name for node in ast.walk(tree) if isinstance(node, ast.Import) for name in node.names}
            names |= {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and not node.level}
            assert not {name.partition(".")[0] for name in names} & EDGE_LIBRARIES, file


def wide(source: str, most: int = 8) -> list[tuple[str, int]]:
    """Functions of a file that take more than so many positional arguments, each with their number; self, cls and the context that numba
    hands to an intrinsic are given by nobody who calls."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)):
            names = [item.arg for item in (*node.args.posonlyargs, *node.args.args)]
            intrinsic = any(getattr(mark, "id", "") == "intrinsic" for mark in getattr(node, "decorator_list", ()))
            count = len(names) - (names[:1] in (["self"], ["cls"]) or intrinsic)
            if count > most:
                found.append((getattr(node, "name", "lambda"), count))
    return found


def test_no_function_takes_more_than_eight_positional_arguments():
    files = [file for folder in ("src", "scripts", "examples") for file in (ROOT / folder).rglob("*.py")]
    found = {str(file.relative_to(ROOT)): wide(file.read_text(encoding="utf-8")) for file in files}
    assert len(found) > 100 and not {file: functions for file, functions in found.items() if functions}


def test_a_function_of_nine_arguments_is_seen():
    nine = ", ".join("abcdefghi")
    assert wide(f"@kernel\ndef f({nine}): pass\nclass A:\n    def g(self, {nine}): pass\nh = lambda {nine}: 0") == [
        ("f", 9), ("g", 9), ("lambda", 9),
    ]
    assert wide("def f(a, b, c, d, e, f, g, h, *, i): pass\n@intrinsic\ndef k(typing, a, b, c, d, e, f, g, h): pass") == []


def test_an_evaluation_loads_none_of_the_edge():
    code = (
        "import sys; from evodevo_sim import Task, evaluate, load_genome, perform\n"
        f"print(sorted({EDGE_LIBRARIES!r} & {{name.partition('.')[0] for name in sys.modules}}))"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=True)
    assert result.stdout.strip() == "[]"


def test_the_figure_is_that_of_the_imports(tmp_path):
    pytest.importorskip("matplotlib")
    architecture.draw(tmp_path / "figure.svg")
    drawn, kept = ((path).read_text(encoding="utf-8") for path in (tmp_path / "figure.svg", architecture.FIGURE))
    assert drawn == kept, "run python scripts/architecture.py"
