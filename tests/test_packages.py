"""The packages as colcon, pip and rosdep see them: versions, dependencies, examples, launch files."""

import ast
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
import threading
import types
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml
from evodevo_sim.parameters import default_task
from evodevo_sim.ros.messages import genome_message, task_message
from lab import Operator, simulators
from packaging.requirements import Requirement

import evodevo_sim
from evodevo_msgs.srv import Load
from evodevo_sim import GenomeError, champions, load_champion, load_genome

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("evodevo_msgs", "evodevo_sim", "evodevo_ga")
# What a module that is imported is called by rosdep.  None: it has no key there, README says how to install it.
KEYS = {
    "matplotlib": "python3-matplotlib", "mpl_toolkits": "python3-matplotlib", "mcap": "mcap-ros2-support", "mcap_ros2": "mcap-ros2-support",
    "numba": "python3-numba", "llvmlite": "python3-numba", "numpy": "python3-numpy", "psutil": "python3-psutil", "rich": "python3-rich",
    "scipy": "python3-scipy", "tqdm": "python3-tqdm", "yaml": "python3-yaml", "zstandard": "python3-zstandard",
    "rosbags": "python3-rosbags-pip", "rerun": None, "rerun_cli": None, "rerun_bindings": None, "pyarrow": None,
    "serial": "python3-serial", "cobs": None, "ribs": None, "distributed": None,
    "PIL": "python3-pil", "av": None,
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


def test_the_manifest_of_the_messages_names_what_they_use():
    lists = (ROOT / "src/evodevo_msgs/CMakeLists.txt").read_text()
    found = set(re.findall(r"find_package\((\w+)", lists))
    texts = [file.read_text() for file in (ROOT / "src/evodevo_msgs").glob("*/*.[ms]*")]
    used = {name for text in texts for name in re.findall(r"^(\w+)/\w+", text, re.MULTILINE)}
    root = manifest("evodevo_msgs")
    assert {node.text for node in root.findall("depend")} == used and used <= found
    assert found - used == {node.text for node in root.findall("buildtool_depend")}


@pytest.mark.parametrize("package", PACKAGES[1:])
def test_requirements_for_pip_bring_what_a_package_imports(package):
    """ROS's own packages come with those that the extra `ros` names, evodevo_msgs by colcon."""
    given = setup_of(package)
    named = {Requirement(one) for group in (given["install_requires"], *given["extras_require"].values()) for one in group}
    brought = {one.name.lower().replace("_", "-") for one in named} | ({"evodevo-sim"} & {package.replace("_", "-")})
    brought |= {"PIL"} if "pillow" in brought else set()
    if any("ros" in one.extras for one in named):  # those of the other package's extra
        brought |= {Requirement(one).name for one in setup_of("evodevo_sim")["extras_require"]["ros"]}
    names = {"mcap_ros2": "mcap-ros2-support", "yaml": "pyyaml", "mpl_toolkits": "matplotlib", "rerun": "rerun-sdk", "serial": "pyserial"}
    names |= {"pyarrow": "rerun-sdk"} if package == "evodevo_sim" else {}
    names |= dict.fromkeys(("rerun_cli", "rerun_bindings"), "rerun-sdk") | {"llvmlite": "numba", "rclpy": "ros-jazzy-rclpy"}
    of_ros = {"ament_index_python", "builtin_interfaces", "evodevo_msgs", "geometry_msgs", "rcl_interfaces", "std_msgs", "std_srvs"}
    of_ros |= {"diagnostic_msgs", "sensor_msgs", "visualization_msgs"}
    assert {names.get(name, name).replace("_", "-") for name in imported(package) - of_ros} <= brought


def setup_of(package):
    """The arguments of a package's setup()."""
    (call,) = [
        node for node in ast.walk(ast.parse((ROOT / "src" / package / "setup.py").read_text()))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "setup"
    ]
    return {one.arg: ast.literal_eval(one.value) for one in call.keywords if one.arg in ("install_requires", "extras_require")}


def test_there_is_one_version():
    versions = {package: manifest(package).findtext("version") for package in PACKAGES}
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    versions["CITATION.cff"] = citation["version"]
    versions["CHANGELOG.md"] = re.search(r"^## \[(\d\S*)\]", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)[1]
    versions["evodevo_sim.__version__"] = evodevo_sim.__version__
    assert len(set(versions.values())) == 1, versions


def test_the_citation_is_one():
    """CFF 1.2: what it demands, and that a reference is complete."""
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["cff-version"] == "1.2.0" and {"message", "title", "authors"} <= set(citation)
    (paper,) = citation["references"]
    assert {"type", "title", "authors", "journal", "year"} <= set(paper) and len(paper["authors"]) == 4
    assert all({"family-names", "given-names"} == set(author) for author in paper["authors"])


# --- pip ---------------------------------------------------------------------------------------------------------------

# What an installation without extras has: the standard library and these, and no ROS.
DECLARED = ("numpy", "numba", "llvmlite", "yaml", "evodevo_sim", "evodevo_ga")
ALONE = """
import sys, sysconfig

class Others:
    def find_spec(self, name, path=None, target=None):
        top = name.partition(".")[0]
        if top not in %(declared)r and top not in sys.stdlib_module_names and not top.startswith("_"):
            raise ModuleNotFoundError(f"No module named {top!r}", name=name)

sys.path[:0] = [%(site)r]
sys.meta_path.insert(0, Others())
""" % {"declared": DECLARED, "site": "SITE"}  # noqa: UP031  (it holds braces)

LIBRARY = """
import evodevo_sim
from evodevo_ga import Evolution, Settings
from evodevo_ga.in_process import evaluate_all
from evodevo_sim import Task, champions, evaluate, load_champion, make_own_body, perform, simulate_body
from evodevo_sim.kernels.jit import CACHE_DIRECTORY, is_compiled
from evodevo_sim.live import Animat
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.tasks.audit import audit

assert evodevo_sim.__file__.startswith("SITE"), evodevo_sim.__file__
assert all(str(file).startswith("SITE") for file in champions().values()) and len(champions()) == 7
task = with_settings(Task(), {"control_steps": 120})
genome = load_champion("ribbon")
assert evaluate(genome, task) == perform(genome, task).evaluation
assert is_compiled("swim") and "SITE" not in str(CACHE_DIRECTORY)
assert audit(genome, task, quick=True).stands
motion = simulate_body(make_own_body({"position": [[0, 0], [1, 0], [0, 1]]}), "swim", duration=0.1)
assert not motion.cause
animat = Animat(load_champion("seeker"), default_task("chemotaxis"))
animat.step()
evolution = Evolution(Settings(population=4, elite=1, tournament=2, generations=1), seed=1)
evolution.tell(evaluate_all(evolution.ask(), task))
for line in ("from evodevo_sim.analysis.gait import analyse", "from evodevo_sim.recording import read_recording"):
    try:
        exec(line)
    except ModuleNotFoundError as error:
        print(error)
"""


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Both packages as pip installs them, from a copy of the sources, without what they depend on."""
    folder = tmp_path_factory.mktemp("pip")
    for package in PACKAGES[1:]:
        shutil.copytree(
            ROOT / "src" / package, folder / package, symlinks=True, ignore=shutil.ignore_patterns("__pycache__", "build", "*.egg-info")
        )
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-index", "--no-deps"]
    pip += ["--no-build-isolation", "--target", folder / "site", *(folder / package for package in PACKAGES[1:])]
    result = subprocess.run(pip, capture_output=True, text=True, timeout=120)
    assert result.returncode == 0, result.stderr
    return folder / "site"


def alone(site, script, folder):
    """Run a script on an installation that has what is declared, and nothing else."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    command = [sys.executable, "-c", (ALONE + script).replace("SITE", str(site))]
    return subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True, timeout=280)


