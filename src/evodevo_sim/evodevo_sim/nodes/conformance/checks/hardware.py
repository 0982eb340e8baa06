"""Checks of a node that drives hardware."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from std_srvs.srv import Trigger

from evodevo_msgs.msg import Actuation

from ....ros.topics import CHANNELS, COMMAND_STREAM
from ..session import Heard, NotAsked, Session, check, must
from .asking import CEASE, living, load, states


def hardware(s: Session) -> None:
    if not s.has("arm") and not s.publishers(CHANNELS.name):
        raise NotAsked("it drives no hardware")


@check("channels", "channels comes late too, and wires each cell to a channel and a marker of its own, within limits")
def _channels(s: Session) -> None:
    hardware(s)
    heard = s.listen(CHANNELS, reliable=True, kept=True, depth=1)
    must(s.until(lambda: len(heard), 10.0), "no channels came to a late subscriber")
    c = heard.messages[-1]
    cells = len(c.channel)
    for name in ("channel", "marker"):
        must(sorted(getattr(c, name)) == list(range(cells)), f"{name} is not each of 0 to {cells - 1} once")
    must(len(c.x) == len(c.y) == cells and np.isfinite([*c.x, *c.y]).all(), f"it does not tell where each of its {cells} cells is at rest")
    least, most, rate = np.array(c.least), np.array(c.most), np.array(c.rate)
    must(len(least) == len(most) == len(rate) == cells, "limits have unequal arrays")
    must((least < most).all() and (rate > 0).all() and np.isfinite(rate).all(), "a channel lacks a limit of magnitude or of rate")


def health(heard: Heard) -> str:
    """What the newest diagnostic of this node says; nothing where none came."""
    for message in reversed(heard.messages):
        for status in message.status:
            if "driver" in status.name:
                return status.message
    return ""


def diagnostics(s: Session) -> Heard:
    heard = Heard()
    s.node.create_subscription(DiagnosticArray, "/diagnostics", heard.add, 100)
    return heard


@check("diagnostics", "diagnostics come at least every two seconds")
def _diagnostics(s: Session) -> None:
    hardware(s)
    heard = diagnostics(s)
    must(s.until(lambda: health(heard), 5.0), "no diagnostics came within 5 s")
    seen = len(heard)
    must(s.until(lambda: len(heard) > seen, 2.5), "none came within 2.5 s of the last one")


@check("emergency stop", "stop vents at once, says so in a diagnostic, and nothing moves by command until arm")
def _stop(s: Session) -> None:
    hardware(s)
    heard = diagnostics(s)
    states(s, 20)
    must(s.call(Trigger, "stop").success, "stop was refused")
    must(s.until(lambda: "stop" in health(heard), 5.0), f"the diagnostic says {health(heard)!r}")
    load(s)
    time.sleep(2 * CEASE)
    must("stop" in health(heard), f"it moves again unasked: {health(heard)!r}")
    must(s.call(Trigger, "arm").success, "arm was refused")
    living(s)
    must(s.until(lambda: "armed" in health(heard), 10.0), f"after arm the diagnostic says {health(heard)!r}")


def alone(s: Session) -> Any:
    """A publisher of commands, where no animat lives any more."""
    hardware(s)
    s.call(Trigger, "stop")
    s.call(Trigger, "arm")
    publisher = s.node.create_publisher(COMMAND_STREAM.type, s.at(COMMAND_STREAM.name), COMMAND_STREAM.quality)
    must(s.until(publisher.get_subscription_count, 5.0), f"nobody hears {s.at(COMMAND_STREAM.name)}")
    return publisher


def cells_of(s: Session) -> int:
    heard = s.listen(CHANNELS, reliable=True, kept=True, depth=1)
    must(s.until(lambda: len(heard), 10.0), "no channels came")
    return len(heard.messages[-1].channel)


def stream(s: Session, publisher: Any, activation: list[float], until: Any, seconds: float = 5.0) -> bool:
    """Command at 60 Hz until it comes true."""

    def one() -> bool:
        publisher.publish(Actuation(activation=activation))
        time.sleep(1 / 60)
        return bool(until())

    return s.until(one, seconds)


@check("command", "a stream of commands arms the body, and a diagnostic says so")
def _command(s: Session) -> None:
    publisher, heard, cells = alone(s), diagnostics(s), cells_of(s)
    must(stream(s, publisher, [0.0] * cells, lambda: "armed" in health(heard)), f"the diagnostic says {health(heard)!r}")


@check("silence", "where commands cease the body is vented, and a diagnostic names it")
def _silence(s: Session) -> None:
    publisher, heard, cells = alone(s), diagnostics(s), cells_of(s)
    must(stream(s, publisher, [0.0] * cells, lambda: "armed" in health(heard)), f"the diagnostic says {health(heard)!r}")
    must(s.until(lambda: "armed" not in health(heard), 3.0), "it stays armed 3 s after the last command")
    must(any(word in health(heard) for word in ("command", "vent")), f"the diagnostic says {health(heard)!r}")


@check("odd commands", "a command for other cells, or with what is no number, is not carried out")
def _odd_commands(s: Session) -> None:
    publisher, heard, cells = alone(s), diagnostics(s), cells_of(s)
    must(s.until(lambda: health(heard) and "armed" not in health(heard), 5.0), f"the diagnostic says {health(heard)!r}")
    for odd in ([0.0] * (cells + 1), [math.nan] * cells, []):
        armed = stream(s, publisher, odd, lambda: "armed" in health(heard), 1.0)
        must(not armed, f"a command of {odd[:2]} ... for {len(odd)} cells armed it")
