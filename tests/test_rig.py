"""Evolution on hardware: trials on a body, the search of one body, and `evolve` on a driver with an emulated rig."""

import subprocess
import sys
import threading
from contextlib import contextmanager

import numpy as np
import pytest
import rclpy
from evodevo_ga.arguments import Options, parse
from evodevo_ga.keeping.resume import resumed
from evodevo_ga.one_body import NEAR, OneBody
from evodevo_ga.pool.vigil import PoolError
from evodevo_ga.run import rig as rig_module
from evodevo_ga.run.rig import Rig, find_body
from evodevo_sim.commands import audit
from evodevo_sim.development.shape import same_cells
from evodevo_sim.hardware.rig import make_rig
from evodevo_sim.hardware.trial import TrialError, trial
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.recording import read_recording
from evodevo_sim.recording.life import life_of
from evodevo_sim.ros.messages import evaluation_message
from evodevo_sim.ros.requests import BROKEN, UNREADY
from evodevo_sim.tasks.grown import grow
from evodevo_sim.tasks.outcome import Metrics, Status
from lab import DEADLINE, Operator
from rclpy.experimental import EventsExecutor
from rigs import GENOME, Instant, driver
from rigs import rig as emulated

from evodevo_ga import Evolution, Settings, scheme
from evodevo_msgs.srv import Cancel, Evaluate
from evodevo_sim import Evaluation, ParameterError, champions, evaluate, load_champion, random_genome

TASK = with_settings(default_task("swim"), {"control_steps": 400})
SHORT = with_settings(default_task("swim"), {"control_steps": 120})

# --- trials -----------------------------------------------------------------------------------------------------------------


def test_a_life_on_an_ideal_body_earns_what_it_earns_in_simulation():
    genome = load_champion(GENOME)
    shown = []
    found = trial(genome, TASK, 1, Instant(genome, TASK), show=lambda animat: shown.append(animat.steps))
    simulated = evaluate(genome, TASK, 1)
    assert found.status == Status.OK and found.fitness == pytest.approx(simulated.fitness, rel=0.05)
    assert found.metrics.activation_amplitude == pytest.approx(simulated.metrics.activation_amplitude, rel=1e-6)
    assert shown == list(range(TASK.control_steps + 1))


def test_lost_markers_do_not_change_what_a_life_earns():
    genome = load_champion(GENOME)
    whole, lossy = (trial(genome, TASK, 1, Instant(genome, TASK, make_rig({"sensors": {"lost": lost}}))) for lost in (0.0, 0.3))
    assert lossy.status == Status.OK and lossy.fitness == pytest.approx(whole.fitness, rel=0.05)
    blind = trial(genome, SHORT, 1, Instant(genome, SHORT, make_rig({"sensors": {"lost": 1.0}})))
    assert blind.status == Status.UNSTABLE and "no marker was seen from one window to the next in each of 3 lives" in blind.cause


def test_a_life_that_was_vented_is_lived_again():
    genome = load_champion(GENOME)
    calm = trial(genome, SHORT, 1, Instant(genome, SHORT))
    body = Instant(genome, SHORT, vented=range(170, 210))
    disturbed = trial(genome, SHORT, 1, body)
    assert disturbed.status == Status.OK and body.steps > 2 * SHORT.control_steps + 150
    assert disturbed.fitness == pytest.approx(calm.fitness, rel=0.1)
    often = trial(genome, SHORT, 1, Instant(genome, SHORT, vented=range(0, 10**5, 7)))
    assert often.status == Status.UNSTABLE and often.fitness < 0.0 and "not armed for" in often.cause and len(often.cause) < 300


def test_what_ends_a_trial_says_why_and_whether_anything_moved():
    genome = load_champion(GENOME)
    with pytest.raises(TrialError, match="pressure") as early:
        trial(genome, SHORT, 1, Instant(genome, SHORT, stopped=0))
    assert not early.value.moved
    with pytest.raises(TrialError, match="pressure") as late:
        trial(genome, SHORT, 1, Instant(genome, SHORT, stopped=180))
    assert late.value.moved
    with pytest.raises(TrialError, match="did not answer for 10 s"):
        trial(genome, SHORT, 1, Instant(genome, SHORT, silent=range(180, 10**5)))
    with pytest.raises(TrialError, match="it was stopped"):
        trial(genome, SHORT, 1, Instant(genome, SHORT), stop=lambda: True)
    with pytest.raises(ParameterError, match="give swim"):
        trial(genome, default_task("walk"), 1, Instant(genome, SHORT))


