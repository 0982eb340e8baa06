"""`ros2 run evodevo_ga evolve`: the node that evolves animats on simulator nodes and records the run."""

from __future__ import annotations

import signal
import sys
import time
from contextlib import ExitStack

import rclpy
from evodevo_sim.command_process import heeded
from evodevo_sim.parameters import ParameterError
from evodevo_sim.recording import RecordingError
from evodevo_sim.recording.guarded import GuardedRecorder
from evodevo_sim.ros.environment import EnvironmentFault, started
from evodevo_sim.ros.process import stay_on_this_host
from evodevo_sim.tasks.evaluation import prepare
from evodevo_sim.view.files import OutputError
from evodevo_sim.view.run_view import RunView
from rclpy.experimental import EventsExecutor

from .arguments import Options, parse
from .auditor import Auditor
from .keeping.checkpoint import NAME as CHECKPOINT
from .keeping.errors import KeepingError, ResumeError
from .keeping.lock import NAME as LOCK
from .keeping.lock import Lock, refuse_if_held
from .keeping.sessions import Sessions
from .pool.vigil import PoolError
from .run.backends import check_backend
from .run.loop import Run
from .run.recorded import Recorded, recorded_in
from .run.rig import find_body
from .times import START, Times


class _Stop:
    """Set by the first signal, which `process.heeded` hands it."""

    asked = False

    def ask(self, number: int) -> None:
        self.asked = True
        again = "" if number == signal.SIGHUP else " Once more to end at once."
        print(f"\nStopping: keeping what was done.{again}", file=sys.stderr)

    def __call__(self) -> bool:
        return self.asked


def main(arguments: list[str] | None = None) -> int:
    arguments = sys.argv[1:] if arguments is None else arguments
    return evolve(parse(arguments), arguments)


def evolve(options: Options, arguments: list[str]) -> int:
    """Evolve as the command line says.  Args: arguments: those of ROS among them.  Returns: the exit code."""
    stay_on_this_host()
    try:
        check_backend(options)
        if options.resumed is None:
            refuse_if_held(options.out)
            _refuse_other(options)
            return _run(options, arguments, Recorded())
        with Lock(options.out):
            options = parse(arguments)  # again: who held the lock may have gone on meanwhile
            recorded = recorded_in(options.out)
            _refuse_finished(options, recorded)
            return _run(options, arguments, recorded)
    except (EnvironmentFault, OutputError, RecordingError, PoolError, KeepingError, ParameterError, ResumeError) as error:
        print(f"evolve: {error}", file=sys.stderr)
        return 2


def _run(options: Options, arguments: list[str], recorded: Recorded) -> int:
    stop, times = _Stop(), Times()
    body = find_body(options, arguments) if options.rig else None
    view = None if options.view is None else RunView(options.out.name, options.task, options.view)  # it may refuse before anything is made
    with ExitStack() as stack:
        recorder = stack.enter_context(GuardedRecorder(options.out, go_on=options.resumed is not None))
        recorder.mend = f"make room, then `ros2 run evodevo_ga evolve --resume {options.out}`"
        recorder.companions.add(LOCK)
        if view is not None:
            recorder.hearers.append(stack.enter_context(view).hear)
        stack.enter_context(started("evolve", arguments))
        if options.resumed is None:
            stack.enter_context(Lock(options.out))
        node, began, executor = rclpy.create_node("evolve"), time.monotonic(), EventsExecutor()
        executor.add_node(node)
        with times(START):
            prepare(options.task)  # before simulators start, so that they only load the kernels
        stack.enter_context(heeded(stop.ask))
        auditor = stack.enter_context(Auditor(options.task, options.seed))
        return Run(options, recorder, auditor, stop, times, node, executor, began, recorded=recorded, body=body).go()


def _refuse_other(options: Options) -> None:
    """Raises ResumeError where another run is in the directory that is to be made."""
    if (options.out / CHECKPOINT).exists():
        raise ResumeError(f"{options.out} holds a run already: go on with it by --resume {options.out}, or choose another directory")


def _refuse_finished(options: Options, recorded: Recorded) -> None:
    """Raises ResumeError where nothing is left to be done."""
    assert options.resumed is not None
    for note in options.resumed.notes:
        print(f"evolve: {note}", file=sys.stderr)
    e = options.resumed.evolution
    reached = options.limits.reached(e.evaluations, Sessions(options.out).seconds)
    if recorded.lived and (e.finished or reached):
        flag = "--patience" if e.stagnation >= e.settings.patience else "--generations" if e.finished else reached.partition(" ")[0]
        raise ResumeError(f"{options.out} is finished, after {e.generation + 1} generations: raise {flag} to go on")


if __name__ == "__main__":
    from .commands import evolve as entry

    sys.exit(entry())