def test_an_installation_works_with_what_is_declared_alone(site, tmp_path):
    result = alone(site, LIBRARY, tmp_path)
    assert result.returncode == 0, result.stderr
    gaits, recording = result.stdout.splitlines()
    assert gaits == "scipy is not installed: pip install 'evodevo_sim[gaits]'"
    assert re.fullmatch(r"\w+ is not installed: (pip install 'evodevo_sim\[ros\]'|build it with colcon, as README tells)", recording)


COMMAND = """
import evodevo_sim.commands.entry as entry
sys.argv = ["COMMAND", *ARGUMENTS]
sys.exit(getattr(entry, "COMMAND")())
"""


@pytest.mark.parametrize("command, arguments, extra", [
    ("audit", ["genome.yaml"], "ros"), ("simulator", [], "ros"), ("gait", ["genome.yaml"], "(ros|gaits)"),
])
def test_commands_that_lack_an_extra_say_which_in_a_line(site, tmp_path, command, arguments, extra):
    result = alone(site, COMMAND.replace("COMMAND", command).replace("ARGUMENTS", repr(arguments)), tmp_path)
    assert result.returncode == 2 and result.stdout == "", result.stderr
    says = rf"{command}: \w+ is not installed: (pip install 'evodevo_sim\[{extra}\]'|build it with colcon, as README tells)\n"
    assert re.fullmatch(says, result.stderr), result.stderr


