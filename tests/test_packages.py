"""The packages as colcon, pip and rosdep see them: versions, dependencies, examples, launch files."""

import ast
import importlib.util
import re
import subprocess
import sys
import types
from pathlib import Path
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("evodevo_msgs", "evodevo_sim", "evodevo_ga")
# What a module that is imported is called by rosdep.  None: it has no key there, README says how to install it.
KEYS = {
    "matplotlib": "python3-matplotlib", "mpl_toolkits": "python3-matplotlib", "mcap": "mcap-ros2-support", "mcap_ros2": "mcap-ros2-support",
    "numba": "python3-numba", "llvmlite": "python3-numba", "numpy": "python3-numpy", "psutil": "python3-psutil", "rich": "python3-rich",
    "scipy": "python3-scipy", "tqdm": "python3-tqdm", "yaml": "python3-yaml", "zstandard": "python3-zstandard",
    "rosbags": "python3-rosbags-pip", "rerun": None, "rerun_cli": None, "rerun_bindings": None, "pyarrow": None,
}


def manifest(package):
    return ElementTree.parse(ROOT / "src" / package / "package.xml").getroot()


def imported(package):
    """Top-level names that a package's modules import, but for the standard library and itself."""
    names = set()
    for file in (ROOT / "src" / package / package).rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                names |= {name.name.partition(".")[0] for name in node.names}
            elif isinstance(node, ast.ImportFrom) and not node.level:
                names.add(node.module.partition(".")[0])
    return names - set(sys.stdlib_module_names) - {package}


@pytest.mark.parametrize("package", PACKAGES[1:])
def test_a_manifest_names_what_its_package_imports_and_nothing_else(package):
    wanted = {KEYS.get(name, name) for name in imported(package)} - {None}
    assert {node.text for node in manifest(package).findall("exec_depend")} == wanted


def test_there_is_one_version():
    versions = {package: manifest(package).findtext("version") for package in PACKAGES}
    versions["CITATION.cff"] = re.search(r"^version: (\S+)", (ROOT / "CITATION.cff").read_text(), re.MULTILINE)[1]
    import evodevo_sim

    versions["evodevo_sim.__version__"] = evodevo_sim.__version__
    assert len(set(versions.values())) == 1, versions


EXAMPLES = {
    "evaluate_champion.py": ([], r"OK: fitness \d+\.\d+ m, 32 cells"),
    "evolve_here.py": (["2"], r"generation 1: best .*\nchampion: \d+ elements"),
    "other_ground.py": ([], r"flat +OK +\d+\.\d+ m\nrough +OK .*\nstiffer +OK "),
    "live_animat.py": (["60"], r"after 1\.0 s its 32 cells are at"),
}


@pytest.mark.parametrize("name", EXAMPLES)
def test_examples_run(name):
    arguments, says = EXAMPLES[name]
    result = subprocess.run([sys.executable, ROOT / "examples" / name, *arguments], capture_output=True, text=True, timeout=280)
    assert result.returncode == 0, result.stderr
    assert re.search(says, result.stdout), result.stdout


class _Made:
    """Stands for any action or substitution of launch: keeps what it was made of."""

    def __init__(self, *given, **named):
        self.given, self.named = given, named

    def perform(self, context):
        return context[self.given[0]]


@pytest.fixture
def launch_stand_in(monkeypatch):
    """The names of ROS's launch packages, which no index of Python packages holds: what they make is looked at, not run."""
    for name, members in {
        "launch": ["LaunchDescription"],
        "launch.actions": ["DeclareLaunchArgument", "OpaqueFunction", "SetEnvironmentVariable", "Shutdown"],
        "launch.substitutions": ["EnvironmentVariable", "LaunchConfiguration"], "launch_ros": [], "launch_ros.actions": ["Node"],
    }.items():
        module = types.ModuleType(name)
        for member in members:
            setattr(module, member, type(member, (_Made,), {}))
        monkeypatch.setitem(sys.modules, name, module)


@pytest.mark.parametrize("file", sorted(ROOT.glob("src/*/launch/*.launch.py")), ids=lambda file: file.name)
def test_launch_files_start_executables_that_exist_on_this_host_alone(file, launch_stand_in):
    spec = importlib.util.spec_from_file_location("launch_file", file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    actions = module.generate_launch_description().given[0]
    variables = [action.given[0] for action in actions if type(action).__name__ == "SetEnvironmentVariable"]
    assert variables == ["ROS_AUTOMATIC_DISCOVERY_RANGE"]
    context = {
        action.given[0]: action.named.get("default_value", "genome.yaml")
        for action in actions if type(action).__name__ == "DeclareLaunchArgument"
    }
    nodes = [action for action in actions if type(action).__name__ == "Node"]
    for action in actions:
        if type(action).__name__ == "OpaqueFunction":
            nodes += action.named["function"](context)
    assert len(nodes) >= 2
    for node in nodes:
        setup = (ROOT / "src" / node.named["package"] / "setup.py").read_text()
        assert f'"{node.named["executable"]} = ' in setup
