"""A run over DDS while its processes are stopped, killed and joined: the bits of the run in this process, and nobody dropped for good."""

import os
import signal
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest
from evodevo_ga.backends.ros import find_simulators
from evodevo_ga.in_process import evaluate_all
from evodevo_ga.status import main as status_here
from evodevo_ga.usual import usual_task
from evodevo_sim.parameters import with_settings
from evodevo_sim.recording import read_recording
from evodevo_sim.ros.host import has_ended, process_identity, runs
from evodevo_sim.ros.loopback import OWN_PROFILE, PROFILES
from evodevo_sim.ros.messages import genome_message, task_message
from evodevo_sim.ros.own_simulators import OwnSimulators
from evodevo_sim.ros.topics import STATISTICS, WORKER
from genomes import beating
from lab import DEADLINE, Operator, simulators

from evodevo_ga import Evolution, Settings
from evodevo_msgs.srv import Evaluate
from evodevo_sim import load_genome

NAMES = [
    "--population", "12", "--cells", "8", "--seed", "3", "--scheme", "panmictic", "--set", "control_steps=300", "--generations", "100000",
]
TASK = with_settings(usual_task("swim"), {"development.max_cells": 8, "control_steps": 300})


@pytest.fixture
def soon(tmp_path, monkeypatch):
    """Processes that are started count as gone after a second without a sign, not after six."""
    profile = tmp_path / "soon.xml"
    text = OWN_PROFILE.read_text()
    assert "<leaseDuration><sec>6</sec>" in text
    profile.write_text(text.replace("<leaseDuration><sec>6</sec>", "<leaseDuration><sec>1</sec>"))
    monkeypatch.setenv(PROFILES, str(profile))


class Watched:
    """An `evolve` whose generations an operator hears."""

    def __init__(self, operator, process):
        self.operator, self.process = operator, process
        self._heard = operator.listen(STATISTICS.type, STATISTICS.name, STATISTICS.quality)

    def more(self, generations=2):
        """Wait for so many new generations."""
        count = len(self._heard) + generations
        self.operator.until(lambda: len(self._heard) >= count or self.process.poll() is not None)
        assert self.process.poll() is None, self.process.communicate()

    def own(self):
        """Process numbers of its own simulators."""
        found = []
        for entry in Path("/proc").iterdir():
            if entry.name.isdigit():
                try:
                    if f"/_evolve_{self.process.pid}/".encode() in (entry / "cmdline").read_bytes():
                        found.append(int(entry.name))
                except OSError:
                    continue
        return found

    def end(self, code=130):
        self.process.send_signal(signal.SIGINT)
        _, stderr = self.process.communicate(timeout=DEADLINE)
        assert self.process.returncode == code and "Traceback" not in stderr, stderr
        return stderr


@contextmanager
def evolving(operator, out, *arguments):
    command = [sys.executable, "-m", "evodevo_ga.evolve", *NAMES, "--quiet", *arguments, "--out", str(out)]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    try:
        yield Watched(operator, process)
    finally:
        if process.poll() is None:
            process.kill()
            process.communicate()


def check_bits(out):
    """Each generation that was recorded is that of the run in this process, and so is the champion."""
    recording = read_recording(out)
    evolution = Evolution(Settings(population=12, generations=100000), 3)
    for told in recording.statistics:
        found = evolution.tell(evaluate_all(evolution.ask(), TASK, 3, 2))
        assert (found.best, found.median, found.diversity, found.evaluations) == (told.best, told.median, told.diversity, told.evaluations)
        if found.improved:
            champion = evolution.champion.genome
    assert load_genome(out / "champion.yaml") == champion and len(recording.statistics) > 3
    assert not (out / "quarantine").exists()


def stop(run, numbers, rounds):
    """Stop processes until others have noticed: `rounds` of the operator's spinning, a twentieth of a second each."""
    for number in numbers:
        os.kill(number, signal.SIGSTOP)
    for _ in range(rounds):
        run.operator.executor.spin_once(timeout_sec=0.05)
        run.operator.until(lambda: True)
    for number in numbers:
        os.kill(number, signal.SIGCONT)


def test_a_run_whose_processes_are_stopped_and_killed_is_the_undisturbed_one(soon, tmp_path):
    with Operator() as operator, evolving(operator, tmp_path / "run", "--simulators", "2") as run:
        run.more()
        for numbers in ([run.process.pid], run.own()[:1], run.own()):
            stop(run, numbers, 50)
            run.more()
        for k in range(3):
            own = run.own()
            os.kill(own[k % len(own)], signal.SIGKILL)
            run.more()
        for number in run.own():  # all at once
            os.kill(number, signal.SIGKILL)
        run.more()
        run.end()
    check_bits(tmp_path / "run")


