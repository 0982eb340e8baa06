"""Chemotaxis: what cells smell, that lives stay pure, and that only turning to both sides pays."""

import dataclasses

import numpy as np
import pytest
from evodevo_sim.brain.scent import scent, scent_row
from evodevo_sim.live.animat import Animat
from evodevo_sim.parameters import Chemotaxis, default_task
from evodevo_sim.tasks.chemotaxis.fitness import approach, attempt, placements, score
from evodevo_sim.tasks.chemotaxis.kernel import SAMPLES, Trials
from genomes import FAR, dividing, first_viable, pulsing
from hypothesis import given, settings
from hypothesis import strategies as st

from evodevo_sim import Development, Status, evaluate, perform

TASK = dataclasses.replace(
    default_task("chemotaxis"), development=Development(max_cells=12), control_steps=400,
    chemotaxis=Chemotaxis(least_distance=0.0, pairs=1),
)
SWIM = dataclasses.replace(TASK, name="swim")
ANGLE, DISTANCE = TASK.chemotaxis.angle, TASK.chemotaxis.distance
REACH = TASK.chemotaxis.scent_reach
LENGTH = TASK.windows * SAMPLES


def pulsing_smeller(sign=1):
    """A genome whose muscles beat, in which scent changes how much they contract."""
    genome = pulsing()
    x, y = genome.x.copy(), genome.y.copy()
    x[3], y[3] = 4.0, FAR  # within reach of the contraction output at (0.5, FAR)
    sign_of = genome.sign.copy()
    sign_of[3] = sign
    return dataclasses.replace(genome, x=x, y=y, sign=sign_of)


# --- scent ------------------------------------------------------------------------------------------------------------


@settings(deadline=None)
@given(st.floats(0, 100), st.floats(0, 6.3))
def test_scent_falls_linearly_from_its_peak_to_nothing(distance, angle):
    found = scent(distance * np.cos(angle), distance * np.sin(angle), 10.0, 25.0)
    assert found == pytest.approx(max(0.0, 10.0 * (1.0 - distance / 25.0)), abs=1e-12)


def test_every_cell_smells_the_target_at_its_own_place():
    animat = Animat(pulsing_smeller(), TASK)
    animat.target = (3.0, -4.0)
    places = animat.position.copy()
    animat.step()
    away = np.hypot(*(places - animat.target).T)
    assert smelt(animat) == pytest.approx(10.0 * np.maximum(0.0, 1.0 - away / REACH), abs=1e-12)
    animat.target = None
    animat.step()
    assert not smelt(animat).any()


@pytest.mark.parametrize("variant", ["continual_graph", "graph_at_end"])
def test_a_scent_of_nothing_is_no_scent_bit_for_bit(variant):
    """The network with the input, at a scent of 0, is the one without it; the first swim is that of a swimmer."""
    development = dataclasses.replace(TASK.development, variant=variant)
    for genome in [*first_viable(2), pulsing_smeller()]:
        task = dataclasses.replace(TASK, development=development)
        seeker, swimmer = Animat(genome, task), Animat(genome, dataclasses.replace(SWIM, development=development))
        result = attempt(genome, task, 0, np.empty((0, 2)))
        for _ in range(task.control_steps):
            if swimmer.status != Status.OK:  # resting ends its life, but not that of who waits for a target
                break
            assert np.array_equal(seeker.position, swimmer.position) and np.array_equal(seeker.activation, swimmer.activation)
            seeker.step()
            swimmer.step()
        assert result.path[-1] == pytest.approx(swimmer.position.mean(axis=0), abs=1e-6)


def test_scent_steers_muscles_only_where_the_task_has_a_target():
    lives = []
    for task, target in ((TASK, (3.0, 0.0)), (TASK, None), (SWIM, (3.0, 0.0))):
        animat = Animat(pulsing_smeller(), task)
        animat.target = target
        for _ in range(20):
            animat.step()
        lives.append(animat.activation.copy())
    assert not np.array_equal(lives[0], lives[1]) and np.array_equal(lives[1], lives[2])


def smelt(animat):
    return animat.brain.brain.table[scent_row(animat.brain.brain.units), : len(animat.position)]


# --- the three swims ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("variant", ["continual_graph", "graph_at_end"])
def test_a_performance_is_the_evaluation_and_the_swim_to_the_left_bit_for_bit(variant):
    task = dataclasses.replace(TASK, development=dataclasses.replace(TASK.development, variant=variant))
    genome = pulsing_smeller()
    performance = perform(genome, task)
    assert performance.evaluation == evaluate(genome, task) == evaluate(genome, task)
    animat = Animat(genome, task)
    animat.target = performance.target
    for step in range(task.control_steps + 1):
        assert np.array_equal(animat.position, performance.position[step])
        assert np.array_equal(animat.activation, performance.activation[step])
        animat.step()


