"""Genomes and their files: what is malformed is refused by name, and what is written is read back to the bit."""

import contextlib
import dataclasses

import numpy as np
import pytest
from evodevo_sim.genetics.elements import HEADER
from evodevo_sim.genetics.genome_file import UNSAID, genome_text, parse_file
from evodevo_sim.parameters import Development, default_task, preset, with_settings
from genomes import hand_made, random_genomes
from hypothesis import given
from hypothesis import strategies as st

from evodevo_sim import Genome, GenomeError, load_genome, parse_genome, random_genome, read_genome, save_genome


@given(random_genomes())
def test_a_file_holds_every_bit(genome):
    assert parse_genome(genome_text(genome, {"task": "swim", "note": "a: b # c"})) == genome


@given(st.floats(allow_nan=False, allow_infinity=False, min_value=-1e6, max_value=1e6))
def test_any_coordinate_survives_the_file(x):
    assert parse_genome(genome_text(hand_made({"axis": (-1, x, -x)}))) == hand_made({"axis": (-1, x, -x)})


@pytest.mark.parametrize(
    "change, says",
    [
        (dict(x=np.nan), "element 3: point is not finite"),
        (dict(y=np.inf), "element 3: point is not finite"),
        (dict(sign=0), "element 3: sign"),
        (dict(kind=1), "special elements are the first"),
        (dict(kind=9), "kind is unknown"),
    ],
)
def test_malformed_elements_are_named(change, says):
    genome = hand_made()
    arrays = dict(kind=genome.kind.copy(), sign=genome.sign.copy(), x=genome.x.copy(), y=genome.y.copy())
    for name, value in change.items():
        arrays[name][3] = value
    with pytest.raises(GenomeError, match=says):
        Genome(**arrays)


@given(random_genomes(2), st.data())
def test_arrays_are_taken_or_refused_alike_by_the_quick_look_and_by_the_thorough_one(genome, data):
    arrays = [values.copy() for values in genome.arrays()]
    for _ in range(data.draw(st.integers(0, 2))):
        which, place = data.draw(st.integers(0, 3)), data.draw(st.integers(0, len(genome) - 1))
        points = st.sampled_from([np.nan, np.inf, -np.inf, 1e6, -1e6, 1e6 + 1.0, 9e5, -0.0])
        arrays[which][place] = data.draw([st.integers(0, 255), st.integers(-128, 127), points, points][which])
    if data.draw(st.booleans()):
        arrays[data.draw(st.integers(0, 3))] = arrays[data.draw(st.integers(0, 3))][: data.draw(st.integers(0, len(genome)))]

    def told(*given):
        try:
            return Genome(*given).key()
        except GenomeError as error:
            return str(error)

    assert told(*arrays) == told(*(values.tolist() for values in arrays))


def test_a_genome_keeps_arrays_of_its_own():
    first = hand_made()
    arrays = [values.copy() for values in first.arrays()]
    genome = Genome(*arrays)
    for values in arrays:
        values[:] = 0
    assert genome == first and not any(values.flags.writeable for values in genome.arrays())


def test_unequal_lengths_and_missing_header_are_refused():
    genome = hand_made()
    with pytest.raises(GenomeError, match="equal numbers"):
        Genome(genome.kind, genome.sign, genome.x, genome.y[:-1])
    with pytest.raises(GenomeError, match=f"the {HEADER} special elements"):
        Genome(*(array[:3] for array in genome.arrays()))


