"""The controller of one robot with a file of parameters.

ros2 launch fuzzyfleet_ros controller.launch.py params:=my.yaml
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description() -> LaunchDescription:
    """What ``ros2 launch`` asks for."""
    usual = Path(get_package_share_directory("fuzzyfleet_ros")) / "config" / "turtlebot3.yaml"
    return LaunchDescription(
        [
            DeclareLaunchArgument("params", default_value=str(usual), description="a file of parameters"),
            DeclareLaunchArgument("namespace", default_value="", description="of the robot, such as robot1"),
            Node(
                package="fuzzyfleet_ros",
                executable="controller",
                namespace=LaunchConfiguration("namespace"),
                output="screen",
                parameters=[LaunchConfiguration("params")],
            ),
        ]
    )