def test_every_swim_begins_at_the_same_birth_and_targets_stand_by_its_way():
    result = attempt(pulsing_smeller(), TASK, 0, placements(TASK))
    assert result.tested and result.status == Status.OK
    start, heading = result.path[0], np.array(result.heading)
    assert np.array_equal(result.paths[0, 0], start) and np.array_equal(result.paths[1, 0], start)
    assert heading == pytest.approx((result.path[-1] - start) / np.linalg.norm(result.path[-1] - start))
    left, right = (np.array(target) - start for target in result.targets)
    across = np.array([-heading[1], heading[0]])
    for target, side in ((left, 1), (right, -1)):
        assert (target @ heading, target @ across) == pytest.approx(
            (DISTANCE * np.cos(ANGLE), side * DISTANCE * np.sin(ANGLE)), abs=1e-9
        )


def test_more_placements_change_no_swim():
    few = attempt(pulsing_smeller(), TASK, 0, placements(TASK))
    more = attempt(pulsing_smeller(), TASK, 0, [(0.3, 5.0), *placements(TASK)])
    assert np.array_equal(few.paths, more.paths[1:]) and np.array_equal(few.path, more.path)


@pytest.mark.parametrize("sign", [1, -1])
def test_swims_that_can_pay_nothing_are_spared_and_nothing_else_changes(sign):
    task, genome = dataclasses.replace(TASK, chemotaxis=Chemotaxis(least_distance=0.0, pairs=3)), pulsing_smeller(sign)
    every, few = (attempt(genome, task, 0, placements(task), every=every) for every in (True, False))
    n = few.swims
    assert every.swims == 6 > n >= 1 and np.array_equal(every.paths[:n], few.paths[:n]) and not few.paths[n:].any()
    bonus = few.active * task.activity_bonus * (few.actives[:n].min() - every.actives.min())
    assert score(few, task).fitness == pytest.approx(score(every, task).fitness + bonus, abs=1e-12)
    assert evaluate(genome, task) == score(few, task)


def test_who_gets_nowhere_is_not_tested_with_targets():
    task = dataclasses.replace(TASK, chemotaxis=Chemotaxis(least_distance=1e5))
    assert not attempt(pulsing_smeller(), task, 0, placements(task)).tested
    found = evaluate(dividing(), TASK)
    assert found.status == Status.RESTING and found.fitness == 0.0 and found.metrics.steering.distance == 0.0
    performance = perform(dividing(), TASK)
    assert performance.target is None and np.isfinite(performance.position).all()


