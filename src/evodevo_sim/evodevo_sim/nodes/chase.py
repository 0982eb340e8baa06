"""`ros2 run evodevo_sim chase`: an animat on a simulator node, and targets for it to follow."""

from __future__ import annotations

import argparse
import signal
import sys
import threading
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from geometry_msgs.msg import PoseStamped
from rclpy.experimental import EventsExecutor
from rclpy.qos import qos_profile_sensor_data
from rclpy.signals import SignalHandlerOptions
from tqdm import tqdm

from evodevo_msgs.msg import Body, CellStates
from evodevo_msgs.srv import Load

from ..genetics.genome import GenomeError
from ..live.targets import Drawn, Random, load_points
from ..parameters import ParameterError
from ..recording import Recorder, RecordingError, is_recording, read_recording
from ..recording.champion import Champion, champion_of
from ..ros.barrier import Callbacks, brief
from ..ros.command_line import Parser, pairs, real_number, warn, whole_number
from ..ros.loopback import loopback_alone
from ..ros.messages import genome_message, target_message, task_message
from ..ros.own_simulators import OwnSimulators
from ..ros.process import stay_on_this_host, without_ros
from ..view.files import OutputError
from ..view.palettes import add_palette
from .simulator import LATCHED, NEWEST

_EPILOG = """\
examples:
  ros2 run evodevo_sim chase bags/RUN
      ten random targets around the champion of a run, on a simulator of its own
  ros2 run evodevo_sim chase champion.yaml --targets path.csv --out bags/chase
      the targets that a file draws, a line `x,y` each; the recording is made anew, and replays as any other
  ros2 run evodevo_sim chase champion.yaml --targets bags/chase --real-time-factor 4
      the targets of a recording, four times as fast
  ros2 run evodevo_sim chase champion.yaml --simulator /sim_0 --view
      on a simulator node of the graph; in the Rerun viewer while it swims

A target counts as captured when the centre of mass is within --capture metres of it; then, or after --each simulated seconds, the
next one comes.
Exit code: 0; 1 where the animat failed or the simulator was lost; 2 for bad input; 130 after Ctrl-C. What was recorded is kept.
"""
_START = 90.0  # s for a simulator of our own to start; it may have to compile
_ANSWER = 10.0  # s for a simulator of the graph to answer
_SILENCE = 10.0  # s without cell states after which a simulator counts as lost


class ChaseError(RuntimeError):
    """The chase cannot go on; the message says why."""


def _parse(arguments):
    parser = Parser("chase", "Let an animat follow targets, live.", _EPILOG)
    parser.add_argument("source", metavar="GENOME|BAG", help="a genome file, or the recording of a run")
    parser.add_argument("--targets", default="random", metavar="random|FILE|BAG", help="where targets come from (default %(default)s)")
    parser.add_argument("--count", type=whole_number, metavar="N", help="targets (default: 10 random ones, or all)")
    parser.add_argument(
        "--distance", type=real_number, nargs=2, default=(4.0, 12.0), metavar="M", help="of random targets, from and to (default 4 12)"
    )
    parser.add_argument("--seed", type=whole_number, default=1, metavar="N", help="of random targets (default %(default)s)")
    parser.add_argument(
        "--each", type=real_number, default=60.0, metavar="S", help="simulated seconds for each target (default %(default)s)"
    )
    parser.add_argument(
        "--capture", type=real_number, default=3.0, metavar="M", help="distance that counts as captured (default %(default)s)"
    )
    pace = "simulated s per s; beyond about 5, cell states are missed and targets come late (default %(default)s)"
    parser.add_argument("--real-time-factor", type=real_number, default=1.0, metavar="X", help=pace)
    parser.add_argument("--simulator", metavar="NAMESPACE", help="of a simulator node on the graph (default: one of our own)")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="for a genome: a number of its task")
    parser.add_argument("--out", type=Path, metavar="DIR", help="directory of a recording, made anew")
    parser.add_argument("--view", action="store_true", help="show it in the Rerun viewer")
    parser.add_argument("--save", type=Path, metavar="FILE.rrd", help="save a Rerun file while it runs")
    add_palette(parser)
    parser.add_argument("--quiet", action="store_true", help="no progress bar")
    given = parser.parse_args(without_ros(parser, arguments))
    for name, value, least, most in (
        ("--each", given.each, 1e-3, 1e6), ("--capture", given.capture, 1e-3, 1e6),
        ("--count", 1 if given.count is None else given.count, 1, 10**9),
        ("--real-time-factor", given.real_time_factor, 0.01, 100.0), ("--seed", given.seed, 0, 2**63),
    ):
        if not least <= value <= most:
            parser.error(f"{name} is {value}: give {least:g} to {most:g}")
    return parser, given


