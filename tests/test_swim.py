"""The swimming task: pure, from rest, and scored so that only sustained motion pays."""

import dataclasses
import itertools
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from bodies import LAW, accelerations_of, body_of
from evodevo_sim.physics.forces import make_scratch, set_rest_lengths
from evodevo_sim.physics.step_size import substeps_in_drag
from evodevo_sim.plant.simulated import RELAX_TOLERANCE
from evodevo_sim.tasks.life import develop
from evodevo_sim.tasks.outcome import Status
from evodevo_sim.tasks.swim.fitness import kernel_arguments
from genomes import beating, dividing, first_viable, hand_made

from evodevo_sim import Development, Scene, Task, evaluate, load_genome, perform

TASK = Task(development=Development(max_cells=16), control_steps=400)


@pytest.fixture(scope="module")
def swimmer():
    genome = beating()
    return genome, perform(genome, TASK)


def test_evaluation_gives_the_same_bits_every_time_and_in_threads(swimmer):
    genome, performance = swimmer
    with ThreadPoolExecutor(2) as pool:
        both = list(pool.map(lambda _: evaluate(genome, TASK), range(4)))
    assert all(e == evaluate(genome, TASK) for e in both)
    assert performance.evaluation == both[0]


@pytest.mark.parametrize("variant", ["continual_graph", "graph_at_end"])
def test_a_performance_is_the_evaluation_bit_for_bit(variant):
    task = dataclasses.replace(TASK, development=dataclasses.replace(TASK.development, variant=variant))
    for genome in first_viable(2) + [dividing(), hand_made()]:
        assert perform(genome, task).evaluation == evaluate(genome, task)


def test_a_swimmer_beats_from_rest_and_goes_somewhere(swimmer):
    _, performance = swimmer
    evaluation = performance.evaluation
    assert evaluation.status == Status.OK and evaluation.metrics.cells == 16
    assert not performance.velocity[0].any()
    assert performance.position[0].mean(axis=0) == pytest.approx(performance.body.position.mean(axis=0), abs=1e-9)
    assert evaluation.metrics.activation_amplitude > 0.02 and evaluation.metrics.distance > 1e-3 and evaluation.fitness > 0
    # In the shape that its muscles hold: no cell accelerates there, unlike with the muscles at rest.
    body, rest = performance.body, np.empty_like(performance.body.rest_length)
    set_rest_lengths(body, LAW, performance.activation[0], rest)
    start = performance.position[0].T.copy(), np.zeros((2, 16))
    assert np.abs(accelerations_of(body, LAW, *start, rest)).max() <= RELAX_TOLERANCE
    assert np.abs(accelerations_of(body, LAW, *start, body.rest_length)).max() > 1.0


