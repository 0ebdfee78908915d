from launch import LaunchDescription
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description():
    manager = Node(
        package="controller_manager", executable="ros2_control_node", remappings=[(LaunchConfiguration("from"), "/tf")]
    )
    spawner = Node(
        package="controller_manager",
        executable="spawner",
        arguments=["mecanum_controller", "--controller-ros-args", "-r ~/tf_odometry:=/tf"],
    )
    return LaunchDescription([manager, spawner])
