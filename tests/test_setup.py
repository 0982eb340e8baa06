"""Set-up: the lock, the shell's environment, the stand-in for `ros2`, and the packages as colcon sees them."""

import os
import re
import shutil
import signal
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parent.parent
STAND_IN = ROOT / "scripts" / "bin" / "ros2"
PACKAGES = ["evodevo_ga", "evodevo_msgs", "evodevo_sim"]
SHELLS = [shell for shell in ("bash", "zsh") if shutil.which(shell)]

needs_environment = pytest.mark.skipif(
    Path(sys.prefix) != ROOT / ".venv", reason="is about .venv: `make test` runs the tests there"
)


# --- the lock ------------------------------------------------------------------------------------------------------------


def pins() -> dict[str, set[str]]:
    """Versions that the lock holds of each package; there are two where Python's version decides."""
    versions: dict[str, set[str]] = {}
    for name, version in re.findall(r"^([\w.-]+)==([\w.]+)", (ROOT / "requirements.lock").read_text(), re.MULTILINE):
        versions.setdefault(name, set()).add(version)
    return versions


def top_level() -> list[Requirement]:
    lines = [line.split("#")[0].strip() for line in (ROOT / "requirements.in").read_text().splitlines()]
    return [Requirement(line) for line in lines if line]


def test_lock_holds_only_pinned_and_hashed_packages():
    entries = (ROOT / "requirements.lock").read_text().replace("\\\n", " ").splitlines()
    for entry in entries:
        assert re.fullmatch(r"[\w.-]+==[\w.]+( ; [\w\s.'<>=!]+?)?(\s+--hash=sha256:[0-9a-f]{64})+\s*", entry), entry


@pytest.mark.parametrize("requirement", top_level(), ids=str)
def test_lock_meets_requirement(requirement):
    versions = pins()[requirement.name.lower().replace("_", "-")]
    assert all(version in requirement.specifier for version in versions)


def test_lock_leaves_out_the_package_that_clashes_with_the_wheels_own():
    assert "lark-parser" in pins() and "lark" not in pins()


# --- constraints for what the lock does not hold ----------------------------------------------------------------------