def test_simulators_that_come_and_go_and_the_last_one_change_no_bit(soon, tmp_path):
    first, second, third = (f"/pool_{os.getpid()}_{k}" for k in range(3))
    with Operator() as operator, simulators(first) as [one]:
        operator.until(lambda: f"{first}/evaluate" in find_simulators(operator.node))
        with evolving(operator, tmp_path / "run", "--look", "5") as run:
            run.more()
            with simulators(second, arguments=["-p", "threads:=2"]) as [other]:
                told = operator.listen(WORKER.type, f"{second}/worker", WORKER.quality)
                operator.until(lambda: told and told[-1].evaluations > 0 and told[-1].threads == 2)
                one.kill()
                run.more(5)
                other.kill()
                line = run.process.stderr.readline()
                while "waiting for one" not in line:
                    assert line, "it ended"
                    line = run.process.stderr.readline()
            with simulators(third):
                run.more()
                run.end()
    check_bits(tmp_path / "run")


def test_a_request_that_is_asked_again_is_evaluated_once_and_threads_keep_the_order():
    name, task = f"/once_{os.getpid()}", task_message(with_settings(TASK, {"control_steps": 3000}))
    with simulators(name, arguments=["-p", "threads:=2"]), Operator() as operator:
        told = operator.listen(WORKER.type, f"{name}/worker", WORKER.quality)
        client = operator.node.create_client(Evaluate, f"{name}/evaluate")
        operator.until(client.service_is_ready)
        genomes = [genome_message(beating())] * 3
        asked = [client.call_async(Evaluate.Request(task=task, seed=1, genomes=genomes, id=5)) for _ in range(3)]
        asked.append(client.call_async(Evaluate.Request(task=task, seed=2, genomes=genomes[:2], id=5)))  # another one, by its content
        operator.until(lambda: all(one.done() for one in asked))
        again = client.call_async(Evaluate.Request(task=task, seed=1, genomes=genomes, id=5))
        operator.until(again.done)
        answers = [one.result() for one in [*asked[:3], again]]
        assert all(answer == answers[0] and not answer.error and answer.seconds > 0.0 for answer in answers)
        assert len(asked[3].result().evaluations) == 2
        operator.until(lambda: told and told[-1].evaluations >= 5)
        assert told[-1].evaluations == 5 and told[-1].faults == 0 and told[-1].threads == 2 and has_ended(told[-1].process) is False


def test_status_shows_who_is_there_and_says_where_nobody_is(capsys):
    name = f"/status_{os.getpid()}"
    command = [sys.executable, "-c", "import sys; from evodevo_ga.status import main; sys.exit(main(sys.argv[1:]))"]

    def status(*arguments):
        return subprocess.run([*command, *arguments], capture_output=True, text=True, timeout=DEADLINE)

    with simulators(name, arguments=["-p", "threads:=3"]), Operator() as operator:
        operator.until(lambda: f"{name}/evaluate" in find_simulators(operator.node))
        done = status("--look", "30")
    row = next(line for line in done.stdout.splitlines() if name in line)
    assert done.returncode == 0 and " 3 " in row and "not ours" not in row, done.stdout + done.stderr
    done = status("--look", "0.2")
    assert done.returncode in (0, 1) and (done.returncode == 0) == (done.stderr == ""), done.stderr  # what was killed is listed for a while
    for bad in ("0", "nan", "much"):
        with pytest.raises(SystemExit) as left:
            status_here(["--look", bad])
        said = capsys.readouterr().err
        assert left.value.code == 2 and said.count("\n") == 1 and "--look" in said


def test_own_simulators_are_started_anew_under_another_name_until_they_end_too_often(tmp_path, monkeypatch):
    clock = [0.0]
    monkeypatch.setattr("evodevo_sim.ros.own_simulators.time.monotonic", lambda: clock[0])
    monkeypatch.setattr("evodevo_sim.ros.own_simulators._OFTEN", 3)
    with OwnSimulators(1, tmp_path / "log") as own:
        names = []
        while not own.spent():
            names += own.services
            if own.services:
                one = own._own[0].process
                one.kill()
                one.wait()
                assert own.watch() == names[-1:] and own.services == []
                assert own.watch() == []  # its pause is not over
            clock[0] += 6.0
            own.watch()
        assert len(set(names)) == 3 and not own.alive()


def test_whether_a_process_runs_is_told_by_its_identity_and_never_guessed():
    mine = process_identity()
    assert has_ended(mine) is False and runs(mine) is True
    *space, number, started = mine.split("/")
    assert has_ended("/".join([*space, number, str(int(started) + 1)])) is True  # the number was given to another one
    assert has_ended("/".join([*space, "999999999", started])) is True
    for other in ("another/1/2/3", "", "/", mine + "/x", "x/" + mine, "/".join([*space, "self", started])):
        assert has_ended(other) is None and runs(other) is None
    with subprocess.Popen([sys.executable, "-c", "print('here', flush=True); input()"], stdin=-1, stdout=-1) as child:
        child.stdout.readline()
        started = Path(f"/proc/{child.pid}/stat").read_text().rpartition(") ")[2].split()[19]
        identity = "/".join([*space, str(child.pid), started])
        os.kill(child.pid, signal.SIGSTOP)
        os.waitid(os.P_PID, child.pid, os.WSTOPPED | os.WNOWAIT)
        assert runs(identity) is False and has_ended(identity) is False
        child.kill()
        os.waitid(os.P_PID, child.pid, os.WEXITED | os.WNOWAIT)
        assert has_ended(identity) is True and runs(identity) is False
