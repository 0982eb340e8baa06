"""The serial line to a firmware: opened by one program alone, checked by a handshake, opened again when it was unplugged."""

from __future__ import annotations

import os
import select
import time
from collections.abc import Callable

import serial

from ..inputs import InputError
from .protocol import VERSION, FrameError, Hello, Message, Parser, Welcome, encode

HANDSHAKE_WITHIN = 5.0  # s; a controller that begins anew when its port is opened takes one or two of them
_ASK_EVERY = 0.1  # s
_WRITE_WITHIN = 0.1  # s: a line that is full for so long is broken
_READ = 65536  # bytes at once


class LineError(InputError, OSError):
    """A line that cannot be used; the message names the port and the mend."""


class SerialLine:
    """An open line.  Args: port: its path; baud: bits a second.  Raises LineError.

    Attributes: parser: counts what was damaged.
    """

    def __init__(self, port: str, baud: int = 921600):
        self.port, self.parser = port, Parser()
        self._unread: list[Message] = []
        try:
            self._serial = serial.Serial(port, baud, timeout=0, write_timeout=_WRITE_WITHIN, exclusive=True)
            self._serial.reset_input_buffer()
        except (OSError, ValueError) as error:
            raise LineError(f"{port}: {_why(error, port)}") from None

    def close(self) -> None:
        self._serial.close()

    def send(self, message: Message) -> None:
        """Raises LineError where the line is broken."""
        try:
            self._serial.write(encode(message))
        except (OSError, serial.SerialException) as error:
            raise LineError(f"{self.port}: it cannot be written to ({error}): plug it in again") from None

    def wait(self, seconds: float, wake: int = -1) -> list[Message]:
        """The messages that came, after at most so many seconds.  Args: wake: a file whose readiness ends the waiting, or none.

        Raises LineError where the line is broken.
        """
        if self._unread:
            found, self._unread = self._unread, []
            return found
        try:
            ready, _, _ = select.select([self._serial.fileno(), *([wake] if wake >= 0 else [])], [], [], max(seconds, 0.0))
            if self._serial.fileno() not in ready:
                return []
            data = os.read(self._serial.fileno(), _READ)
        except BlockingIOError:
            return []
        except (OSError, ValueError, TypeError, serial.SerialException) as error:
            raise LineError(f"{self.port}: it is unplugged ({error}): plug it in again") from None
        if not data:
            raise LineError(f"{self.port}: it is unplugged: plug it in again")
        return list(self.parser.feed(data))

    def greet(self, stop: Callable[[], bool] = lambda: False) -> Welcome:
        """Ask who is there.  Raises LineError where nobody answers in time, or in another version."""
        end, ask, heard = time.monotonic() + HANDSHAKE_WITHIN, 0.0, 0
        while (now := time.monotonic()) < end and not stop():
            if now >= ask:
                self.send(Hello())
                ask = now + _ASK_EVERY
            messages = self.wait(min(ask, end) - now)
            for k, message in enumerate(messages):
                if isinstance(message, Welcome):
                    self._unread = messages[k + 1 :]
                    if message.version != VERSION:
                        raise LineError(
                            f"{self.port}: its firmware speaks version {message.version} of the protocol, this driver {VERSION}: "
                            "install firmware and driver of one release"
                        )
                    return message
            heard += len(messages)
        if self.parser.damaged or heard:
            why = self.parser.why or "no welcome"
            raise LineError(f"{self.port}: what answers there is no firmware of this protocol ({why}): give another port")
        raise LineError(f"{self.port}: nobody answers within {HANDSHAKE_WITHIN:g} s: switch the body on, or give another port")


def _why(error: BaseException, port: str) -> str:
    number = getattr(error, "errno", None)
    text = str(error)
    if "lock" in text.lower():
        return "another program has it open: end that one, or give another port"
    if not os.path.exists(port):
        return "there is no such port: plug the body in, or give another one"
    if number in (13, 1):
        return "it may not be opened: add yourself to the group that owns it, e.g. dialout"
    return f"it cannot be opened as a serial port ({os.strerror(number) if number else text}): give another one"


__all__ = ["FrameError", "LineError", "SerialLine"]
