"""Compiled kernels on disk: found again by the next process, and never those of other sources."""

import os
import shutil
import subprocess
import sys
import types
from collections import namedtuple
from pathlib import Path

import pytest
import somebodys
from evodevo_sim.kernels import jit as _jit
from somebodys import hits

import evodevo_sim

own = pytest.fixture(somebodys.own)


PACKAGE = Path(evodevo_sim.__file__).parent
SCRIPT = """
from evodevo_sim.kernels import jit as _jit
before = _jit.is_compiled("regulation.affinity")
from evodevo_sim.kernels.lanes import padded
from evodevo_sim.genetics.regulation import activation, affinity
activation(1.0), padded(3)
print(before, affinity(3.0), sum(1 for _ in _jit.CACHE_DIRECTORY.rglob("*.nbc")), _jit.CACHE_DIRECTORY)
"""


def run(folder, script=SCRIPT, **changed):
    """Runs a script on the package in a folder, with the caches there.  Returns: what it printed, and on standard error."""
    environment = {k: v for k, v in os.environ.items() if k not in ("NUMBA_CACHE_DIR", "NUMBA_BOUNDSCHECK")}
    environment |= {"PYTHONPATH": f"{folder}:{environment.get('PYTHONPATH', '')}", "XDG_CACHE_HOME": str(folder / "cache")}
    result = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, env=environment | changed, timeout=120)
    compiled, value, files, directory = result.stdout.split()
    return Run(compiled == "True", float(value), int(files), Path(directory), result.stderr)


Run = namedtuple("Run", "found value files directory stderr")


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """The folder of a copy of the package in which SCRIPT was run, and what came of it."""
    folder = tmp_path_factory.mktemp("first")
    shutil.copytree(PACKAGE, folder / "evodevo_sim", ignore=shutil.ignore_patterns("__pycache__"))
    return folder, run(folder)


@pytest.fixture
def copy(first, tmp_path):
    """A copy of that folder, and what came of the first run."""
    shutil.copytree(first[0], tmp_path / "copy")
    return tmp_path / "copy", first[1]


def test_the_next_process_finds_what_the_first_compiled_though_everything_was_moved(copy):
    folder, first = copy
    again = run(folder)
    assert not first.found and again.found and first.files >= 3 and not first.stderr and not again.stderr
    assert (again.value, again.files, again.directory.name) == (first.value, first.files, first.directory.name)
    assert again.directory != first.directory


def test_a_changed_constant_in_another_file_is_never_a_stale_hit(copy):
    folder, first = copy
    source = folder / "evodevo_sim" / "genetics" / "regulation.py"
    source.write_text(source.read_text().replace("REACH = 5.0", "REACH = 4.0"))
    after = run(folder)
    assert not after.found and after.value != first.value and after.directory.name != first.directory.name


def test_looking_at_every_index_never_meets_kernels_that_do_not(copy):
    folder, first = copy
    looking = run(folder, NUMBA_BOUNDSCHECK="1")
    assert not looking.found and looking.value == first.value and looking.directory.name != first.directory.name


def test_a_chosen_cache_directory_keeps_kernels_of_other_sources_apart(copy, tmp_path):
    folder, first = copy
    chosen = run(folder, NUMBA_CACHE_DIR=str(tmp_path / "chosen"))
    assert chosen.directory == tmp_path / "chosen" / "evodevo" / first.directory.name and chosen.files == first.files


def test_a_changed_constant_in_a_sub_package_is_never_a_stale_hit(copy):
    folder, first = copy
    package = folder / "evodevo_sim"
    inner = package / "genetics" / "networks"
    inner.mkdir()
    (inner / "__init__.py").write_text("from .regulation import affinity\n")
    source = inner / "regulation.py"
    moved = (package / "genetics" / "regulation.py").read_text()
    source.write_text(moved.replace("from ..", "from ...").replace("from .elements", "from ..elements"))
    (package / "genetics" / "regulation.py").unlink()
    for file in package.rglob("*.py"):
        if file.parent != inner:
            file.write_text(file.read_text().replace("genetics.regulation import", "genetics.networks.regulation import"))
    script = SCRIPT.replace("genetics.regulation import", "genetics.networks.regulation import")
    before = run(folder, script)
    assert before.value == first.value
    source.write_text(source.read_text().replace("REACH = 5.0", "REACH = 4.0"))
    after = run(folder, script)
    assert not after.found and after.value != before.value and after.directory != before.directory


