"""All commands alike, those that are installed: signals at any moment, outputs that nobody reads, odd environments, help at once.

A command that is added is walked over without a line here; one in `BUSY` is kept at work long enough to be interrupted in it."""

import os
import re
import resource
import shlex
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import evodevo_sim.analysis.gait
import pytest
from ament_index_python.packages import get_package_prefix
from evodevo_sim.own_body.motion import SCENES
from evodevo_sim.physics.step_size import INTEGRATORS
from evodevo_sim.ros.command_line import see_it
from evodevo_sim.tasks.audit import MOST_CHANGE
from evodevo_sim.tasks.walk.audit import MOST_CHANGE as MOST_WALK_CHANGE
from evodevo_sim.worlds import PRESETS

import evodevo_ga
import evodevo_sim

ROOT = Path(__file__).resolve().parent.parent
CHAMPIONS, BAGS = ROOT / "ros_ws/src/evodevo_sim/champions", ROOT / "bags"
PACKAGES = ("evodevo_sim", "evodevo_ga")
COMMANDS = {path.name: path for package in PACKAGES for path in Path(get_package_prefix(package), "lib", package).iterdir()}
NODES = {"simulator", "chase", "evolve", "status"}  # they need the ROS graph
BODY = "position: [[0, 0], [1, 0], [0.5, 0.8]]\nactivation: {amplitude: 0.3, frequency: 1.0, phase: [0, 1, 2]}\n"
# What keeps a command busy for some seconds; {} is a directory of its own.
BUSY = {
    "audit": [CHAMPIONS / "ribbon.yaml", "--set", "control_steps=100000"],
    "chase": [CHAMPIONS / "seeker.yaml", "--each", "1000", "--capture", "0.001", "--out", "{}/a bag"],
    "evolve": ["--generations", "100000", "--simulators", "1", "--out", "{}/a run"],
    "film": [CHAMPIONS / "ribbon.yaml", "--set", "control_steps=100000", "-o", "{}/a.html"],
    "gait": [CHAMPIONS / "ribbon.yaml", "--set", "control_steps=100000", "--out", "{}/gait.png"],
    "replay": [BAGS / "sample-chemotaxis", "--no-viewer", "--save", "{}/a.rrd", "--png", "{}/a.png"],
    "simulate": ["{}/body.yaml", "--duration", "100000", "--out", "{}/a bag", "--npz", "{}/a.npz"],
    "simulator": [],
    "turning": [CHAMPIONS / "seeker.yaml"] * 200,
}
MOMENTS = (0.0, 0.03, 0.07, 0.15, 0.3, 0.6, 1.0, 1.7)  # s after signals are heard; what is not in BUSY ends within the first ones
HEARD_WITHIN = 0.3  # s of processor time
DEADLINE = 60.0  # s; the machine may be busy


def start(name, *arguments, **popen):
    """A command as its users start it: with the start-up hook of ROS's wheels, if there is one."""
    environment = popen.pop("env", os.environ) | {"DISPLAY": "", "WAYLAND_DISPLAY": ""}
    environment.pop("_ROS_WHEELS_BOOTSTRAP_COMPLETE", None)
    popen = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True} | popen
    return subprocess.Popen([COMMANDS[name], *map(str, arguments)], env=environment, start_new_session=True, **popen)


def run(name, *arguments, **popen):
    with start(name, *arguments, **popen) as process:
        out, err = process.communicate(timeout=DEADLINE)
    return process.returncode, out, err


def side_by_side(function, cases, at_once=3):
    with ThreadPoolExecutor(at_once) as pool:
        return list(pool.map(lambda case: function(*case), cases))


def hears(pid) -> bool:
    """Whether a process catches SIGTERM, which Python by itself does not."""
    caught = int(re.search(r"^SigCgt:\s*(\w+)", Path(f"/proc/{pid}/status").read_text(), re.MULTILINE)[1], 16)
    return bool(caught >> (signal.SIGTERM - 1) & 1)