def test_an_installation_holds_what_belongs_to_it(site):
    names = {path.relative_to(site).as_posix() for path in site.rglob("*") if path.is_file()}
    sources = [ROOT / "src" / package for package in PACKAGES[1:]]
    modules = {path.relative_to(source).as_posix() for source in sources for path in (source / source.name).rglob("*.py")}
    assert modules <= names
    assert {"evodevo_sim/py.typed", "evodevo_ga/py.typed", "evodevo_sim/ros/discovery.xml", "evodevo_sim/champions/walker.yaml"} <= names
    assert {"share/evodevo_sim/launch/live.launch.py", "share/evodevo_ga/launch/evolve.launch.py", "share/evodevo_sim/package.xml"} <= names


def test_a_simulator_node_needs_neither_scipy_nor_what_draws(tmp_path):
    script = """
import sys
sys.modules.update(dict.fromkeys(["scipy", "matplotlib", "rerun", "pyarrow", "mpl_toolkits", "psutil", "rosbags"]))
import evodevo_sim.nodes.simulator
"""
    result = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120)
    assert result.returncode == 0, result.stderr


def test_a_champion_that_does_not_exist_names_those_that_do():
    with pytest.raises(GenomeError, match=r"^no champion is called 'fish': take one of jellyfish, jumper, .*, walker$"):
        load_champion("fish")


# --- examples ----------------------------------------------------------------------------------------------------------


EXAMPLES = {
    "evaluate_champion.py": (["jellyfish"], r"OK: fitness \d+\.\d+ m, 32 cells"),
    "evolve_here.py": (["2", "CHAMPION"], r"generation 0: .*\ngeneration 1: best .*\nchampion: \d+ elements"),
    "other_ground.py": ([], r"flat +OK +\d+\.\d+ m\nrough +OK .*\nsofter +OK "),
    "live_animat.py": (["60"], r"after 1\.0 s its 32 cells are at"),
    "body_by_hand.py": ([], r"sound: after 5\.0 s it is \(\+0\.33, \+0\.17\) m"),
    "name_its_gait.py": ([], r"undulation: .*\n\d\.\d\d Hz"),
    "plant_of_your_own.py": ([], r"32 cells, moved by up to 0\.\d\d m"),
    "driver_of_your_own.py": (["1"], r"ready\n"),
    "listen_to_cells.py": (["/example", "3"], r"(step \d+: 32 cells, the first at .* m\n){3}"),
}


def run_example(name, arguments, says):
    result = subprocess.run([sys.executable, ROOT / "examples" / name, *arguments], capture_output=True, text=True, timeout=280)
    assert result.returncode == 0, result.stderr
    assert re.fullmatch(f"(?s){says}.*", result.stdout), result.stdout


