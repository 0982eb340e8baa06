"""Across the reality gap: tracking errors, numbers of a body fitted to recordings, and recordings of hardware wherever recordings go."""

import sys
from pathlib import Path

import numpy as np
import pytest
from evodevo_sim.analysis.stretches import LONGEST_GAP, filled
from evodevo_sim.commands import compare, film, gait, identify, info, replay
from evodevo_sim.hardware.rig import load_rig
from evodevo_sim.identification import FITTED, ObservationError, fit, predicted, tracking
from evodevo_sim.identification.fitting import USUAL
from evodevo_sim.identification.observation import body_of_parts
from evodevo_sim.identification.prediction import Model
from evodevo_sim.identification.tracking import laid_on
from evodevo_sim.recording import Recorder, read_recording
from evodevo_sim.recording.life import life_of
from evodevo_sim.recording.observed import control_step_of, observation_of
from evodevo_sim.ros.messages import body_message, cell_states_message
from hypothesis import given
from hypothesis import strategies as st

sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))
from identification import TRUTH, bodies, commands, observed

SECONDS = 4.0
PARTS = (("material", "stiffness"), ("material", "damping"), ("scene", "drag_normal"), ("scene", "drag_tangential"))


@pytest.fixture(scope="module")
def some():
    """Four small bodies."""
    return sorted(bodies(8, 3), key=lambda body: body.task.development.max_cells)[:4]


def record(directory, one, lost=0.0, first=1):
    """A recording as `ros2 bag record /eel/body /eel/cell_states` makes it.  Args: lost: share of the states that did not arrive."""
    rng = np.random.default_rng(5)
    with Recorder(directory) as recorder:
        recorder.write("eel/body", body_message(one.body), 10**9)
        for k in range(first, len(one.time)):
            if rng.random() >= lost:
                speed = (one.position[k] - one.position[k - 1]) / (one.time[k] - one.time[k - 1])
                message = cell_states_message(one.position[k], speed, one.activation[k], k, one.time[k])
                recorder.write("eel/cell_states", message, 10**9 + round(one.time[k] * 1e9))
    return directory


@pytest.mark.parametrize("noise, most", [(0.0, 0.02), (0.01, 0.05)])
def test_numbers_fitted_to_some_bodies_are_the_true_ones_and_hold_for_others(some, noise, most):
    seen = [observed(body, SECONDS, noise, k, lost=0.02) for k, body in enumerate(some[:2])]
    names = [name for name in USUAL if name != "drag_tangential" or not noise]  # it takes longer motions to tell from noise
    found = fit(seen, Model().with_numbers({"drag_tangential": TRUTH["drag_tangential"]}), names)
    for name, value in found.numbers.items():
        assert abs(value / TRUTH[name] - 1.0) < most, (name, value)
    for k, body in enumerate(some[2:]):
        other = observed(body, SECONDS, 0.0, 10 + k)
        track = predicted(other, found.model)
        assert tracking(other.time, other.position, track, other.length).relative < 0.03
        plain = tracking(other.time, other.position, predicted(other, Model()), other.length).relative
        assert plain > 2.0 * tracking(other.time, other.position, track, other.length).relative


def test_a_delay_is_told_from_a_lag(some):
    one = observed(some[0], SECONDS, 0.0, 1)
    late = 3
    shifted = type(one)(one.name, one.body, one.time[late:], one.position[:-late], one.activation[late:])
    found = fit([shifted], Model().with_numbers({name: TRUTH[name] for name in USUAL}), ["lag", "delay"])
    assert found.numbers["delay"] == pytest.approx(late / 60, abs=2e-3) and found.numbers["lag"] == pytest.approx(TRUTH["lag"], rel=0.02)


def test_what_leaves_no_trace_is_refused(some):
    one = observed(some[0], SECONDS, 0.0, 1)
    still = type(one)(one.name, one.body, one.time, np.repeat(one.position[:1], len(one.time), 0), np.zeros_like(one.activation))
    with pytest.raises(ObservationError, match="say nothing of"):
        fit([still], Model(), ["lag"])
    with pytest.raises(ObservationError, match="'mass' cannot be fitted: choose of stiffness"):
        fit([one], Model(), ["mass"])


@given(st.floats(-3, 3), st.floats(-50, 50), st.floats(-50, 50), st.integers(0, 2**32))
def test_motions_that_differ_by_a_pose_do_not_differ(angle, x, y, seed):
    rng = np.random.default_rng(seed)
    position, time = np.cumsum(rng.normal(size=(20, 5, 2)), axis=0), np.arange(20) / 60
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    other = position @ turn.T + (x, y)
    seen = np.where(rng.random((20, 5, 1)) < 0.2, np.nan, position)
    seen[0] = position[0]
    found = tracking(time, seen, other, 4.0)
    assert found.rms < 1e-9 and found.shape.max() < 1e-9 and found.centre.max() < 1e-9
    off = tracking(time, position, other + np.linspace(0.0, 2.0, 20)[:, None, None] * turn[:, 0], 4.0)
    assert off.centre[-1] == pytest.approx(2.0) and off.shape.max() < 1e-9 and off.relative == pytest.approx(off.rms / 4.0)
    assert np.allclose(laid_on(position[:1], other[:1], np.ones((1, 5), bool))(other), position)


