"""Who evaluates the genomes of a run where that is no simulator node: threads of this process, or workers of a Dask cluster."""

from __future__ import annotations

from collections.abc import Callable

from ..arguments import Options, cores
from ..backends.contract import Backend, BackendError
from ..backends.local import LocalBackend
from ..pool.driver import Pool
from ..pool.vigil import PoolError

_START = 30.0  # s, for a worker to start, and to load its kernels


def check_backend(options: Options) -> None:
    """Raises PoolError where the backend cannot be used, before anything of the run is written."""
    if options.backend == "dask":
        from ..backends.dask_scheduler import check

        try:
            check(options.scheduler)
        except BackendError as error:
            raise PoolError(str(error)) from None


def other_pool(options: Options, stop: Callable[[], bool]) -> Pool:
    """The pool of a run whose backend is not ROS, once there is somebody in it, for whom one waits a while.  Raises PoolError."""
    try:
        backend = _backend(options)
    except BackendError as error:
        raise PoolError(str(error)) from None
    print(f"Evolving on {backend}; recording to {options.out}", flush=True)
    pool = Pool(backend, quarantine=options.out, give_up_after=options.give_up_after)
    pool.wait(_START, stop)
    return pool


def _backend(options: Options) -> Backend:
    if options.backend == "local":
        return LocalBackend(options.threads or cores())
    from ..backends.dask import DaskBackend

    return DaskBackend(options.scheduler, options.task, options.threads or cores())
