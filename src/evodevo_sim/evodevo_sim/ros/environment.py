"""What the environment says to ROS: looked at before `rclpy` is imported, which ends the process, or prints pages, where it is wrong."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_RMW = "RMW_IMPLEMENTATION"
_SECURITY = "ROS_SECURITY_ENABLE"
_MOST_DOMAIN = 232  # beyond it DDS has no ports


class EnvironmentFault(RuntimeError):
    """ROS cannot start; the message says which setting is wrong, and the mend."""


def without_ros(arguments: list[str]) -> list[str]:
    """The arguments of a command that are not ROS's: those from `--ros-args` to `--`, or to the end, are."""
    own, within = [], False
    for argument in arguments:
        if argument == "--ros-args":
            within = True
        elif not within:
            own.append(argument)
        elif argument == "--":
            within = False
    return own


def need_no_graph() -> None:
    """For commands that only read or write messages: whatever DDS the environment chooses, they take the one that is installed."""
    for name in (_RMW, "RCL_ASSERT_RMW_ID_MATCHES"):
        os.environ.pop(name, None)


def check_environment() -> None:
    """Raises EnvironmentFault where a node could not start."""
    domain = os.environ.get("ROS_DOMAIN_ID", "")
    if domain and not (domain.isascii() and domain.isdigit() and len(domain) < 10 and int(domain) <= _MOST_DOMAIN):
        raise EnvironmentFault(f"ROS_DOMAIN_ID is {domain[:40]!r}: give a whole number from 0 to {_MOST_DOMAIN}, or unset it")
    _check_rmw(os.environ.get(_RMW, ""))
    _check_log()


def _check_rmw(chosen: str) -> None:
    from ament_index_python.resources import get_resources

    installed = sorted(set(get_resources("rmw_typesupport")) - {"rmw_implementation"})
    if chosen and installed and chosen not in installed:
        raise EnvironmentFault(f"{_RMW} is {chosen[:40]!r}, which is not installed: unset it, or give {' or '.join(installed)}")


def _check_log() -> None:
    """ROS writes a log for every node and does not start where it cannot."""
    chosen, home = os.environ.get("ROS_LOG_DIR"), os.environ.get("ROS_HOME")
    if not (chosen or home or os.environ.get("HOME")):
        raise EnvironmentFault("there is no HOME, and no place for ROS's log: set HOME or ROS_LOG_DIR to a directory that can be written")
    directory = Path(chosen) if chosen else Path(home or Path(os.environ["HOME"], ".ros"), "log")
    if str(directory).startswith("~"):
        directory = Path(os.environ.get("HOME", "/"), str(directory)[1:].lstrip("/"))
    try:
        directory.mkdir(parents=True, exist_ok=True)
        reason = "" if os.access(directory, os.W_OK | os.X_OK) else "Permission denied"
    except OSError as error:
        reason = error.strerror or str(error)
    if reason:
        raise EnvironmentFault(f"ROS's log cannot be written to {directory} ({reason}): set ROS_LOG_DIR to a directory that can be")


@contextmanager
def started(name: str, arguments: list[str]) -> Iterator[None]:
    """ROS, as a context.  Raises EnvironmentFault where it does not start, or ROS's own arguments are malformed."""
    import rclpy
    from rclpy.impl.implementation_singleton import rclpy_implementation as rcl
    from rclpy.signals import SignalHandlerOptions
    from rclpy.utilities import remove_ros_args

    from .loopback import loopback_alone

    try:
        remove_ros_args([name, *arguments])  # says what is malformed in one line, where `init` prints another one
        with loopback_alone():
            rclpy.init(args=[name, *arguments], signal_handler_options=SignalHandlerOptions.NO)
    except (rcl.RCLError, rcl.RCLInvalidROSArgsError, rcl.UnknownROSArgsError) as error:
        raise EnvironmentFault(" ".join(str(error).partition(", at ")[0].split())[:250] + " (see --help)") from None
    try:
        if os.environ.get(_SECURITY, "").lower() == "true":
            _try_security()
        yield
    finally:
        rclpy.try_shutdown()


def _try_security() -> None:
    """Raises EnvironmentFault where no node can be made with the security that the environment asks for."""
    import rclpy
    from rclpy.impl.implementation_singleton import rclpy_implementation as rcl

    try:
        rclpy.create_node("security", start_parameter_services=False).destroy_node()
    except rcl.RCLError as error:
        why = " ".join(str(error).partition(", at ")[0].removeprefix("error creating node: ").split())[:120]
        raise EnvironmentFault(
            f"{_SECURITY} is true, and no secured node can be made ({why}): mend the keystore or the enclave, take a Fast DDS that has "
            "security, or unset it"
        ) from None
