"""A body that is not there: firmware, actuators, physics and camera behind a pseudo-terminal, as a rig's file has them."""

from __future__ import annotations

import contextlib
import errno
import os
import queue
import select
import time
import tty
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ..plant import Outcome
from .calibration import Calibration
from .chain import ActuatorChain, SensorChain
from .firmware import Firmware
from .rig import Event, Line, Rig

_READ = 65536  # bytes at once
_GARBAGE = 200  # bytes in each control step


class BodyFailed(RuntimeError):
    """The physics of the emulated body could not be carried on."""


class EmulatedBody:
    """Actuators, physics and camera.

    Args: plant: a simulated body of N cells (`plant.Plant`); calibration: how its channels and markers are wired; rig; control_step: s.
    """

    def __init__(self, plant: Any, calibration: Calibration, rig: Rig, control_step: float):
        self._plant, self._calibration, self._step = plant, calibration, control_step
        self.cells = calibration.cells
        self.actuators = ActuatorChain(rig.actuators, calibration.cells, control_step)
        self._sensors = SensorChain(rig.sensors, plant.position, control_step, rig.seed)

    def move(self, levels: np.ndarray) -> None:
        """Live for one control step with the valves at `levels` (N,), by channel."""
        asked = np.clip(self._calibration.activation_of(self._calibration.by_cell(levels)), -1.0, 1.0)
        if self._plant.move(self.actuators.step(asked), self._step) != Outcome.SOUND:
            raise BodyFailed("the physics of the emulated body could not be carried on: emulate another genome, or higher stiffness")

    def pressure(self) -> np.ndarray:
        """(N,) by channel."""
        return self._calibration.by_channel(self._calibration.levels_of(self.actuators.activation))

    def markers(self) -> np.ndarray:
        """(N, 2), as the camera tells them."""
        return self._calibration.marks(self._sensors.see(self._plant.position))


class Noisy:
    """One direction of a line: frames that do not arrive, or not as they were sent."""

    def __init__(self, line: Line, seed: int, direction: int):
        self._line, self._rng = line, np.random.default_rng((seed, 2, direction))
        self._rest = b""

    def __call__(self, data: bytes) -> bytes:
        if not (self._line.lost or self._line.damaged):
            return data
        *frames, self._rest = (self._rest + data).split(b"\0")
        return b"".join(map(self._frame, frames))

    def _frame(self, frame: bytes) -> bytes:
        if not frame:
            return b"\0"
        lost, damaged = self._rng.random(2)
        if lost < self._line.lost:
            return b""
        if damaged < self._line.damaged and frame:
            place = int(self._rng.integers(len(frame)))
            frame = frame[:place] + bytes([frame[place] ^ int(self._rng.integers(1, 256))]) + frame[place + 1 :]
        return frame + b"\0"


class Emulator:
    """A body on a pseudo-terminal, in real time.

    Args: body: the physics; firmware; rig: what goes wrong, and when; control_step: s; link: a path that leads to the terminal
    while it is plugged in; log: called with a line on each event.
    """

    def __init__(
        self, body: EmulatedBody, firmware: Firmware, rig: Rig, control_step: float, link: Path,
        log: Callable[[str], None] = lambda line: None,
    ):
        self._body, self._firmware, self._rig, self._step = body, firmware, rig, control_step
        self._link, self._log = link, log
        self.cells = body.cells
        self._in, self._out = Noisy(rig.line, rig.seed, 0), Noisy(rig.line, rig.seed, 1)
        self._garbage = np.random.default_rng((rig.seed, 3))
        self._master = self._slave = -1
        self._until: dict[str, float] = {}  # kind of event: s at which it is over
        self._asked: queue.SimpleQueue[Event] = queue.SimpleQueue()
        self.late = 0  # control steps that began more than one step late

    def happen(self, event: Event) -> None:
        """Let something happen in the next control step, whatever its `at`.  From any thread."""
        self._asked.put(event)

    def run(self, stop: Callable[[], bool]) -> None:
        """Until `stop()`.  Raises OSError where the link cannot be made, BodyFailed."""
        self._plug()
        try:
            self._run(stop)
        finally:
            self._unplug()

    def _run(self, stop: Callable[[], bool]) -> None:
        start = due = time.monotonic()
        waiting, steps = list(self._rig.events), 0  # the body's clock ticks with its physics, also where the machine is busy
        while not stop():
            now = time.monotonic() - start
            while waiting and waiting[0].at <= now:
                self._begin(waiting.pop(0), now)
            while not self._asked.empty():
                self._begin(self._asked.get(), now)
            self._end(now)
            pressure = self._body.pressure()
            if self._on("pressure"):
                pressure = pressure + 1e6
            self._firmware.watch(pressure, now)
            self._body.move(self._firmware.levels)
            steps += 1
            self._send(self._firmware.state(pressure, self._body.markers(), steps * self._step))
            due += self._step
            if time.monotonic() > due + self._step:
                self.late += 1
                due = time.monotonic()
            while (left := due - time.monotonic()) > 0:
                self._listen(left, start)

    def _begin(self, event: Event, now: float) -> None:
        cells = event.cells + (self._body.actuators.fail_by_lot(event.count, self._rig.seed) if event.count else ())
        self._log(f"{now:.2f} s: {event.what}" + (f" of cells {', '.join(map(str, cells))}" if cells else ""))
        self._until[event.what] = now + event.lasts
        match event.what:
            case "unplug":
                self._unplug()
            case "restart":
                self._firmware.restart(self._firmware.boot + 1)
            case "fail":
                self._body.actuators.fail(event.cells)
            case "stop":
                self._firmware.stop()

    def _end(self, now: float) -> None:
        for what in [what for what, until in self._until.items() if until <= now]:
            del self._until[what]
            if what == "unplug":
                self._plug()

    def _on(self, what: str) -> bool:
        return what in self._until

    # --- the terminal ----------------------------------------------------------------------------------------------------

    def _plug(self) -> None:
        self._master, self._slave = os.openpty()  # kept open here too, so that a host which leaves does not end the line
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        with contextlib.suppress(FileNotFoundError):
            os.unlink(self._link)
        os.symlink(os.ttyname(self._slave), self._link)

    def _unplug(self) -> None:
        if self._master < 0:
            return
        with contextlib.suppress(FileNotFoundError):
            os.unlink(self._link)
        os.close(self._slave)
        os.close(self._master)
        self._master = self._slave = -1

    def _listen(self, seconds: float, start: float) -> None:
        if self._master < 0:
            time.sleep(seconds)
            return
        ready, _, _ = select.select([self._master], [], [], seconds)
        if ready:
            try:
                data = os.read(self._master, _READ)
            except OSError as error:
                if error.errno not in (errno.EIO, errno.EAGAIN):
                    raise
                return
            answer = self._firmware.receive(self._in(data), time.monotonic() - start)
            if answer:
                self._send(answer)

    def _send(self, data: bytes) -> None:
        """What nobody reads is lost, as on a line without flow control."""
        if self._master < 0 or self._on("silence"):
            return
        data = self._out(data)
        if self._on("garbage"):
            data = self._garbage.integers(0, 256, _GARBAGE, np.uint8).tobytes() + data
        with contextlib.suppress(BlockingIOError):
            os.write(self._master, data)
