"""The evolve node end to end: real nodes over DDS on loopback, the same bits everywhere, and nothing lost when things go wrong."""

import os
import signal
import subprocess
import sys
import time

import pytest
import yaml
from evodevo_ga.arguments import parse
from evodevo_ga.backends.ros import find_simulators
from evodevo_ga.in_process import evaluate_all
from evodevo_ga.settings import UNLIMITED
from evodevo_ga.usual import usual_task
from evodevo_sim.parameters import with_settings
from evodevo_sim.recording import read_recording
from evodevo_sim.recording.life import life_of
from evodevo_sim.tasks.evaluation import invalid
from evodevo_sim.view.summary import headline, markdown
from lab import DEADLINE, Operator, simulators

from evodevo_ga import Evolution, Settings, scheme
from evodevo_sim import evaluate, load_genome

SMALL = ["--generations", "4", "--population", "14", "--cells", "8", "--seed", "3", "--set", "control_steps=80"]
TASK = with_settings(usual_task("swim"), {"development.max_cells": 8, "control_steps": 80})


def start(*arguments, out, output=subprocess.PIPE, **popen):
    command = [sys.executable, "-m", "evodevo_ga.evolve", *SMALL, *arguments, "--out", str(out)]
    environment = {k: v for k, v in os.environ.items() if k != "ROS_AUTOMATIC_DISCOVERY_RANGE"}
    return subprocess.Popen(command, stdout=output, stderr=subprocess.PIPE, text=True, env=environment, **popen)


def run(*arguments, out):
    process = start(*arguments, out=out)
    stdout, stderr = process.communicate(timeout=DEADLINE)
    return process.returncode, stdout, stderr


@pytest.fixture(scope="module")
def in_process():
    evolution = Evolution(Settings(generations=4, population=14), 3)
    history = []
    while not evolution.finished:
        history.append(evolution.tell(evaluate_all(evolution.ask(), TASK, 3)))
    return evolution, history


@pytest.mark.parametrize("arguments", [["--simulators", "1"], ["--simulators", "2", "--quiet"]])
def test_a_run_through_nodes_is_the_run_in_process_bit_for_bit(tmp_path, in_process, arguments):
    evolution, history = in_process
    code, stdout, stderr = run(*arguments, out=tmp_path / "run")
    assert code == 0, stderr
    assert ("s of wall time" in stdout and "waiting for simulators" in stdout) == ("--quiet" not in arguments)
    assert "ros2 run evodevo_sim replay" in stdout
    assert load_genome(tmp_path / "run/champion.yaml") == evolution.champion.genome
    recording = read_recording(tmp_path / "run")
    assert [s.best for s in recording.statistics] == [g.best for g in history]
    assert [s.median for s in recording.statistics] == [g.median for g in history]
    assert [s.diversity for s in recording.statistics] == [g.diversity for g in history]
    assert recording.settings.seed == 3 and recording.settings.scheme == "panmictic" and recording.settings.task.development.max_cells == 8
    grown = [champion for champion in recording.champions if not champion.evaluation.cause]
    assert [(a.generation, a.fitness) for a in recording.audits] == [(c.generation, c.evaluation.fitness) for c in grown] != []
    assert "audit: the fitness stands" in (tmp_path / "run/champion.yaml").read_text() and "the fitness stands" in stdout


def test_a_layered_run_through_nodes_is_recorded_with_its_settings(tmp_path):
    evolution = Evolution(Settings(generations=4, population=14, layers=2, age_gap=2), 3)
    history = []
    while not evolution.finished:
        history.append(evolution.tell(evaluate_all(evolution.ask(), TASK, 3)))
    code, _, stderr = run("--scheme", "alps", "--layers", "2", "--age-gap", "2", "--simulators", "1", out=tmp_path / "run")
    assert code == 0, stderr
    recording = read_recording(tmp_path / "run")
    assert (recording.settings.scheme, recording.settings.layers, recording.settings.age_gap) == ("alps", 2, 2)
    assert [(s.best, s.diversity) for s in recording.statistics] == [(g.best, g.diversity) for g in history]
    assert load_genome(tmp_path / "run/champion.yaml") == evolution.champion.genome


