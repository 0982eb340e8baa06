"""An animat in Rerun while it lives: in the viewer, in a file, or both."""

from __future__ import annotations

import os
import subprocess
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from ..command_process import exit_code
from .colours import ACCENT, INK, SECOND, THIRD, activation_colours
from .files import OutputError, check
from .palettes import DEFAULT
from .viewer import NO_RERUN, free_port, has_display, is_installed, opened, switched_on

_HEIGHT = 0.02  # m, of lines above the cells' discs


class LiveView:
    """A Rerun stream, as a context.

    Args: name: of the recording; path: a Rerun file, or None; viewer: whether to open the viewer; reach: m to where scent ends;
        palette: of the cells.
    """

    def __init__(self, name: str, path: str | os.PathLike | None, viewer: bool, reach: float, palette: str = DEFAULT):
        if not is_installed():
            raise OutputError(NO_RERUN)
        if viewer and not has_display():
            raise OutputError("there is no display for --view: use --save FILE.rrd instead")
        if path:
            check(Path(path), ".rrd")
        self._name, self._path, self._viewer, self._reach, self._palette = name, path, viewer, reach, palette
        self._pairs = np.empty((0, 2), int)
        self._target = None
        self._stack = ExitStack()
        self._process: subprocess.Popen | None = None

    def __enter__(self) -> LiveView:
        import rerun as rr

        self._rr = rr
        with switched_on():
            self._stream = rr.RecordingStream(f"evodevo {self._name}")
        sinks: list[rr.FileSink | rr.GrpcSink] = [rr.FileSink(str(self._path))] if self._path else []
        if self._viewer:
            port = free_port()
            self._process = self._stack.enter_context(opened("--port", str(port)))
            sinks.append(rr.GrpcSink(f"rerun+http://127.0.0.1:{port}/proxy"))
        self._stream.set_sinks(*sinks)
        style = {"plots/distance": ("to the target", SECOND), "plots/captured": ("captured", THIRD)}
        for entity, (name, colour) in style.items():
            self._stream.log(entity, rr.SeriesLines(names=name, colors=colour), static=True)
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """End the stream.  A viewer stays open until the user closes it, or a signal asked us to end."""
        with self._stack:
            self._stream.disconnect()
            if self._process and kind is None and not exit_code():
                print("Close the viewer to end.", flush=True)
                self._process.wait()

    def embody(self, body: Any) -> None:
        """Take the springs of a Body message."""
        self._pairs = np.column_stack((body.spring_a, body.spring_b)).astype(int)

    def show(self, seconds: float, position: np.ndarray, activation: np.ndarray, target: Any, captured: int) -> None:
        """Show one instant.  Args: position (N, 2) m; activation (N,); target (2,) m or None."""
        rr, stream = self._rr, self._stream
        stream.set_time("time", duration=seconds)
        space = np.column_stack((position, np.zeros(len(position))))
        stream.log("animat/cells", rr.Points3D(space, radii=0.5, colors=activation_colours(activation, self._palette)))
        if self._pairs.size and self._pairs.max() < len(position):
            lifted = space + (0.0, 0.0, 0.5 + _HEIGHT)
            stream.log("animat/springs", rr.LineStrips3D(lifted[self._pairs], radii=0.02, colors=INK))
        centre = space.mean(axis=0)
        stream.log("animat/centre", rr.Points3D([centre + (0.0, 0.0, 0.5)], radii=0.1, colors=ACCENT))
        if target is None:
            return
        stream.log("plots/distance", rr.Scalars(float(np.hypot(*(centre[:2] - target)))))
        stream.log("plots/captured", rr.Scalars(float(captured)))
        if target != self._target:
            from .rerun_log import scent_rings

            self._target = target
            stream.log("animat/target", rr.Points3D([(*target, 0.0)], radii=0.4, colors=SECOND))
            stream.log("animat/scent", rr.LineStrips3D(scent_rings(target, self._reach), colors=(206, 196, 228)))