def wheel(directory: Path, name: str, version: str) -> None:
    """An empty wheel."""
    about = f"{name}-{version}.dist-info"
    with zipfile.ZipFile(directory / f"{name}-{version}-py3-none-any.whl", "w") as archive:
        archive.writestr(f"{about}/METADATA", f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
        archive.writestr(f"{about}/WHEEL", "Wheel-Version: 1.0\nGenerator: tests\nRoot-Is-Purelib: true\nTag: py3-none-any\n")
        archive.writestr(f"{about}/RECORD", "")


def test_pip_installs_the_peers_under_the_constraints(tmp_path):
    """Real pip, without an index, on empty wheels; with the lock itself it asks for hashes of the peers."""
    peers = ROOT / "benchmarks" / "requirements-peers.txt"
    for line in peers.read_text().splitlines():
        if line and not line.startswith("#"):
            wheel(tmp_path, *line.split("=="))
    constraints = tmp_path / "constraints.txt"
    constraints.write_text(subprocess.run([ROOT / "scripts" / "constraints.sh"], capture_output=True, text=True, check=True).stdout)
    held = [Requirement(line) for line in constraints.read_text().splitlines()]
    assert sorted(f"{one.name}{one.specifier}" for one in held) == sorted(f"{name}=={v}" for name, vs in pins().items() for v in vs)
    pip = [sys.executable, "-m", "pip", "install", "--dry-run", "--quiet", "--ignore-installed"]
    pip += ["--no-index", f"--find-links={tmp_path}", "-r", peers]
    lock = subprocess.run([*pip, "-c", ROOT / "requirements.lock"], capture_output=True, text=True, timeout=60)
    assert lock.returncode and "hash" in lock.stderr.lower()
    assert subprocess.run([*pip, "-c", constraints], capture_output=True, text=True, timeout=60).returncode == 0


def test_engines_that_are_missing_name_the_command(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    import peers

    assert "make peers" in peers.INSTALL and "make peers" in subprocess.run(
        ["make", "-C", ROOT, "help"], capture_output=True, text=True, timeout=30).stdout


# --- the environment of a shell ----------------------------------------------------------------------------------------


def in_shell(shell: str, script: str, directory: Path = ROOT, **variables: str) -> subprocess.CompletedProcess:
    """Run `script` in a shell that has sourced env.sh and otherwise holds only `variables`."""
    environment = {"PATH": "/usr/bin:/bin", "HOME": os.environ.get("HOME", "/")} | variables
    command = [shell, "-c", f". '{directory}/scripts/env.sh' && {script}"]
    return subprocess.run(command, env=environment, capture_output=True, text=True, cwd="/", timeout=30)


@needs_environment
@pytest.mark.parametrize("shell", SHELLS)
def test_environment_keeps_nodes_on_this_host(shell):
    assert in_shell(shell, "printenv ROS_AUTOMATIC_DISCOVERY_RANGE").stdout == "LOCALHOST\n"


@needs_environment
@pytest.mark.parametrize("shell", SHELLS)
def test_environment_leaves_a_chosen_discovery_range(shell):
    result = in_shell(shell, "printenv ROS_AUTOMATIC_DISCOVERY_RANGE", ROS_AUTOMATIC_DISCOVERY_RANGE="SUBNET")
    assert result.stdout == "SUBNET\n"


@needs_environment
@pytest.mark.parametrize("shell", SHELLS)
def test_environment_finds_python_ros2_and_packages(shell):
    result = in_shell(shell, "command -v python ros2 && ros2 pkg prefix evodevo_sim && python -c 'import rclpy, evodevo_msgs.msg'")
    assert result.stdout.splitlines() == [
        str(ROOT / ".venv/bin/python"), str(STAND_IN), str(ROOT / "ros_ws/install/evodevo_sim")
    ], result.stderr


@needs_environment
@pytest.mark.parametrize("shell", SHELLS)
def test_environment_can_be_sourced_again(shell):
    variables = "$PATH $AMENT_PREFIX_PATH $CMAKE_PREFIX_PATH $PYTHONPATH"
    once, twice = in_shell(shell, f'echo "{variables}" && . {ROOT}/scripts/env.sh && echo "{variables}"').stdout.splitlines()
    assert once == twice


@needs_environment
@pytest.mark.parametrize("shell", SHELLS)
def test_a_real_ros2_goes_before_the_stand_in(shell, tmp_path):
    executable(tmp_path / "ros2", "echo real")
    assert in_shell(shell, "ros2", PATH=f"/usr/bin:/bin:{tmp_path}").stdout == "real\n"


@pytest.mark.parametrize("shell", SHELLS)
def test_environment_says_what_to_do_before_set_up(shell, tmp_path):
    shutil.copytree(ROOT / "scripts", tmp_path / "scripts")
    result = in_shell(shell, "echo went on", directory=tmp_path)
    assert result.returncode == 1 and "run 'make setup'" in result.stderr and not result.stdout


# --- the stand-in ------------------------------------------------------------------------------------------------------


def executable(path: Path, script: str) -> Path:
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(0o755)
    return path


@pytest.fixture
def ros2(tmp_path):
    """Starts the stand-in where the ament index holds one package, `fake_robot`, with the executable `walk`."""
    index = tmp_path / "share/ament_index/resource_index/packages"
    library = tmp_path / "lib/fake_robot"
    index.mkdir(parents=True)
    library.mkdir(parents=True)
    (index / "fake_robot").touch()
    executable(library / "walk", 'echo "$$" "$@"; [ "$1" != wait ] || exec sleep 30; exit 7')
    (library / "notes.txt").touch()

    def start(*arguments: str) -> subprocess.Popen:
        return subprocess.Popen(
            [sys.executable, STAND_IN, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            env=os.environ | {"AMENT_PREFIX_PATH": str(tmp_path)},
            # A shell in the background ignores it.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # noqa: PLW1509  (it takes no lock)
        )

    return start


def finish(process: subprocess.Popen) -> tuple[int, str, str]:
    out, err = process.communicate(timeout=20)
    return process.returncode, out, err


def test_run_becomes_the_executable_and_hands_on_arguments(ros2):
    process = ros2("run", "fake_robot", "walk", "--speed", "a b", "--ros-args", "-p", "x:=1")
    assert finish(process) == (7, f"{process.pid} --speed a b --ros-args -p x:=1\n", "")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signals_reach_the_executable(ros2, number):
    process = ros2("run", "fake_robot", "walk", "wait")
    assert process.stdout.readline() == f"{process.pid} wait\n"
    process.send_signal(number)
    assert finish(process)[0] == -number


@pytest.mark.parametrize(
    "arguments, code, message",
    [
        (("run", "no_robot", "walk"), 1, "Package 'no_robot' not found"),
        (("run", "../robot", "walk"), 1, "Package '../robot' not found"),
        (("pkg", "prefix", "no_robot"), 1, "Package 'no_robot' not found"),
        (("pkg", "executables", "no_robot"), 1, "Package 'no_robot' not found"),
        (("run", "fake_robot", "swim"), 1, "No executable found"),
        (("run", "fake_robot", "notes.txt"), 1, "No executable found"),
        (("run", "fake_robot"), 2, "ros2 --help"),
        (("topic", "list"), 2, "ros2 --help"),
    ],
)
def test_an_error_is_one_line_with_the_mend(ros2, arguments, code, message):
    returned, out, err = finish(ros2(*arguments))
    assert (returned, out, err.count("\n")) == (code, "", 1) and message in err


@pytest.mark.parametrize(
    "arguments, answer",
    [
        (("pkg", "list"), "fake_robot\n"),
        (("pkg", "executables"), "fake_robot walk\n"),
        (("pkg", "executables", "fake_robot"), "fake_robot walk\n"),
    ],
)
def test_lists(ros2, arguments, answer):
    assert finish(ros2(*arguments)) == (0, answer, "")


@pytest.mark.parametrize("arguments", [(), ("--help",), ("run", "--help")])
def test_help(ros2, arguments):
    code, out, _ = finish(ros2(*arguments))
    assert code == 0 and "ros2 run PACKAGE EXECUTABLE" in out


# --- the packages ------------------------------------------------------------------------------------------------------


@needs_environment
@pytest.mark.parametrize("base", ["src", "src/evodevo", "src/evodevo/ros_ws"])
def test_packages_are_found_once_in_somebody_elses_workspace(base, tmp_path):
    (tmp_path / "src").mkdir()
    (tmp_path / "src/evodevo").symlink_to(ROOT)
    command = ["colcon", "--log-base", os.devnull, "list", "--names-only", "--base-paths", tmp_path / base]
    assert subprocess.run(command, capture_output=True, text=True, timeout=60).stdout.split() == PACKAGES


@needs_environment
def test_executables_start_with_the_environments_python():
    scripts = [path for path in ROOT.glob("ros_ws/install/evodevo_*/lib/evodevo_*/*") if path.is_file()]
    assert {path.name for path in scripts} >= {"evolve", "simulator", "replay"}
    assert {path.read_text().splitlines()[0] for path in scripts} == {f"#!{ROOT}/.venv/bin/python"}


@needs_environment
def test_wheels_name_no_directory_of_the_machine_that_built_them():
    files = list(Path(sys.prefix).glob("share/*/cmake/*.cmake"))
    assert files and not [path for path in files if "/opt/python/" in path.read_text()]


# --- set-up itself -----------------------------------------------------------------------------------------------------


def set_up(directory: Path, **variables: str) -> tuple[int, str, str]:
    """Exit code, output and errors of set-up in a checkout."""
    result = subprocess.run(
        [directory / "scripts/setup.sh"], env=os.environ | variables, capture_output=True, text=True, timeout=300
    )
    return result.returncode, result.stdout, result.stderr


@needs_environment
def test_set_up_leaves_alone_what_is_in_place():
    assert set_up(ROOT) == (0, "", "")


@pytest.fixture
def checkout(tmp_path):
    """A checkout in which nothing is set up, and which never gets as far as to install anything."""
    shutil.copytree(ROOT / "scripts", tmp_path / "scripts")
    (tmp_path / "requirements.lock").touch()
    return tmp_path


def test_set_up_names_an_interpreter_that_does_not_run(checkout):
    code, out, err = set_up(checkout, PYTHON="/nowhere/python3")
    assert (code, out, err.count("\n")) == (1, "", 1) and "/nowhere/python3 does not run" in err and "PYTHON=" in err


def test_set_up_names_an_interpreter_that_does_not_fit(checkout):
    old = executable(checkout / "python3", "echo is 3.9 >&2; exit 1")
    code, out, err = set_up(checkout, PYTHON=str(old))
    assert (code, out, err.count("\n")) == (1, "", 1) and f"{old} is 3.9" in err


def test_set_up_asks_for_a_compiler(checkout):
    tools = checkout / "tools"
    tools.mkdir()
    for tool in ("bash", "cat", "cut", "dirname", "env", "flock", "sed", "sha256sum", "uname"):
        (tools / tool).symlink_to(shutil.which(tool))
    code, out, err = set_up(checkout, PATH=str(tools), CXX="")
    assert (code, out, err.count("\n")) == (1, "", 1) and "apt install g++" in err
