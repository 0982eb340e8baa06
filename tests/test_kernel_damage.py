"""Damage to an entry: whatever was done to its file, it is compiled anew, in one line, and the next process finds it sound."""

import os
import pickle
import shutil

import pytest
import somebodys
from evodevo_sim.kernels.cache import MAGIC, Damaged, read_entry, write_entry
from hypothesis import assume, given
from hypothesis import strategies as st
from somebodys import hits

own = pytest.fixture(somebodys.own)


CONTENT = bytes(range(256)) * 40
KEY = bytes(range(32))


@pytest.fixture(scope="module")
def entry(tmp_path_factory):
    path = tmp_path_factory.mktemp("entries") / "f-0.nbc"
    write_entry(path, KEY, CONTENT)
    return path, path.read_bytes()


def read_damaged(path, data):
    path.write_bytes(data)
    with pytest.raises(Damaged):
        read_entry(path, KEY)


@given(st.data())
def test_no_entry_that_differs_in_any_byte_is_read(entry, data):
    path, sound = entry
    at = data.draw(st.integers(0, len(sound) - 1))
    read_damaged(path, sound[:at])
    read_damaged(path, sound[:at] + bytes([sound[at] ^ data.draw(st.integers(1, 255))]) + sound[at + 1 :])
    read_damaged(path, sound[:at] + bytes(len(sound) - at) if any(sound[at:]) else sound[:at])
    added = data.draw(st.binary(min_size=1, max_size=50))
    read_damaged(path, sound + added)
    assume(sound[:at] + added + sound[at:] != sound)
    read_damaged(path, sound[:at] + added + sound[at:])
    path.write_bytes(sound)
    assert read_entry(path, KEY) == CONTENT
    with pytest.raises(Damaged, match="another"):
        read_entry(path, KEY[::-1])


def emptied(path, other):
    path.write_bytes(b"")


def cut(path, other):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def flipped(path, other):
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)


def swapped(path, other):
    shutil.copy(other, path)


def made_a_directory(path, other):
    path.unlink()
    path.mkdir()
    (path / "inside").write_text("")


def made_a_pipe(path, other):
    path.unlink()
    os.mkfifo(path)


def made_a_dangling_link(path, other):
    path.unlink()
    path.symlink_to("nowhere")


def linked_to_itself(path, other):
    path.unlink()
    path.symlink_to(path.name)


def written_by_something_else(path, other):
    """Its checksum is right; what is in it is no kernel."""
    key = path.read_bytes()[len(MAGIC) : len(MAGIC) + 32]
    write_entry(path, key, pickle.dumps((1, 2, 3)))


def written_with_other_modules(path, other):
    key = path.read_bytes()[len(MAGIC) : len(MAGIC) + 32]
    write_entry(path, key, b"cno_such_module\nf\n.")


@pytest.mark.parametrize("damage", [
    emptied, cut, flipped, swapped, made_a_directory, made_a_pipe, made_a_dangling_link, linked_to_itself, written_by_something_else,
    written_with_other_modules,
])
def test_a_damaged_entry_is_compiled_anew_and_said_in_one_line(own, capfd, damage):
    module = own()
    module.times(3.0), module.first(module.Pair(2.0, 1.0))
    path = own.entry()
    damage(path, own.entry("first"))
    module = own()
    assert module.times(3.0) == 7.0 and hits(module.times) == 0
    told = capfd.readouterr().err
    assert told.count("\n") == (damage is not made_a_dangling_link) and len(told) <= 300
    assert not told or ("is damaged" in told and "compiled anew" in told and path.name in told)
    module = own()
    assert module.times(3.0) == 7.0 and hits(module.times) == 1 and not capfd.readouterr().err


def test_many_damaged_entries_are_said_in_one_line(own, capfd):
    module = own()
    module.times(3.0), module.first(module.Pair(2.0, 1.0)), module.times(3)
    for path in own.caches.rglob("*.nbc"):
        emptied(path, None)
    module = own()
    module.times(3.0), module.first(module.Pair(2.0, 1.0)), module.times(3)
    assert capfd.readouterr().err.count("\n") == 1
