"""Kernels that others call by address: compiled once, found again from disk, and never called where they are not what they were."""

import importlib
import os
import pty
import subprocess
import sys
import termios
import textwrap
from contextlib import suppress

import pytest

SCRIPT = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from evodevo_sim.kernels import jit
jit.CACHE_DIRECTORY = Path(sys.argv[2])
import apart_outer
print(apart_outer.outer(3.0), sum(apart_outer.outer.stats.cache_hits.values()), len(apart_outer.inner.for_kernels.overloads))
"""


@pytest.fixture
def apart(tmp_path):
    """Runs `outer`, which calls `inner` by address, in a process of its own: what it prints."""
    folder, caches = tmp_path / "apart", tmp_path / "caches" / "ours"
    folder.mkdir()
    (folder / "apart_inner.py").write_text(textwrap.dedent("""
        from evodevo_sim.kernels.jit import kernel, lean, seam

        @lean
        def linked(x):
            return x + 1.0

        @seam
        def inner(x, n):
            return 2.0 * linked(x) + n
    """))
    (folder / "apart_outer.py").write_text(textwrap.dedent("""
        from apart_inner import inner
        from evodevo_sim.kernels.jit import kernel

        @kernel
        def outer(x):
            total = 0.0
            for n in range(2):
                total += inner(x, n) + inner(x, 0) + inner(x, 1)
            return total
    """))

    def run():
        done = subprocess.run([sys.executable, "-c", SCRIPT, str(folder), str(caches)], capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stderr
        return (*done.stdout.split(), done.stderr)

    run.folder, run.entries = folder, lambda name: sorted(caches.parent.rglob(f"{name}-*.nbc"))
    return run


def test_a_caller_from_disk_finds_what_it_calls(apart):
    assert apart() == ("51.0", "0", "1", "")
    assert len(apart.entries("*")) == 3  # linked, inner and outer: none twice for the constants that it is called with
    assert apart() == ("51.0", "1", "1", "")


@pytest.mark.parametrize("harm", ["gone", "cut"])
def test_what_a_caller_calls_is_compiled_anew_where_its_entry_is_harmed(apart, harm):
    apart()
    entry, = apart.entries("apart_inner.inner")
    entry.unlink() if harm == "gone" else entry.write_bytes(b"cut")
    value, hit, overloads, error = apart()
    assert (value, hit, overloads) == ("51.0", "1", "1") and error.count("is damaged") == (harm == "cut")
    assert entry.stat().st_size > 1000


def test_a_change_of_what_is_called_by_address_reaches_its_callers(apart):
    apart()
    inner = apart.folder / "apart_inner.py"
    inner.write_text(inner.read_text().replace("2.0 * linked", "3.0 * linked"))
    assert apart()[:2] == ("75.0", "0")


def test_an_entry_whose_callee_has_another_name_by_now_is_compiled_anew(apart, monkeypatch):
    from evodevo_sim.kernels.apart import Callee, Missing, place

    monkeypatch.syspath_prepend(str(apart.folder))
    module = importlib.import_module("apart_inner")
    try:
        for name in ("inner", "nothing", "linked.nothing"):
            with pytest.raises(Missing):
                place(Callee("evodevo.of another time", module.__name__, name, ()))
    finally:
        sys.modules.pop("apart_inner")


def test_a_terminal_sees_how_many_kernels_are_left(apart):
    script = SCRIPT.replace("import apart_outer", "from evodevo_sim.kernels import progress\nprogress._DELAY = 0.0\nimport apart_outer")
    master, slave = pty.openpty()
    termios.tcsetwinsize(slave, (30, 100))
    arguments = [sys.executable, "-c", script, str(apart.folder), str(apart.folder.parent / "caches" / "ours")]
    with subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=slave) as process:
        os.close(slave)
        seen = b""
        with suppress(OSError):  # the end of a terminal that nobody has open
            while chunk := os.read(master, 4096):
                seen += chunk
        assert process.wait(timeout=300) == 0
    os.close(master)
    shown = seen.decode().split("\r")
    assert any("Compiling" in line and "0/3" in line for line in shown)
    assert not shown[-1].strip()  # it leaves nothing behind


def test_a_processor_without_vectors_of_four_is_told_of_in_one_line(apart, monkeypatch):
    monkeypatch.setenv("NUMBA_CPU_NAME", "x86-64")
    monkeypatch.setenv("NUMBA_CPU_FEATURES", "")
    value, _, _, *error = apart()
    assert value == "51.0" and error[0].count("\n") == 1 and "AVX2" in error[0]
