"""Files that people write: damaged ones, traps, limits, and what is no file of text are refused in one short line, or read as meant."""

import json
import math
import os
import time

import numpy as np
import pytest
from evodevo_sim.genetics.genome_file import genome_text
from evodevo_sim.inputs import InputError, decimal, one_line, shown
from evodevo_sim.own_body.body_file import make_own_body
from evodevo_sim.parameters import Material, Task, default_task, with_settings
from evodevo_sim.text_file import MOST_BYTES, MOST_DEPTH, MOST_VALUES, parsed, read_text
from evodevo_sim.worlds import with_world
from genomes import hand_made
from hypothesis import given, settings
from hypothesis import strategies as st
from test_benchmarks import BENCHMARKS

from evodevo_sim import GenomeError, ParameterError, load_genome

READERS = ("genome", "body", "world", "target_yaml", "target_csv")


@pytest.fixture
def fuzz_files(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    import fuzz_files

    return fuzz_files


def refused(text):
    with pytest.raises(InputError) as caught:
        parsed(text, InputError)
    message = str(caught.value)
    assert len(message) <= 300 and message.isprintable()
    return message


@pytest.mark.parametrize("reader", READERS)
def test_damaged_files_are_read_or_refused_in_one_short_line(fuzz_files, tmp_path, reader):
    found = fuzz_files.fuzz(reader, 300, 2, tmp_path)
    assert not found.faults and found.read > 10 and found.refused > 100


def test_the_fuzzer_finds_each_fault_of_a_reader(fuzz_files, tmp_path, monkeypatch):
    def reader(message):
        def read(path):
            raise message if isinstance(message, Exception) else ValueError(message.format(path))

        return {"one": fuzz_files.Reader(read, ValueError, ".yaml", ["a: 1"])}

    for message, says in (
        (RecursionError("deep"), "RecursionError"), ("{} " + "x" * 300, "characters"), ("{}: one\ntwo", "2 lines"),
        ("no name", "does not name"), ("{}: fine", None),
    ):
        monkeypatch.setattr(fuzz_files, "readers", lambda message=message: reader(message))
        faults = fuzz_files.fuzz("one", 1, 1, tmp_path).faults
        assert (says in faults[0]) if says else not faults


@pytest.mark.parametrize(
    "text, value",
    [
        ("1e-5", 1e-5), ("-1E5", -1e5), ("5.", 5.0), (".5", 0.5), ("+3", 3), ("00.5", 0.5), ("1e-400", 0.0), ("9" * 400, math.inf),
        ("1e999", math.inf),
        ("-.inf", -math.inf), ("yes", "yes"), ("on", "on"), ("maybe", "maybe"), ("true", True), ("False", False), ("~", None),
        ("null", None),
        ("2024-02-28", "2024-02-28"), ("2024-02-28T23:59:59Z", "2024-02-28T23:59:59Z"), ("'0x_'", "0x_"),
        ('"2024-02-30"', "2024-02-30"), ("0.1.2", "0.1.2"),
        ("１２", "１２"), ("<<", "<<"),
    ],
)
def test_plain_words_mean_one_thing(text, value):
    for document, place in ((f"a: {text}", "a"), (f"- {text}", 0)):
        found = parsed(document, InputError)[place]
        assert found == value and type(found) is type(value)


TRAPS = ("2024-02-28 25:00:00", "0x_", "0x1F", "0b1", "0o17", "017", "1:30", "-1:30:00", "1_000", "1_0.5", "2024-02-30", "0000-01-01")


@pytest.mark.parametrize("trap", TRAPS)
def test_what_other_readers_take_for_a_number_or_a_date_is_refused_with_its_line(tmp_path, trap):
    assert refused(f"a: 1\nb: [2, {trap}]").startswith(f"line 2: '{trap}' is ")
    (tmp_path / "genome.yaml").write_text(f"evodevo_genome: 1\nabout: {{made: {trap}}}\nelements: []\n")
    with pytest.raises(GenomeError, match=r"genome.yaml: line 2"):
        load_genome(tmp_path / "genome.yaml")


@pytest.mark.parametrize(
    "text, says",
    [
        ("a: 1\na: 2", "line 2: the key 'a' comes twice"), ('{"a": 1, "b": {"c": 1, "c": 2}}', "the key 'c' comes twice"),
        ("a: &x 1", "line 1: 'x' is an alias"),
        ("a: *x", "'x' is an alias"), ("a: !!binary eA==", "is a tag"), ("!!python/object:os.system x", "is a tag"),
        ("%TAG ! x\n--- 1", "line 1: begins with %"),
        ("a: 1\n---\nb: 2", "line 2: a second document"), ("? [1]\n: 2", "line 1: a key is a list"), ("a:\n\t- 1", "from line 2 on"),
        ("a: \x01", "line 1: '\\x01' is no character"),
        ("a: [1", "neither YAML nor JSON"), ("a: '" + "x\n" * 9, "neither YAML nor JSON from line"),
    ],
)
def test_what_yaml_can_do_and_no_file_needs_is_refused_by_name(text, says):
    assert says in refused(text)


@pytest.mark.parametrize("opening", ["[", "{a: ", '{"a":', "- ", "[[], ", "? "])
@pytest.mark.parametrize("deep", [MOST_DEPTH + 1, 3000, 200_000])
def test_depth_ends_no_process(opening, deep):
    began = time.thread_time()
    assert "mend" in (message := refused(opening * deep)) or "within each other" in message or "a key is" in message
    assert time.thread_time() - began < 1.0
    assert parsed("[" * MOST_DEPTH + "]" * MOST_DEPTH, InputError)


def test_limits_of_size_are_named_at_once(tmp_path):
    began = time.thread_time()
    (tmp_path / "a.yaml").write_bytes(b"x" * (MOST_BYTES + 1))
    with pytest.raises(InputError, match="has more than 16,000,000 bytes"):
        read_text(tmp_path / "a.yaml", InputError, "a file")
    for text in ("[" + "0," * MOST_VALUES + "0]", "[" + "0,\n" * MOST_VALUES + "0"):
        assert "more than 1,000,000 values" in refused(text)
    assert time.thread_time() - began < 1.0


def test_the_largest_genome_and_body_are_within_the_limits():
    line = "- {kind: transcription_factor, sign: -1, x: -999999.1234567891, y: -1.2345678901234567e-300}\n"
    assert 100_000 * len(line) < MOST_BYTES and 100_000 * 9 < MOST_VALUES and line[:2] in genome_text(hand_made())
    assert 4096 * (2 * 60 + 3 * 60 + 3 * 2 * 20 + 3 * 30 + 2 * 5 * 10) < MOST_BYTES  # positions, velocities and so on, block by block


@pytest.mark.parametrize(
    "data, says",
    [
        (b"", "is empty"), (b" \n\t", "is empty"), ("a: 1".encode("utf-16"), "is UTF-16: save it as UTF-8"),
        ("a: 1".encode("utf-32"), "is UTF-32"),
        ("a: 1".encode("utf-16-le"), "line 1 has a NUL byte"), (b"a: 1\n\xff", "line 2 has bytes that are no UTF-8"),
        (b"\x7fELF\0\xff", "has a NUL byte"),
    ],
)
def test_what_is_no_text_is_named(tmp_path, data, says):
    (tmp_path / "a.yaml").write_bytes(data)
    with pytest.raises(InputError) as caught:
        read_text(tmp_path / "a.yaml", InputError, "a file")
    assert says in str(caught.value) and "a.yaml" in str(caught.value)


def test_a_mark_of_byte_order_and_ends_of_lines_do_not_matter(tmp_path):
    (tmp_path / "a.yaml").write_bytes(b"\xef\xbb\xbfa: 1\r\nb: 2\r\n")
    assert parsed(read_text(tmp_path / "a.yaml", InputError, "a file"), InputError) == {"a": 1, "b": 2}


def test_what_is_no_regular_file_is_named_and_never_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    names = (tmp_path / "pipe", "/dev/null", "/dev/zero", tmp_path, tmp_path / "none", tmp_path / "loop", "x" * 5000, "a\0b")
    for name, says in zip(names, ("a pipe or a device",) * 3 + ("a directory", "No such file", "symbolic links", "too long", "null")):
        with pytest.raises(GenomeError, match=says) as caught:
            load_genome(name)
        assert len(str(caught.value)) <= 300 and str(caught.value).isprintable()
    with pytest.raises(ParameterError, match="neither a file nor one of"):
        with_world(default_task("walk"), "x" * 5000)


@given(st.floats(allow_nan=False) | st.integers(-(10**18), 10**18))
def test_every_number_that_python_writes_is_read(number):
    for text in (repr(number), f"a: {number!r}", json.dumps({"a": number})):
        found = decimal(text) if text == repr(number) else parsed(text, InputError)["a"]
        if not (isinstance(number, float) and math.isinf(number)):
            assert found == number


@settings(max_examples=50)
@given(
    st.recursive(
        st.text() | st.integers() | st.floats() | st.none() | st.binary(), lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner)
    ),
    st.integers(20, 100),
)
def test_any_value_is_shown_on_one_line_in_so_many_characters(value, most):
    assert len(shown(value, most)) <= most and shown(value, most).isprintable()


