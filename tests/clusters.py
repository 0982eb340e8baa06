"""Schedulers and workers of Dask for tests: processes of their own on this host, ended at the end."""

import os
import subprocess
import sys
from contextlib import contextmanager

# A scheduler or a worker as `dask scheduler` and `dask worker` start them, without their nannies and pages.
SERVER = """
import asyncio, sys
import distributed
{before}
async def main():
    async with {server} as server:
        print(server.address, flush=True)
        await server.finished()
asyncio.run(main())
"""
SCHEDULER = "distributed.Scheduler(host='127.0.0.1', port=0, dashboard_address='127.0.0.1:0')"
WORKER = "distributed.Worker({scheduler!r}, host='127.0.0.1', nthreads=1, dashboard_address='127.0.0.1:0')"


@contextmanager
def started(server, before="", **environment):
    """A process with a server of Dask's: (process, its address)."""
    process = subprocess.Popen(
        [sys.executable, "-c", SERVER.format(server=server, before=before)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        env=os.environ | environment,
    )
    try:
        yield process, process.stdout.readline().strip()
    finally:
        process.kill()
        process.communicate()
