"""A simulator node and, when it is ready, a live animat on it that chases targets in Rerun.

    ros2 launch evodevo_sim live.launch.py genome:=bags/sample-chemotaxis arguments:="--view --count 20"
"""

import shlex

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, RegisterEventHandler, SetEnvironmentVariable, Shutdown
from launch.event_handlers import OnProcessIO
from launch.substitutions import EnvironmentVariable, LaunchConfiguration
from launch_ros.actions import Node


def _nodes(context):
    genome = LaunchConfiguration("genome").perform(context)
    arguments = shlex.split(LaunchConfiguration("arguments").perform(context))
    simulator = Node(
        package="evodevo_sim", executable="simulator", namespace="sim_0", parameters=[{"task": "chemotaxis"}], output="screen",
        on_exit=[Shutdown()],
    )
    chase = Node(
        package="evodevo_sim", executable="chase", arguments=[genome, "--simulator", "/sim_0", *arguments], output="screen",
        on_exit=[Shutdown()],
    )
    waiting = [chase]

    def heard(event):
        return [waiting.pop()] if waiting and b"ready" in event.text else None

    return [simulator, RegisterEventHandler(OnProcessIO(target_action=simulator, on_stdout=heard, on_stderr=heard))]


def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument("genome", description="genome file, or recording, of an animat that follows targets"),
        DeclareLaunchArgument("arguments", default_value="--view", description="more arguments of chase"),
        SetEnvironmentVariable(
            "ROS_AUTOMATIC_DISCOVERY_RANGE", EnvironmentVariable("ROS_AUTOMATIC_DISCOVERY_RANGE", default_value="LOCALHOST")
        ),
        OpaqueFunction(function=_nodes),
    ])
