"""The files that compiled kernels depend on, found by reading imports, and a hash of them.

A file counts when it makes kernels, and so does every file that one of those imports, through
packages and what their `__init__` passes on.  Imports inside functions count, since a function may build a kernel from what it
imports; those under `if TYPE_CHECKING` do not, since they bring no value at run time.  A package's `__init__` counts where a name
is taken from it, with the one import that the name comes from, and with all its imports where it makes the name itself.
Not followed: modules imported by a name in a string, and an `__init__` that changes values of other modules.
"""

from __future__ import annotations

import ast
import hashlib
import os
import sys
import sysconfig
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

MAKERS = frozenset({"kernel", "lean", "seam", "inlined"})
_LIBRARY = tuple(Path(sysconfig.get_path(name)).resolve() for name in ("stdlib", "platstdlib"))


class Bound(NamedTuple):
    """One import.  name: what it binds in its file, "" where nothing; base: folder where the search for `parts` starts, None where
    that is outside; whole: all names (`import *`); plain: `import a.b`, which binds the first of the parts."""

    name: str
    base: Path | None
    parts: tuple[str, ...]
    whole: bool = False
    plain: bool = False


class _Names(ast.NodeVisitor):
    """imports: statements that are run; chains: (name, *attributes), each as long as it is written; made: names bound otherwise."""

    def __init__(self):
        self.imports: list[ast.Import | ast.ImportFrom] = []
        self.chains: list[tuple[str, ...]] = []
        self.made: set[str] = set()

    def visit_If(self, node: ast.If) -> None:
        test = node.test
        if getattr(test, "id", getattr(test, "attr", "")) == "TYPE_CHECKING":
            for item in node.orelse:
                self.visit(item)
        else:
            self.generic_visit(node)

    def visit_Import(self, node: ast.Import) -> None:
        self.imports.append(node)

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        self.imports.append(node)

    def visit_Attribute(self, node: ast.Attribute) -> None:
        chain, inner = [node.attr], node.value
        while isinstance(inner, ast.Attribute):
            chain.append(inner.attr)
            inner = inner.value
        if isinstance(inner, ast.Name):
            self.chains.append((inner.id, *reversed(chain)))
        else:
            self.visit(inner)

    def visit_Name(self, node: ast.Name) -> None:
        if isinstance(node.ctx, ast.Load):
            self.chains.append((node.id,))
        else:
            self.made.add(node.id)

    def _visit_definition(self, node) -> None:
        self.made.add(node.name)
        self.generic_visit(node)

    visit_FunctionDef = visit_AsyncFunctionDef = visit_ClassDef = _visit_definition


def _names(file: Path) -> _Names:
    return _names_of(file.read_bytes())


@lru_cache(maxsize=1000)
def _names_of(content: bytes) -> _Names:
    found = _Names()
    with suppress(SyntaxError, ValueError):  # a file that cannot be imported feeds no kernel
        found.visit(ast.parse(content))
    return found


def _find(base: Path, parts: tuple[str, ...]) -> tuple[Path, tuple[str, ...]]:
    """The module (a file) or package (a folder) that a dotted name leads to, and the parts that are names within it."""
    for i, part in enumerate(parts):
        folder, module = base / part, base / f"{part}.py"
        if (folder / "__init__.py").is_file():
            base = folder
        elif module.is_file():
            return module, parts[i + 1 :]
        elif folder.is_dir():
            base = folder
        else:
            return base, parts[i:]
    return base, ()