def test_another_body_fails_and_nothing_moves():
    body = Instant(load_champion(GENOME), SHORT)
    found = trial(load_champion("ribbon"), SHORT, 1, body)
    assert found.status == Status.INVALID_GENOME and "the body 'eel'" in found.cause and not body.told


def test_a_network_at_rest_is_not_waited_for():
    genome = next(
        one for k in range(100) if grow(one := random_genome(np.random.default_rng(k), 20), TASK).status == Status.OK
        and evaluate(one, TASK).status == Status.RESTING
    )
    body = Instant(genome, TASK)
    found = trial(genome, TASK, 1, body)
    assert found.status == Status.RESTING and found.fitness == 0.0 and len(body.told) < TASK.control_steps + 302


# --- the search of one body -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [GENOME, "ribbon"])
def test_children_of_one_body_have_it_and_no_other(name):
    genome = load_champion(name)
    settings = Settings(**scheme("one-body") | {"population": 6, "generations": 3, "elite": 1})
    evolution = Evolution(settings, 1, (genome,), "one-body", SHORT)
    body, best = grow(genome, SHORT).position, []
    while not evolution.finished:
        asked = evolution.ask()
        assert len(asked) >= 5 and all(same_cells(grow(one, SHORT).position, body, NEAR) for one in asked)
        assert len({grow(one, SHORT).key for one in asked}) == len(asked)
        again = Evolution.resumed(evolution.state(), SHORT).ask() if evolution.population else asked
        assert again == asked
        best.append(evolution.tell([evaluate(one, SHORT, 1) for one in asked]).best)
    assert best == sorted(best) and evolution.growths > 0 and len(evolution.population) == 6


def test_one_body_without_a_genome_is_that_of_a_random_one():
    search = OneBody(Settings(**scheme("one-body") | {"population": 4, "elite": 1}))
    search.task = SHORT
    children = search.first((), np.random.default_rng(2))
    bodies = [grow(child.genome, SHORT).position for child in children]
    assert len(children) == 4 and all(same_cells(one, bodies[0], NEAR) for one in bodies)


# --- evolve and its answers -------------------------------------------------------------------------------------------------

START = str(champions()[GENOME])


@pytest.mark.parametrize("arguments, says", [
    (["--rig", "eel", "--start", START], "--rig is 'eel': give the namespace of a driver"),
    (["--rig", "/eel"], "--rig is given without --start"),
    (["--rig", "/eel", "--start", START, "--simulators", "2"], "--simulators is given beside --rig"),
    (["--rig", "/eel", "--start", START, "--backend", "local"], "--backend is given beside --rig"),
    (["--rig", "/eel", "--start", START, "--plant", "plant.yaml"], "--plant is given beside --rig"),
    (["--rig", "/eel", "--start", START, "--task", "walk"], "--task is walk: give swim with --rig"),
])
def test_what_cannot_go_on_hardware_is_refused(arguments, says, capsys):
    with pytest.raises(SystemExit) as left:
        parse(arguments)
    said = capsys.readouterr().err
    assert left.value.code == 2 and says in said and said.count("\n") == 1


def test_the_scheme_of_a_rig_is_that_of_one_body():
    assert parse(["--rig", "/eel", "--start", START]).scheme == "one-body"
    assert parse(["--rig", "/eel", "--start", START, "--scheme", "panmictic"]).scheme == "panmictic"


def test_a_driver_that_is_not_there_is_named(monkeypatch, tmp_path):
    monkeypatch.setattr(rig_module, "_FIND", 0.2)
    options = Options(TASK, Settings(), 1, tmp_path, None, 1.0, True, rig="/nobody")
    with pytest.raises(PoolError, match="nobody tells /nobody/channels: start the driver"):
        find_body(options, [])


FINE = Evaluation(1.5, Status.OK, "", Metrics(cells=3))


@contextmanager
def answering(*answers):
    """(a `Rig`, what it said, ids of the requests) before a service that gives these answers, one after the other: an Evaluation, or a
    text of an error; None: none."""
    waiting, ids, said = list(answers), [], []
    with Operator() as operator:
        def evaluate(request, response):
            ids.append(request.id)
            answer = waiting.pop(0) if waiting else FINE
            if isinstance(answer, str):
                response.error = answer
            else:
                response.evaluations = [evaluation_message(answer)]
            return response

        operator.node.create_service(Evaluate, "/ray/evaluate", evaluate)
        operator.node.create_service(Cancel, "/ray/cancel", lambda request, response: response)
        stop = threading.Event()

        def spin():
            while not stop.is_set():
                operator.executor.spin_once(timeout_sec=0.05)

        thread = threading.Thread(target=spin)
        context = rclpy.Context()
        rclpy.init(context=context)
        node, executor = rclpy.create_node("evolves", context=context), EventsExecutor(context=context)
        executor.add_node(node)
        thread.start()
        try:
            yield Rig(node, executor, "/ray", said.append, 60.0), said, ids
        finally:
            stop.set()
            thread.join()
            node.destroy_node()
            executor.shutdown()
            rclpy.try_shutdown(context=context)