def main(arguments: list[str] | None = None) -> int:
    arguments = sys.argv[1:] if arguments is None else arguments
    parser, given = _parse(arguments)
    stop = threading.Event()  # looked at between messages: an exception could come in the middle of a write
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    stay_on_this_host()
    try:
        champion = champion_of(given.source, pairs(given.set), "chemotaxis", warn(parser.prog))
        if not champion.task.has_target:
            raise ParameterError(
                f"{given.source} was evolved for {champion.task.name}, without targets: give its champion.yaml, or another run"
            )
        targets = _targets(given)
        with ExitStack() as stack:
            view = _viewer(given, stack, champion)
            recorder = stack.enter_context(Recorder(given.out)) if given.out else None
            with loopback_alone():
                rclpy.init(args=[parser.prog, *arguments], signal_handler_options=SignalHandlerOptions.NO)
            stack.callback(rclpy.try_shutdown)
            return Chase(given, champion, targets, recorder, view, stop).run(stack)
    except (GenomeError, OutputError, ParameterError, RecordingError) as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return 2
    except ChaseError as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return 1


def _targets(given):
    if given.targets == "random":
        return Random(given.seed, *given.distance)
    path = Path(given.targets)
    if is_recording(path):
        recording = read_recording(path)
        for line in recording.notes:
            warn("chase")(line)
        poses = recording.targets
        points = [(pose.pose.position.x, pose.pose.position.y) for pose in poses]
        if not points or not np.isfinite(points).all():
            raise RecordingError(f"{path} holds no targets, or one that is not finite: give a recording of chase")
        return Drawn(points)
    return Drawn(load_points(path))


def _viewer(given, stack, champion: Champion):
    if not (given.view or given.save):
        return None
    from ..view.live_view import LiveView

    return stack.enter_context(LiveView(champion.name, given.save, given.view, champion.task.chemotaxis.scent_reach, given.palette))