def test_a_run_in_which_nothing_lives_says_so_and_ends_with_exit_code_1(tmp_path):
    code, stdout, stderr = run("--simulators", "1", "--quiet", "--set", "development.division_threshold=0.9999999", out=tmp_path / "run")
    said = [line for line in stderr.splitlines() if line.startswith("evolve: ")]
    assert code == 1 and len(said) == 1 and len(said[0]) <= 300
    assert "nothing viable evolved: all of the last" in said[0] and "the egg never divided" in said[0]
    assert "Champion: fitness" not in stdout and "Best of those that failed: fitness -2.000" in stdout
    assert read_recording(tmp_path / "run").champions[-1].evaluation.cause == "the egg never divided"  # it can be looked into


def test_a_run_for_plain_distance_is_recorded_as_one(tmp_path):
    code, _, stderr = run("--simulators", "1", "--quiet", "--set", "task.fitness=distance", "--generations", "2", out=tmp_path / "run")
    recording = read_recording(tmp_path / "run")
    best = recording.champions[-1].evaluation
    assert code == 0, stderr
    assert recording.settings.task.fitness == "distance" and best.fitness == best.metrics.distance


def test_the_papers_scheme_ends_by_patience_alone():
    assert parse(["--scheme", "paper"]).settings.generations == UNLIMITED
    assert parse(["--scheme", "paper", "--generations", "7"]).settings.generations == 7
    assert parse([]).settings.generations == 50
    evolution = Evolution(Settings(**scheme("paper") | {"population": 10, "patience": 60}), 1)
    while not evolution.finished:
        genomes = evolution.ask()
        evolution.tell([invalid("of no use")] * len(genomes))
    assert evolution.generation == evolution.stagnation == 60  # beyond the 50 of other schemes


def test_champions_that_fail_their_audit_are_marked_and_change_nothing_else(tmp_path, in_process):
    code = "import evodevo_sim.tasks.audit as audit; audit.MOST_GAP = -1.0; from evodevo_ga.evolve import main; raise SystemExit(main())"
    command = [sys.executable, "-c", code, *SMALL, "--simulators", "1", "--out", str(tmp_path / "run")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE)
    assert done.returncode == 0, done.stderr
    recording = read_recording(tmp_path / "run")
    assert recording.audits and not any(audit.stands for audit in recording.audits)
    assert "of the energy is unexplained" in recording.audits[-1].faults[0]
    assert done.stdout.count("of generation") == len(recording.audits) and "Audit:    FAILED: as evolved: " in done.stdout
    assert "audit: 'FAILED: " in (tmp_path / "run/champion.yaml").read_text()
    assert load_genome(tmp_path / "run/champion.yaml") == in_process[0].champion.genome
    assert "fails its audit" in headline(recording, life_of(recording))[1]
    assert "**Audit:** **failed:** as evolved" in markdown(recording, life_of(recording))


def test_a_run_uses_the_simulators_on_the_graph_and_outlives_one(tmp_path, in_process):
    namespaces = [f"/lab_{os.getpid()}_{i}" for i in range(2)]
    with simulators(*namespaces) as nodes, Operator() as operator:
        services = [f"{namespace}/evaluate" for namespace in namespaces]
        operator.until(lambda: set(services) <= set(find_simulators(operator.node)))
        process = start("--look", "5", out=tmp_path / "run")
        assert "2 simulators of the graph" in first_line(process)
        nodes[0].kill()
        _stdout, stderr = process.communicate(timeout=DEADLINE)
        assert process.returncode == 0, stderr
        assert load_genome(tmp_path / "run/champion.yaml") == in_process[0].champion.genome
        assert nodes[1].poll() is None  # not ours, so not ended


