"""Which files kernels depend on: found by imports of every form, and remembered."""

import gc
import importlib
import pkgutil
from pathlib import Path

import pytest
from evodevo_sim.kernels import jit as _jit
from evodevo_sim.kernels.sources import sources_of_package
from hypothesis import given, settings
from hypothesis import strategies as st
from numba.core.dispatcher import Dispatcher
from numba.extending import _Intrinsic

import evodevo_sim

PACKAGE = Path(evodevo_sim.__file__).parent



def test_every_file_whose_code_numba_was_given_counts():
    for module in pkgutil.walk_packages([str(PACKAGE)], "evodevo_sim."):
        importlib.import_module(module.name)
    objects = gc.get_objects()  # proxies of what is gone among them, which nobody can ask what they are
    functions = [item.py_func for item in objects if issubclass(type(item), Dispatcher)]
    functions += [item._defn for item in objects if issubclass(type(item), _Intrinsic)]
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
