"""A body on a serial line, kept safe: one thread owns the line, commands are limited and time out, faults have names."""

from __future__ import annotations

import contextlib
import os
import select
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

import numpy as np

from .calibration import Calibration
from .limits import Limiter
from .protocol import Arm, Command, Fault, Mode, State, Stop, Welcome, after, lost_between
from .serial_line import LineError, SerialLine

_TRY_EVERY = 0.2  # s between attempts to open a line that was lost
_LOOK = 0.01  # s, at the clock
_PERSON = 0.5  # s for which a person's arming is meant, since the stop that it undoes may be on its way
_LATENCIES = 100_000


class Health(Enum):
    """What is the matter with a body, the worst first."""

    UNPLUGGED = "the line is lost"
    FOREIGN = "what answers is another body or another version"
    STOPPED = "emergency stop, or too much pressure: a person must arm it"
    SILENT = "no state comes"
    STALE = "commands ceased to come"
    VENTED = "vented"
    FINE = "armed"


@dataclass(frozen=True, eq=False)
class Sight:
    """A state as the host has it.

    Attributes: state: as it came; position, velocity (N, 2) m, m/s by cell, NaN where a marker is lost; time: s of the firmware's clock,
    without its overflows; arrived: s of the host's steady clock; number: of states since the start.
    """

    state: State
    position: np.ndarray
    velocity: np.ndarray
    time: float
    arrived: float
    number: int


@dataclass
class Counts:
    """What went wrong on the line since the start."""

    lost: int = 0  # states that never came
    damaged: int = 0  # frames that were none
    reopened: int = 0
    restarted: int = 0  # firmware
    vented: int = 0  # by whatever cause


