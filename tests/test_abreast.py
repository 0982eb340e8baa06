"""Copies of one body abreast: the bits of each are those of the same life alone, whatever happens to the others."""

import dataclasses

import numpy as np
import pytest
from bodies import POLYGON_EDGES, POLYGONS, body_of, random_body
from evodevo_sim.brain.controller import Rules
from evodevo_sim.brain.scent import make_signals
from evodevo_sim.kernels.jit import kernel
from evodevo_sim.kernels.vectors import four
from evodevo_sim.parameters import Chemotaxis, Development, default_task, with_settings
from evodevo_sim.physics.abreast import (
    COPIES,
    advance_abreast,
    force_abreast,
    go_along,
    make_abreast,
    put_copy,
    put_rest,
    set_out,
    set_rest_abreast,
    take_copy,
    take_rest,
)
from evodevo_sim.physics.bounds import find_drag_rate
from evodevo_sim.physics.control_step import advance
from evodevo_sim.physics.forces import Ramp, accelerations, make_law, make_scratch, set_rest_lengths
from evodevo_sim.physics.soundness import SOUND
from evodevo_sim.plant.abreast import move_abreast
from evodevo_sim.plant.muscles import actuators_of
from evodevo_sim.plant.simulated import make_body_state
from evodevo_sim.tasks.chemotaxis.fitness import attempt, placements
from evodevo_sim.tasks.chemotaxis.kernel import Trials
from evodevo_sim.tasks.life import Kept, birth
from evodevo_sim.tasks.swim.abreast import begin, courses, make_copies
from evodevo_sim.tasks.swim.fitness import kernel_arguments
from evodevo_sim.tasks.swim.kernel import Stakes, course
from genomes import dividing, first_viable, pulsing
from hypothesis import given, settings
from hypothesis import strategies as st
from kept import NOISE, genome

from evodevo_sim import Status, evaluate, perform, random_genome

TASK = dataclasses.replace(
    default_task("chemotaxis"), development=Development(max_cells=12), control_steps=200,
    chemotaxis=Chemotaxis(least_distance=0.0, pairs=2),
)
LAWS = [{}, {"material.pressure": 0.0}, {"scene.drag_normal": 0.0, "scene.drag_tangential": 0.0}, {"material.damping": 0.0}]
RIG = {"rig.lag": 0.1, "rig.dead_time": 0.05, "rig.rate": 8.0, "rig.failures": 2, "rig.fail_at": 1.0}
EYES = {"rig.sensor_noise": 0.05, "rig.sensor_delay": 0.05, "rig.sensor_lost": 0.1}
STEP = TASK.control_step


def a_body(cells, seed):
    """A random body; the one of five cells has chambers of many corners."""
    return body_of(POLYGONS, POLYGON_EDGES) if cells == 5 else random_body(np.random.default_rng(seed), cells)


def copies_of(body, seed, faster=1.0):
    """Positions, velocities (4, 2, N), and activations before and after (4, N)."""
    rng, cells = np.random.default_rng(seed), len(body.position)
    position = body.position.T + rng.uniform(-0.03, 0.03, (COPIES, 2, cells))
    return position, faster * rng.uniform(-1.0, 1.0, (COPIES, 2, cells)), rng.uniform(-1.0, 1.0, (2, COPIES, cells))


def laid_out(body, law, position, velocity, activation):
    """Copies abreast, with rest lengths on their way."""
    abreast = make_abreast(body)
    for copy in range(COPIES):
        put_copy(abreast, copy, position[copy], velocity[copy])
    set_rest_abreast(body, law, activation[0], abreast)
    set_out(abreast)
    set_rest_abreast(body, law, activation[1], abreast)
    return abreast


def law_of(changed):
    task = with_settings(TASK, changed)
    return make_law(task.material.arguments(), task.scene.arguments())


def ramp_of(body, law, activation, copy):
    before, after = np.empty((2, body.rest_length.size))
    set_rest_lengths(body, law, activation[0, copy], before)
    set_rest_lengths(body, law, activation[1, copy], after)
    return before, after


@kernel
def _forces(body, law, share, abreast):
    for k in range(abreast.k1.size):
        abreast.k1[k] = 0.0
    force_abreast(body, law, abreast.state, four(share), abreast, abreast.k1)


@settings(max_examples=40, deadline=None)
@given(st.integers(3, 33), st.integers(0, 2**32), st.sampled_from(LAWS), st.sampled_from([0.0, 0.25, 1.0]))
def test_forces_are_those_of_each_copy_alone(cells, seed, changed, share):
    body, law = a_body(cells, seed), law_of(changed)
    position, velocity, activation = copies_of(body, seed)
    cells = len(body.position)
    abreast, scratch, out = laid_out(body, law, position, velocity, activation), make_scratch(body), np.empty((2, cells))
    _forces(body, law, share, abreast)
    found = abreast.k1[: 8 * cells].reshape(cells, 2, COPIES) * body.inverse_mass[:, None, None]
    for copy in range(COPIES):
        before, after = ramp_of(body, law, activation, copy)
        accelerations(body, law, before + share * (after - before), position[copy], velocity[copy], scratch, out)
        assert np.array_equal(found[:, :, copy].T, out)