@pytest.mark.parametrize("name", [name for name in EXAMPLES if name != "listen_to_cells.py"])
def test_examples_run(name, tmp_path):
    arguments, says = EXAMPLES[name]
    run_example(name, [str(tmp_path / "champion.yaml") if one == "CHAMPION" else one for one in arguments], says)
    if "CHAMPION" in arguments:
        load_genome(tmp_path / "champion.yaml")


def test_the_example_of_a_node_hears_a_live_animat():
    with simulators("/example"), Operator() as operator:
        genome = genome_message(load_champion("seeker"))
        task = task_message(default_task("chemotaxis"))
        assert operator.call(Load, "/example/load", genome=genome, task=task, real_time_factor=1.0).success
        run_example("listen_to_cells.py", *EXAMPLES["listen_to_cells.py"])


def test_each_example_is_run_and_listed():
    files = {path.name for path in (ROOT / "examples").iterdir() if path.is_file()}
    assert files == {*EXAMPLES, "notebook.ipynb", "body.yaml"}
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert not [name for name in (*files, "climb/climb.py") if f"examples/{name}" not in readme]


def test_the_notebook_runs_and_holds_no_outputs():
    """As Jupyter would run it: cell by cell, in one namespace."""
    notebook = json.loads((ROOT / "examples/notebook.ipynb").read_text(encoding="utf-8"))
    cells = [one for one in notebook["cells"] if one["cell_type"] == "code"]
    assert not [one for one in cells if one["outputs"] or one["execution_count"]]
    script = "import sys\nscope = {}\nfor cell in sys.argv[1:]:\n    exec(cell, scope)\nassert 'rclpy' not in sys.modules"
    result = subprocess.run(
        [sys.executable, "-c", script, *("".join(one["source"]) for one in cells)], env=os.environ | {"MPLBACKEND": "Agg"},
        capture_output=True, text=True, timeout=280,
    )
    assert result.returncode == 0, result.stderr
    assert re.fullmatch(r".*ribbon.*\nOK: fitness \d+\.\d+ m, 32 cells\nchampion: fitness \d+\.\d+ m\n", result.stdout), result.stdout


# --- launch files ------------------------------------------------------------------------------------------------------


class _Made:
    """Stands for any action, substitution or event handler of launch: keeps what it was made of."""

    def __init__(self, *given, **named):
        self.given, self.named = given, named

    def perform(self, context):
        return context[self.given[0]]

    @property
    def kind(self):
        return type(self).__name__


@pytest.fixture
def launch_stand_in(monkeypatch):
    """The names of ROS's launch packages, which no index of Python packages holds."""
    for name, members in {
        "launch": ["LaunchDescription"],
        "launch.actions": ["DeclareLaunchArgument", "OpaqueFunction", "RegisterEventHandler", "SetEnvironmentVariable", "Shutdown"],
        "launch.event_handlers": ["OnProcessIO"], "launch.substitutions": ["EnvironmentVariable", "LaunchConfiguration"],
        "launch_ros": [], "launch_ros.actions": ["Node"],
    }.items():
        module = types.ModuleType(name)
        for member in members:
            setattr(module, member, type(member, (_Made,), {}))
        monkeypatch.setitem(sys.modules, name, module)


LAUNCH_FILES = {file.name: file for file in ROOT.glob("src/*/launch/*.launch.py")}


def launched(name, **arguments):
    """What a launch file starts with these arguments: (actions at once)."""
    spec = importlib.util.spec_from_file_location("launch_file", LAUNCH_FILES[name])
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    actions = module.generate_launch_description().given[0]
    assert [one.given[0] for one in actions if one.kind == "SetEnvironmentVariable"] == ["ROS_AUTOMATIC_DISCOVERY_RANGE"]
    declared = {one.given[0]: one.named.get("default_value") for one in actions if one.kind == "DeclareLaunchArgument"}
    assert set(arguments) <= set(declared)
    (function,) = [one.named["function"] for one in actions if one.kind == "OpaqueFunction"]
    return function(declared | arguments)


