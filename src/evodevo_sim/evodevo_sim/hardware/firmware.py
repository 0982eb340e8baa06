"""A firmware that is emulated: what any must do (docs/reference/protocol.md), in the order of calls that a real one has.

`receive` takes bytes whenever they come, `tick` is called in each control step and returns the bytes that it sends.  Time is an argument.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .protocol import VERSION, Arm, Command, Fault, Hello, Message, Mode, Parser, State, Stop, Welcome, after, encode

WATCHDOG = 0.033  # s: two frames


class Firmware:
    """Valves and their safety, without the body.

    Args: channels: number; vent (K,): levels of open valves; most_pressure: above which it vents; version, name, boot: as it tells them.

    Attributes: levels (K,): what the valves are set to; mode, fault, executed: as `State` has them; log: called with each change of mode.
    """

    def __init__(
        self, vent: np.ndarray, most_pressure: float, name: str = "emulated", boot: int = 1, version: int = VERSION,
        watchdog: float = WATCHDOG, log: Callable[[str], None] = lambda line: None,
    ):
        self._vent, self._most = np.asarray(vent, np.float32), most_pressure
        self._name, self._version, self._watchdog, self._log = name, version, watchdog, log
        self._parser = Parser()
        self.boot = boot
        self.restart(boot)

    def restart(self, boot: int) -> None:
        """Begin as after a loss of power."""
        self.boot = boot
        self.levels = self._vent.copy()
        self.mode, self.fault, self.executed = Mode.VENTED, Fault.RESTART, 0
        self._sequence = 0
        self._heard = -np.inf

    @property
    def damaged(self) -> int:
        """Frames that were none."""
        return self._parser.damaged

    def receive(self, data: bytes, now: float) -> bytes:
        """Take what came on the line at `now`, s.  Returns: what it answers at once."""
        return b"".join(self._answer(message, now) for message in self._parser.feed(data))

    def _answer(self, message: Message, now: float) -> bytes:
        match message:
            case Hello():
                channels = len(self._vent)
                return encode(Welcome(self._version, channels, channels, self.boot, round(self._watchdog * 1e3), self._name))
            case Arm(on=True, person=person):
                if self.mode != Mode.STOPPED or person:
                    self._enter(Mode.ARMED, Fault.NONE)
                    self._heard = now
            case Arm(on=False):
                if self.mode == Mode.ARMED:
                    self._enter(Mode.VENTED, Fault.NONE)
            case Stop():
                self._enter(Mode.STOPPED, Fault.STOP)
            case Command():
                self._execute(message, now)
        return b""

    def _execute(self, command: Command, now: float) -> None:
        if command.levels.size != self._vent.size or not np.isfinite(command.levels).all():
            self.fault |= Fault.COMMAND
        elif self.mode == Mode.ARMED:
            self.levels, self.executed, self._heard = command.levels.copy(), command.sequence, now

    def _enter(self, mode: Mode, fault: Fault) -> None:
        if mode != self.mode:
            self._log(f"{self.mode.name.lower()} -> {mode.name.lower()}" + (f": {fault.name.lower()}" if fault and fault.name else ""))
        self.mode, self.fault = mode, fault if mode == Mode.ARMED else self.fault | fault
        if mode != Mode.ARMED:
            self.levels = self._vent.copy()

    def watch(self, pressure: np.ndarray, now: float) -> None:
        """Vent where nobody speaks, or where a chamber of air has too much.  Args: pressure (K,): measured at `now`, s."""
        if self.mode == Mode.ARMED and now - self._heard > self._watchdog:
            self._enter(Mode.VENTED, Fault.SILENCE)
        if self.mode != Mode.STOPPED and not bool((pressure <= self._most).all()):
            self._enter(Mode.STOPPED, Fault.PRESSURE)

    def stop(self) -> None:
        """A button was pressed."""
        self._enter(Mode.STOPPED, Fault.STOP)

    def state(self, pressure: np.ndarray, marker: np.ndarray, measured: float) -> bytes:
        """The frame of a state.  Args: pressure (K,), marker (K, 2); measured: s of the firmware's clock at which they were."""
        self._sequence = after(self._sequence)
        time = int(measured * 1e6) & 0xFFFFFFFF
        return encode(State(self._sequence, time, self.executed, self.mode, self.fault, pressure, marker))
