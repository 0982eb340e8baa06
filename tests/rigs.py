"""Emulated bodies and their driver for tests: processes of their own, and a body that lives without time passing."""

import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np
from evodevo_sim.hardware.calibration import calibration_of
from evodevo_sim.hardware.emulator import EmulatedBody
from evodevo_sim.hardware.protocol import Fault, Mode, State
from evodevo_sim.hardware.rig import Rig
from evodevo_sim.hardware.serial_body import Health, Sight
from evodevo_sim.live import Animat
from lab import DEADLINE

from evodevo_sim import champions

GENOME = "undulator"
PLAIN = Rig()


class Said(NamedTuple):
    """A command: what it has said until now, and a file that it reads."""

    text: Callable[[], str]
    input: Any

    def __call__(self):
        return self.text()

    def hear(self, line):
        print(line, file=self.input, flush=True)


@contextmanager
def running(directory, command, *arguments, ready):
    """What a command says, as a function, from when it has said `ready` on; asked to end at the end, which it must in good order."""
    file = directory / f"{command}.log"
    with open(file, "w") as log:
        process = subprocess.Popen(
            [sys.executable, "-m", f"evodevo_sim.commands.{command}", *map(str, arguments)], stdout=log, stderr=log,
            stdin=subprocess.PIPE, text=True,
        )
        file_of_input = process.stdin
    try:
        deadline = time.monotonic() + DEADLINE
        while ready not in file.read_text():
            assert process.poll() is None and time.monotonic() < deadline, file.read_text()
            time.sleep(0.02)
        yield Said(file.read_text, file_of_input)
    finally:
        process.terminate()
        try:
            code = process.wait(20.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            raise
    assert code == 0 and "Traceback" not in file.read_text(), file.read_text()


@contextmanager
def rig(directory, rig=""):
    """An emulated body at directory/eel, with the faults of a rig's file."""
    (directory / "plant.yaml").write_text(rig or "{}")
    link, calibration = directory / "eel", directory / "eel.yaml"
    arguments = (champions()[GENOME], "--link", link, "--calibration", calibration, "--rig", directory / "plant.yaml")
    with running(directory, "emulate", *arguments, ready="emulating") as emulated:
        while not link.is_symlink():
            time.sleep(0.01)
        yield link, calibration, emulated


@contextmanager
def driver(link, calibration, *parameters, namespace="/eel"):
    arguments = ("--port", link, "--calibration", calibration, "--ros-args", "-r", f"__ns:={namespace}", *parameters)
    with running(link.parent, "driver", *arguments, ready="ready") as said:
        yield said


class Instant:
    """An emulated body in the place of a `SerialBody`: a control step passes whenever somebody looks.

    Args: genome, task: of the body; rig: as of `emulate`; vented: control steps, since the begin, in which it is vented; silent: those in
    which no state comes; stopped: the step from which on it is stopped.
    """

    def __init__(self, genome, task, rig=PLAIN, vented=(), silent=(), stopped=10**9):
        animat = Animat(genome, task)
        self.calibration = calibration_of(animat.body.position, "eel")
        self._body = EmulatedBody(animat.plant, self.calibration, rig, task.control_step)
        self._step, self._vented, self._silent, self._stopped = task.control_step, set(vented), set(silent), stopped
        self._wanted, self._sight, self.steps, self.why = None, None, 0, "the firmware stopped: pressure"
        self.told = []

    @property
    def health(self):
        return Health.STOPPED if self.steps >= self._stopped else Health.FINE

    def command(self, activation, answers=-1):
        self._wanted = np.array(activation)
        self.told.append(self._wanted)

    def look(self, after_number=-1, within=None):
        c = self.calibration
        vented = self.steps in self._vented or self._wanted is None
        self._body.move(c.by_channel(c.vent if vented else c.levels_of(self._wanted)))
        self.steps += 1
        position = c.seen(self._body.markers())
        before = self._sight.position if self._sight else position
        state = State(self.steps & 65535, 0, 0, Mode.VENTED if vented else Mode.ARMED, Fault.NONE, self._body.pressure(), position)
        now = self.steps * self._step
        self._sight = Sight(state, position, (position - before) / self._step, now, now, self.steps)
        return None if self.steps - 1 in self._silent else self._sight
