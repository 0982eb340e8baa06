"""The scheduler of a Dask cluster: reached, and of a version that fits, or one line that says what is wrong."""

from __future__ import annotations

import logging
import re
import warnings
from collections.abc import Mapping
from typing import Any

from evodevo_sim.extras import lacking
from evodevo_sim.inputs import one_line

from .contract import BackendError

CONNECT = 5.0  # s
_ADDRESS = re.compile(r"(tcp|tls|ws|wss|ucx)://(\[[0-9a-fA-F:.]+\]|[A-Za-z0-9._-]+):[0-9]{1,5}")
_ALIKE = ("distributed", "dask", "msgpack")  # what scheduler, workers and we must have in the same version, in part or whole


def check(scheduler: str) -> None:
    """Raises BackendError where Dask is not installed, or no scheduler of our version is there; an empty address asks for none."""
    distributed = imported()
    if scheduler:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            connected(distributed, scheduler).close(timeout=2)


def imported() -> Any:
    try:
        import distributed
    except ModuleNotFoundError as error:
        raise BackendError(str(lacking(error))) from None
    for name in ("distributed", *logging.root.manager.loggerDict):
        if name.partition(".")[0] == "distributed":
            logging.getLogger(name).setLevel(logging.CRITICAL)  # its pages of warnings; what counts is said here
    return distributed


def connected(distributed: Any, scheduler: str) -> Any:
    """A client.  Raises BackendError: no address, nobody there, or of another version."""

    class Client(distributed.Client):
        def __del__(self) -> None:
            """Whoever made it closes it; one that never came to a scheduler has nothing to close, and would wait for it."""

    shown = one_line(scheduler, 80)
    if not _ADDRESS.fullmatch(scheduler):
        raise BackendError(f"{shown!r} is no address of a Dask scheduler: give one like tcp://HOST:8786")
    try:
        client = Client(scheduler, timeout=CONNECT, set_as_default=False, name="evolve")
    except (OSError, TimeoutError):
        raise BackendError(
            f"no Dask scheduler of this version answers at {shown} within {CONNECT:g} s: start one by `dask scheduler`, or give its address"
        ) from None
    except Exception as error:
        raise BackendError(
            f"the Dask scheduler at {shown} cannot be used ({one_line(f'{type(error).__name__}: {error}', 90)}): "
            "give the address of one of this version of Dask"
        ) from None
    try:
        unlike = _other_versions(client.get_versions(check=False))
    except Exception as error:
        unlike = one_line(f"it does not tell them: {type(error).__name__}: {error}", 90)
    if unlike:
        client.close(timeout=2)
        raise BackendError(f"the Dask scheduler at {shown} has other versions: {unlike}")
    return client


def _other_versions(told: Mapping[str, Any]) -> str:
    """In what a scheduler's versions differ from ours, and the mend; nothing where they do not."""
    theirs, ours = told["scheduler"]["packages"], told["client"]["packages"]
    for name in _ALIKE:
        if theirs.get(name) != ours.get(name):
            return f"{name} {theirs.get(name)} there, {ours.get(name)} here: install the same on both"
    there, here = (str(packages.get("python")).split(".")[:2] for packages in (theirs, ours))
    if there != here:
        return f"Python {'.'.join(there)} there, {'.'.join(here)} here: run the scheduler in the same environment"
    return ""
