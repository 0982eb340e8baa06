"""Nodes of this host have no socket that the network could reach, find each other all the same, and leave a user's own choice alone."""

import os
import socket
import subprocess
import sys

import psutil
import pytest
from evodevo_sim.ros.loopback import OWN_PROFILE, PROFILES, RANGE, loopback_alone
from evodevo_sim.ros.process import stay_on_this_host
from lab import DEADLINE, Operator, simulators
from std_srvs.srv import Trigger

NAMESPACE = f"/loopback_{os.getpid()}"
# A node of somebody else on this host: the range alone, no profile of ours.
OTHER = """
import os
os.environ.pop("FASTRTPS_DEFAULT_PROFILES_FILE", None)
import rclpy
from std_srvs.srv import Trigger
rclpy.init()
node = rclpy.create_node("other")
node.create_service(Trigger, "{0}/ours_calls", lambda request, response: response)
client = node.create_client(Trigger, "{0}/theirs_calls")
assert client.wait_for_service(60.0)
future = client.call_async(Trigger.Request())
rclpy.spin_until_future_complete(node, future, timeout_sec=60.0)
assert future.done()
print("heard", flush=True)
while rclpy.ok():
    rclpy.spin_once(node, timeout_sec=0.1)
"""


def addresses(pid):
    """Of every socket of the internet families that a process and its children have."""
    family = [psutil.Process(pid), *psutil.Process(pid).children(recursive=True)]
    found = [c for process in family for c in process.net_connections("inet")]
    assert all(c.family in (socket.AF_INET, socket.AF_INET6) for c in found)
    return {c.laddr.ip for c in found}


def test_a_simulator_has_sockets_at_loopback_alone_and_is_found_by_them():
    with simulators(NAMESPACE) as [process], Operator() as operator:
        assert not operator.call(Trigger, f"{NAMESPACE}/reset").success  # over DDS, from this process to that one
        assert addresses(process.pid) == {"127.0.0.1"}
        assert addresses(os.getpid()) <= {"127.0.0.1"}
        with open(f"/proc/{process.pid}/environ", "rb") as file:
            assert f"{RANGE}=LOCALHOST".encode() in file.read().split(b"\0")


def test_nodes_of_others_on_this_host_are_heard_and_hear_us():
    with Operator() as operator:
        operator.node.create_service(Trigger, f"{NAMESPACE}/theirs_calls", lambda request, response: response)
        process = subprocess.Popen(
            [sys.executable, "-c", OTHER.format(NAMESPACE)], stdout=subprocess.PIPE, text=True, env=os.environ | {RANGE: "LOCALHOST"}
        )
        try:
            assert operator.call(Trigger, f"{NAMESPACE}/ours_calls") is not None
            os.set_blocking(process.stdout.fileno(), False)
            operator.until(lambda: b"heard" in (process.stdout.buffer.read() or b""))  # None: nothing yet
        finally:
            process.terminate()
            process.wait(DEADLINE)


@pytest.mark.parametrize(
    "chosen",
    [
        {RANGE: "SUBNET"}, {RANGE: "OFF"}, {PROFILES: "own.xml"}, {"ROS_STATIC_PEERS": "192.0.2.7"},
        {"ROS_STATIC_PEERS": "192.0.2.7", RANGE: "LOCALHOST"},
    ],
)
def test_a_users_own_choice_goes_before(monkeypatch, chosen):
    monkeypatch.setattr(os, "environ", {k: v for k, v in os.environ.items() if k not in (RANGE, PROFILES)} | chosen)
    stay_on_this_host()
    before = dict(os.environ)
    assert before.get(PROFILES) == chosen.get(PROFILES) and before[RANGE] == chosen.get(RANGE, "LOCALHOST")
    with loopback_alone():
        assert os.environ == before


def test_the_range_reads_this_host_again_whatever_happens_meanwhile(monkeypatch):
    monkeypatch.setenv(RANGE, "LOCALHOST")
    monkeypatch.setenv(PROFILES, str(OWN_PROFILE))
    with pytest.raises(RuntimeError), loopback_alone():  # noqa: PT012  (what is left by an error is looked at before it)
        assert os.environ[RANGE] == "SYSTEM_DEFAULT"
        raise RuntimeError
    assert os.environ[RANGE] == "LOCALHOST"


def test_a_profile_in_the_directory_of_the_command_is_a_users_own_too(monkeypatch, tmp_path):
    monkeypatch.setenv(RANGE, "LOCALHOST")
    monkeypatch.setenv(PROFILES, str(OWN_PROFILE))
    (tmp_path / "DEFAULT_FASTRTPS_PROFILES.xml").write_text("<dds/>")
    monkeypatch.chdir(tmp_path)
    with loopback_alone():
        assert os.environ[RANGE] == "LOCALHOST"