def test_a_run_that_loses_its_last_simulator_keeps_what_was_done(tmp_path):
    with simulators(f"/lone_{os.getpid()}") as [node], Operator() as operator:
        operator.until(lambda: f"/lone_{os.getpid()}/evaluate" in find_simulators(operator.node))
        process = start("--generations", "100000", "--look", "5", "--give-up-after", "0", out=tmp_path / "run")
        assert "of the graph" in first_line(process)
        wait_for(tmp_path / "run/champion.yaml", process)
        node.terminate()
        stdout, stderr = process.communicate(timeout=DEADLINE)
    assert process.returncode == 2 and "evolve: no simulator is left" in stderr and "Traceback" not in stderr
    recording = read_recording(tmp_path / "run")
    assert recording.statistics and recording.champions and recording.body.cells and not recording.truncated
    assert "Champion: fitness" in stdout and f"Gait:     {recording.gait.name}" in stdout


def test_a_run_does_not_wait_for_a_simulator_that_is_listed_but_dead(tmp_path, in_process):
    namespace = f"/dead_{os.getpid()}"
    with simulators(namespace) as [node], Operator() as operator:
        operator.until(lambda: f"{namespace}/evaluate" in find_simulators(operator.node))
        node.kill()
        code, stdout, stderr = run(out=tmp_path / "run")
    assert code == 0, stderr
    assert "of our own" in stdout
    assert load_genome(tmp_path / "run/champion.yaml") == in_process[0].champion.genome


def first_line(process):
    """What it says first, once kernels are compiled."""
    while "Compiling" in (line := process.stdout.readline()):
        pass
    return line


def wait_for(path, process):
    """Until a file is there, while the process lives."""
    deadline = time.monotonic() + DEADLINE
    while not path.exists():
        assert time.monotonic() < deadline and process.poll() is None
        select_stderr(process)


def own_simulators(pid):
    """Process ids of simulators in the namespace of the evolve process `pid`."""
    found = []
    for entry in os.listdir("/proc"):
        if entry.isdigit():
            try:
                with open(f"/proc/{entry}/cmdline", "rb") as file:
                    command = file.read()
            except OSError:
                continue
            if f"/_evolve_{pid}/".encode() in command:
                found.append(int(entry))
    return found


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_keeps_what_was_done_and_ends_its_simulators(tmp_path, number):
    process = start("--generations", "100000", "--simulators", "1", out=tmp_path / "run")
    wait_for(tmp_path / "run/champion.yaml", process)
    process.send_signal(number)
    stdout, stderr = process.communicate(timeout=DEADLINE)
    assert process.returncode == 130, stderr
    assert "Traceback" not in stderr and "Champion: fitness" in stdout
    recording = read_recording(tmp_path / "run")
    assert not recording.truncated and len(recording.statistics) >= 1 and len(recording.champions) >= 1
    best = load_genome(tmp_path / "run/champion.yaml")
    assert evaluate(best, TASK, 3).fitness == recording.statistics[-1].best
    assert not own_simulators(process.pid)


def test_a_closed_terminal_ends_a_run_in_good_order_though_it_says_so_twice_and_nobody_reads(tmp_path):
    reader, writer = os.pipe()
    process = start("--generations", "100000", "--simulators", "1", out=tmp_path / "a run", output=writer)
    os.close(reader)
    os.close(writer)
    wait_for(tmp_path / "a run/champion.yaml", process)
    process.send_signal(signal.SIGHUP)
    process.send_signal(signal.SIGHUP)
    _, stderr = process.communicate(timeout=DEADLINE)
    assert process.returncode == 130 and "Error" not in stderr
    recording = read_recording(tmp_path / "a run")
    assert recording.champions and recording.body.cells and recording.gait and (tmp_path / "a run/metadata.yaml").exists()
    assert not own_simulators(process.pid)


