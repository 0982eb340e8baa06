"""Compiled kernels on disk: found again by the next process, and never those of other sources."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from evodevo_sim.kernels import jit as _jit

import evodevo_sim

PACKAGE = Path(evodevo_sim.__file__).parent
SCRIPT = """
from evodevo_sim import _jit
before = _jit.is_compiled("regulation.affinity")
from evodevo_sim.kernels.lanes import padded
from evodevo_sim.genetics.regulation import activation, affinity
activation(1.0), padded(3)
print(before, affinity(3.0), sum(1 for _ in _jit.CACHE_DIRECTORY.rglob("*.nbc")), _jit.CACHE_DIRECTORY)
"""


@pytest.fixture
def copy(tmp_path):
    """Runs SCRIPT on a copy of the package with a cache of its own."""
    shutil.copytree(PACKAGE, tmp_path / "evodevo_sim", ignore=shutil.ignore_patterns("__pycache__"))
    environment = {k: v for k, v in os.environ.items() if k not in ("NUMBA_CACHE_DIR", "NUMBA_BOUNDSCHECK")}
    environment |= {"PYTHONPATH": f"{tmp_path}:{environment.get('PYTHONPATH', '')}", "XDG_CACHE_HOME": str(tmp_path / "cache")}

    def run(**changed):
        result = subprocess.run(
            [sys.executable, "-c", SCRIPT], capture_output=True, text=True, env=environment | changed, timeout=120
        )
        compiled, value, files, directory = result.stdout.split()
        return compiled == "True", float(value), int(files), directory

    run.directory = tmp_path / "evodevo_sim"
    return run


def test_the_next_process_finds_what_the_first_compiled(copy):
    first, again = copy(), copy()
    assert not first[0] and again[0]
    assert first[1:] == again[1:] and first[2] >= 3


def test_a_changed_constant_in_another_file_is_never_a_stale_hit(copy):
    _, before, _, directory = copy()
    source = copy.directory / "regulation.py"
    source.write_text(source.read_text().replace("REACH = 5.0", "REACH = 4.0"))
    compiled, after, _, elsewhere = copy()
    assert not compiled and after != before and elsewhere != directory


def test_looking_at_every_index_never_meets_kernels_that_do_not(copy):
    first, looking = copy(), copy(NUMBA_BOUNDSCHECK="1")
    assert not looking[0] and looking[1] == first[1] and looking[3] != first[3]


def test_a_chosen_cache_directory_keeps_kernels_of_other_sources_apart(copy, tmp_path):
    _, _, _, directory = copy(NUMBA_CACHE_DIR=str(tmp_path / "chosen"))
    assert (tmp_path / "chosen") in Path(directory).parents and Path(directory).name == Path(copy()[3]).name


def test_every_file_that_holds_or_feeds_a_kernel_counts():
    names = {path.stem for path in _jit.kernel_sources()}
    assert names >= {path.stem for path in PACKAGE.glob("*.py") if "\n@kernel\n" in path.read_text()}
    assert {"genome", "parameters", "_jit"} <= names


def test_old_caches_go_and_the_present_one_stays(tmp_path, monkeypatch):
    monkeypatch.setattr(_jit, "_caches", lambda: tmp_path)
    monkeypatch.setattr(_jit, "CACHE_DIRECTORY", tmp_path / "present")
    for name in ("present", "old", "recent"):
        (tmp_path / name).mkdir()
    long_ago = os.stat(tmp_path).st_mtime - 30 * 86400
    for name in ("present", "old"):
        os.utime(tmp_path / name, (long_ago, long_ago))
    _jit.remove_old_caches()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["present", "recent"]
