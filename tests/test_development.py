"""Growth: division, mechanics, the Gabriel graph, both variants."""

import numpy as np
import pytest
from evodevo_sim.development.gabriel import gabriel_graph
from evodevo_sim.genetics.elements import MORPHOGEN, OUTPUTS
from evodevo_sim.genetics.regulation import activation
from evodevo_sim.tasks.life import develop
from evodevo_sim.tasks.swim.fitness import kernel_arguments
from genomes import FAR, dividing, first_viable, hand_made, unit
from hypothesis import given, settings
from hypothesis import strategies as st

from evodevo_sim import Development, ParameterError, Task, perform, random_genome


def brute_force_gabriel(p):
    """Edges by the definition with a closed circle, for points in general position."""
    n = len(p)
    return [
        (i, j) for i in range(n) for j in range(i + 1, n)
        if all(np.dot(p[i] - p[k], p[j] - p[k]) > 0 for k in range(n) if k not in (i, j))
    ]


@settings(max_examples=50, deadline=None)
@given(st.integers(2, 40), st.integers(0, 2**32))
def test_gabriel_graph_is_the_definition(cells, seed):
    p = np.random.default_rng(seed).uniform(-3, 3, (cells, 2))
    assert [tuple(e) for e in gabriel_graph(p).tolist()] == brute_force_gabriel(p)


def test_a_perfect_square_has_no_diagonal():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    assert gabriel_graph(square).tolist() == [[0, 1], [0, 3], [1, 2], [2, 3]]


def life(genome, **development):
    return perform(genome, Task(development=Development(**development), control_steps=8))


@pytest.mark.parametrize("variant", ["continual_graph", "graph_at_end"])
@pytest.mark.parametrize("cells", [2, 17, 32, 64])
def test_a_dividing_egg_fills_its_limit_with_spaced_cells(variant, cells):
    performance = life(dividing(), variant=variant, max_cells=cells)
    p = performance.growth[-1]
    assert len(p) == cells and np.isfinite(p).all()
    distance = np.linalg.norm(p[:, None] - p[None], axis=-1)[np.triu_indices(cells, 1)]
    assert distance.min() > 0.7  # cells are discs of diameter 1, pressed a little by adhesion
    assert np.linalg.matrix_rank(p - p[0], tol=1e-3) == min(cells - 1, 2)  # two-dimensional from three cells on


def test_an_egg_without_division_factor_stays_one_cell():
    performance = life(hand_made())
    assert performance.growth.shape[1] == 1 and performance.body is None


def test_cells_only_appear_never_vanish_and_inherit_their_place():
    growth = life(dividing(), max_cells=20).growth
    counts = np.isfinite(growth[..., 0]).sum(axis=1)
    assert counts[0] == 1 and np.all(np.diff(counts) >= 0) and counts[-1] == 20


@pytest.mark.parametrize("variant", ["continual_graph", "graph_at_end"])
def test_growth_is_the_same_every_time(variant):
    for genome in first_viable(3):
        once, again = (life(genome, variant=variant) for _ in range(2))
        assert np.array_equal(once.growth, again.growth, equal_nan=True)
        assert np.array_equal(once.position, again.position, equal_nan=True)


@pytest.mark.parametrize("variant", ["continual_graph", "graph_at_end"])
@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10_000), steps=st.integers(1, 150))
def test_growth_ends_at_any_step_with_the_gabriel_graph_of_that_moment(variant, seed, steps):
    genome = random_genome(np.random.default_rng(seed)) if seed % 3 else dividing()
    performance = life(genome, variant=variant, steps=steps, max_cells=24)
    assert performance.growth_edges[-1].tolist() == gabriel_graph(performance.growth[-1]).tolist()


@pytest.mark.parametrize("variant", ["continual_graph", "graph_at_end"])
@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_random_genomes_always_grow_to_something_finite(variant, seed):
    performance = life(random_genome(np.random.default_rng(seed)), variant=variant, max_cells=12)
    assert np.isfinite(performance.growth[-1]).all()


@pytest.mark.parametrize(
    "name, value", [("variant", "C"), ("max_cells", 0), ("steps", 2.5), ("division_threshold", np.nan), ("repulsion", "x")]
)
def test_impossible_settings_are_named(name, value):
    with pytest.raises(ParameterError, match=name):
        Development(**{name: value})


ROOM = 0.6
STILL = dict(repulsion=0.0, adhesion=0.0)  # all stay where they were born


