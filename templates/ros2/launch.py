"""Load and activate {{ package }}_controller in a running controller manager."""

import os

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

CONTROLLER = "{{ package }}_controller"


def generate_launch_description():
    file = PathJoinSubstitution([FindPackageShare("{{ package }}"), "config", "controllers.yaml"])
    arguments = [
        CONTROLLER,
        "--controller-manager",
        LaunchConfiguration("controller_manager"),
        "--param-file",
        LaunchConfiguration("parameters"),
    ]
    if os.environ.get("ROS_DISTRO") == "humble":  # its spawner does not read the type from the file
        arguments += ["--controller-type", "{{ package }}/ModelController"]
    return LaunchDescription(
        [
            DeclareLaunchArgument("controller_manager", default_value="/controller_manager"),
            DeclareLaunchArgument("parameters", default_value=file),
            Node(package="controller_manager", executable="spawner", arguments=arguments),
        ]
    )
