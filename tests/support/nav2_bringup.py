"""A stand-in for nav2_bringup: a launch file with the nodes and remaps of the real one, and a parameter file."""

from pathlib import Path

# As nav2_bringup/launch/navigation_launch.py has them: the remaps of the nodes that send velocities.
NODES = {
    "humble": {
        "controller_server": [("cmd_vel", "cmd_vel_nav")],
        "behavior_server": [],
        "velocity_smoother": [("cmd_vel", "cmd_vel_nav"), ("cmd_vel_smoothed", "cmd_vel")],
        "bt_navigator": [],
    },
    "jazzy": {
        "controller_server": [("cmd_vel", "cmd_vel_nav")],
        "behavior_server": [("cmd_vel", "cmd_vel_nav")],
        "velocity_smoother": [("cmd_vel", "cmd_vel_nav")],
        "collision_monitor": [],
        "docking_server": [("cmd_vel", "cmd_vel_nav")],
        "bt_navigator": [],
    },
}
NODES["kilted"] = NODES["jazzy"]
LAUNCH = """
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

NODES = {nodes!r}


def localisation(context):
    # As the real one has it, slam_toolbox or AMCL; both read the file of the others.
    name = 'slam_toolbox' if LaunchConfiguration('slam').perform(context) == 'True' else 'amcl'
    file, namespace = LaunchConfiguration('params_file'), LaunchConfiguration('namespace')
    return [Node(package='nav2', executable=name, name=name, parameters=[file], namespace=namespace)]


def generate_launch_description():
    namespace, file = LaunchConfiguration('namespace'), LaunchConfiguration('params_file')
    return LaunchDescription([
        DeclareLaunchArgument('namespace', default_value='', description='as the real one declares it'),
        OpaqueFunction(function=localisation),
        *(
            Node(package='nav2', executable=name, name=name, remappings=remaps, parameters=[file], namespace=namespace)
            for name, remaps in NODES.items()
        ),
    ])
"""
TUNED = """
collision_monitor: {ros__parameters: {cmd_vel_in_topic: cmd_vel_smoothed, cmd_vel_out_topic: cmd_vel}}
controller_server: {ros__parameters: {controller_frequency: 20.0}}
amcl: {ros__parameters: {tf_broadcast: true, robot_model_type: "nav2_amcl::DifferentialMotionModel"}}
"""
# What a controller takes on Humble by `use_stamped_vel`, and otherwise; its odometry.
VELOCITIES = ({True: "~/cmd_vel", False: "~/cmd_vel_unstamped"}, "~/odom")
REFERENCES = ({True: "~/reference", False: "~/reference_unstamped"}, "~/odometry")
TAKES = {
    "diff_drive": VELOCITIES,
    "omni_wheel_drive": VELOCITIES,
    "tricycle": ({True: "~/cmd_vel", False: "~/cmd_vel"}, "~/odom"),
    "mecanum_drive": REFERENCES,
    "ackermann_steering": REFERENCES,
    "bicycle_steering": REFERENCES,
    "tricycle_steering": REFERENCES,
}
ON_TF = ("diff_drive", "omni_wheel_drive", "tricycle")  # the others have their transforms on ~/tf_odometry
SENDERS = ("controller_server", "behavior_server", "docking_server")


def write_nav2_bringup(folder: Path, distribution: str) -> Path:
    """Write the share folder of nav2_bringup of a distribution, and return it."""
    bringup = folder / "nav2_bringup"
    files = {"launch/bringup_launch.py": LAUNCH.format(nodes=NODES[distribution]), "params/nav2_params.yaml": TUNED}
    for file, text in files.items():
        (bringup / file).parent.mkdir(parents=True, exist_ok=True)
        (bringup / file).write_text(text, "utf-8")
    return bringup