@given(st.integers(1, 40), st.integers(0, 40))
def test_short_gaps_alone_are_filled_in(length, begin):
    time = np.arange(100) / 60
    values = np.stack([3.0 * time, time * 0.0 + 7.0], axis=1)
    holed = values.copy()
    holed[begin : begin + length, 0] = np.nan
    found = filled(time, holed)
    short = begin > 0 and (length + 1) / 60 <= LONGEST_GAP + 1e-9
    assert np.allclose(found, values) if short else np.isnan(found[begin : begin + length, 0]).all()
    assert np.isnan(holed[begin]).any()  # what was given is not changed


def test_a_body_is_made_anew_of_what_a_recording_tells(some):
    body = observed(some[3], 1.0, 0.0, 1).body
    message = body_message(body)
    springs = np.column_stack((message.spring_a, message.spring_b))
    polygons = np.split(body.polygon_cell, body.polygon_start[1:-1].astype(int)) if len(body.polygon_area) else []
    chambers = [*body.triangle, *polygons]
    areas = np.concatenate((body.triangle_area, body.polygon_area))
    shuffled = np.random.default_rng(1).permutation(len(springs))
    made = body_of_parts("eel", body.position + 0.05, springs[shuffled][:, ::-1], body.rest_length[shuffled], chambers, areas)
    for name in ("spring_a", "spring_b", "rest_length", "triangle_area", "polygon_area", "outline"):
        assert np.allclose(getattr(made, name), getattr(body, name)), name
    folded = body.position.copy()
    folded[:, 0] *= -1.0
    with pytest.raises(ObservationError, match="folded"):
        body_of_parts("eel", folded, springs, body.rest_length, chambers, areas)


def test_commands_read_recordings_of_hardware(some, tmp_path, capsys):
    plant, truth = observed(some[0], SECONDS, 0.002, 1, lost=0.01), observed(some[0], SECONDS, 0.0, 1)
    record(tmp_path / "plant", plant, lost=0.05)
    record(tmp_path / "simulated", truth, first=0 + 1)
    record(tmp_path / "other", observed(some[1], SECONDS, 0.0, 2))
    assert compare.main([str(tmp_path / "simulated"), str(tmp_path / "plant"), "--csv", str(tmp_path / "e.csv")]) == 0
    said = capsys.readouterr().out
    assert "on the plant, " in said and len((tmp_path / "e.csv").read_text().splitlines()) > 200
    out = tmp_path / "found.yaml"
    known = {f"{part}.{name}": TRUTH[name] for part, name in PARTS if name != "stiffness"}
    given = ["--fit", "stiffness", "lag", *(word for name, value in known.items() for word in ("--set", f"{name}={value}"))]
    given += ["--others", str(tmp_path / "other"), "-o", str(out)]
    assert identify.main([str(tmp_path / "plant"), *given]) == 0
    said = capsys.readouterr().out
    assert "--set material.stiffness=3" in said and "% of its length" in said
    assert load_rig(out).actuators.lag == pytest.approx(TRUTH["lag"], rel=0.05) and "material.stiffness=3" in out.read_text()
    for arguments, says in (
        ([str(tmp_path / "plant"), "-o", str(out)], "exists already"), ([str(tmp_path / "none")], "does not exist"),
        ([str(tmp_path / "plant"), "--fit", "mass"], "choose of"),
        ([str(tmp_path / "plant"), "--set", "material.mass=-1"], "material.mass is -1"),
        ([str(tmp_path / "plant"), "--rig", str(tmp_path / "none.yaml")], "none.yaml"),
    ):
        refused(identify.main, arguments, says, capsys)
    refused(compare.main, [str(tmp_path / "plant"), str(tmp_path / "other")], "of one body", capsys)


def refused(main, arguments, says, capsys):
    with pytest.raises(SystemExit) as left:
        main(arguments)
    said = capsys.readouterr().err
    assert left.value.code == 2 and says in said and said.count("\n") == 1 and len(said) <= 300, said


def test_a_recording_of_hardware_goes_wherever_recordings_go(some, tmp_path, capsys):
    """Markers are lost now and then, and states too: nothing else tells it from a simulator's."""
    one = observed(some[1], 6.0, 0.002, 1, lost=0.02)
    assert np.isnan(one.position).any(axis=(1, 2)).mean() > 0.1
    bag = record(tmp_path / "eel", one, lost=0.03)
    life = life_of(read_recording(bag))
    assert len(life.time) > 0.9 * len(one.time) and np.isfinite(life.position).all() and np.isfinite(life.velocity).all()
    seen, step, task = observation_of(bag)
    assert task is None and control_step_of(seen, step) == pytest.approx(1 / 60, rel=1e-6) and np.isnan(seen.position).any()
    assert gait.main([str(bag), "--out", str(tmp_path / "gait.svg"), "--csv", str(tmp_path / "cells.csv")]) == 0
    assert replay.main([str(bag), "--no-viewer", "--picture", str(tmp_path / "story.svg")]) == 0
    assert film.main([str(bag), "-o", str(tmp_path / "film.html")]) in (0, None)
    assert info.main([str(bag), "--json"]) == 0
    said = capsys.readouterr().out
    assert '"states"' in said and all((tmp_path / name).stat().st_size > 1000 for name in ("gait.svg", "story.svg", "film.html"))


def test_every_number_has_a_place_in_the_model():
    model = Model().with_numbers({name: 0.5 * (low + min(high, 10.0)) for name, (low, high, _) in FITTED.items()})
    for name, (low, high, _) in FITTED.items():
        assert model.number(name) == 0.5 * (low + min(high, 10.0)), name


def test_commands_of_the_benchmark_stay_within_their_range():
    assert np.abs(commands(5, 500, 1 / 60, np.random.default_rng(1))).max() <= 1.0
