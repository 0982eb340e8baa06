"""Compiled kernels on disk: found again by the next process, and never those of other sources."""

import gc
import importlib
import os
import pkgutil
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from evodevo_sim.kernels import jit as _jit
from evodevo_sim.kernels.sources import sources_of_package
from numba.core.dispatcher import Dispatcher
from numba.extending import _Intrinsic

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

    def run(script=SCRIPT, **changed):
        result = subprocess.run(
            [sys.executable, "-c", script], capture_output=True, text=True, env=environment | changed, timeout=120
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


def test_a_changed_constant_in_a_sub_package_is_never_a_stale_hit(copy):
    inner = copy.directory / "genetics"
    inner.mkdir()
    (inner / "__init__.py").write_text("from .regulation import affinity\n")
    source = inner / "regulation.py"
    source.write_text((copy.directory / "regulation.py").read_text().replace("from .", "from .."))
    (copy.directory / "regulation.py").unlink()
    for file in copy.directory.rglob("*.py"):
        if file.parent != inner:
            file.write_text(file.read_text().replace("from .regulation import", "from .genetics.regulation import"))
    moved = SCRIPT.replace("sim.regulation import", "sim.genetics.regulation import")
    _, before, _, directory = copy(moved)
    source.write_text(source.read_text().replace("REACH = 5.0", "REACH = 4.0"))
    compiled, after, _, elsewhere = copy(moved)
    assert not compiled and after != before and elsewhere != directory


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
    assert "parameters.py" in names
    assert not names & {"__init__.py", "messages.py", "evaluation.py", "gait/contact.py", "replay/cli.py", "nodes/simulator.py"}


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
    ("K; from .late import f", {"late.py", "near.py"}),
    ("K; from .far import *", {"far.py", "near.py"}),
    ("K; from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from .view import draw\nelse:\n    from .near import N", {"near.py"}),
    ("K\ntry:\n    from .absent import A\nexcept ImportError:\n    from .near import N", {"near.py"}),
    ("K; from ...... import far; import p.absent, q.near", set()),
])
def test_imports_of_every_form_are_followed(tmp_path, text, expected):
    for name, content in (TREE | {"a.py": text.replace("K", "from .jit import kernel; kernel(len)", 1) if text[0] == "K" else text}).items():
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
    long_ago = os.stat(tmp_path).st_mtime - 30 * 86400
    for name in ("present", "old"):
        os.utime(tmp_path / name, (long_ago, long_ago))
    _jit.remove_old_caches()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["present", "recent"]
