"""ros2 launch pelagos_bridge bridge.launch.py url:=http://ocean:8080"""
import os

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description():
    share = get_package_share_directory("pelagos_bridge")
    return LaunchDescription([
        DeclareLaunchArgument("url", default_value="http://127.0.0.1:8080"),
        DeclareLaunchArgument(
            "config", default_value=os.path.join(share, "config",
                                                 "bridge.yaml")),
        Node(package="pelagos_bridge", executable="bridge",
             name="pelagos_bridge", output="screen",
             parameters=[LaunchConfiguration("config"),
                         {"url": LaunchConfiguration("url")}]),
    ])
