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
