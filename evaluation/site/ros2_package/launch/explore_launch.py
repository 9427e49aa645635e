"""Start the explorer of one robot; ``ros2 launch indoor_explorers_ros explore_launch.py policy:=dddqn``."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

DEFAULTS = {"policy": "frontier", "cell": "0.25", "radius": "0.22", "lidar_range": "8.0", "use_sim_time": "false"}


def generate_launch_description() -> LaunchDescription:
    """Return the node with its parameters as arguments, in the namespace ``namespace``."""
    names = [DeclareLaunchArgument(name, default_value=value) for name, value in DEFAULTS.items()]
    node = Node(
        package="indoor_explorers_ros",
        executable="explorer",
        namespace=LaunchConfiguration("namespace"),
        parameters=[{name: LaunchConfiguration(name) for name in DEFAULTS}],
        remappings=[("/tf", "tf"), ("/tf_static", "tf_static")],
        output="screen",
    )
    return LaunchDescription([DeclareLaunchArgument("namespace", default_value=""), *names, node])