def processor_time(pid) -> float:
    """Seconds."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(") ")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def until(ready, seconds=DEADLINE):
    deadline = time.monotonic() + seconds
    while not ready():
        assert time.monotonic() < deadline
        time.sleep(0.005)


def interrupted(name, moment, number, directory):
    """(whether it was still at work, exit code, stdout, stderr, s of processor time until it heard signals, 0 where it ended first)."""
    directory.mkdir()
    (directory / "body.yaml").write_text(BODY)
    arguments = [str(argument).replace("{}", str(directory)) for argument in BUSY.get(name, [])]
    with start(name, *arguments, cwd=directory) as process:
        until(lambda: process.poll() is not None or hears(process.pid))
        spent = processor_time(process.pid) if process.poll() is None else 0.0  # what has ended unwaited for still has its files
        time.sleep(moment)  # the case, not a synchronisation
        at_work = process.poll() is None
        process.send_signal(number)
        try:
            out, err = process.communicate(timeout=DEADLINE)
        except subprocess.TimeoutExpired:
            process.kill()
            return at_work, "never", *process.communicate(), spent
    return at_work, process.returncode, out, err, spent


def test_ctrl_c_at_any_moment_ends_every_command_in_good_order(tmp_path):
    cases = [
        (name, moment, signal.SIGINT, tmp_path / f"{name}-{moment}")
        for moment in MOMENTS for name in COMMANDS if name in BUSY or moment in MOMENTS[::2][:3]
    ]
    heard = dict.fromkeys(COMMANDS, 0)
    for (name, moment, _, directory), (at_work, code, out, err, spent) in zip(cases, side_by_side(interrupted, cases)):
        case = f"{name} after {moment} s: {code}\n{out}\n{err}"
        assert "Traceback" not in err and "Error" not in err and "nan" not in out.split(), case
        assert code == (0 if name == "simulator" else 130) or not at_work or name not in BUSY, case
        assert spent <= HEARD_WITHIN, case
        heard[name] += at_work
        for named in re.findall(r"replay (.*)", out):
            assert all(Path(directory, path).is_dir() for path in shlex.split(named)), case
        kept = {path.name for path in directory.iterdir()} - {"body.yaml"}
        assert kept <= {"a bag", "a run", "a.rrd", "a.png", "a.html", "bags"}, case  # no halves
        for recording in kept & {"a bag", "a run"}:
            assert (directory / recording / "metadata.yaml").exists(), case
    assert all(heard[name] >= 5 for name in BUSY), heard


def test_sigterm_and_a_closed_terminal_end_every_command(tmp_path):
    codes = {"simulator": 0, "evolve": 130}
    cases = [(name, 0.5, number, tmp_path / f"{name}-{int(number)}") for number in (signal.SIGTERM, signal.SIGHUP) for name in BUSY]
    for (name, _, number, _), (at_work, code, _, err, _) in zip(cases, side_by_side(interrupted, cases)):
        assert code == codes.get(name, 128 + number) and at_work and "Traceback" not in err, (name, number, code, err)


def test_nohup_is_respected(tmp_path):
    ignore = {"preexec_fn": lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN)}
    with start("gait", CHAMPIONS / "ribbon.yaml", "--set", "control_steps=100000", **ignore) as process:
        until(lambda: hears(process.pid))
        process.send_signal(signal.SIGHUP)
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=DEADLINE)
    assert process.returncode == 128 + signal.SIGTERM


def test_sigterm_is_heeded_while_kernels_compile(tmp_path):
    with start("gait", CHAMPIONS / "ribbon.yaml", env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}) as process:
        assert "Compiling" in process.stdout.readline()
        begun = processor_time(process.pid)
        until(lambda: processor_time(process.pid) > begun + 2.0)
        began = time.monotonic()
        process.send_signal(signal.SIGTERM)
        _, err = process.communicate(timeout=DEADLINE)
    assert process.returncode == 143 and err == "" and time.monotonic() - began < 3.0


def bare_start():
    """s of processor time of a Python that does nothing, the least of three, as busy as this machine is."""
    took = []
    for _ in range(3):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, "-c", "pass"], check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        took.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return min(took)


@pytest.mark.parametrize("name", COMMANDS)
def test_help_takes_no_time_and_does_not_mind_who_reads_it_or_where(name, tmp_path):
    took = []
    for _ in range(3):  # the least is what it needs: others on this machine make it longer
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        code, out, err = run(name, "--help")
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        assert code == 0 and out.startswith(f"usage: {name}") and not err
        took.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    assert min(took) <= max(0.3, 6.0 * bare_start())
    reader, writer = os.pipe()
    os.close(reader)
    (tmp_path / "gone").mkdir()
    odd = {"HOME": "/dev/null", "RMW_IMPLEMENTATION": "rmw_foo", "ROS_DOMAIN_ID": "abc", "ROS_LOG_DIR": "/proc/x"}
    code, _, err = run(name, "--help", stdout=writer, env=os.environ | odd, cwd=tmp_path / "gone", preexec_fn=(tmp_path / "gone").rmdir)
    os.close(writer)
    assert (code, err) == (0, "")


def test_output_that_nobody_reads_or_that_cannot_be_written(tmp_path):
    reader, writer = os.pipe()
    os.close(reader)
    picture = tmp_path / "a.png"
    code, _, err = run("gait", BAGS / "sample-swim", "--out", picture, stdout=writer)
    os.close(writer)
    assert (code, err) == (0, "") and picture.stat().st_size > 1000
    with open("/dev/full", "w") as full:
        code, _, err = run("gait", "--help", stdout=full)
    assert code == 1 and err.count("\n") == 1 and "No space left" in err
    closed = subprocess.run(["sh", "-c", f"exec {shlex.quote(str(COMMANDS['gait']))} --help >&- <&-"], stderr=subprocess.PIPE, text=True)
    assert (closed.returncode, closed.stderr) == (0, "")


ODD = {
    "ROS_DOMAIN_ID": ("abc", "300", "-1", "1e9999"), "RMW_IMPLEMENTATION": ("rmw_foo", "rmw_cyclonedds_cpp"),
    "ROS_LOG_DIR": ("/proc/x", "/dev/null/x"), "HOME": ("/dev/null", "", None),
}


def test_nodes_say_in_one_line_what_in_the_environment_is_wrong(tmp_path):
    arguments = {"chase": [CHAMPIONS / "seeker.yaml"], "evolve": ["--out", tmp_path / "run"]}

    def refused(name, variable, value):
        environment = {k: v for k, v in os.environ.items() if k not in ("ROS_LOG_DIR", "ROS_HOME", variable)}
        environment |= {} if value is None else {variable: value}
        return run(name, *arguments.get(name, []), env=environment, cwd=tmp_path)

    cases = [(name, variable, value) for name in sorted(NODES) for variable, values in ODD.items() for value in values]
    for (name, variable, value), (code, out, err) in zip(cases, side_by_side(refused, cases)):
        case = f"{name}, {variable}={value}: {code}\n{out}\n{err}"
        assert code == 2 and not out and err.count("\n") == 1 and err.startswith(f"{name}: ") and len(err) <= 300, case
        assert variable in err or "ROS_LOG_DIR" in err, case
    assert list(tmp_path.iterdir()) == []


def test_what_needs_no_graph_does_not_mind_what_is_wrong_with_it(tmp_path):
    caches = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    odd = {variable: values[0] for variable, values in ODD.items()} | {"NUMBA_CACHE_DIR": str(caches)}
    (tmp_path / "body.yaml").write_text(BODY)
    bag = tmp_path / "a bag"
    for name, *arguments in (
        ("simulate", "body.yaml", "--duration", "0.1", "--out", bag), ("replay", bag, "--no-viewer", "--png", "a.png"),
        ("gait", BAGS / "sample-walk"),
    ):
        code, out, err = run(name, *arguments, env=os.environ | odd, cwd=tmp_path)
        assert (code, err) == (0, ""), (name, code, out, err)
    for name in ("audit", "turning"):  # they read the recording, and find no champion
        code, out, err = run(name, bag, env=os.environ | odd, cwd=tmp_path)
        assert code == 2 and "holds no champion" in err and err.count("\n") == 1, (name, code, out, err)


def test_a_working_directory_that_is_gone_is_said_in_one_line(tmp_path):
    def start_nowhere(name):
        gone = tmp_path / name
        gone.mkdir()
        return run(name, "x", cwd=gone, preexec_fn=gone.rmdir)

    for name, (code, out, err) in zip(COMMANDS, side_by_side(start_nowhere, [(name,) for name in COMMANDS])):
        assert code == 2 and not out and err.count("\n") == 1 and err.startswith(f"{name}: the working directory"), (name, code, err)


def test_a_printed_command_can_be_typed_as_it_stands():
    for path in ("bags/run", "a b", "it's", "$(rm x)", "-x;y"):
        assert shlex.split(see_it(path).partition("ros2")[2]) == ["run", "evodevo_sim", "replay", path]


def test_help_names_all_that_can_be_chosen():
    text = {name: " ".join(run(name, "--help")[1].split()) for name in ("simulate", "evolve", "audit")}
    assert all(f"{', '.join(choice)} " in text["simulate"] for choice in (SCENES, INTEGRATORS))
    assert all(f"walk: {', '.join(PRESETS)}, or a file" in text[name] for name in ("simulate", "evolve"))
    assert f"(default {MOST_CHANGE}, of walkers {MOST_WALK_CHANGE})" in text["audit"]


@pytest.mark.parametrize("package", [evodevo_sim, evodevo_sim.analysis.gait, evodevo_ga], ids=lambda package: package.__name__)
def test_packages_offer_what_they_list_and_import_it_late(package):
    name = package.__name__
    code = (
        f"import sys, {name} as package\n"
        "assert not {'numba', 'numpy', 'rclpy', 'scipy'} & set(sys.modules), sorted(sys.modules)\n"
        "assert set(package.__all__) <= set(dir(package)) and len(set(package.__all__)) == len(package.__all__)\n"
        "try: package.nothing\n"
        "except AttributeError as error: assert 'nothing' in str(error)\n"
        "else: raise AssertionError\n"
        f"from {name} import *\n"
        f"from {name} import library\n"
        "assert sorted(library.__all__) == sorted(package.__all__)\n"
        "assert all(globals()[one] is getattr(package, one) is getattr(library, one) for one in package.__all__)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=DEADLINE)
    assert done.returncode == 0, done.stderr