@settings(max_examples=40, deadline=None)
@given(
    st.integers(3, 33), st.integers(0, 2**32), st.sampled_from(LAWS), st.tuples(*[st.integers(1, 4)] * 4),
    st.sampled_from([1.0, 8.0, 200.0]),
)
def test_a_control_step_is_that_of_each_copy_alone_unless_it_must_be_taken_alone(cells, seed, changed, substeps, faster):
    body, law = a_body(cells, seed), law_of(changed)
    position, velocity, activation = copies_of(body, seed, faster)
    cells = len(body.position)
    abreast, scratch = laid_out(body, law, position, velocity, activation), make_scratch(body)
    abreast.substeps[:] = substeps
    advance_abreast(body, law, abreast, STEP)
    for copy in range(COPIES):
        x, v = np.empty((2, 2, cells))
        take_copy(abreast.start, copy, x, v)
        assert np.array_equal(x, position[copy]) and np.array_equal(v, velocity[copy])
        outcome = advance(body, law, Ramp(*ramp_of(body, law, activation, copy), 0.0), x, v, STEP, substeps[copy], scratch)
        if abreast.sound[copy]:
            now = np.empty((2, 2, cells))
            take_copy(abreast.state, copy, *now)
            assert outcome == SOUND and np.array_equal(now, (x, v)) and abreast.rate[copy] == scratch.rate[0]


def test_calm_copies_need_not_go_alone():
    body, law = a_body(32, 1), law_of({})
    position, velocity, activation = copies_of(body, 1, 0.1)
    abreast = laid_out(body, law, position, velocity, 0.1 * activation)
    advance_abreast(body, law, abreast, STEP)
    assert abreast.sound.tolist() == [1.0] * COPIES


@pytest.mark.parametrize("alone", [(), (2,), (0, 1, 3), (0, 1, 2)])
def test_copies_that_blow_up_change_no_others(alone):
    """Those that are too fast go alone, up the ladder, and come out as they would anyway; a lane without a copy goes along."""
    body, law = a_body(20, 5), law_of({})
    position, velocity, activation = copies_of(body, 5, 0.1)
    velocity[list(alone)] *= 3000.0
    activation *= 0.1
    state = make_body_state(
        body, TASK.material.arguments(), TASK.scene.arguments(), STEP, 1.0, True, np.zeros(1, np.int64), actuators_of(TASK)
    )
    abreast, outcomes = laid_out(body, law, position, velocity, activation), np.zeros(COPIES, np.int64)
    go_along(abreast, 3, 2)
    move_abreast(state, abreast, STEP, outcomes)
    substeps, ends = abreast.substeps.copy(), outcomes.tolist()
    assert {copy for copy in range(3) if abreast.sound[copy] == 0.0} == set(alone) - {3}
    for copy in range(3):
        x, v, now = position[copy].copy(), velocity[copy].copy(), np.empty((2, 2, 20))
        outcome = advance(body, law, Ramp(*ramp_of(body, law, activation, copy), 0.0), x, v, STEP, substeps[copy], state.scratch)
        take_copy(abreast.state, copy, *now)
        assert outcome == ends[copy] and np.array_equal(now, (x, v), equal_nan=True)


def test_rest_lengths_are_kept_copy_by_copy():
    body = a_body(9, 2)
    abreast, rest = make_abreast(body), np.random.default_rng(0).random((COPIES, body.rest_length.size))
    for copy in range(COPIES):
        put_rest(abreast, copy, rest[copy])
    found = np.empty(body.rest_length.size)
    for copy in range(COPIES):
        take_rest(abreast.rest, copy, found)
        assert np.array_equal(found, rest[copy])


# --- swims whose copies do not start alike ---------------------------------------------------------------------------------


