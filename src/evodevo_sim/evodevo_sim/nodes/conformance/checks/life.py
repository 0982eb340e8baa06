"""Checks of a life: its body, states and actuation."""

from __future__ import annotations

import itertools
import math

import numpy as np

from ....ros.topics import ACTUATION, BODY, CELL_STATES
from ..session import Session, check, must
from .asking import LOOK, living, position, stamp, states

_LOST = 0.2  # share of the states of a stream that may be lost on the way


@check("load", "load of a genome that grows this body succeeds, and states come")
def _load(s: Session) -> None:
    states(s, 5)


@check("body", "body comes to who subscribes late, and its springs, chambers and outline name its cells")
def _body(s: Session) -> None:
    living(s)
    heard = s.listen(BODY, reliable=True, kept=True, depth=1)
    must(s.until(lambda: len(heard)), "no body came to a late subscriber")
    b = heard.messages[-1]
    must(b.cells > 0, "body.cells is 0")
    for name in ("spring_a", "spring_b", "outline_a", "outline_b", "chamber_cell"):
        values = np.array(getattr(b, name), int)
        must((values < b.cells).all(), f"body.{name} names cell {values.max(initial=0)} of {b.cells}")
    must(len(b.spring_a) == len(b.spring_b) == len(b.rest_length), "body's springs have unequal arrays")
    must(all(length > 0.0 for length in b.rest_length), "body has a rest length that is not positive")


@check("arrays", "every array of a state has one entry for each cell of the body")
def _arrays(s: Session) -> None:
    heard = states(s, 5)
    bodies = s.listen(BODY, reliable=True, kept=True, depth=1)
    must(s.until(lambda: len(bodies)), "no body came")
    for name in ("position_x", "position_y", "velocity_x", "velocity_y", "activation"):
        have = {len(getattr(message, name)) for message in heard.messages}
        must(have == {bodies.messages[-1].cells}, f"{name} has {sorted(have)} entries, the body {bodies.messages[-1].cells} cells")


@check("steps in order", "the step of each state is greater than that of the one before, and few are missing")
def _order(s: Session) -> None:
    steps = np.array([message.step for message in states(s).messages], int)
    gaps = np.diff(steps)
    must((gaps > 0).all(), f"step {steps[int(np.argmin(gaps)) + 1]} came after step {steps[int(np.argmin(gaps))]}")
    must(len(steps) >= (1 - _LOST) * (steps[-1] - steps[0] + 1), f"{len(steps)} of {steps[-1] - steps[0] + 1} states came")


@check("stamps", "stamps grow with the steps, by one control step for each")
def _stamps(s: Session) -> None:
    messages = states(s).messages
    stamps, steps = np.array(list(map(stamp, messages))), np.array([message.step for message in messages], float)
    must((np.diff(stamps) > 0).all(), "a stamp is not later than the one before")
    step = (stamps[-1] - stamps[0]) / max(steps[-1] - steps[0], 1)
    must(abs(step / s.task.control_step - 1) < 0.05, f"a step is {step:.4g} s by the stamps, control_step is {s.task.control_step:.4g} s")
    off = np.abs(stamps - stamps[0] - step * (steps - steps[0])).max()
    must(off < 0.5 * step + 0.005, f"a stamp is {off * 1e3:.1f} ms from where its step puts it")


@check("pace", "at a real_time_factor of 1 a second of states takes a second")
def _pace(s: Session) -> None:
    heard = states(s, 90)
    simulated = stamp(heard.messages[-1]) - stamp(heard.messages[29])
    real = heard.times[-1] - heard.times[29]
    must(abs(simulated / real - 1) < 0.15, f"{simulated:.3g} s of states took {real:.3g} s")


@check("frame", "body, states and actuation name one frame")
def _frame(s: Session) -> None:
    heard, bodies, commands = states(s, 3), s.listen(BODY, reliable=True, kept=True, depth=1), s.listen(ACTUATION, reliable=True)
    must(s.until(lambda: len(bodies) and len(commands)), "no body or no actuation came")
    frames = {message.header.frame_id for one in (heard, bodies, commands) for message in one.messages}
    must(len(frames) == 1 and frames != {""}, f"the frames are {sorted(frames)}")


