"""Real nodes for tests: simulators as processes of their own, and a node here that talks to them over DDS."""

import os
import subprocess
import sys
import time
from contextlib import contextmanager

DEADLINE = 120.0  # s; a cold cache compiles for most of it


@contextmanager
def simulators(*namespaces, arguments=()):
    """Simulator processes in these namespaces, ended at the end."""
    processes = [
        subprocess.Popen(
            [sys.executable, "-m", "evodevo_sim.commands.simulator", "--ros-args", "-r", f"__ns:={namespace}", *arguments],
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        )
        for namespace in namespaces
    ]
    try:
        yield processes
    finally:
        for process in processes:
            process.terminate()
        for process in processes:
            try:
                process.communicate(timeout=10.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.communicate()


class Operator:
    """A node of the tests' own, as a context."""

    def __enter__(self):
        import rclpy
        from evodevo_sim.ros.loopback import loopback_alone
        from rclpy.executors import SingleThreadedExecutor

        self.context = rclpy.Context()
        with loopback_alone():
            rclpy.init(context=self.context)
        self.node = rclpy.create_node(f"operator_{os.getpid()}", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self._clients = {}
        return self

    def __exit__(self, *_):
        import rclpy

        self.node.destroy_node()
        rclpy.try_shutdown(context=self.context)

    def until(self, done, seconds=DEADLINE):
        """Spin until `done()` says something true, and return that."""
        deadline = time.monotonic() + seconds
        while not (answer := done()):
            assert time.monotonic() < deadline, "nothing happened in time"
            self.executor.spin_once(timeout_sec=0.05)
        return answer

    def call(self, service_type, name, **request):
        if name not in self._clients:
            self._clients[name] = self.node.create_client(service_type, name)
        client = self._clients[name]
        self.until(client.service_is_ready)
        future = client.call_async(service_type.Request(**request))
        self.until(future.done)
        return future.result()

    def listen(self, message_type, name, quality):
        """A list that fills with the messages of a topic."""
        heard = []
        self.node.create_subscription(message_type, name, heard.append, quality)
        return heard
