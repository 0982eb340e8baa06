"""Schemes: named ways to search, each a set of numbers and the class that searches with them.

    register(Scheme("climb", "children of the champion alone", {"population": 20}, Climb))      # then `Evolution(..., scheme="climb")`
"""

from __future__ import annotations

import dataclasses
import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING

from evodevo_sim.inputs import shown
from evodevo_sim.parameters import ParameterError, known_kind

from .settings import UNLIMITED, Settings

if TYPE_CHECKING:
    from .search import Search

_PANMICTIC = f"{__package__}.panmictic:Panmictic"
_LAYERS = f"{__package__}.layers:Layers"
_NICHES = f"{__package__}.niches:Niches"
_ARCHIVE = f"{__package__}.archive:Archive"
_GAITS = f"{__package__}.gaits:Gaits"
_UNLIKE = {"elongations": 12, "fillings": 6, "redraws": 8, "founders": 2500, "units": 44, "apart": 9.0, "tournament": 10}
_ONE_BODY = f"{__package__}.one_body:OneBody"


@dataclass(frozen=True)
class Scheme:
    """A way to search.

    Attributes: name: as `--scheme` takes it; what: it is, in a few words; settings: what differs from the defaults of Settings;
    search: its class, or anything that makes a Search of Settings; or its name as "module:class", imported when it is asked for;
    growth: the preset by which its bodies grow where nobody says, empty: the law of the model, None: that of all runs (`usual.GROWTH`).
    """

    name: str
    what: str
    settings: Mapping[str, float] = field(default_factory=dict)
    search: Callable[[Settings], Search] | str = _PANMICTIC
    growth: str | None = None

    def __post_init__(self):
        known = [item.name for item in dataclasses.fields(Settings)]
        for name in self.settings:
            if name not in known:
                raise ParameterError(f"scheme {self.name!r}: setting {name!r} is unknown: choose one of {', '.join(known)}")
        object.__setattr__(self, "settings", MappingProxyType(dict(self.settings)))

    @property
    def make(self) -> Callable[[Settings], Search]:
        """What makes its search."""
        return _imported(self.search) if isinstance(self.search, str) else self.search


def _imported(name: str):
    module, _, attribute = name.partition(":")
    return getattr(importlib.import_module(module), attribute)


_schemes: dict[str, Scheme] = {}
SCHEMES: Mapping[str, Scheme] = MappingProxyType(_schemes)


def register(scheme: Scheme) -> None:
    """Add a scheme, so that its name can be given wherever schemes are.  Raises ParameterError where the name is taken."""
    if _schemes.get(scheme.name, scheme) != scheme:
        raise ParameterError(f"scheme {scheme.name!r} is taken: give yours another name than {', '.join(_schemes)}")
    _schemes[scheme.name] = scheme


for _scheme in (
    Scheme("panmictic", "one population in which all compete"),
    # Section 3 of the paper, which ends a run after 500 generations without improvement and not before, and what its authors' saved
    # files fit.
    Scheme(
        "paper", "its baseline",
        {"generations": UNLIMITED, "tournament": 2, "point_mutation": 0.1, "point_scale": 3.0, "flip": 0.0}, growth="",
    ),
    Scheme("alps", "age layers", {"layers": 5}, _LAYERS),
    Scheme("niches", "of body shapes", {"niches": 5, "founders": 1000, "point_decades": 1.0, "tournament": 2}, _NICHES),
    Scheme("archive", "of unlike bodies", _UNLIKE, _ARCHIVE),
    Scheme("gaits", "an archive of unlike bodies with unlike gaits", _UNLIKE, _GAITS),
    Scheme(
        "one-body", "networks alone, of the body that is given",
        {"redraws": 8, "units": 44, "apart": 9.0, "tournament": 2, "start_share": 1.0}, _ONE_BODY,
    ),
):
    register(_scheme)

# The settings that part a population when above 1, and the search that does it.
_POPULATION = 50  # from which on what an archive is founded by is not most of a run
_CELLS = 5  # from which on bodies are unlike enough for an archive
_PARTING = {"layers": _LAYERS, "niches": _NICHES}


def default_scheme(task: str, settings: dict[str, float] | None = None, cells: int = 32, refines: bool = False) -> str:
    """The scheme of a search that names none: what suits the task; one population where its settings part one, or it or bodies are small.

    Args: refines: whether genomes to begin from are given.  docs/reference/search.md tells what each scheme is.
    """
    chosen = settings or {}
    small = cells < _CELLS or chosen.get("population", Settings.population) < _POPULATION
    other = small or any(chosen.get(name, 1) > 1 for name in _PARTING)
    kind = known_kind(task)
    return "panmictic" if other else (kind.refining if refines else "") or kind.scheme


def scheme_of(name: str) -> Scheme:
    """Raises ParameterError where there is none of that name."""
    if name not in SCHEMES:
        raise ParameterError(f"scheme {shown(name)} is unknown: choose one of {', '.join(SCHEMES)}")
    return SCHEMES[name]


def scheme(name: str, task: str = "swim") -> dict[str, float]:
    """What a scheme and a task change, for `Settings(**scheme(name, task))`.  Raises ParameterError where there is none of that name."""
    return dict(known_kind(task).search) | dict(scheme_of(name).settings)


def search_of(settings: Settings, name: str = "panmictic") -> Search:
    """The search of a scheme.  Schemes of one population take layers or niches too, whichever the settings have above 1.

    Raises ParameterError where there is no scheme of that name, or its search takes no such parts.
    """
    scheme, own = scheme_of(name), (_PANMICTIC, *_PARTING.values())
    make = scheme.make
    for number, parting in _PARTING.items():
        if getattr(settings, number) > 1:
            parted = _imported(parting)
            if scheme.search in own or make in map(_imported, own):
                return parted(settings)
            if not (isinstance(make, type) and issubclass(make, parted)):
                given = f"settings.{number} is {getattr(settings, number)}"
                raise ParameterError(f"{given}: give 1, the search of scheme {name!r} has no {number}")
    return make(settings)
