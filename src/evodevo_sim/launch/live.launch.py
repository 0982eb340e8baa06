"""A simulator node, and a live animat that chases targets in Rerun:  ros2 launch evodevo_sim live.launch.py genome:=champion.yaml"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, SetEnvironmentVariable, Shutdown
from launch.substitutions import EnvironmentVariable, LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument("genome", description="genome file, or recording, of an animat that follows targets"),
        SetEnvironmentVariable(
            "ROS_AUTOMATIC_DISCOVERY_RANGE", EnvironmentVariable("ROS_AUTOMATIC_DISCOVERY_RANGE", default_value="LOCALHOST")
        ),
        Node(
            package="evodevo_sim", executable="simulator", namespace="sim_0", parameters=[{"task": "chemotaxis"}], output="screen",
        ),
        Node(
            package="evodevo_sim", executable="chase", arguments=[LaunchConfiguration("genome"), "--view", "--simulator", "/sim_0"],
            output="screen", on_exit=Shutdown(),
        ),
    ])
