"""The checks of the contract (docs/reference/plant.md), in the order in which they are asked."""

from __future__ import annotations

import itertools
import math
import time
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from std_srvs.srv import SetBool, Trigger

from evodevo_msgs.msg import Actuation, Genome
from evodevo_msgs.srv import Evaluate, Load

from ...ros.topics import ACTUATION, BODY, CELL_STATES, CHANNELS, COMMAND_STREAM, TARGET_POSE
from .session import Heard, NotAsked, Session, check, must

_SERVICES = {
    "load": "evodevo_msgs/srv/Load", "pause": "std_srvs/srv/SetBool", "reset": "std_srvs/srv/Trigger",
    "evaluate": "evodevo_msgs/srv/Evaluate",
}
_LOOK = 60  # states that a check looks at
_LOST = 0.2  # share of the states of a stream that may be lost on the way
_CEASE = 0.3  # s after which what was asked to cease has ceased


def stamp(message: Any) -> float:
    return message.header.stamp.sec + message.header.stamp.nanosec * 1e-9


def load(session: Session, **changes: Any) -> Any:
    request = {"task": session.task, "genome": session.genome, "real_time_factor": 1.0} | changes
    return session.call(Load, "load", **request)


def living(session: Session) -> None:
    answer = load(session)
    must(answer.success, f"load was refused: {answer.message}")


def states(session: Session, count: int = _LOOK) -> Heard:
    """So many states of a living animat, from now on."""
    living(session)
    heard = session.listen(CELL_STATES)
    must(session.until(lambda: len(heard) >= count), f"{len(heard)} of {count} cell states came within {session.patience:g} s")
    return heard


def position(message: Any) -> np.ndarray:
    return np.stack([message.position_x, message.position_y], 1)


# --- interfaces -------------------------------------------------------------------------------------------------------------


@check("services", "load, pause, reset and evaluate are there, with their types")
def _services(s: Session) -> None:
    s.until(lambda: all(map(s.has, _SERVICES)), 10.0)
    offered = dict(s.node.get_service_names_and_types())
    for name, kind in _SERVICES.items():
        must(kind in offered.get(s.at(name), []), f"{s.at(name)} is {offered.get(s.at(name)) or 'not there'}, not {kind}")


@check("topics", "body, cell_states and actuation are published and target_pose is heard, with their types")
def _topics(s: Session) -> None:
    for topic in (BODY, CELL_STATES, ACTUATION):
        kind = f"{topic.type.__module__.split('.')[0]}/msg/{topic.type.__name__}"
        kinds = {info.topic_type for info in s.publishers(topic.name)}
        must(kinds == {kind}, f"{s.at(topic.name)} is published as {sorted(kinds) or 'nothing'}, not {kind}")
    must(s.until(lambda: s.node.count_subscribers(s.at(TARGET_POSE.name)), 5.0), f"nobody hears {s.at(TARGET_POSE.name)}")


@check("quality of body", "body is reliable and latched, so that who comes late has it")
def _quality_of_body(s: Session) -> None:
    for info in s.publishers(BODY.name):
        quality = info.qos_profile
        must(quality.reliability == BODY.quality.reliability, "body is published best effort")
        must(quality.durability == BODY.quality.durability, "body is published volatile: who comes late never has it")


@check("quality of actuation", "actuation is reliable, so that a driver has the newest command even where a packet was lost")
def _quality_of_actuation(s: Session) -> None:
    for info in s.publishers(ACTUATION.name):
        must(info.qos_profile.reliability == ACTUATION.quality.reliability, "actuation is published best effort")


# --- refusals, which change nothing -----------------------------------------------------------------------------------------


@check("a malformed genome", "load refuses a genome that is none, in one line of at most 300 characters")
def _malformed(s: Session) -> None:
    answer = load(s, genome=Genome(kind=[9], sign=[1], x=[0.0], y=[0.0]))
    must(not answer.success, "a genome of unknown kinds was loaded")
    line = answer.message
    must(0 < len(line) <= 300 and "\n" not in line, f"its message has {len(line)} characters: {line[:80]!r}")


@check("an odd pace", "load refuses a real_time_factor that is negative or no number")
def _odd_pace(s: Session) -> None:
    for pace in (-1.0, math.nan, math.inf):
        must(not load(s, real_time_factor=pace).success, f"an animat was loaded at a pace of {pace}")


@check("refusals are harmless", "what is refused does not disturb the animat that lives")
def _harmless(s: Session) -> None:
    heard = states(s, 20)
    last = heard.messages[-1].step
    load(s, genome=Genome(kind=[9], sign=[1], x=[0.0], y=[0.0]))
    seen = len(heard)
    must(s.until(lambda: len(heard) > seen + 20), "after a refused load no state came")
    must(heard.messages[-1].step > last, f"after a refused load the step went from {last} to {heard.messages[-1].step}")


# --- a life -----------------------------------------------------------------------------------------------------------------


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
    must(s.until(lambda: len(heard) > _LOOK and len(commands) > _LOOK), f"{len(heard)} states and {len(commands)} commands came")
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
    must(s.until(lambda: len(heard) > _LOOK and len(commands) > _LOOK), "too few states or commands came")
    told = dict(zip((message.step for message in commands.messages), commands.times))
    late = [at - told[message.step] for message, at in zip(heard.messages, heard.times) if message.step in told]
    ninety = float(np.percentile(late, 90))
    must(ninety < 1.5 * s.task.control_step + 0.02, f"it takes {ninety * 1e3:.1f} ms")