@check("validity", "a coordinate is finite, or a lost cell has NaN in all of its coordinates; no position is the last one by rote")
def _validity(s: Session) -> None:
    messages = states(s).messages
    whole = np.stack([position(message) for message in messages])
    velocity = np.stack([np.stack([message.velocity_x, message.velocity_y], 1) for message in messages])
    lost = np.isnan(whole).any(-1)
    must((np.isnan(whole).all(-1) == lost).all(), "a cell has one coordinate and lacks the other")
    must(not np.isinf(whole).any() and not np.isinf(velocity).any(), "a coordinate or a speed is infinite")
    must(np.isnan(velocity[lost]).all(), "a cell that is not seen has a velocity")
    must(not lost.all(), "no cell is ever seen")
    moving = (np.diff(whole, axis=0) != 0.0).any(-1)
    must(moving.any(), "no cell ever moves")


@check("velocities", "velocities are those of the positions")
def _velocities(s: Session) -> None:
    messages = states(s, 120).messages
    pairs = [(a, b) for a, b in itertools.pairwise(messages) if b.step == a.step + 1]
    must(len(pairs) > 30, "too few states came one after the other to tell")
    moved = np.array([(position(b) - position(a)) / (stamp(b) - stamp(a)) for a, b in pairs])
    told = np.array([np.stack([b.velocity_x, b.velocity_y], 1) for _, b in pairs])
    seen = np.isfinite(moved) & np.isfinite(told)
    size = math.sqrt(float(np.mean(moved[seen] ** 2))) + 1e-9
    off = math.sqrt(float(np.mean((moved[seen] - told[seen]) ** 2)))
    must(off < 0.5 * size, f"they are off by {off:.3g} m/s, where cells move at {size:.3g} m/s")


@check("activation", "activation is finite, from -1 to 1, in states and in actuation")
def _activation(s: Session) -> None:
    heard, commands = states(s), s.listen(ACTUATION, reliable=True)
    must(s.until(lambda: len(commands) > 20), "no actuation came")
    for name, one in (("states", heard), ("actuation", commands)):
        values = np.array([message.activation for message in one.messages])
        must(np.isfinite(values).all() and (np.abs(values) <= 1.0).all(), f"in {name} it is from {values.min():.3g} to {values.max():.3g}")


@check("actuation", "actuation of a step is what the state of that step has, and each step has one")
def _actuation(s: Session) -> None:
    living(s)
    heard, commands = s.listen(CELL_STATES), s.listen(ACTUATION, reliable=True)
    must(s.until(lambda: len(heard) > LOOK and len(commands) > LOOK), f"{len(heard)} states and {len(commands)} commands came")
    told = {message.step: message for message in commands.messages}
    steps = sorted(told)
    must(len(steps) > 0.95 * (steps[-1] - steps[0] + 1), f"{len(steps)} of {steps[-1] - steps[0] + 1} commands came")
    both = [(message, told[message.step]) for message in heard.messages if message.step in told]
    must(len(both) > 20, "states and commands have no steps in common")
    for state, command in both:
        must(np.array_equal(state.activation, command.activation), f"in step {state.step} actuation and state differ")
        must(abs(stamp(state) - stamp(command)) < 0.5 * s.task.control_step, f"in step {state.step} their stamps differ")


@check("latency", "a state follows its command within a control step and a half, in the 90th percentile")
def _latency(s: Session) -> None:
    living(s)
    heard, commands = s.listen(CELL_STATES), s.listen(ACTUATION, reliable=True)
    must(s.until(lambda: len(heard) > LOOK and len(commands) > LOOK), "too few states or commands came")
    told = dict(zip((message.step for message in commands.messages), commands.times))
    late = [at - told[message.step] for message, at in zip(heard.messages, heard.times) if message.step in told]
    ninety = float(np.percentile(late, 90))
    must(ninety < 1.5 * s.task.control_step + 0.02, f"it takes {ninety * 1e3:.1f} ms")