def started(node, index):
    """A node of a launch file as a process.  Its place in the graph is `index` of several."""
    setup = (ROOT / "src" / node.named["package"] / "setup.py").read_text()
    assert f'"{node.named["executable"]} = ' in setup
    command = [ROOT / "scripts/bin/ros2", "run", node.named["package"], node.named["executable"], *node.named.get("arguments", ())]
    if "namespace" in node.named:
        command += ["--ros-args", "-r", f"__ns:=/{node.named['namespace']}"]
        command += [word for one in node.named["parameters"] for key, value in one.items() for word in ("-p", f"{key}:={value}")]
    return subprocess.Popen([sys.executable, *command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def play(actions):
    """Start the nodes of a launch file, and what their output sets off.  Returns: the output of the node that came last."""
    handlers = {one.given[0].named["target_action"]: one.given[0].named for one in actions if one.kind == "RegisterEventHandler"}
    processes, follow, lock = [], [], threading.Lock()

    def listen(node, process):
        for line in process.stdout:
            with lock:
                follow.extend(handlers[node]["on_stderr"](types.SimpleNamespace(text=line.encode())) or ())
            if follow:
                done.set()
        done.set()

    done = threading.Event()
    try:
        for node in [one for one in actions if one.kind == "Node"]:
            processes.append(started(node, len(processes)))
            threading.Thread(target=listen, args=(node, processes[-1]), daemon=True).start()
        assert done.wait(120) and len(follow) == 1 and all(process.poll() is None for process in processes)
        processes.append(started(follow[0], 0))
        output = processes[-1].communicate(timeout=120)[0]
        assert processes[-1].returncode == 0 and [one.kind for one in follow[0].named["on_exit"]] == ["Shutdown"], output
        return output
    finally:
        for process in processes:
            process.terminate()
        for process in processes:
            process.wait(10)


def test_evolve_is_launched_on_simulators_that_are_ready(launch_stand_in, tmp_path):
    arguments = f"--generations 1 --population 4 --elite 1 --tournament 2 --quiet --out {tmp_path / 'run'}"
    output = play(launched("evolve.launch.py", simulators="1", arguments=arguments))
    assert "Evolving on 1 simulators of the graph: /sim_0/evaluate" in output


def test_a_chase_is_launched_on_a_simulator_that_is_ready(launch_stand_in, tmp_path):
    given = launched("live.launch.py", genome="seeker.yaml")
    assert [one.kind for one in given] == ["Node", "RegisterEventHandler"]
    arguments = f"--count 1 --each 0.2 --quiet --out {tmp_path / 'chase'}"
    output = play(launched("live.launch.py", genome=str(champions()["seeker"]), arguments=arguments))
    assert "of 1 targets captured" in output and (tmp_path / "chase/metadata.yaml").exists()


def test_evolve_follows_when_each_simulator_is_ready_or_has_ended(launch_stand_in):
    actions = launched("evolve.launch.py", simulators="3", task="walk", arguments="--seed 4")
    nodes = [one for one in actions if one.kind == "Node"]
    heard = [one.given[0].named["on_stderr"] for one in actions if one.kind == "RegisterEventHandler"]
    ready = types.SimpleNamespace(text=b"[INFO] [sim_0.simulator]: ready")
    assert [heard[0](ready), heard[0](ready), nodes[2].named["on_exit"](None, None)] == [None] * 3
    assert heard[1](types.SimpleNamespace(text=b"Compiling the simulation kernels, once: half a minute to a minute.")) is None
    (evolve,) = heard[1](ready)
    assert evolve.named["arguments"] == ["--task", "walk", "--seed", "4"]
    assert heard[1](ready) is None and nodes[0].named["on_exit"](None, None) is None
    for count in ("0", "many", "999"):
        with pytest.raises(RuntimeError, match=f"^simulators is '{count}': give 1 to 256$"):
            launched("evolve.launch.py", simulators=count)