def test_huge_values_are_cut_in_the_middle_and_the_mend_stays():
    deep = []
    for _ in range(100_000):
        deep = [deep]
    for value in (10**5000, "x" * 10**6, deep, [1] * 10**6, np.zeros(10**5)):
        assert len(shown(value)) <= 60
        with pytest.raises(ParameterError, match=r"^material.stiffness is .*: give a number from 1e-06 to 1e\+09") as caught:
            Material(stiffness=value)
        assert len(str(caught.value)) <= 300
    assert one_line("a" * 1000 + "\n" + "b" * 1000, 20) == "a" * 8 + " ... " + "b" * 7


@pytest.mark.parametrize("text", ["nan", "inf", "1_000", "１２", "0x10", "0b1", "017", "1:30", "", "1e", "x" * 10_000, "9" * 10_000, "-"])
def test_settings_from_a_command_line_are_decimal_numbers(text):
    with pytest.raises(ParameterError, match=r"^material.stiffness is ") as caught:
        with_settings(Task(), {"material.stiffness": text})
    assert len(str(caught.value)) <= 300


@pytest.mark.parametrize("name", ["x" * 10_000, "material.stiffnes", "\n", "material.", ".", ""])
def test_unknown_settings_are_cut_and_the_nearest_is_named(name):
    with pytest.raises(ParameterError, match="did you mean '") as caught:
        with_settings(Task(), {name: "1"})
    assert len(str(caught.value)) <= 300


