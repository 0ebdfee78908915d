from launch import LaunchDescription
from launch_ros.actions import Node


def generate_launch_description():
    manager = Node(
        package="controller_manager",
        executable="ros2_control_node",
        parameters=["params.yaml"],
        remappings=[("~/robot_description", "/robot_description"), ("/mecanum_controller/tf_odometry", "/tf")],
    )
    return LaunchDescription([manager])
