"""A run of evolve in Rerun while it goes on: in the viewer, or in a file."""

from __future__ import annotations

import os
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from ..parameters import Task
from .files import OutputError, check
from .palettes import DEFAULT
from .viewer import NO_RERUN, free_port, has_display, is_installed, opened, silent, switched_on

_ROOM = 18  # champions that the gallery shows at once; twice as many, and so on, when there are more


class RunView:
    """A Rerun stream of a run, as a context.  It opens no viewer before the context begins, and leaves it open when the run has ended.

    Args: name: of the run; task: of it; path: a Rerun file, made anew, or nothing for the viewer.
    Raises OutputError where Rerun or a display is missing, or the file cannot be written.
    """

    def __init__(self, name: str, task: Task, path: str | os.PathLike = "", palette: str = DEFAULT):
        if not is_installed():
            raise OutputError(NO_RERUN)
        if not path and not has_display():
            raise OutputError("there is no display for --view: give it a file, --view FILE.rrd, or `replay --show evolve` the run later")
        if path:
            check(Path(path), ".rrd")
        self._name, self._task, self._path, self._palette = name, task, path, palette
        self._stack = ExitStack()
        self._room = _ROOM
        self._fails = ""  # why it shows nothing any more

    def __enter__(self) -> RunView:
        with silent():
            import rerun as rr

        from . import evolve_view

        self._rr = rr
        with switched_on():
            self._stream = rr.RecordingStream(f"evodevo evolve {self._name}")
        if self._path:
            self._stream.set_sinks(rr.FileSink(str(self._path)))
        else:
            port = free_port()
            self._process = self._stack.enter_context(opened("--port", str(port)))
            self._stream.set_sinks(rr.GrpcSink(f"rerun+http://127.0.0.1:{port}/proxy"))
        evolve_view.style(self._stream)
        self._gallery = evolve_view.Gallery(self._stream, self._task, self._palette)
        self._lay_out()
        self._tell(f"# {self._name}\n\nThe first generation is being evaluated.\n")
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        from ..command_process import exit_code

        with self._stack:
            self._stream.disconnect()
            if not self._path and kind is None and not exit_code() and self._process.poll() is None:
                print("Close the viewer to end.", flush=True)
                self._process.wait()

    def hear(self, message: Any) -> None:
        """Show a message of the run, if it is of those that are shown.  It never fails: the run matters more than its picture."""
        from evodevo_msgs import msg

        if self._fails:
            return
        if not self._path and self._process.poll() is not None:
            self._fails = "closed"
            print("evolve: the viewer was closed; the run goes on", flush=True)
            return
        try:
            if isinstance(message, msg.GenerationStatistics):
                self._generation(message)
            elif isinstance(message, msg.Champion):
                self._gallery.add(message)
                if len(self._gallery) > self._room:
                    self._room *= 2
                    self._lay_out()
        except Exception as error:
            self._fails = f"{type(error).__name__}: {error}"
            print(f"evolve: --view shows no more ({self._fails[:120]}); the run goes on", flush=True)

    def _lay_out(self) -> None:
        from . import evolve_view

        self._stream.send_blueprint(evolve_view.blueprint(self._gallery, self._room))

    def _generation(self, s: Any) -> None:
        self._stream.set_time("generation", sequence=s.generation)
        for name in ("best", "median", "diversity"):
            self._stream.log(f"evolution/{name}", self._rr.Scalars(float(getattr(s, name))))
        self._tell(
            f"# {self._name}\n\n**Generation {s.generation}:** best {s.best:.3f}, median {s.median:.3f}, diversity {s.diversity:.2f}.\n\n"
            f"{s.evaluations:,} evaluations, {s.evaluations_per_second:.0f} in a second; {s.stagnation} generations without improvement.\n"
        )

    def _tell(self, text: str) -> None:
        self._stream.log("summary", self._rr.TextDocument(text, media_type=self._rr.MediaType.MARKDOWN))
