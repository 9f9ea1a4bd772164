"""The simulator and a controller for each robot of a scenario.

ros2 launch fuzzyfleet_ros loopback.launch.py scenario:=three-cross law:=fuzzy
"""

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, EmitEvent, OpaqueFunction, RegisterEventHandler
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from fuzzyfleet_ros.names import robot_name, scenario_of


def nodes(context: LaunchContext) -> list[object]:
    """The nodes of the scenario that is asked for."""
    said = {name: LaunchConfiguration(name).perform(context) for name in ("scenario", "law", "robot", "save")}
    together = LaunchConfiguration("lockstep").perform(context).lower() == "true"
    robots = len(scenario_of(said["scenario"], said["robot"]).robots)
    both = {"scenario": said["scenario"], "law": said["law"], "robot": said["robot"], "lockstep": together}
    simulator = Node(
        package="fuzzyfleet_ros",
        executable="simulator",
        output="screen",
        parameters=[{**both, "save": said["save"]}],
    )
    controllers = [
        Node(
            package="fuzzyfleet_ros",
            executable="controller",
            namespace=robot_name(i) if robots > 1 else "",
            output="screen",
            parameters=[{**both, "member": i + 1, "use_sim_time": together}],
        )
        for i in range(robots)
    ]
    over = OnProcessExit(target_action=simulator, on_exit=[EmitEvent(event=Shutdown(reason="the drive is over"))])
    return [simulator, *controllers, RegisterEventHandler(over)]


def generate_launch_description() -> LaunchDescription:
    """What ``ros2 launch`` asks for."""
    return LaunchDescription(
        [
            DeclareLaunchArgument("scenario", default_value="reference", description="a scenario's name or .toml file"),
            DeclareLaunchArgument("law", default_value="fuzzy", description="a law as the command line names it"),
            DeclareLaunchArgument("robot", default_value="", description="a robot's name or .toml file"),
            DeclareLaunchArgument("lockstep", default_value="false", description="each period together"),
            DeclareLaunchArgument("save", default_value="", description="a file .npz for the run"),
            OpaqueFunction(function=nodes),
        ]
    )
