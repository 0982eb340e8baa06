"""The Rerun viewer: files for it, and the program itself."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

from ..command_process import if_ended
from ..recording import Recording
from ..recording.life import Life
from .files import OutputError
from .palettes import DEFAULT

COMMAND = "rerun --bind 127.0.0.1"  # what a user types before a file; by itself the program listens on all interfaces
NO_RERUN = "the Rerun viewer is not installed: pip install rerun-sdk"


def has_display() -> bool:
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def is_installed() -> bool:
    return find_spec("rerun") is not None


def save(
    recording: Recording, life: Life, path: str, step: Callable[[str], None] = lambda part: None, palette: str = DEFAULT,
    show: str | None = None, cell: int | None = None,
) -> None:
    """Write a Rerun file.

    Args: step: called with the name of each part before it is written; show: a purpose, see `purposes`; cell: whose thoughts.

    Raises OutputError where Rerun is missing or cannot write, RecordingError where the recording does not serve the purpose.
    """
    if not is_installed():
        raise OutputError(NO_RERUN)
    import rerun

    from .purposes import chosen, log_purpose

    purpose = chosen(recording, life, show)
    with switched_on():
        stream = rerun.RecordingStream("evodevo" if purpose == "watch" else f"evodevo {purpose}")  # the viewer keeps a layout for each
        try:
            stream.save(path)
            layout = log_purpose(stream, recording, life, purpose, step, palette, cell)
            if rerun.get_application_id(stream) is not None:  # none where Rerun is switched off after all
                stream.send_blueprint(layout)
        finally:
            stream.disconnect()
    if not os.path.getsize(path):
        raise OutputError("Rerun wrote nothing: unset RERUN in the environment, and try again")


@contextmanager
def switched_on() -> Iterator[None]:
    """Without the switch by which the environment turns all of Rerun off: who asks for a file wants its contents."""
    switch = os.environ.pop("RERUN", None)
    try:
        yield
    finally:
        if switch is not None:
            os.environ["RERUN"] = switch


@contextmanager
def silent() -> Iterator[None]:
    """Rerun, if it is imported here first, logs nothing of its own, as where its viewer is closed, unless the environment asks it to."""
    asked = "RUST_LOG" in os.environ
    os.environ.setdefault("RUST_LOG", "off")
    try:
        yield
    finally:
        if not asked:
            del os.environ["RUST_LOG"]


@contextmanager
def opened(*arguments: str | os.PathLike) -> Iterator[subprocess.Popen]:
    """The viewer, as a context that ends it.  Nothing leaves this host.  Yields its process."""
    import rerun_cli

    # The program itself: its Python wrapper would leave it running when it is ended.
    beside = Path(rerun_cli.__file__).parent / "rerun"
    program = str(beside) if beside.exists() else "rerun"
    with tempfile.TemporaryDirectory(prefix="evodevo-") as settings:
        homes = {"XDG_CONFIG_HOME": settings, "XDG_DATA_HOME": settings}
        environment = {"RUST_LOG": "error"} | os.environ | homes
        # The viewer sends statistics of its use to its makers unless its settings say not to, which this command writes.
        subprocess.run([program, "analytics", "disable"], env=environment, capture_output=True, check=False)
        viewer = subprocess.Popen([program, "--bind", "127.0.0.1", *arguments], env=environment)
        try:
            with if_ended(lambda: _end(viewer, settings)):
                yield viewer
        finally:
            if viewer.poll() is None:
                viewer.terminate()
                viewer.wait()


def _end(viewer: subprocess.Popen, settings: str) -> None:
    """End the viewer while another thread may wait for it, and remove its settings."""
    viewer.terminate()
    try:
        viewer.wait(2.0)
    except subprocess.TimeoutExpired:
        viewer.kill()
    shutil.rmtree(settings, ignore_errors=True)


def show(path: str | os.PathLike) -> int:
    """Open a Rerun file in the viewer and wait until it is closed.  Returns its exit code."""
    with opened("--port", "auto", path) as viewer:
        code = viewer.wait()
    if code:
        print(f"replay: the viewer ended with code {code}: --no-viewer saves a file instead", file=sys.stderr)
    return code


def free_port() -> int:
    """A port of this host that nobody listens on."""
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]
