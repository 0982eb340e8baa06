"""N simulator nodes and an evolution on them:  ros2 launch evodevo_ga evolve.launch.py simulators:=4 arguments:="--generations 200" """

import shlex

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, SetEnvironmentVariable, Shutdown
from launch.substitutions import EnvironmentVariable, LaunchConfiguration
from launch_ros.actions import Node


def _nodes(context):
    count = int(LaunchConfiguration("simulators").perform(context))
    task = LaunchConfiguration("task").perform(context)
    arguments = shlex.split(LaunchConfiguration("arguments").perform(context))
    simulators = [
        Node(package="evodevo_sim", executable="simulator", namespace=f"sim_{k}", parameters=[{"task": task}], output="screen")
        for k in range(count)
    ]
    evolve = Node(
        package="evodevo_ga", executable="evolve", arguments=["--task", task, "--look", "60", *arguments], output="screen",
        on_exit=Shutdown(),
    )
    return [*simulators, evolve]


def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument("simulators", default_value="2", description="simulator nodes, one a core"),
        DeclareLaunchArgument("task", default_value="swim", description="what to evolve for"),
        DeclareLaunchArgument("arguments", default_value="", description="more arguments of evolve"),
        SetEnvironmentVariable(
            "ROS_AUTOMATIC_DISCOVERY_RANGE", EnvironmentVariable("ROS_AUTOMATIC_DISCOVERY_RANGE", default_value="LOCALHOST")
        ),
        OpaqueFunction(function=_nodes),
    ])
