"""A sample of benchmarks/stress.py: whatever the body, muscles and parameters, a life ends sound or with a named outcome."""

import sys
from pathlib import Path

import numpy as np
import pytest
from bodies import slab
from evodevo_sim.live.animat import Animat, NotViable
from evodevo_sim.parameters import with_settings
from evodevo_sim.physics.bounds import bounds
from evodevo_sim.physics.forces import Law
from evodevo_sim.physics.integrators import State, carry_adaptively, make_system, make_work
from evodevo_sim.physics.replayed_motion import Frames, Method, follow
from evodevo_sim.physics.soundness import UNSTABLE
from evodevo_sim.physics.step_size import EULER, MOST_SUBSTEPS, RK4
from evodevo_sim.tasks.outcome import STIFF, Status
from genomes import dividing
from hypothesis import given, settings
from hypothesis import strategies as st

from evodevo_sim import Task, evaluate

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
from stress import stress

OUTCOMES = {"sound", "unstable", "inverted", "too stiff", "too many steps", "not run: many steps", "coincident cells"}
FAR = {"material.stiffness": 1e9, "material.mass": 1e-6, "control_step": 1.0}


def faults_of(seed, beyond):
    with np.errstate(all="ignore"):
        row = stress(seed, 0, beyond)
    assert {row["swim"], row["own"]} <= OUTCOMES
    return [fault for fault in row["faults"].split("; ") if fault]


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2**32))
def test_every_life_within_the_ranges_ends_sound_or_with_a_name(seed):
    assert faults_of(seed, beyond=False) == []


@pytest.mark.parametrize("case", [6123, 6152, 6405, 11031, 12015, 14770, 18141, 22846])
def test_springs_that_pass_through_themselves_and_drag_that_grows_make_no_energy(case):
    """The bodies of `benchmarks/stress.py` that once gained 1 to 67 % of their energy and were called sound."""
    with np.errstate(all="ignore"):
        assert stress(0, case, False)["faults"] == ""


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**32))
def test_beyond_the_ranges_nothing_crashes_and_no_nan_is_called_sound(seed):
    assert [fault for fault in faults_of(seed, beyond=True) if not fault.startswith("energy")] == []


def test_a_body_that_would_need_hours_is_named_at_once():
    evaluation = evaluate(dividing(), with_settings(Task(), FAR))
    assert (evaluation.status, evaluation.cause) == (Status.UNSTABLE, STIFF) and f"{MOST_SUBSTEPS} physics steps" in STIFF
    assert evaluation.fitness < -1 and evaluation.metrics.substeps == 0 and evaluation.metrics.chambers
    with pytest.raises(NotViable, match="physics steps"):
        Animat(dividing(), with_settings(Task(), FAR))


def test_a_frame_that_would_take_for_ever_ends_unstable():
    body = slab(3, 2)
    system = make_system(body, Law(1e9, 0.0, 1e9, 0.0, 0.0, 0.2))
    position, velocity, work = body.position.T.copy(), np.zeros((2, 6)), make_work(body)
    state, frames = State(position, velocity, np.zeros(0)), Frames(np.array([0.0, 60.0]), *np.empty((2, 2, 6, 2)))
    for method in (EULER, RK4):
        outcome, reached, _ = follow(system, Method(method, 0, 8.0, 0.0), bounds(system), 0.0, (0, 1), state, work, frames)
        assert (outcome, reached) == (UNSTABLE, 0) and np.array_equal(position.T, body.position)
    velocity[0, 0] = 1.0
    outcome, _, evaluations = carry_adaptively(system, 0.0, 60.0, 1e-9, 1e-6, state, work)
    assert outcome == UNSTABLE and evaluations < 1_000_000