@pytest.fixture(autouse=True)
def soon(monkeypatch):
    monkeypatch.setattr(rig_module, "_REST", 0.05)


def test_answers_of_hardware_are_taken_asked_again_or_refused():
    genome = load_champion(GENOME)
    broken = f"{BROKEN}: pressure"
    with answering(f"{UNREADY}: arm it", FINE, broken, FINE, broken, broken) as (rig, _, ids):
        first, second, third = rig.evaluate([genome] * 3, SHORT, 1)
        assert first == second == FINE and len(ids) == 6 and len(set(ids)) == 3
        assert third.status == Status.UNSTABLE and "pressure, in each of 2 lives" in third.cause
        assert rig.evaluate([genome], SHORT, 1, stop=lambda: True) is None
    with answering("no such task: give swim") as (rig, _, _), pytest.raises(PoolError, match="/ray refuses to evaluate: no such task"):
        rig.evaluate([genome], SHORT, 1)
    odd = Evaluation(float("nan"), Status.OK, "", Metrics())
    with answering(odd) as (rig, _, _), pytest.raises(PoolError, match="a fitness of nan"):
        rig.evaluate([genome], SHORT, 1)


def test_a_body_that_is_gone_is_waited_for_but_not_for_ever(monkeypatch):
    with answering() as (rig, said, _):
        gone = Rig(rig._node, rig._executor, "/gone", said.append, 0.3)
        with pytest.raises(PoolError, match="nobody offers /gone/evaluate: start or arm it, and go on by --resume"):
            gone.evaluate([load_champion(GENOME)], SHORT, 1)
        assert said == ["waiting for the body: nobody offers /gone/evaluate"]


# --- the whole --------------------------------------------------------------------------------------------------------------


def evolve(*arguments):
    command = [sys.executable, "-m", "evodevo_ga.evolve", "--rig", "/rig", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE)


def test_evolve_on_an_emulated_rig(tmp_path, capsys):
    """A generation of two; then the run goes on."""
    faults = "actuators: {lag: 0.05}\nsensors: {noise: 0.002, lost: 0.01}"
    small = ["--population", "2", "--elite", "1", "--generations", "1", "--set", "control_steps=80", "--quiet", "--out", tmp_path / "run"]
    with emulated(tmp_path, faults) as (link, calibration, _), driver(link, calibration, namespace="/rig") as said:
        other = parse(["--rig", "/rig", "--start", str(champions()["peristalsis"]), *map(str, small)])
        with pytest.raises(PoolError, match=r"peristalsis.yaml: .*the body 'undulator' has .*: give a genome that grows this body"):
            find_body(other, [])
        assert "armed" not in said() and not (tmp_path / "run").exists()
        done = evolve("--start", START, *small)
        assert done.returncode == 0 and "Evolving on the body of /rig" in done.stdout, done.stdout + done.stderr
        assert "Audit:    none: it lived on hardware" in done.stdout
        more = evolve("--resume", tmp_path / "run", "--generations", "2", "--quiet")
        assert more.returncode == 0, more.stdout + more.stderr
    recording = read_recording(tmp_path / "run")
    assert [s.generation for s in recording.statistics] == [0, 1] and not recording.audits and recording.settings.scheme == "one-body"
    assert recording.channels.name == "undulator" and len(recording.channels.x) == recording.body.cells
    assert recording.champions[-1].evaluation.status == 0 and recording.champions[-1].evaluation.metrics.distance > 0.05
    life = life_of(recording)
    assert len(life.time) > 60 and len(life.growth) > 10 and np.ptp(life.centre, axis=0).max() > 0.02
    assert resumed(tmp_path / "run").rig == "/rig"
    for main, says in ((audit.main, "lived on the body 'undulator', which no audit repeats"),):
        with pytest.raises(SystemExit) as left:
            main([str(tmp_path / "run")])
        err = capsys.readouterr().err
        assert left.value.code == 2 and says in err and err.count("\n") == 1