@pytest.mark.parametrize(
    "text, says",
    [
        ("", "is empty"),
        ("# nothing", "not a genome file"),
        ("evodevo_genome: 2\nelements: []", "version 2 is unknown"),
        ("evodevo_genome: 1\nelement: []", "unknown key 'element'"),
        ("evodevo_genome: 1\nelements: [1, 2]", "element 0: give exactly the keys"),
        ("evodevo_genome: 1\nelements:\n- {special: axis, sign: 1, x: 0, y: 0}", "element 0: special is 'axis'"),
        ("evodevo_genome: [", "neither YAML nor JSON from line"),
        ("evodevo_genome: 1\nelements:\n- {special: maternal_x, sign: yes, x: 0, y: 0}", "element 0: sign"),
        ("evodevo_genome: 1\nelements:\n- {special: maternal_x, sign: 1, x: here, y: 0}", "element 0: x is 'here'"),
        ("evodevo_genome: 1\ndevelopment: 0.6\nelements: []", "development is 0.6: give settings and values"),
        ("evodevo_genome: 1\ndevelopment: {room: 1}\nelements: []", "setting 'room' is unknown: did you mean 'division_room'?"),
        ("evodevo_genome: 1\ndevelopment: {1: 1}\nelements: []", "development: setting '1' is unknown"),
        ("evodevo_genome: 1\ndevelopment: {division_room: -1}\nelements: []", "development.division_room is -1: give a number from 0"),
        ("evodevo_genome: 1\ndevelopment: {division_room: true}\nelements: []", "development.division_room is True: give a number"),
        ("evodevo_genome: 1\ndevelopment: {variant: [b]}\nelements: []", "development.variant is .'b'.: choose one of"),
    ],
)
def test_a_bad_file_is_refused_with_the_place(tmp_path, text, says):
    path = tmp_path / "genome.yaml"
    path.write_text(text)
    with pytest.raises(GenomeError, match=says) as error:
        load_genome(path)
    assert str(path) in str(error.value) and "\n" not in str(error.value)


def test_files_cut_anywhere_never_pass_for_whole(tmp_path):
    text = genome_text(random_genome(np.random.default_rng(0)))
    whole = parse_genome(text)
    for end in range(0, len(text) - 1, 7):
        with contextlib.suppress(GenomeError):
            assert len(parse_genome(text[:end])) < len(whole)  # a cut between two lines is a shorter genome


def test_saving_replaces_a_file_whole(tmp_path):
    path = tmp_path / "genome.yaml"
    path.write_text("old")
    save_genome(path, hand_made())
    assert load_genome(path) == hand_made()
    assert [p.name for p in tmp_path.iterdir()] == ["genome.yaml"]


def test_missing_and_binary_files_get_one_line(tmp_path):
    with pytest.raises(GenomeError, match="No such file"):
        load_genome(tmp_path / "none.yaml")
    (tmp_path / "binary").write_bytes(b"\xff\xfd\x00")
    with pytest.raises(GenomeError, match="not a text file"):
        load_genome(tmp_path / "binary")


LAWS = st.builds(
    Development, variant=st.sampled_from(["continual_graph", "graph_at_end"]), max_cells=st.integers(1, 64),
    division_room=st.sampled_from([0.0, 0.6, 1e-7]), division_neighbours=st.integers(0, 8), waiting_turn=st.floats(-1.0, 1.0),
    adhesion=st.sampled_from([0.1, 0.03]),
)


@given(LAWS)
def test_a_file_says_by_which_law_its_genome_was_bred(law):
    file = parse_file(genome_text(hand_made(), {"task": "walk"}, law))
    assert file.task().development == law and file.about == {"task": "walk"}
    walking = file.task("walk", {"development.max_cells": "7"})
    assert walking == dataclasses.replace(default_task("walk"), development=dataclasses.replace(law, max_cells=7))
    assert file.bred_otherwise(file.task("chemotaxis")) == ""


def test_a_file_that_says_nothing_grows_as_if_no_cell_waits_whatever_the_defaults_are(tmp_path):
    path = tmp_path / "genome.yaml"
    save_genome(path, hand_made(), None, with_settings(default_task("swim"), {f"development.{name}": 0 for name in UNSAID}).development)
    assert "development" not in path.read_text()
    law = read_genome(path).task("walk").development
    assert (law.division_room, law.division_neighbours, law.waiting_turn) == (0.0, 0, 0.0)
    save_genome(path, hand_made())  # by the law that is usual
    assert read_genome(path).task().development == Development()
    other = with_settings(default_task("swim"), preset("contact_inhibition"))
    save_genome(path, hand_made(), None, other.development)
    assert read_genome(path).bred_otherwise(with_settings(other, {"development.division_room": 0.5})) == "development.division_room=0.6"
