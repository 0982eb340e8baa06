"""How animats turn: what a body does without scent, which side contracts, and whether history counts."""

import dataclasses

import numpy as np
import pytest
from evodevo_sim.analysis.turning import Turning, actuation, memory_of, turning
from evodevo_sim.commands.turning import main
from evodevo_sim.genetics.elements import TRANSCRIPTION_FACTOR
from evodevo_sim.parameters import Chemotaxis, default_task
from genomes import FAR, dividing, hand_made, pulsing, unit
from test_chemotaxis import pulsing_smeller

from evodevo_sim import Development, ParameterError, Task, save_genome

TASK = dataclasses.replace(
    default_task("chemotaxis"), development=Development(max_cells=12), control_steps=400, chemotaxis=Chemotaxis(least_distance=0.0)
)


def passing(cells=12, steps=400):
    """A made-up track (T + 1, N, 2) of cells that pass a target at 0 at various distances."""
    x = np.linspace(-12.0, 12.0, steps + 1)[:, None] + np.zeros(cells)
    return np.stack((x, np.broadcast_to(np.linspace(1.0, 6.0, cells), x.shape)), axis=-1)


def reflex():
    """No beat: contraction follows the scent of the moment."""
    special = {"constant": (1, 0.0, 0.0), "division": (1, 0.0, 0.0), "scent": (1, 0.0, FAR), "contraction": (1, 4.8, FAR)}
    return hand_made(special)


def keeper():
    """Contraction once smelt stays: a unit that feeds itself, set on by strong scent."""
    special = {"constant": (1, 0.0, 0.0), "division": (1, 0.0, 0.0), "scent": (1, 4.85, FAR), "contraction": (1, 1.0, 2 * FAR)}
    # The second regulatory element, a negative one at the constant, is the threshold that a weak scent does not pass.
    units = [unit([(1, 0.0, FAR), (1, 0.0, 2 * FAR), (-1, 4.0, 0.0)], [(TRANSCRIPTION_FACTOR, 1, 0.0, 2 * FAR)])]
    return hand_made(special, units)


def test_a_reflex_has_no_memory_and_a_switch_has():
    track = passing()
    assert memory_of(reflex(), TASK, track, (0.0, 0.0)) < 0.01
    weak_then_strong = np.full((400, 12), 0.5)
    weak_then_strong[:40] = 9.0
    muscles = actuation(keeper(), TASK, weak_then_strong)
    never = actuation(keeper(), TASK, np.full((400, 12), 0.5))
    assert np.abs(muscles[-1]).min() > 5 * np.abs(never[-1]).max()  # long after, at an equal scent


def test_networks_on_the_tape_of_a_life_do_what_they_did_in_it():
    from evodevo_sim import perform

    genome, task = pulsing_smeller(), TASK
    performance = perform(genome, task)
    away = np.hypot(*np.moveaxis(performance.position[:-1] - performance.target, -1, 0))
    tape = task.chemotaxis.scent_peak * np.maximum(0.0, 1.0 - away / task.chemotaxis.scent_reach)
    assert actuation(genome, task, tape) == pytest.approx(performance.activation[1:], abs=1e-9)


def test_maps_of_a_body_that_smells_nothing_are_empty():
    found = turning(pulsing(), TASK)
    assert not found.change.any() and not found.swing.any() and np.isnan(found.memory)
    assert found.control == "indifferent" and found.turn[0] == pytest.approx(-found.turn[1])
    assert found.turns in ("neither", "left", "right")


def test_maps_compare_the_same_time_without_a_target():
    found = turning(pulsing_smeller(), TASK)
    assert found.change.shape == (2, 12) and np.abs(found.change).max() > 0.01 and np.isfinite(found.memory)
    assert found.paths.shape[0] == 3 and np.array_equal(found.paths[0, 0], found.paths[2, 0])


def made_up(turn=(0.0, 0.0), near=(0.0, 0.0), memory=0.0):
    zero = np.zeros((2, 3))
    return Turning(
        np.array([1.0, 0.0]), zero[0, :2], zero.T, zero[:, :2], np.zeros((3, 2, 2)), np.array(turn), np.ones(2), zero, zero,
        np.array(near), memory,
    )


def test_words_follow_from_the_numbers():
    assert [made_up(turn=t).turns for t in ((0.5, 0.5), (0.5, -0.5), (0.0, 0.4), (0.0, 0.0))] == ["both", "left", "right", "neither"]
    assert [made_up(near=n).side for n in ((-0.1, -0.2), (0.1, 0.2), (-0.1, 0.2), (0.1, -0.2))] == ["nearer", "farther", "left", "right"]
    assert [made_up(memory=m).control for m in (0.01, 0.9, np.nan)] == ["reactive", "internal state", "indifferent"]


@pytest.mark.parametrize(
    "genome, task, says", [(pulsing(), Task(), "no targets"), (hand_made(), TASK, "never divided"), (dividing(), TASK, "does not swim")],
)
def test_what_has_no_turns_says_so(genome, task, says):
    with pytest.raises(ParameterError, match=says):
        turning(genome, task)


def test_the_command_prints_a_line_each_and_draws(tmp_path, capsys):
    save_genome(tmp_path / "smeller.yaml", pulsing_smeller())
    settings = [f"--set={name}={value}" for name, value in (("development.max_cells", 12), ("control_steps", 400))]
    source = str(tmp_path / "smeller.yaml")
    assert main([source, source, "--out", str(tmp_path / "map.png"), *settings]) == 0
    out = capsys.readouterr().out.splitlines()
    assert len(out) == 3 and out[0] == out[1] and out[0].startswith("smeller: turns to ") and "side" in out[0]
    assert (tmp_path / "map.png").read_bytes().startswith(b"\x89PNG")


def test_the_command_names_what_is_wrong(tmp_path, capsys):
    save_genome(tmp_path / "egg.yaml", hand_made())
    for arguments, says in ((["nowhere.yaml"], "nowhere.yaml"), ([str(tmp_path / "egg.yaml")], "egg: there is nothing to analyse")):
        with pytest.raises(SystemExit) as leaving:
            main(arguments)
        error = capsys.readouterr().err
        assert leaving.value.code == 2 and says in error and error.count("\n") == 1