def test_a_boolean_is_no_number(tmp_path):
    (tmp_path / "world.yaml").write_text("friction: true")
    for give in (lambda: Material(mass=True), lambda: Task(starts=True), lambda: with_world(default_task("walk"), tmp_path / "world.yaml")):
        with pytest.raises(ParameterError, match="is True: give"):
            give()


@pytest.mark.parametrize("arguments", [["--seed", "1_000"], ["--seed", "１２"], ["--cells", "9" * 5000], ["--starts", "0x10"],
["--look", "1_0"], ["--elite", "x" * 9999], ["--start", "x" * 9999], ["--task", "x" * 9999], ["--set", "x" * 9999], ["--world", "x" * 9999],
                                       ["--preset", "x" * 9999]])
def test_arguments_of_evolve_are_refused_in_one_short_line(capsys, arguments):
    from evodevo_ga.arguments import parse

    with pytest.raises(SystemExit) as left:
        parse(arguments)
    said = capsys.readouterr().err
    assert left.value.code == 2 and len(said) <= 301 and said.count("\n") == 1 and said.rstrip("\n").isprintable()


def test_more_springs_or_faces_than_a_plane_holds_are_refused_before_they_are_compared():
    position = [[float(k), float(k * k)] for k in range(9)]
    for key, entries in (("springs", [[0, 1]] * 30), ("chambers", [[0, 1, 2]] * 20)):
        with pytest.raises(ValueError, match=f"{key} has {len(entries)} entries"):
            make_own_body({"position": position, key: entries})
