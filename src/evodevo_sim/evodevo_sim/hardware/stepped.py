"""An emulated body by the clock of whoever drives it: firmware, actuators, physics and camera without a line and without waiting.

    body = SteppedBody(EmulatedBody(plant, calibration, rig, step), calibration, step)
    trial(genome, task, seed, body)         # as on a body that is there, as fast as it goes
"""

from __future__ import annotations

import numpy as np

from .calibration import Calibration
from .emulator import EmulatedBody
from .firmware import Firmware
from .limits import Limiter
from .protocol import Arm, Command, Parser, State, after, encode
from .serial_body import Health, Sight


class SteppedBody:
    """What a `HardwarePlant` drives in the place of a `SerialBody`: each look beyond the last state is one control step.

    Args: body; calibration: its own; control_step: s.
    """

    health, why = Health.FINE, "it is emulated"

    def __init__(self, body: EmulatedBody, calibration: Calibration, control_step: float):
        c = self.calibration = calibration
        self._body, self._step = body, control_step
        self._firmware = Firmware(c.by_channel(c.vent), c.most_pressure, c.name, watchdog=np.inf)
        self._firmware.receive(encode(Arm(True)), 0.0)
        self._limiter, self._parser = Limiter(c.least, c.most, c.rate, c.vent), Parser()
        self._sequence, self._steps = 0, 0
        self.command(np.zeros(c.cells))
        self._sight = self._seen(None)

    def command(self, activation: np.ndarray, answers: int = -1) -> None:
        """Go to the activation (N,) of e - c, as fast as limits let it.  Args: answers: is of no meaning here, where nothing is late."""
        levels = self._limiter.towards(self.calibration.levels_of(np.asarray(activation, float)), self._step)
        self._sequence = after(self._sequence)
        self._firmware.receive(encode(Command(self._sequence, self.calibration.by_channel(levels))), self._steps * self._step)

    def look(self, after_number: int = -1, within: float | None = None) -> Sight:
        """The sight after that number, for which the body lives on if it must."""
        while self._sight.number <= after_number:
            self._firmware.watch(self._body.pressure(), self._steps * self._step)
            self._body.move(self._firmware.levels)
            self._steps += 1
            self._sight = self._seen(self._sight)
        return self._sight

    def _seen(self, before: Sight | None) -> Sight:
        now = self._steps * self._step
        (state,) = self._parser.feed(self._firmware.state(self._body.pressure(), self._body.markers(), now))
        assert isinstance(state, State)
        position = self.calibration.seen(state.marker)
        velocity = np.zeros(position.shape) if before is None else (position - before.position) / self._step
        return Sight(state, position, velocity, now, now, 0 if before is None else before.number + 1)