class SerialBody:
    """A body behind a port.

    Args: port; calibration; baud; report: called, in the thread of the line, with each change of health and a line that
    says why; seen: likewise with each sight.
    Raises LineError where nobody answers at first, or another body than that of the calibration.

    The body is armed only while commands come, at least every `calibration.command_within` s.
    """

    def __init__(
        self, port: str, calibration: Calibration, baud: int = 921600,
        report: Callable[[Health, str], None] = lambda health, why: None,
        seen: Callable[[Sight], None] = lambda sight: None,
    ):
        c = self.calibration = calibration
        self.port, self._baud, self._report, self._seen = port, baud, report, seen
        self.limiter = Limiter(c.least, c.most, c.rate, c.vent)
        self.counts, self.health, self.why = Counts(), Health.VENTED, ""
        self.latency: deque[float] = deque(maxlen=_LATENCIES)  # s from a state's arrival to the command that answers it, newest last
        self._news = threading.Condition()
        self._sight: Sight | None = None
        self._wanted: np.ndarray | None = None  # levels by cell, before limits
        self._wanted_at, self._answers = -np.inf, -1
        self._hold = self._stop = self._closed = False
        self._person_at = -np.inf  # s of the steady clock at which a person asked to arm it, until that is sent
        self._person_sent = -np.inf  # at which it was sent, once for each time that a person asked
        self._sequence, self._sent_at = 0, time.monotonic()
        self._wake, self._waker = os.pipe()
        self._line: SerialLine | None = self._open()
        self._thread = threading.Thread(target=self._run, name="line", daemon=True)
        self._thread.start()

    # --- what others ask -------------------------------------------------------------------------------------------------

    def command(self, activation: np.ndarray, answers: int = -1) -> None:
        """From now on, go to the activation (N,) of e - c, as fast as limits let it.  Args: answers: number of the sight that led to it."""
        with self._news:
            self._wanted, self._wanted_at = self.calibration.levels_of(np.asarray(activation, float)), time.monotonic()
            self._answers, self._hold = answers, False
        os.write(self._waker, b"c")

    def hold(self) -> None:
        """Keep the last command until another one comes, or `release`."""
        with self._news:
            self._hold = self._wanted is not None

    def release(self) -> None:
        """Ask for nothing any more: the body is vented."""
        with self._news:
            self._wanted, self._hold = None, False
        os.write(self._waker, b"r")

    def stop(self) -> None:
        """Emergency stop: vented, until a person arms it."""
        with self._news:
            self._stop, self._wanted, self._hold, self._person_at = True, None, False, -np.inf
        os.write(self._waker, b"s")

    def rearm(self) -> None:
        """A person says that it may move again after a stop."""
        with self._news:
            self._person_at, self._stop = time.monotonic(), False
        os.write(self._waker, b"a")

    def look(self, after_number: int = -1, within: float | None = None) -> Sight | None:
        """The newest sight after that number, or None where none comes within s (or the calibration's patience)."""
        patience = self.calibration.state_within if within is None else within
        with self._news:
            self._news.wait_for(lambda: self._closed or (self._sight is not None and self._sight.number > after_number), patience)
            return self._sight if self._sight is not None and self._sight.number > after_number else None

    def close(self) -> None:
        """Vent, and leave the line."""
        with self._news:
            if self._closed:
                return
            self._closed = True
            self._news.notify_all()
        os.write(self._waker, b"e")
        self._thread.join()
        os.close(self._wake)
        os.close(self._waker)

    @property
    def damaged(self) -> int:
        """Frames that were none, since the start."""
        line = self._line
        return self.counts.damaged + (line.parser.damaged if line is not None else 0)

    # --- the thread of the line ------------------------------------------------------------------------------------------

    def _open(self) -> SerialLine:
        line = SerialLine(self.port, self._baud)
        try:
            welcome = line.greet(lambda: self._closed)
            if fault := self._why_foreign(welcome):
                raise LineError(f"{self.port}: {fault}")
        except LineError:
            line.close()
            raise
        self._boot = welcome.boot
        self._mode, self._last, self._clock, self._state_at = Mode.VENTED, -1, 0.0, time.monotonic()
        self._armed_at = -np.inf
        return line

    def _why_foreign(self, welcome: Welcome) -> str:
        have, want = (welcome.channels, welcome.markers), (self.calibration.cells, self.calibration.cells)
        if have != want:
            return (
                f"its firmware {welcome.name[:32]!r} has {have[0]} channels and {have[1]} markers, the calibration "
                f"{self.calibration.name[:32]!r} {want[0]}: give the calibration of this body"
            )
        return ""

    def _run(self) -> None:
        while not self._closed:
            try:
                if self._line is None:
                    self._line = self._open()
                    self.counts.reopened += 1
                    self._say(Health.VENTED, "the line is back")
                self._step(self._line)
            except LineError as error:
                foreign = self._line is None and "firmware" in str(error)
                if self._line is not None:
                    self.counts.damaged += self._line.parser.damaged
                    self._line.close()
                    self._line = None
                    self.limiter.reset()
                self._say(Health.FOREIGN if foreign else Health.UNPLUGGED, str(error))
                self._pause(_TRY_EVERY)
        if self._line is not None:
            with contextlib.suppress(LineError):
                self._line.send(Stop() if self._stop else Arm(False))
            self._line.close()

    def _pause(self, seconds: float) -> None:
        ready, _, _ = select.select([self._wake], [], [], seconds)
        if ready:
            os.read(self._wake, 4096)

    def _step(self, line: SerialLine) -> None:
        messages = line.wait(_LOOK, self._wake)
        self._pause(0.0)
        for message in messages:
            if isinstance(message, State):
                self._take(message)
            elif isinstance(message, Welcome) and message.boot != self._boot:
                self._boot = message.boot
        self._act(line, time.monotonic())

    def _take(self, state: State) -> None:
        now, c = time.monotonic(), self.calibration
        if len(state.pressure) != c.cells or len(state.marker) != c.cells:
            self.counts.damaged += 1
            return
        before = self._sight
        if self._last >= 0:
            lost = lost_between(self._last, state.sequence)
            self.counts.lost += lost
        elapsed = ((state.time - int(self._clock * 1e6)) & 0xFFFFFFFF) * 1e-6
        fresh = self._last < 0 or bool(state.fault & Fault.RESTART) or elapsed > 60.0
        self._last, self._clock = state.sequence, state.time * 1e-6 if fresh else self._clock + elapsed
        position = c.seen(state.marker)
        if before is None or fresh or elapsed <= 0.0:
            velocity = np.where(np.isfinite(position), 0.0, np.nan)
        else:
            velocity = (position - before.position) / elapsed
        with self._news:
            number = before.number + 1 if before else 0
            sight = self._sight = Sight(state, position, velocity, self._clock, now, number)
            self._news.notify_all()
        self._seen(sight)
        self._mode, self._state_at = state.mode, now
        if state.mode == Mode.STOPPED and now - self._person_sent > _PERSON:
            self._stop = True  # also where the firmware begins anew and has forgotten it
        if state.mode != Mode.ARMED and self.health == Health.FINE:
            self.counts.vented += 1
            if state.fault & Fault.RESTART:
                self.counts.restarted += 1

    def _act(self, line: SerialLine, now: float) -> None:
        c = self.calibration
        with self._news:
            wanted, age, answers, stale = self._wanted, now - self._wanted_at, self._answers, None
            if wanted is not None and age > c.command_within and not self._hold:
                wanted = self._wanted = None
                stale = (Health.STALE, f"no command for {age * 1e3:.0f} ms, more than {c.command_within * 1e3:.0f}: vented")
            stop, person = self._stop, now - self._person_at < _PERSON
        silent = now - self._state_at > c.state_within
        if stop and self._mode != Mode.STOPPED:
            line.send(Stop())
        elif person and self._mode == Mode.STOPPED:
            line.send(Arm(True, person=True))
            self._stop, self._person_at, self._person_sent = False, -np.inf, now
            stop = False
            self.limiter.reset()
        if wanted is None or silent or stop:
            if self._mode == Mode.ARMED and now - self._sent_at > _LOOK:
                line.send(Arm(False))
                self._sent_at = now
            self.limiter.reset()
            self._tell(silent, stale)
            return
        if self._mode == Mode.VENTED:
            if now - self._armed_at > 3 * _LOOK:
                self.limiter.reset()
                line.send(Arm(True))
                self._armed_at = now
        elif self._mode == Mode.ARMED and (answers >= 0 or now - self._sent_at >= _LOOK):
            self._sequence = after(self._sequence)
            line.send(Command(self._sequence, c.by_channel(self.limiter.towards(wanted, now - self._sent_at))))
            self._sent_at = time.monotonic()
            if answers >= 0:
                with self._news:
                    if self._answers == answers:
                        self._answers = -1
                if self._sight is not None and self._sight.number == answers:
                    self.latency.append(self._sent_at - self._sight.arrived)
        self._tell(silent, None)

    def _tell(self, silent: bool, also: tuple[Health, str] | None) -> None:
        state = self._sight.state if self._sight is not None else None
        fault = state.fault if state is not None else Fault.NONE
        names = ", ".join(one.name.lower() for one in Fault if one and one in fault and one.name) or "as asked"
        if silent:
            self._say(Health.SILENT, f"no state for more than {self.calibration.state_within * 1e3:.0f} ms")
        elif self._mode == Mode.STOPPED:
            self._say(Health.STOPPED, f"the firmware stopped: {names}")
        elif also is not None:
            self._say(*also)
        elif self._mode == Mode.VENTED:
            if self.health != Health.STALE or self._wanted is not None:
                self._say(Health.VENTED, f"the firmware vented: {names}")
        elif self._wanted is not None:  # or else it was armed by a person, and is vented in a moment since nobody asks for anything
            self._say(Health.FINE, "armed")

    def _say(self, health: Health, why: str) -> None:
        if health != self.health or (health == Health.VENTED and why != self.why):
            self.health, self.why = health, why
            self._report(health, why)