def test_old_caches_go_and_the_present_one_stays(tmp_path, monkeypatch):
    monkeypatch.setattr(_jit, "_caches", lambda: tmp_path)
    monkeypatch.setattr(_jit, "CACHE_DIRECTORY", tmp_path / "present")
    for name in ("present", "old", "recent"):
        (tmp_path / name).mkdir()
    files = [tmp_path / name for name in ("sources-old.txt", "sources-recent.txt", "present/left.tmp", "present/f.nbc")]
    for path in files:
        path.write_text("")
    long_ago = os.stat(tmp_path).st_mtime - 30 * 86400
    for path in (tmp_path / "present", tmp_path / "old", files[0], *files[2:]):
        os.utime(path, (long_ago, long_ago))
    _jit.remove_old_caches()
    left = sorted(path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*"))
    assert left == ["present", "present/f.nbc", "recent", "sources-recent.txt"]


def test_a_kernel_of_another_module_is_found_again_wherever_its_files_are(own, tmp_path):
    module = own()
    assert module.times(3.0) == 7.0 and hits(module.times) == 0
    module = own()
    assert module.times(3.0) == 7.0 and hits(module.times) == 1
    own.folder.rename(tmp_path / "elsewhere")
    module = own(tmp_path / "elsewhere")
    assert module.times(3.0) == 7.0 and hits(module.times) == 1
    assert own.entry().parent != own.caches / "ours"


def test_a_module_that_changes_under_a_running_process_is_never_a_stale_hit_in_the_next(own):
    module = own()
    file = own.folder / "own_constants.py"
    file.write_text("FACTOR = 3.0\n")
    assert module.times(3.0) == 7.0 and not list(own.caches.rglob("*.nbc"))
    again = own()
    assert again.times(3.0) == 10.0 and hits(again.times) == 0


@pytest.mark.parametrize("name, before, after, expected", [
    ("own_kernels.py", "FACTOR * x", "FACTOR - x", 0.0),
    ("own_constants.py", "2.0", "3.0", 10.0),
    ("own_package/inner.py", "1.0", "4.0", 10.0),
])
def test_a_change_in_any_file_of_another_module_is_never_a_stale_hit(own, name, before, after, expected):
    assert own().times(3.0) == 7.0
    file = own.folder / name
    file.write_text(file.read_text().replace(before, after))
    module = own()
    assert module.times(3.0) == expected and hits(module.times) == 0


def test_a_change_in_our_kernels_compiles_those_of_other_modules_anew(own, monkeypatch):
    own().times(3.0)
    monkeypatch.setattr(_jit, "_HASH", "other")
    module = own()
    assert module.times(3.0) == 7.0 and hits(module.times) == 0


def test_fields_of_a_named_tuple_that_change_places_are_never_a_stale_hit(own, monkeypatch):
    for order, expected in (("a b", 1.0), ("b a", -1.0), ("a b", 1.0)):  # made in a file that the kernel's does not import
        other = types.ModuleType("own_types")
        other.Other = namedtuple("Other", order, module="own_types")
        monkeypatch.setitem(sys.modules, "own_types", other)
        first = own().first
        assert first(other.Other(3.0, 2.0)) == expected
    assert hits(first) == 1 and sum(1 for _ in own.caches.rglob("*first-*.nbc")) == 2


def test_options_of_compilation_tell_kernels_apart(own):
    function = own().times.py_func
    for options in ({}, {"fastmath": True}, {"nogil": False}, {}):
        compiled = _jit.kernel(function, **options)
        compiled(3.0)
    assert hits(compiled) == 1 and sum(1 for _ in own.caches.rglob("*.nbc")) == 3


def test_kernels_that_belong_to_one_process_leave_nothing_behind(own):
    module = own()
    times = module.times
    module.times(3.0)

    def closed(x):
        return times(x) + 1.0

    def handed(f, x):
        return f(x)

    local = namedtuple("local", "a b")
    space = {"kernel": _jit.kernel, "__name__": "typed_in"}
    exec("f = kernel(lambda x: x + 1.0)", space)  # of no file, as in a notebook
    assert _jit.kernel(closed)(3.0) == 8.0
    assert _jit.kernel(handed)(times, 3.0) == 7.0
    assert module.first(local(2.0, 1.0)) == 1.0
    assert _jit.kernel(lambda x: local(x, x))(1.0) == (1.0, 1.0)
    assert space["f"](1.0) == 2.0
    assert {path.name.rpartition("-")[0] for path in own.caches.rglob("*.nbc")} == {own.entry().name.rpartition("-")[0]}


def test_in_an_environment_without_a_writable_cache_kernels_run(copy):
    folder, first = copy
    unkept = run(folder, XDG_CACHE_HOME="/dev/null")
    assert unkept.value == first.value and unkept.files == 0
    assert unkept.stderr.count("\n") == 1 and "/dev/null/evodevo" in unkept.stderr and "(Not a directory)" in unkept.stderr
    assert not [path for path in (folder / "evodevo_sim").rglob("*") if path.suffix in (".nbi", ".nbc")]


def test_processes_that_compile_and_read_at_once_do_not_meet(own):
    """Writers replace the same entries while readers read them, and somebody damages them now and then."""
    script = """
import sys
sys.path.insert(0, sys.argv[1])
from pathlib import Path
from evodevo_sim.kernels import jit as _jit
_jit.CACHE_DIRECTORY = Path(sys.argv[2])
import own_kernels
for i in range(8):
    f = _jit.kernel(own_kernels.times.py_func)
    assert f(3.0) == 7.0
    if i % 4 == 3:
        for path in Path(sys.argv[2]).parent.rglob("*.nbc"):
            path.unlink(missing_ok=True) if i % 8 == 3 else path.write_bytes(b"cut")
"""
    command = [sys.executable, "-c", script, str(own.folder), str(own.caches / "ours")]
    running = [subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) for _ in range(3)]
    for process in running:
        out, err = process.communicate(timeout=120)
        assert process.returncode == 0 and not out, err
        assert all("is damaged" in line for line in err.splitlines()) and err.count("\n") <= 1
    assert not list(own.caches.rglob("*.tmp"))