def swims_of(animal, task, kicks):
    """(status, step, active, path) of swims that begin with velocities (2,) m/s of the first cell: abreast, and one by one."""
    genes, model = kernel_arguments(animal, task, -np.inf)
    rules = Rules(task.control_step, model.development, model.continual, make_signals((3.0, 1.0), 10.0, 25.0))
    paths, alone = np.zeros((len(kicks), 10 * task.windows + 1, 2)), []
    _, life = birth(genes, model, 1.0)
    copies = make_copies(life, rules.signals.eyes)
    begin(copies, life, len(kicks))
    copies.target[:] = rules.signals.target
    born = np.empty((2, 2, life.brain.activation.size))
    for copy, kick in enumerate(kicks):
        take_copy(copies.abreast.state, copy, *born)
        born[1, :, 0] = kick
        put_copy(copies.abreast, copy, *born)
        find_drag_rate(life.state.body, life.state.law, *born, life.state.scratch)
        copies.abreast.rate[copy] = life.state.scratch.rate[0]
    courses(life, model, rules._replace(signals=make_signals()), copies, paths)
    for kick in kicks:
        _, life = birth(genes, model, 1.0)
        life.state.velocity[:, 0] = kick
        path, nothing = np.zeros(paths.shape[1:]), (np.empty((0, 0, 0)), np.empty((0, 0)))
        kept = Kept(np.empty((2, life.brain.activation.size)), *nothing)
        status, step, _, active, _ = course(life, model, rules, path, kept, Stakes(-np.inf, np.inf, np.inf))
        alone.append((status, step, active, path))
    return list(zip(copies.status.tolist(), copies.step.tolist(), copies.active.tolist(), paths)), alone


@pytest.mark.parametrize("animal", [dividing, pulsing])
@pytest.mark.parametrize("kicks", [[0.0, 1e5, 1.0, 0.0], [0.0, 0.0, 3.0], [1e5, 1e5, 0.0, 2.0], [0.0, 1e5]])
def test_ends_of_some_change_no_others(animal, kicks):
    """Some blow up at once, some rest sooner than others."""
    together, alone = swims_of(animal(), dataclasses.replace(TASK, control_steps=2000), [(kick, -kick) for kick in kicks])
    for one, other in zip(together, alone, strict=False):
        assert one[0] == other[0] and one[2] == other[2] and np.array_equal(one[3], other[3], equal_nan=True)
        assert one[0] == Status.OK or one[1] == other[1]
    ends = {one[0] for one, _ in zip(together, alone, strict=False)}
    assert (1e5 in kicks) == bool(ends & {Status.UNSTABLE, Status.INVERTED}) and (animal is dividing) == (Status.RESTING in ends)


# --- whole evaluations ----------------------------------------------------------------------------------------------------


def same(one: Trials, other: Trials) -> bool:
    return all(np.array_equal(a, b, equal_nan=True) for a, b in zip(one, other, strict=True))


def both(genome, task, seed=0, **how):
    """The swims abreast and one by one, which must be the same."""
    together = attempt(genome, task, seed, placements(task), **how)
    apart = attempt(genome, task, seed, placements(task), alone=len(placements(task)), **how)
    assert same(together, apart)
    return together


@pytest.mark.parametrize("pairs", [1, 2, 3])
@pytest.mark.parametrize("changed", [{}, NOISE, {"noise.sensing": 0.3}, RIG, EYES, NOISE | RIG | EYES])
def test_swims_abreast_are_those_one_by_one(changed, pairs):
    task = with_settings(TASK, {"chemotaxis.pairs": pairs, **changed})
    for seed, animal in enumerate([pulsing(), *first_viable(1)]):
        assert both(animal, task, seed).swims == 2 * pairs


@pytest.mark.parametrize("name", ["seeker"])
@pytest.mark.parametrize("every", [True, False])
def test_a_shipped_seeker_swims_the_same(name, every):
    task = with_settings(default_task("chemotaxis"), {"control_steps": 1000})
    assert both(genome(name), task, every=every).swims == 4


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**32), st.booleans(), st.sampled_from(["continual_graph", "graph_at_end"]), st.sampled_from([-np.inf, 0.5]))
def test_random_genomes_swim_the_same(seed, every, variant, bar):
    task = dataclasses.replace(TASK, development=Development(max_cells=16, variant=variant))
    both(random_genome(np.random.default_rng(seed)), task, every=every, bar=bar)


def test_swims_that_would_not_have_been_are_not_told_of():
    found = [both(animal, TASK, every=False) for animal in [pulsing(), *first_viable(3)]]
    few = [result for result in found if result.swims < 4]
    assert few and not any(result.paths[result.swims :].any() or result.actives[result.swims :].any() for result in few)


def test_a_bar_stops_between_swims():
    ends = {bar: both(pulsing(), TASK, bar=bar) for bar in np.linspace(0.0, 3.0, 16)}
    stopped = [result for result in ends.values() if result.status == Status.STOPPED and result.swims]
    assert all(np.isfinite(result.bound) for result in stopped)
    assert {result.status for result in ends.values()} >= {Status.OK, Status.STOPPED}


@pytest.mark.parametrize("alone", [0, 1, 2, 3])
def test_however_many_are_alone(alone):
    task = dataclasses.replace(TASK, chemotaxis=Chemotaxis(least_distance=0.0, pairs=3))
    together, some = (attempt(pulsing(), task, 0, placements(task), alone=count) for count in (0, alone))
    assert same(together, some)


def test_a_swim_that_is_shown_is_the_one_that_was_evaluated():
    assert perform(pulsing(), TASK).evaluation == evaluate(pulsing(), TASK)
