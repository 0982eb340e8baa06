"""Kernels of somebody else's, in a module of its own, small enough to be compiled often."""

import importlib
import sys

from evodevo_sim.kernels import cache as _kernel_cache
from evodevo_sim.kernels import jit as _jit

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