def test_a_second_ctrl_c_ends_at_once_and_the_recording_is_whole(tmp_path):
    process = start("--generations", "100000", "--simulators", "1", out=tmp_path / "run")
    wait_for(tmp_path / "run/champion.yaml", process)
    os.kill(process.pid, signal.SIGSTOP)  # so that both are there before the first is heeded
    process.send_signal(signal.SIGINT)
    process.send_signal(signal.SIGTERM)
    os.kill(process.pid, signal.SIGCONT)
    stdout, stderr = process.communicate(timeout=DEADLINE)
    assert process.returncode == 130 and "Traceback" not in stderr and "Champion" not in stdout
    recording = read_recording(tmp_path / "run")
    assert recording.champions and recording.body is None and not recording.truncated
    assert yaml.safe_load((tmp_path / "run/metadata.yaml").read_text())["rosbag2_bagfile_information"]["message_count"] > 1
    assert [file.suffix for file in (tmp_path / "run").iterdir() if file.name.startswith(".")] == []


def select_stderr(process):
    """Wait a moment for output of the process, without sleeping longer than it is silent."""
    import select

    ready, _, _ = select.select([process.stderr], [], [], 0.1)
    if ready:
        os.read(process.stderr.fileno(), 65536)


def test_a_killed_run_leaves_no_simulators_and_its_champion(tmp_path):
    process = start("--generations", "100000", "--simulators", "1", out=tmp_path / "run")
    wait_for(tmp_path / "run/champion.yaml", process)
    [simulator] = own_simulators(process.pid)
    with open(f"/proc/{simulator}/environ", "rb") as file:
        assert b"ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST" in file.read().split(b"\0")
    process.kill()
    process.communicate()
    deadline = time.monotonic() + DEADLINE
    while own_simulators(process.pid):
        assert time.monotonic() < deadline
    load_genome(tmp_path / "run/champion.yaml")


@pytest.mark.parametrize(
    "arguments, says",
    [
        (["--preset", "treacle"], "preset 'treacle' is unknown: choose one of low_drag, high_drag, contact_inhibition"),
        (["--task", "fly"], "task 'fly' is unknown: choose one of swim"),
        (["--population", "1"], "settings.population is 1"),
        (["--population", "many"], "--population"),
        (["--seed", "-1"], "--seed is -1"),
        (["--cells", "0"], "development.max_cells is 0"),
        (["--set", "scene.drag=3"], "did you mean 'scene.drag_normal'"),
        (["--set", "scene.drag_normal=thick"], "scene.drag_normal is 'thick'"),
        (["--set", "windows=3"], "task.windows is 3"),
        (["--speed", "9"], "--speed"),
        (["--simulators", "0"], "--simulators is 0"),
        (["--look", "nan"], "--look is nan"),
    ],
)
def test_bad_flags_get_one_line_and_exit_code_2(tmp_path, arguments, says):
    code, _stdout, stderr = run(*arguments, out=tmp_path / "run")
    assert code == 2 and says in stderr and stderr.count("\n") == 1
    assert not (tmp_path / "run").exists()


def test_an_existing_directory_is_never_overwritten(tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "run/precious").write_text("data")
    code, _, stderr = run(out=tmp_path / "run")
    assert code == 2 and stderr.count("\n") == 1 and str(tmp_path / "run") in stderr
    assert [p.name for p in (tmp_path / "run").iterdir()] == ["precious"]


def test_a_place_that_cannot_be_written_gets_one_line(tmp_path):
    (tmp_path / "file").write_text("")
    code, _, stderr = run(out=tmp_path / "file/run")
    assert code == 2 and stderr.count("\n") == 1


def test_help_teaches(tmp_path):
    code, stdout, _ = run("--help", out=tmp_path)
    assert code == 0
    for word in ("--generations", "--set", "ros2 run evodevo_ga evolve", "replay", "champion.yaml"):
        assert word in stdout


def test_a_preset_sets_its_numbers_and_single_settings_go_over_it():
    options = parse(["--preset", "high_drag", "--set", "scene.drag_tangential=3"])
    assert (options.task.scene.drag_normal, options.task.scene.drag_tangential) == (400.0, 3.0)