# --- control ----------------------------------------------------------------------------------------------------------------


def quiet(heard: Heard) -> bool:
    """Whether nothing comes any more."""
    time.sleep(_CEASE)
    seen = len(heard)
    time.sleep(_CEASE)
    return len(heard) == seen


@check("pause", "pause holds the animat, and lets it go on where it was")
def _pause(s: Session) -> None:
    heard = states(s, 10)
    answer = s.call(SetBool, "pause", data=True)
    must(answer.success, f"pause was refused: {answer.message}")
    must(quiet(heard), "states come on while it is paused")
    held = heard.messages[-1].step
    seen = len(heard)
    must(s.call(SetBool, "pause", data=False).success, "going on was refused")
    must(s.until(lambda: len(heard) > seen + 5), "it does not go on")
    must(0 < heard.messages[seen].step - held <= 10, f"it was held at step {held} and goes on at {heard.messages[seen].step}")


@check("reset", "reset begins the life anew, from its first step")
def _reset(s: Session) -> None:
    heard = states(s, 30)
    before = heard.messages[-1].step
    must(s.call(Trigger, "reset").success, "reset was refused")
    must(s.until(lambda: any(message.step < before for message in heard.messages[30:])), "the steps go on as if nothing had been")
    first = min(message.step for message in heard.messages[30:])
    must(first <= 10, f"the first step that came is {first}")


@check("reset while paused", "an animat that is held stays so through a reset")
def _reset_held(s: Session) -> None:
    heard = states(s, 5)
    s.call(SetBool, "pause", data=True)
    must(s.call(Trigger, "reset").success, "reset was refused")
    must(quiet(heard), "states come on while it is paused")
    s.call(SetBool, "pause", data=False)


@check("load anew", "load takes the place of the animat that lives, at its first step, held or not")
def _anew(s: Session) -> None:
    states(s, 30)
    s.call(SetBool, "pause", data=True)
    heard = s.listen(CELL_STATES)
    living(s)
    must(s.until(lambda: len(heard) > 5), "after a pause a loaded animat does not live")
    must(heard.messages[min(3, len(heard) - 1)].step < 30, f"it begins at step {heard.messages[0].step}")


@check("odd targets", "targets in another frame, not finite or long past are ignored, and the node lives on")
def _targets(s: Session) -> None:
    heard = states(s, 5)
    publisher = s.node.create_publisher(TARGET_POSE.type, s.at(TARGET_POSE.name), TARGET_POSE.quality)
    must(s.until(publisher.get_subscription_count, 5.0), "nobody hears targets")
    for change in ("frame", "nan", "stamp"):
        pose = PoseStamped()
        pose.header.frame_id = "nowhere" if change == "frame" else heard.messages[-1].header.frame_id
        pose.pose.position.x = math.nan if change == "nan" else 1.0
        pose.header.stamp.sec = 1 if change == "stamp" else 0
        publisher.publish(pose)
    seen = len(heard)
    must(s.until(lambda: len(heard) > seen + 30), "after odd targets no state comes")
    must(np.isfinite([message.activation for message in heard.messages]).all(), "after odd targets the activation is not finite")


# --- evaluation -------------------------------------------------------------------------------------------------------------


def short(s: Session) -> Any:
    """The task, of a second or so."""
    import copy

    task = copy.deepcopy(s.task)
    task.control_steps = 80
    return task


@check("evaluate", "evaluate answers one evaluation for each genome, in order, with finite numbers")
def _evaluate(s: Session) -> None:
    odd = Genome(kind=[9], sign=[1], x=[0.0], y=[0.0])
    answer = s.call(Evaluate, "evaluate", task=short(s), genomes=[s.genome, odd])
    must(not answer.error, f"it was refused: {answer.error}")
    must(len(answer.evaluations) == 2, f"{len(answer.evaluations)} evaluations for 2 genomes")
    good, bad = answer.evaluations
    must(all(math.isfinite(one.fitness) for one in (good, bad)), f"a fitness is {good.fitness}, {bad.fitness}")
    must(bad.status == 6 and bad.cause, f"a malformed genome has status {bad.status} and cause {bad.cause!r}")
    must(good.status != 6 and good.metrics.cells > 0, f"a good genome has status {good.status}: {good.cause}")


@check("an empty batch", "evaluate refuses a request without genomes, in its error field")
def _empty(s: Session) -> None:
    answer = s.call(Evaluate, "evaluate", task=short(s), genomes=[])
    must(answer.error and not answer.evaluations, "an empty request was answered without an error")


@check("an odd task", "evaluate and load refuse a task whose numbers are out of range")
def _odd_task(s: Session) -> None:
    task = short(s)
    task.control_step = -1.0
    must(s.call(Evaluate, "evaluate", task=task, genomes=[s.genome]).error, "a control step of -1 s was evaluated")
    must(not load(s, task=task).success, "a control step of -1 s was loaded")


# --- hardware ---------------------------------------------------------------------------------------------------------------


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
    time.sleep(2 * _CEASE)
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