class Chase:
    """One chase: the node, its animat and its targets.

    Attributes: sent, captured: numbers of targets; closest: m, the least distance to each; states: how many came.
    """

    def __init__(self, given: argparse.Namespace, champion: Champion, targets: Any, recorder: Any, view: Any, stop: threading.Event):
        self.given, self.champion, self.targets, self.recorder, self.view = given, champion, targets, recorder, view
        self.stop = stop
        self.sent = self.captured = self.states = 0
        self.most = given.count or (10 if given.targets == "random" else None)
        self.closest: list[float] = []
        self.target: np.ndarray | None = None
        self.ended = False
        self._since, self._step = 0.0, -1
        self._bar: Any = None  # of tqdm

    def run(self, stack: ExitStack) -> int:
        node = rclpy.create_node("chase")
        stack.callback(node.destroy_node)
        executor = EventsExecutor()
        executor.add_node(node)
        own = None if self.given.simulator else stack.enter_context(OwnSimulators(1, owner="chase", task="chemotaxis"))
        namespace = (own.namespaces[0] if own else "/" + self.given.simulator.strip("/")).rstrip("/")
        self._publisher = node.create_publisher(PoseStamped, f"{namespace}/target_pose", NEWEST)
        self._node = node
        loader = node.create_client(Load, f"{namespace}/load")
        self._wait(executor, loader.service_is_ready, own, f"no simulator answers at {namespace}: start one, or leave --simulator out")
        callbacks = Callbacks(node, through=(OSError, RecordingError, OutputError))
        callbacks.subscription(Body, f"{namespace}/body", self._embody, LATCHED)
        callbacks.subscription(CellStates, f"{namespace}/cell_states", self._follow, qos_profile_sensor_data)
        self._wait(
            executor, lambda: self._publisher.get_subscription_count() and node.count_publishers(f"{namespace}/cell_states"), own,
            f"{namespace} is no simulator",
        )
        c = self.champion
        request = Load.Request(
            task=task_message(c.task), seed=c.seed, genome=genome_message(c.genome), real_time_factor=self.given.real_time_factor
        )
        with tqdm(total=self.most, unit="target", disable=self.given.quiet, leave=False) as self._bar:
            answer = loader.call_async(request)
            self._wait(executor, answer.done, own, "the simulator does not answer")
            if answer.done() and not answer.result().success:
                raise ParameterError(brief(f"{self.given.source}: {answer.result().message}"))
            heard, last = -1, time.monotonic()
            while not (self.ended or self.stop.is_set()):
                executor.spin_once(timeout_sec=0.1)
                if self.states != heard:
                    heard, last = self.states, time.monotonic()
                elif time.monotonic() - last > _SILENCE or (own and not own.alive()):
                    raise ChaseError(f"the simulator fell silent after {self.states} cell states, its animat failed or it ended")
        self._report()
        return 130 if self.stop.is_set() else 0

    def _wait(self, executor, ready, own, otherwise: str) -> None:
        deadline = time.monotonic() + (_START if own else _ANSWER)
        while not ready() and not self.stop.is_set():
            executor.spin_once(timeout_sec=0.05)
            if own and not own.alive():
                raise ChaseError("the simulator ended at once: run `ros2 run evodevo_sim simulator` to see why")
            if time.monotonic() > deadline:
                raise ParameterError(otherwise)

    def _embody(self, message) -> None:
        self._write("body", message, latched=True)
        if self.view:
            self.view.embody(message)

    def _follow(self, message) -> None:
        """One control step's cells: captured? the next target?"""
        if self.ended or not len(message.position_x) or message.step <= self._step:
            return
        position = np.column_stack((message.position_x, message.position_y))
        if not np.isfinite(position).all():
            raise ValueError("a cell's position is not finite")
        self.states, self._step = self.states + 1, message.step
        centre, now = position.mean(axis=0), message.step * self.champion.task.control_step
        if self.target is not None:
            distance = float(np.hypot(*(centre - self.target)))
            self.closest[-1] = min(self.closest[-1], distance)
            captured = distance <= self.given.capture
            self.captured += captured
            if captured or now - self._since >= self.given.each:
                self.target = None
                self._bar.update()
        if self.target is None:
            self._aim(centre, now)
        self._write("cell_states", message)
        if self.view:
            self.view.show(now, position, np.asarray(message.activation), self.target, self.captured)

    def _aim(self, centre, now: float) -> None:
        target = None if self.sent == self.most else self.targets.following(centre)
        if target is None:
            self.ended = True
            return
        self.target, self._since, self.sent = target, now, self.sent + 1
        self.closest.append(float(np.hypot(*(centre - target))))
        message = target_message(target, self._node.get_clock().now().to_msg())
        self._publisher.publish(message)
        self._write("target_pose", message, latched=True)
        self._bar.set_postfix_str(f"{self.captured} captured", refresh=False)

    def _write(self, topic, message, latched=False) -> None:
        if self.recorder:
            self.recorder.write(topic, message, time.time_ns(), latched=latched)

    def _report(self) -> None:
        mean = float(np.mean(self.closest)) if self.closest else float("nan")
        print(
            f"{self.champion.name}: {self.captured} of {self.sent} targets captured within {self.given.capture:g} m, "
            f"closest {mean:.2f} m in the mean, in {self._step * self.champion.task.control_step:.1f} s."
        )
        if self.given.out:
            print(f"See it:   ros2 run evodevo_sim replay {self.given.out}")


if __name__ == "__main__":
    sys.exit(main())
