"""Compiled kernels on disk: found again by the next process, and never those of other sources."""

import gc
import importlib
import os
import pickle
import pkgutil
import resource
import shutil
import subprocess
import sys
import types
from collections import namedtuple
from contextlib import contextmanager
from pathlib import Path

import pytest
from evodevo_sim.kernels import cache as _kernel_cache
from evodevo_sim.kernels import jit as _jit
from evodevo_sim.kernels.cache import MAGIC, Damaged, read_entry, write_entry
from evodevo_sim.kernels.sources import sources_of_package
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numba.core.dispatcher import Dispatcher
from numba.extending import _Intrinsic

import evodevo_sim

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


def test_every_file_whose_code_numba_was_given_counts():
    for module in pkgutil.walk_packages([str(PACKAGE)], "evodevo_sim."):
        importlib.import_module(module.name)
    functions = [item.py_func for item in gc.get_objects() if isinstance(item, Dispatcher)]
    functions += [item._defn for item in gc.get_objects() if isinstance(item, _Intrinsic)]
    files = {Path(function.__code__.co_filename).resolve() for function in functions}
    ours = {file for file in files if file.is_relative_to(PACKAGE.resolve())}
    assert len(ours) > 15 and ours <= set(_jit.kernel_sources())


def test_what_no_kernel_depends_on_does_not_count():
    names = {path.relative_to(PACKAGE.resolve()).as_posix() for path in _jit.kernel_sources()}
    assert not names & {"parameters.py", "task_kinds.py", "inputs.py", "genetics/genome.py"}  # help texts and tasks
    assert not names & {
        "__init__.py", "ros/messages.py", "tasks/evaluation.py", "analysis/gait/contact.py", "view/picture.py", "nodes/simulator.py",
    }


TREE = {
    "__init__.py": "from .far import FAR\nfrom .view import draw",
    "jit.py": "import numba",
    "made/__init__.py": "from .jit2 import kernel, make as lean\nfrom . import jit2\nOWN = 1",
    "made/jit2.py": "from ..jit import kernel, make",
    "near.py": "import sys",
    "kernel.py": "def f(): pass",
    "far.py": "from .near import N",
    "other.py": "",
    "view.py": "from .other import O",
    "sub/__init__.py": "from .inner import X\nfrom ..view import draw\nfrom ..far import near as n",
    "sub/inner.py": "from ..near import N",
    "sub/deep/__init__.py": "from ...far import FAR as DEEP",
    "mid.py": "from . import sub\nsub.inner",
    "late.py": "def f():\n    from .near import N\n    return N",
}
MADE = {"made/__init__.py", "made/jit2.py"}
VIA_VIEW = {"view.py", "other.py"}


@pytest.mark.parametrize("text, expected", [
    ("from .jit import kernel\n@kernel\ndef f(): pass", set()),
    ("from .jit import lean as l\nf = l(len)", set()),
    ("def f():\n    from p.jit import inlined\n    return inlined(inline=True)(len)", set()),
    ("from .made import kernel\n@kernel\ndef f(): pass", MADE),
    ("from .made import lean\n@lean\ndef f(): pass", None),  # another function under that name
    ("from . import jit\n@jit.kernel\ndef f(): pass", set()),
    ("import p.jit\ng = p.jit.lean(len)", set()),
    ("import p.jit as j\n@j.kernel(inline=True)\ndef f(): pass", set()),
    ("from . import made\n@made.jit2.kernel\ndef f(): pass", MADE - {"made/__init__.py"}),
    ("from .jit import *", set()),
    ("from .made import *", MADE),
    ("from . import kernel\nkernel.f(3)", None),  # a module of that name
    ("from .kernel import f", None),
    ("from numba import njit", set()),
    ("def f():\n    import numba.extending", set()),
    ("from .jit import is_compiled", None),
    ("from . import jit\njit.is_compiled(1)", None),
    ("class T: kernel = 1\nT.kernel\nfrom .near import N\nN.kernel", None),
    ("import os", None),
    ("K; from .near import N", {"near.py"}),
    ("K; from . import near", {"near.py"}),
    ("K; from p import near", {"near.py"}),
    ("K; import p.near", {"near.py"}),
    ("K; import p.near as x", {"near.py"}),
    ("K; import p\np.near.N", {"near.py"}),
    ("K; import p\np.FAR + 1", {"__init__.py", "far.py", "near.py"}),
    ("K; import p\nf(p)", {"__init__.py", "far.py", "near.py"} | VIA_VIEW),
    ("K; from p import FAR", {"__init__.py", "far.py", "near.py"}),
    ("K; from . import absent", {"__init__.py", "far.py", "near.py"} | VIA_VIEW),
    ("K; from . import *", {"__init__.py", "far.py", "near.py"} | VIA_VIEW),
    ("K; from .sub import X", {"sub/__init__.py", "sub/inner.py", "near.py"}),
    ("K; from . import sub\nsub.X", {"sub/__init__.py", "sub/inner.py", "near.py"}),
    ("K; from . import sub\nsub.inner.X", {"sub/inner.py", "near.py"}),
    ("K; from .sub import inner as i", {"sub/inner.py", "near.py"}),
    ("K; from .sub import n", {"sub/__init__.py", "far.py", "near.py"}),
    ("K; from .sub.deep import DEEP", {"sub/deep/__init__.py", "far.py", "near.py"}),
    ("K; import p.sub.deep\np.sub.deep.DEEP\np.near", {"sub/deep/__init__.py", "far.py", "near.py"}),
    ("K; from .made import OWN", MADE),
    ("K; from .mid import sub\nsub.X", {"mid.py", "sub/__init__.py", "sub/inner.py", "near.py"}),
    ("K; from . import mid\nmid.sub.n", {"mid.py", "sub/__init__.py", "sub/inner.py", "far.py", "near.py"}),
    ("K; from . import sub", {"sub/__init__.py", "sub/inner.py", "far.py", "near.py"} | VIA_VIEW),
    ("K; from .late import f", {"late.py", "near.py"}),
    ("K; from .far import *", {"far.py", "near.py"}),
    ("K; from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from .view import draw\nelse:\n    from .near import N", {"near.py"}),
    ("K\ntry:\n    from .absent import A\nexcept ImportError:\n    from .near import N", {"near.py"}),
    ("K; from ...... import far; import p.absent, q.near", set()),
])
def test_imports_of_every_form_are_followed(tmp_path, text, expected):
    text = text.replace("K", "from .jit import kernel; kernel(len)", 1) if text[0] == "K" else text
    for name, content in (TREE | {"a.py": text}).items():
        file = tmp_path / "p" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(content)
    (tmp_path / "p" / "broken.py").write_text("from .jit import kernel\n(")
    root = tmp_path / "p"
    found = {path.relative_to(root).as_posix() for path in sources_of_package(root, root / "jit.py")}
    assert found == {"jit.py"} | (set() if expected is None else {"a.py"} | expected)


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