def growth_of(genome, **development):
    """(steps + 1, N, 2) m, without a life after it; NaN where there is no cell yet."""
    law = Development(**development)
    shape = law.steps + 1, law.max_cells
    history, none = np.full((*shape, 2), np.nan), np.full((law.steps + 1, law.max_cells**2 + 1, 2), -1)
    embryo = develop(*kernel_arguments(genome, Task(development=law)), history, np.full(shape, np.nan), none)[2]
    return history[:, : len(embryo.position)]


@pytest.mark.parametrize("variant", ["continual_graph", "graph_at_end"])
@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10_000), turn=st.sampled_from([0.0, 0.02, -1.0]))
def test_with_room_asked_for_no_daughter_comes_nearer_to_others_than_her_mother(variant, seed, turn):
    """Mothers and daughters, half a diameter apart, are a tree; all other pairs have room."""
    genome = random_genome(np.random.default_rng(seed)) if seed % 3 else dividing()
    p = growth_of(genome, variant=variant, **STILL, division_room=ROOM, waiting_turn=turn, max_cells=24, steps=150)[-1]
    distance = np.linalg.norm(p[:, None] - p[None], axis=-1)[np.triu_indices(len(p), 1)]
    near = distance < ROOM
    assert near.sum() == len(p) - 1
    assert distance[near] == pytest.approx(np.full(len(p) - 1, 0.5), abs=1e-9)


def test_cells_wait_for_room_and_grow_on_when_they_have_turned_to_it():
    cells = lambda **law: growth_of(dividing(), **law).shape[1]
    assert cells(division_room=10.0) == 2  # the third would be near the first or the second, wherever it is
    waiting = dict(division_room=ROOM, division_turn=np.pi, axis_turn=0.0, **STILL)
    assert cells(**waiting) == 3  # two daughters on either side that point at their mother, as she does at one
    born = np.isfinite(growth_of(dividing(), **waiting, waiting_turn=0.004)[..., 0]).sum(axis=1)
    assert born[-1] > 3 and int(np.argmax(born > 3)) > 200  # when all has been at rest for long


@pytest.mark.parametrize("variant", ["continual_graph", "graph_at_end"])
def test_cells_with_as_many_neighbours_as_are_given_wait(variant):
    cells = lambda most: growth_of(dividing(), variant=variant, division_neighbours=most).shape[1]
    assert [cells(most) for most in (1, 64, 0)] == [2, 32, 32]  # each of a pair has one neighbour
    assert 2 < cells(2) <= cells(4)


def test_without_room_asked_for_nobody_waits():
    for genome in (dividing(), *(random_genome(np.random.default_rng(k)) for k in range(20))):
        usual, other = growth_of(genome), growth_of(genome, waiting_turn=1.0)
        assert np.array_equal(usual, other, equal_nan=True)


def test_a_newborns_morphogen_reaches_others_after_its_delay():
    """Variant A of two cells, in closed form: what a cell perceives at t is c(t - d/v) / (1 + d/range) of each, 0 from before a birth."""
    place = (0.0, 5 * FAR)
    genome = hand_made(
        {"constant": (1, 0.0, 0.0), "division": (1, 0.0, 0.0), "expansion": (1, *place)}, [unit([(1, 0.0, 0.0)], [(MORPHOGEN, 1, *place)])]
    )
    speed, far, rate = 0.05, 1.0, 0.3
    shape = dict(variant="graph_at_end", max_cells=2, morphogen_speed=speed, morphogen_range=far, regulation_rate=rate)
    made = lambda t: activation(10.0) * (1.0 - (1.0 - rate) ** t)
    growth = life(genome, **shape, steps=60).growth
    born = int(np.isfinite(growth[:, 1, 0]).argmax())
    heard, near = [], 1e-8  # the two still move by less than that; a step of delay more or less is 1e-3 and more
    for steps in range(1, 60):
        genes, model = kernel_arguments(genome, Task(development=Development(**shape, steps=steps)))
        none = np.empty((0, 0, 0)), np.empty((0, 0)), np.empty((0, 0, 0), np.int64)
        _, units, embryo = develop(genes, model, *none)
        t = steps - 1  # when the last step began
        if t < born:
            continue
        distance = np.linalg.norm(growth[t, 1] - growth[t, 0])
        then = t - int(distance / speed)
        factor = 1.0 / (1.0 + distance / far)
        perceived = embryo.table[units + OUTPUTS, :2]
        heard.append(then >= born)
        assert perceived[0] == pytest.approx(made(t) + factor * (made(then) if then >= born else 0.0), abs=near), t
        assert perceived[1] == pytest.approx(made(t) + factor * (made(then) if then >= 0 else 0.0), abs=near), t  # of its mother
    assert born > 0 and heard.count(False) >= 10 and heard.count(True) >= 10  # both sides of the delay were looked at
