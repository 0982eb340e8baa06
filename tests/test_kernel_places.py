"""Where kernels are kept; where they cannot be, they are compiled in memory, and the reason is said in one line."""

import resource
from contextlib import contextmanager
from pathlib import Path

import pytest
import somebodys
from evodevo_sim.kernels import jit as _jit

own = pytest.fixture(somebodys.own)


def full_disk(own):
    own.caches.mkdir()
    return own.caches / "ours"


@pytest.mark.parametrize("place, why", [
    (lambda own: Path("/dev/null/evodevo/ours"), "Not a directory"),
    (lambda own: Path("/proc/evodevo/ours"), "No such file or directory"),
    (lambda own: own.folder / "own_kernels.py", "a file is in its place"),
    (lambda own: own.folder / "own_kernels.py" / "evodevo" / "ours", "Not a directory"),
    (lambda own: Path(f"/tmp/{'n' * 300}/ours"), "File name too long"),
    (full_disk, "File too large"),
    (lambda own: None, "there is no home directory"),
])
def test_without_a_place_for_kernels_they_are_compiled_in_memory_and_the_reason_is_said(own, monkeypatch, capfd, place, why):
    directory = place(own)
    monkeypatch.setattr(_jit, "CACHE_DIRECTORY", directory)
    before = set(own.folder.parent.rglob("*"))
    with limited(why == "File too large"):
        module = own()
        monkeypatch.setattr(module.times._cache, "_directory", directory)
        monkeypatch.setattr(module.times._cache, "_place", lambda changed: directory)
        assert module.times(3.0) == 7.0 and module.times(3) == 7.0
        told = capfd.readouterr().err
        assert told.count("\n") == 1 and len(told) <= 300 and why in told and "NUMBA_CACHE_DIR" in told
        assert "at every start" in told and "once" not in told
        notice = _jit.compiling("own_kernels.absent")
        assert "\n" not in notice and len(notice) <= 300 and why in notice and "once" not in notice
    made = {directory} if why == "File too large" else set()
    assert set(own.folder.parent.rglob("*")) == before | made


@contextmanager
def limited(whether):
    """Files cannot grow beyond 1 kB."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    try:
        if whether:
            resource.setrlimit(resource.RLIMIT_FSIZE, (1000, hard))
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_a_reason_that_was_given_before_compiling_is_not_given_again(own, monkeypatch, capfd):
    monkeypatch.setattr(_jit, "CACHE_DIRECTORY", Path("/dev/null/evodevo/ours"))
    assert "Not a directory" in _jit.compiling("swim.swim")
    assert own().times(3.0) == 7.0 and not capfd.readouterr().err


def test_what_can_be_written_is_promised_once_and_left_clean(own):
    assert _jit.compiling("swim.swim") == "Compiling the simulation kernels, once: half a minute to a minute."
    assert list((own.caches / "ours").iterdir()) == []


@pytest.mark.parametrize("changed, expected", [
    ({"NUMBA_CACHE_DIR": "/a", "XDG_CACHE_HOME": "/b", "HOME": "/c"}, "/a/evodevo"),
    ({"XDG_CACHE_HOME": "/b", "HOME": "/c"}, "/b/evodevo"),
    ({"XDG_CACHE_HOME": "b", "HOME": "/c"}, "/c/.cache/evodevo"),  # by the standard of these variables, a relative one does not count
    ({"HOME": "/dev/null"}, "/dev/null/.cache/evodevo"),
])
def test_where_caches_are(monkeypatch, changed, expected):
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "HOME"):
        monkeypatch.delenv(name, raising=False)
    for name, value in changed.items():
        monkeypatch.setenv(name, value)
    assert str(_jit._caches()) == expected


def test_without_a_home_there_is_no_place_for_caches(monkeypatch):
    def unknown():
        raise RuntimeError("Could not determine home directory.")

    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(Path, "home", unknown)
    assert _jit._caches() is None and set(_jit._remembered_sources()) == _jit._SOURCES
    _jit.remove_old_caches()
