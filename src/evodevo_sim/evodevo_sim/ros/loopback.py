"""Nodes that stay on this host use the loopback interface alone: no socket of theirs can be reached from the network.

With the range LOCALHOST, rmw_fastrtps adds a UDP transport of its own to that of a profile, which listens at all addresses and sends
from the network's.  With SYSTEM_DEFAULT it takes a profile as it is, and `discovery.xml` says all of it: peers at 127.0.0.1, no
multicast, shared memory and loopback.  So that range is given while `rclpy.init` reads it, and only where that profile counts.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
PROFILES = "FASTRTPS_DEFAULT_PROFILES_FILE"
OWN_PROFILE = Path(__file__).with_name("discovery.xml")
_PEERS = "ROS_STATIC_PEERS"  # whoever names some wants to reach other hosts
_RMW = "rmw_fastrtps_cpp"
_OF_DIRECTORY = ("DEFAULT_FASTRTPS_PROFILES.xml", "DEFAULT_FASTDDS_PROFILES.xml")  # a user's own, which Fast DDS reads besides


def prefer_loopback() -> None:
    """Name our profile to Fast DDS, unless the user has chosen a range, peers or a profile."""
    if os.environ.setdefault(RANGE, "LOCALHOST") == "LOCALHOST" and not os.environ.get(_PEERS):
        os.environ.setdefault(PROFILES, str(OWN_PROFILE))


@contextmanager
def loopback_alone() -> Iterator[None]:
    """Call `rclpy.init` in this context.  Changes nothing where our profile does not count; the range reads LOCALHOST again afterwards."""
    if not _ours():
        yield
        return
    os.environ[RANGE] = "SYSTEM_DEFAULT"
    try:
        yield
    finally:
        os.environ[RANGE] = "LOCALHOST"


def _ours() -> bool:
    from rclpy.utilities import get_rmw_implementation_identifier

    return (
        os.environ.get(RANGE) == "LOCALHOST"
        and not os.environ.get(_PEERS)
        and not os.environ.get("ROS_LOCALHOST_ONLY")
        and os.environ.get(PROFILES) == str(OWN_PROFILE)
        and os.access(OWN_PROFILE, os.R_OK)
        and not any(os.path.exists(name) for name in _OF_DIRECTORY)
        and get_rmw_implementation_identifier() == _RMW
    )