def test_metrics_are_those_of_the_track(swimmer):
    _, performance = swimmer
    metrics = performance.evaluation.metrics
    centre = performance.position.mean(axis=1)  # all cells weigh the same
    quarters = centre[:: TASK.control_steps // TASK.windows]

    def between(a, b):
        return np.linalg.norm(b - a)

    assert metrics.distance == pytest.approx(between(centre[0], centre[-1]), abs=1e-9)
    assert metrics.distance_second_half == pytest.approx(between(centre[200], centre[-1]), abs=1e-9)
    ways = [between(a, b) for a, b in itertools.pairwise(quarters)]
    assert metrics.slowest_window == pytest.approx(min(ways) * metrics.distance / sum(ways), abs=1e-9)
    windows = performance.activation[1:].reshape(TASK.windows, -1, metrics.cells)
    assert metrics.activation_amplitude == pytest.approx((np.ptp(windows, axis=1) / 2).mean(axis=1).min(), abs=1e-9)
    body = performance.body
    assert (metrics.springs, metrics.chambers) == (len(body.rest_length), len(body.triangle_area) + len(body.polygon_area))
    assert performance.time[-1] == pytest.approx(TASK.control_steps * TASK.control_step)


def test_a_network_at_rest_moves_nothing_and_earns_nothing():
    evaluation = evaluate(dividing(), TASK)
    assert evaluation.status == Status.RESTING
    assert evaluation.fitness == pytest.approx(0, abs=1e-9) and evaluation.metrics.activation_amplitude < 1e-9
    performance = perform(dividing(), TASK)
    assert performance.position[-1] == pytest.approx(performance.position[0], abs=1e-3)  # resting ends the run, not the track
    assert np.isfinite(performance.position).all()


def test_what_cannot_swim_says_so_and_scores_below_standing_still():
    lone, pair = evaluate(hand_made(), TASK), evaluate(dividing(), dataclasses.replace(TASK, development=Development(max_cells=2)))
    assert lone.status == Status.NO_GROWTH and lone.metrics.cells == 1
    assert pair.status == Status.NO_CHAMBER and pair.metrics.cells == 2 and pair.metrics.chambers == 0
    assert lone.fitness < pair.fitness < 0 and lone.cause and pair.cause
    assert lone.metrics.distance == pair.metrics.distance == 0


def test_a_genome_that_never_divides_ends_when_its_network_rests():
    task = Task()
    genome = hand_made({"constant": (1, 0.0, 0.0), "expansion": (1, 0.0, 0.0)})
    genome, model = kernel_arguments(genome, task)
    nothing = np.empty((0, 0, 0)), np.empty((0, 0)), np.empty((0, 0, 0), np.int64)
    _, _, embryo = develop(genome, model, *nothing)
    assert len(embryo.position) == 1 and embryo.steps < task.development.steps // 2


@pytest.mark.parametrize("scene", [Scene(drag_normal=0.0, drag_tangential=0.0), Scene()])
def test_without_drag_no_swimmer_gets_anywhere(scene):
    evaluation = evaluate(beating(), dataclasses.replace(TASK, scene=scene))
    if scene.drag_normal:
        assert evaluation.metrics.distance > 1e-3
    else:
        assert evaluation.metrics.distance < 1e-9


def test_cells_stay_within_half_a_percent_of_a_diameter_of_a_run_with_sixteen_times_finer_steps():
    """One thousand control steps; the muscles are those of the network, and do not depend on the physics."""
    task = Task(control_steps=1000)
    coarse, fine = perform(beating(), task), perform(beating(), task, finer=16)
    error = coarse.position[-1] - fine.position[-1]
    assert 0 < np.sqrt((error**2).sum(axis=1).mean()) < 5e-3


def test_fast_drag_takes_more_substeps_and_a_scene_without_drag_none():
    """Each edge of a cell adds d l |v_n| / m: at its foot a triangle that falls at 0.5 m/s feels d x (0.5 + 0.25) / s."""
    body = body_of([(0.0, 0.0), (1.0, 0.0), (0.5, 0.9)])
    for drag, expected in ((0.0, 1), (380.0, 1), (390.0, 2), (760.0, 2), (780.0, 3), (1000.0, 3)):
        law = LAW._replace(drag_normal=drag, drag_tangential=0.0)
        velocity = np.array([[0.0, 0.0, 0.0], [-0.5, -0.5, -0.5]])
        many = substeps_in_drag(body, law, body.position.T.copy(), velocity, 1 / 60, 1, make_scratch(body))
        assert many == expected


@pytest.mark.parametrize("drag", [100.0, 1000.0, 10_000.0])
def test_strong_drag_ends_no_life(drag):
    evaluation = evaluate(beating(), dataclasses.replace(TASK, scene=Scene(drag_normal=drag, drag_tangential=drag / 200)))
    assert evaluation.status == Status.OK


@pytest.mark.parametrize("name", ["undulator", "ribbon"])
def test_shipped_swimmers_live_in_a_thousand_times_thicker_fluid_as_in_finer_steps(name):
    genome = load_genome(Path(__file__).parents[1] / f"src/evodevo_sim/champions/{name}.yaml")
    task = Task(scene=Scene(4e4, 200.0), control_steps=400)
    found, fine = perform(genome, task), perform(genome, task, finer=8)
    assert found.evaluation.status == fine.evaluation.status == Status.OK
    assert np.abs(found.position[-1] - fine.position[-1]).max() < 1e-4