class Imports:
    """What files import, transitively.  files: all that count; locate: the folder that holds a top-level name, None where that is
    none of ours."""

    def __init__(self, locate: Callable[[str], Path | None]):
        self.files: set[Path] = set()
        self._locate = locate
        self._done: set = set()

    def bound(self, file: Path) -> Iterator[Bound]:
        """The imports of a file."""
        for node in _names(file).imports:
            if isinstance(node, ast.Import):
                for item in node.names:
                    parts = tuple(item.name.split("."))
                    yield Bound(item.asname or parts[0], self._locate(parts[0]), parts, plain=not item.asname)
                continue
            parts = tuple(node.module.split(".")) if node.module else ()
            base = file.parents[min(node.level, len(file.parents)) - 1] if node.level else self._locate(parts[0])
            for item in node.names:
                if item.name == "*":
                    yield Bound("", base, parts, whole=True)
                else:
                    yield Bound(item.asname or item.name, base, (*parts, item.name))

    def add(self, file: Path) -> None:
        """Count a file and all that it imports."""
        if file in self._done or not file.is_file():
            return
        self._done.add(file)
        self.files.add(file)
        for bound in self.bound(file):
            self._follow(file, bound)

    def _follow(self, file: Path, bound: Bound, rest: tuple[str, ...] | None = None) -> None:
        """Count what an import brings into a file.  rest: the attribute of it that is used, by default all that the file names."""
        if bound.base is None:
            return
        place, names = _find(bound.base, bound.parts)
        if bound.whole:
            if not names:
                self._want(place, ())
            return
        if bound.plain:
            if place.is_file():
                self.add(place)
            place, names = _find(bound.base, bound.parts[:1])
        elif len(names) > 1:  # only the last part can be a name within a module
            return
        elif not names and len(bound.parts) > 1:  # a module that an `__init__` may have bound to something else
            package = _find(bound.base, bound.parts[:-1])[0]
            if package.is_dir():
                self._take(package, bound.parts[-1], (), or_all=False)
        uses = {rest} if rest is not None else {chain[1:] for chain in _names(file).chains if chain[0] == bound.name}
        for used in uses or (set() if bound.plain else {()}):  # what is imported and not used may be for others to take
            self._want(*_find(place, used) if place.is_dir() and not names else (place, names + used))

    def _want(self, place: Path, names: tuple[str, ...]) -> None:
        """Count a module, or of a package the name that is taken, or all where it is taken as a whole."""
        if place.is_file():
            self.add(place)
            if names[1:] and (place, names) not in self._done:
                self._done.add((place, names))
                for bound in self.bound(place):
                    if bound.name == names[0]:
                        self._follow(place, bound, names[1:])
        elif names:
            self._take(place, names[0], names[1:])
        else:
            self.add(place / "__init__.py")

    def _take(self, package: Path, name: str, rest: tuple[str, ...], or_all: bool = True) -> None:
        """Count where the `__init__` of a package has a name from.  or_all: count all its imports where it imports no such name."""
        init = package / "__init__.py"
        if (init, name, rest) in self._done or not init.is_file():
            return
        self._done.add((init, name, rest))
        sources = [bound for bound in self.bound(init) if bound.name == name and not bound.plain]
        if name in _names(init).made or or_all and not sources:
            self.add(init)
            return
        for bound in sources:
            self.files.add(init)
            self._follow(init, bound, rest)

    def makes_kernels(self, file: Path, maker: Path) -> bool:
        """Whether a file uses a decorator of the module `maker`, under whatever name, or imports anything of numba."""
        for bound in self.bound(file):
            if bound.parts[:1] == ("numba",):
                return True
            if bound.base is None:
                continue
            if bound.whole:
                place, names = _find(bound.base, bound.parts)
                if any(self._is_maker(place, (*names, name), maker) for name in MAKERS):
                    return True
                continue
            start = bound.parts[:1] if bound.plain else bound.parts
            for chain in _names(file).chains:
                if chain[0] == bound.name and self._is_maker(bound.base, start + chain[1:], maker):
                    return True
        return False

    def _is_maker(self, base: Path, parts: tuple[str, ...], maker: Path, above: tuple = ()) -> bool:
        """Whether a dotted name leads to a decorator, also through files that pass it on."""
        place, names = _find(base, parts)
        if place == maker:
            return bool(MAKERS.intersection(names[:1]))
        if not names:
            place, names = place.parent, parts[-1:]
        file = place / "__init__.py" if place.is_dir() else place
        if not names or (file, names) in above or not file.is_file():
            return False
        for bound in self.bound(file):
            if bound.base is not None and (bound.whole or bound.name == names[0]):
                start = bound.parts + names[:1] if bound.whole else bound.parts[:1] if bound.plain else bound.parts
                if self._is_maker(bound.base, start + names[1:], maker, (*above, (file, names))):
                    return True
        return False


def package_root(file: Path, module: str) -> Path:
    """The folder of the top-level package that the module of this name, in this file, belongs to."""
    return file.parents[module.count(".") - 1]


def sources_of_package(root: Path, maker: Path) -> list[Path]:
    """The files of the package in the folder `root` that its kernels depend on, in a fixed order.

    Args: maker: the module that holds the decorators.
    """
    imports = Imports(lambda name: root.parent if name == root.name else None)
    for file in sorted(root.rglob("*.py")):
        if file == maker or imports.makes_kernels(file, maker):
            imports.add(file)
    return sorted(imports.files)


def sources_of_file(file: Path, besides: str) -> list[Path]:
    """A file and all that it imports, in a fixed order, but for the package `besides`, the standard library and what is installed."""
    top = top_folder(file)
    own = file.relative_to(top).parts[0].removesuffix(".py")

    def locate(name: str) -> Path | None:
        if name == besides:
            return None
        loaded = getattr(sys.modules.get(name), "__file__", None)
        folders = [top, *([top_folder(Path(loaded).resolve())] if loaded else []), *(Path(path).resolve() for path in sys.path)]
        holders = [folder for folder in folders if (folder / f"{name}.py").is_file() or (folder / name / "__init__.py").is_file()]
        holders += [folder for folder in folders if (folder / name).is_dir()]
        return next((folder for folder in holders[:1] if name == own or not is_installed(folder)), None)

    imports = Imports(locate)
    imports.add(file)
    return sorted(imports.files)


def is_installed(folder: Path) -> bool:
    """Whether modules of a folder belong to Python or to an installed distribution."""
    return not {"site-packages", "dist-packages"}.isdisjoint(folder.parts) or any(folder.is_relative_to(path) for path in _LIBRARY)


def top_folder(file: Path) -> Path:
    """The folder that holds a module, or the top-level package that the module is in."""
    folder = file.parent
    while (folder / "__init__.py").is_file():
        folder = folder.parent
    return folder


def hash_of(files: Iterable[Path], base: Path, *also: object) -> str:
    """A hash of the contents of files, of their paths relative to `base`, and of whatever else counts."""
    digest = hashlib.sha256("\n".join(map(str, also)).encode())
    named = sorted((os.fsencode(path.relative_to(base) if path.is_relative_to(base) else path.name), path) for path in files)
    for name, path in named:
        content = path.read_bytes()
        digest.update(b"\n%b %d\n" % (name, len(content)) + content)
    return digest.hexdigest()[:16]
