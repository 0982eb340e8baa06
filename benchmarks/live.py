"""What one live animat costs a simulator node, and whether targets leak memory.

    python benchmarks/live.py [--minutes 10] [--cells 64] [--targets-per-second 1]

A simulator node of its own runs a grown body in real time, 60 cell states a second, while targets come.  Each tenth of the time
says the node's CPU time over wall time and its resident memory; rates, and times from one cell state to the next, are those of a
subscriber here.
"""

import argparse
import time

import numpy as np
import psutil
import rclpy
from evodevo_sim.live.animat import Animat, NotViable
from evodevo_sim.parameters import default_task, with_settings
from evodevo_sim.ros.loopback import loopback_alone
from evodevo_sim.ros.messages import genome_message, target_message, task_message
from evodevo_sim.ros.own_simulators import OwnSimulators
from evodevo_sim.ros.process import stay_on_this_host
from evodevo_sim.ros.topics import CELL_STATES, TARGET_POSE
from rclpy.executors import SingleThreadedExecutor

from evodevo_msgs.srv import Load
from evodevo_sim import random_genome


def full_grown(task):
    """The first random genome that fills the limit of cells and lives."""
    for seed in range(10_000):
        genome = random_genome(np.random.default_rng(seed))
        try:
            if len(Animat(genome, task).position) == task.development.max_cells:
                return genome
        except NotViable:
            continue


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--cells", type=int, default=64)
    parser.add_argument("--targets-per-second", type=float, default=1.0)
    given = parser.parse_args()
    task = with_settings(default_task("chemotaxis"), {"development.max_cells": given.cells})
    genome = full_grown(task)
    stay_on_this_host()
    with loopback_alone():
        rclpy.init()
    node = rclpy.create_node("live_benchmark")
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    rng = np.random.default_rng(1)
    with OwnSimulators(1, owner="live", task="chemotaxis") as own:
        namespace = own.namespaces[0]
        publisher = node.create_publisher(TARGET_POSE.type, TARGET_POSE.at(namespace), TARGET_POSE.quality)
        loader = node.create_client(Load, f"{namespace}/load")
        heard = []
        node.create_subscription(CELL_STATES.type, CELL_STATES.at(namespace), lambda _: heard.append(time.monotonic()), CELL_STATES.quality)
        while not (loader.service_is_ready() and publisher.get_subscription_count()):
            executor.spin_once(timeout_sec=0.1)
        answer = loader.call_async(Load.Request(task=task_message(task), seed=1, genome=genome_message(genome), real_time_factor=1.0))
        executor.spin_until_future_complete(answer)
        print(answer.result().message, flush=True)
        process = psutil.Process(own._processes[0].pid)
        print("minute  states/s  between: median ms  99 % ms  CPU of one core %  memory MB")
        part, sent = 6.0 * given.minutes, 0
        began = time.monotonic()
        for k in range(10):
            heard.clear()
            start, cpu = time.monotonic(), sum(process.cpu_times()[:2])
            while (now := time.monotonic()) < began + (k + 1) * part:
                executor.spin_once(timeout_sec=0.05)
                if now >= began + sent / given.targets_per_second:
                    publisher.publish(target_message(rng.uniform(-15, 15, 2), node.get_clock().now().to_msg()))
                    sent += 1
            spent = time.monotonic() - start
            used = sum(process.cpu_times()[:2]) - cpu
            memory = process.memory_info().rss / 2**20
            median, most = np.percentile(np.diff(heard), (50, 99)) * 1e3 if len(heard) > 1 else (np.nan, np.nan)
            print(f"{(time.monotonic() - began) / 60:6.2f}  {len(heard) / spent:8.1f}  {median:18.1f}  {most:7.1f}  {100 * used / spent:17.1f}  {memory:9.1f}", flush=True)
    rclpy.shutdown()


if __name__ == "__main__":
    main()