# A kernel of somebody else's, in a file of its own, small enough to be compiled often.

OWN = """
from collections import namedtuple
from evodevo_sim.kernels.jit import kernel, lean
from own_constants import FACTOR
from own_package.inner import TERM

Pair = namedtuple("Pair", "a b")

@lean
def times(x):
    return FACTOR * x + TERM

@kernel
def first(pair):
    return pair.a - pair.b
"""


@pytest.fixture
def own(tmp_path, monkeypatch):
    """Imports OWN, which has been changed or not, as a fresh module whose kernels are kept under `tmp_path / "caches"`."""
    folder = tmp_path / "own"
    (folder / "own_package").mkdir(parents=True)
    (folder / "own_package" / "__init__.py").write_text("import numpy\n")
    (folder / "own_package" / "inner.py").write_text("TERM = 1.0\n")
    (folder / "numpy").mkdir()  # a folder of data, which hides no package
    (folder / "own_constants.py").write_text("FACTOR = 2.0\n")
    (folder / "own_kernels.py").write_text(OWN)
    monkeypatch.setattr(_jit, "CACHE_DIRECTORY", tmp_path / "caches" / "ours")
    monkeypatch.setattr(_kernel_cache, "_told", set())

    def load(folder=folder):
        with monkeypatch.context() as patch:
            patch.syspath_prepend(str(folder))
            patch.setattr(sys, "dont_write_bytecode", True)
            for name in ("own_kernels", "own_constants", "own_package", "own_package.inner"):
                sys.modules.pop(name, None)
            return importlib.import_module("own_kernels")

    load.folder = folder
    load.caches = tmp_path / "caches"
    load.entry = lambda name="times": next(load.caches.rglob(f"{name}-*.nbc"), None) or next(load.caches.rglob(f"*.{name}-*.nbc"))
    return load


def hits(dispatcher):
    return sum(dispatcher.stats.cache_hits.values())


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


# Damage to an entry: whatever was done to its file, it is compiled anew, in one line, and the next process finds it sound.

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


@pytest.fixture(scope="module")
def remembered(tmp_path_factory):
    """Finds the sources by the list in a directory."""
    caches = tmp_path_factory.mktemp("lists")
    found = _jit.kernel_sources()

    def run():
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(_jit, "_caches", lambda: caches)
            patch.setattr(_jit, "kernel_sources", lambda: found)  # what it costs is not the matter here
            assert _jit._remembered_sources() == found
        return next(caches.iterdir())

    return run


@settings(max_examples=20)
@given(st.data())
def test_a_damaged_list_of_sources_is_made_anew(remembered, data):
    path = remembered()
    sound = path.read_bytes()
    at = data.draw(st.integers(0, len(sound) - 1))
    flip = bytes([sound[at] ^ data.draw(st.integers(1, 255))])
    path.write_bytes(data.draw(st.sampled_from([sound[:at], sound + b"x", sound[:at] + flip + sound[at + 1 :]])))
    assert remembered().read_bytes() == sound


# A cache that cannot be written: kernels are compiled in memory, said in one line with the reason, and nothing is left anywhere.


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
    assert _jit.compiling("swim.swim") == "Compiling the simulation kernels, once: about a minute."
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