def test_metrics_are_those_of_the_track():
    performance = perform(pulsing_smeller(), TASK)
    steering, centre = performance.evaluation.metrics.steering, performance.position.mean(axis=1)
    late = centre[np.arange(1, SAMPLES + 1) * (TASK.control_steps // LENGTH) + TASK.control_steps * 3 // 4]
    assert steering.distance == DISTANCE == pytest.approx(np.hypot(*(centre[0] - performance.target)))
    assert steering.left_distance == pytest.approx(np.hypot(*(late - performance.target).T).mean(), abs=1e-9)


# --- what pays ----------------------------------------------------------------------------------------------------------


def seeker(path, left, right, actives=(1.0, 1.0), angle=ANGLE):
    """Trials of made-up paths, which begin at 0 and head along x."""
    targets = np.array([(DISTANCE * np.cos(a), DISTANCE * np.sin(a)) for a in (angle, -angle)])
    return Trials(
        0, -1, path, 0.3, 1.0, 2, 12, 20, 9, True, (1.0, 0.0), targets, np.array([left, right]), np.array(actives), 2, np.inf
    )


def line(length, angle=0.0):
    return np.linspace(0.0, length, LENGTH + 1)[:, None] * (np.cos(angle), np.sin(angle))


def arc(length, turns):
    """A circle that begins along x, to the left where turns are positive."""
    angle = np.linspace(0.0, 2 * np.pi * turns, LENGTH + 1)
    radius = length / (2 * np.pi * turns)
    return radius * np.column_stack((np.sin(angle), 1.0 - np.cos(angle)))


def fitness(*paths, actives=(1.0, 1.0), angle=ANGLE):
    task = dataclasses.replace(TASK, chemotaxis=dataclasses.replace(TASK.chemotaxis, angle=angle))
    return score(seeker(*paths, actives, angle), task).fitness


@pytest.mark.parametrize("share", [0.7, 1.0, 1.3])
def test_a_circler_wins_nothing_from_its_targets(share):
    """Always to the left, with and without a target, wide or narrow, however near it comes to one of them."""
    for turns in (0.1, 0.25, 0.4, 1.0, 3.0):
        path = arc(20.0, turns)
        heading = (path[-1] - path[0]) / max(np.hypot(*path[-1]), 1e-9)
        turn = np.arctan2(*heading[::-1])
        same = path @ np.array([(np.cos(turn), -np.sin(turn)), (np.sin(turn), np.cos(turn))])  # heads along x, as `seeker` wants
        angle = share * ANGLE
        dead = fitness(same, same, same, actives=(0.0, 0.0), angle=angle)
        assert fitness(same, same, same, angle=angle) == pytest.approx(dead + TASK.activity_bonus)  # for muscles that work, and no more
        # One that circles only when it smells something is the best there is on one side, and still gains nothing.
        blind = fitness(line(20.0), line(20.0), line(20.0), angle=angle)
        assert fitness(line(20.0), same, same, angle=angle) == pytest.approx(blind)
    assert fitness(arc(20.0, 3.0), arc(20.0, 3.0), arc(20.0, 3.0)) == pytest.approx(2 * TASK.activity_bonus)


def test_turning_to_both_sides_pays_by_the_worse_one_and_arriving_pays_more():
    ahead = line(20.0)
    blind, to_left, to_right = fitness(ahead, ahead, ahead), line(20.0, ANGLE / 2), line(20.0, -ANGLE / 2)
    assert blind == pytest.approx(REACH + 2 * TASK.activity_bonus)  # beyond the scent's reach, speed pays nothing
    assert fitness(line(9.0), line(9.0), line(9.0)) == pytest.approx(9.0 + 2 * TASK.activity_bonus)
    assert fitness(ahead, to_left, ahead) == fitness(ahead, to_left, to_left) == blind  # one side alone
    both, weak = fitness(ahead, to_left, to_right), fitness(ahead, to_left, line(20.0, -ANGLE / 4))
    there = fitness(ahead, line(DISTANCE, ANGLE), line(DISTANCE, -ANGLE))
    assert blind < weak < both < there
    away = fitness(ahead, to_right, to_left)
    assert away == blind


def test_standing_still_at_a_scent_and_drifting_with_still_muscles_pay_nothing():
    ahead, still = line(20.0), np.zeros((LENGTH + 1, 2))
    assert fitness(ahead, still, still) == pytest.approx(fitness(ahead, ahead, ahead))
    there = line(DISTANCE, ANGLE), line(DISTANCE, -ANGLE)
    assert fitness(ahead, *there, actives=(1.0, 0.0)) == pytest.approx(fitness(ahead, ahead, ahead, actives=(0.0, 0.0)))


def test_approach_measures_distance_gain_and_turn():
    target = np.array([0.0, 10.0])
    distance, gain, turn = approach(np.repeat([[0.0, 0.0], [0.0, 5.0]], [LENGTH + 1 - SAMPLES, SAMPLES], 0), target, (1.0, 0.0), np.pi / 2)
    assert (distance, turn) == (pytest.approx(5.0), pytest.approx(np.pi / 2))
    assert gain == pytest.approx(np.sqrt(10.0**2 + 5.0**2) - 5.0)
    _, _, turn = approach(-line(5.0, np.pi / 2), -target, (1.0, 0.0), -np.pi / 2)
    assert turn == pytest.approx(np.pi / 2)  # towards the target, on whichever side it is


# --- noise --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("which", ["sensing", "concentrations", "actuation"])
def test_noise_is_seeded_and_changes_the_life(which):
    noisy = dataclasses.replace(TASK, noise=dataclasses.replace(TASK.noise, **{which: 0.05}))
    genome = pulsing_smeller()
    assert evaluate(genome, noisy, 1) == evaluate(genome, noisy, 1)
    assert len({evaluate(genome, task, seed).metrics for task, seed in ((noisy, 1), (noisy, 2), (TASK, 1))}) == 3
    assert evaluate(genome, TASK, 1) == evaluate(genome, TASK, 2)


# --- more pairs ---------------------------------------------------------------------------------------------------------


def test_pairs_spread_about_the_one_and_each_pays_by_its_worse_side():
    one, two = placements(TASK), placements(dataclasses.replace(TASK, chemotaxis=Chemotaxis(pairs=2, spread=0.25)))
    assert one == pytest.approx(np.array([(ANGLE, DISTANCE), (-ANGLE, DISTANCE)]))
    assert two == pytest.approx(np.array([(s * ANGLE * (1 + k), DISTANCE * (1 - k)) for k in (-0.25, 0.25) for s in (1, -1)]))
    task = dataclasses.replace(TASK, chemotaxis=Chemotaxis(pairs=2, spread=0.25, least_distance=0.0))
    targets = np.array([(d * np.cos(a), d * np.sin(a)) for a, d in two])

    def paid(*ends):
        paths = np.array([np.linspace(0.0, 1.0, LENGTH + 1)[:, None] * np.asarray(end) for end in ends])
        straight = 0, -1, line(20.0), 0.3, 1.0, 2, 12, 20, 9
        return score(Trials(*straight, True, (1.0, 0.0), targets, paths, np.ones(4), 4, np.inf), task).fitness

    all_four, three = paid(*targets), paid(*targets[:3], np.array([20.0, 0.0]))
    blind = REACH + 2 * TASK.activity_bonus
    assert blind + 20.0 < three < all_four - 20.0
    astray = np.array([20.0, 0.0])
    assert paid(targets[0], astray, *targets[2:]) == pytest.approx(blind)  # the first pair comes first
    for length in (2.0, 5.0, 20.0):  # straight ahead comes nearer to targets that stand ahead, and earns nothing
        assert paid(*[(length, 0.0)] * 4) == pytest.approx(blind)
    found = evaluate(pulsing_smeller(), task)
    assert found == evaluate(pulsing_smeller(), task) and found.metrics.steering.distance == pytest.approx(1.25 * DISTANCE)
