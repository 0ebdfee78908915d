"""Run real rclpy nodes for the tests of the tier ``ros2``: a task as JSON on stdin, its result as JSON on stdout.

``parameters``: what the parser of rcl gives each node of parameter files.
``drive``: stand-ins with the names, parameter files and remaps of a launch file publish and read what their originals
do, and count what arrives. Their topics are from the sources of Nav2, ros2_control, ros2_controllers,
robot_localization and robot_state_publisher. Runs in an environment with ROS 2 from PyPI.
"""

import json
import sys
import time

from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
from sensor_msgs.msg import Imu, JointState, LaserScan
from std_msgs.msg import Empty, String

VELOCITIES = 20  # sent by each node that sends velocities
SPEED = 0.25  # m/s
ATTEMPTS = 4
SECONDS = 1.5  # that ends of topics may take to find each other
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
COMMANDS = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)  # of controllers with references


def parameters(task):
    """Return the parameters of each node, named by its full name, that the parser of rcl takes from a file."""
    process, found = Process(), {}
    for file, names in task["files"].items():
        found[file] = {}
        for full in names:
            namespace, _, name = full.rpartition("/")
            node = process.add(name, f"/{namespace}", ["--params-file", file])
            ours = {key: one.value for key, one in node._parameters.items()}
            found[file][full] = {key: list(v) if hasattr(v, "typecode") else v for key, v in ours.items()}
    process.close()
    return found


class Process:
    """Nodes that share a participant of DDS, as those of one process do."""

    def __init__(self):
        self.context, self.nodes = Context(), []
        self.context.init()
        self.executor = SingleThreadedExecutor(context=self.context)

    def add(self, name, namespace, words):
        node = Node(
            name,
            context=self.context,
            namespace=namespace,
            cli_args=["--ros-args", "--log-level", "error", *words],
            use_global_arguments=False,
            start_parameter_services=False,
            enable_rosout=False,
            automatically_declare_parameters_from_overrides=True,
        )
        self.executor.add_node(node)
        self.nodes.append(node)
        return node

    def close(self):
        for node in self.nodes:
            self.executor.remove_node(node)
            node.destroy_node()
        self.executor.shutdown()
        self.context.shutdown()


class Graph:
    """Stand-ins of the nodes of one launch file, and what arrives at them."""

    def __init__(self, task):
        self.task, self.processes = task, [Process()]
        self.senders, self.steady, self.latched = {}, [], []
        self.expected, self.heard, self.arrived, self.scans = set(), set(), [], {}
        for one in task["nodes"]:
            if one.get("apart"):
                self.processes.append(Process())
            files = [word for file in one["files"] for word in ("--params-file", file)]
            process = self.processes[-1 if one.get("apart") else 0]
            node = process.add(one["name"], one["namespace"], [*files, *one["words"]])
            getattr(self, f"_{one['role']}")(node)
        self.driver = self.processes[0].add("driver", "/", [])
        for topic, message in task["drivers"].items():
            qos = qos_profile_sensor_data if message == "LaserScan" else 10
            self._publish(self.driver, globals()[message], topic, qos)

    def _value(self, node, key, default=None):
        return node.get_parameter(key).value if node.has_parameter(key) else default

    def _twist(self, node):
        default = self.task["distribution"] != "jazzy"
        return TwistStamped if self._value(node, "enable_stamped_cmd_vel", default) else Twist

    def _publish(self, node, kind, topic, qos=10):
        self.steady.append((node.create_publisher(kind, topic, qos), kind))

    def _hear(self, node, kind, topic, qos=10, what=""):
        what = f"{node.get_fully_qualified_name()} reads {what or kind.__name__} on {topic}"
        self.expected.add(what)
        node.create_subscription(kind, topic, lambda _: self.heard.add(what), qos)

    def _sender(self, node):
        self.senders[node.get_name()] = (node.create_publisher(self._twist(node), "cmd_vel", 10), self._twist(node))
        self._listener(node)

    def _listener(self, node):
        if node.has_parameter("odom_topic"):
            self._hear(node, Odometry, node.get_parameter("odom_topic").value)

    def _velocity_smoother(self, node):
        kind = self._twist(node)
        sent = node.create_publisher(kind, "cmd_vel_smoothed", 10)
        node.create_subscription(kind, "cmd_vel", sent.publish, 10)
        self._listener(node)

    def _collision_monitor(self, node):
        """Pass velocities on as long as each source has data; without, it sends zero: "invalid source"."""
        kind = self._twist(node)
        sent = node.create_publisher(kind, self._value(node, "cmd_vel_out_topic", "cmd_vel"), 10)
        sources = self._value(node, "observation_sources", [])
        for source in sources:
            topic = self._value(node, f"{source}.topic", "scan")
            node.create_subscription(
                LaserScan,
                topic,
                lambda _, one=source: self.scans.update({one: time.monotonic()}),
                qos_profile_sensor_data,
            )

        def pass_on(message):
            oldest = min((self.scans.get(source, 0.0) for source in sources), default=0.0)
            is_valid = time.monotonic() - oldest < self._value(node, "source_timeout", 2.0)
            sent.publish(message if is_valid else kind())

        node.create_subscription(kind, self._value(node, "cmd_vel_in_topic", "cmd_vel_raw"), pass_on, 10)

    def _locator(self, node):
        slam = node.get_name() == "slam_toolbox"
        self._hear(
            node, LaserScan, self._value(node, "scan_topic", "/scan" if slam else "scan"), qos_profile_sensor_data
        )
        if self._value(node, "tf_broadcast", True):
            self._publish(node, Empty, "/tf")

    def _costmap(self, node):
        for layer in self._value(node, "plugins", ["obstacle_layer", "voxel_layer"]):
            for source in str(self._value(node, f"{layer}.observation_sources", "")).split():
                topic = self._value(node, f"{layer}.{source}.topic", source)
                self._hear(node, LaserScan, topic, qos_profile_sensor_data)

    def _filter(self, node):
        for key, one in node._parameters.items():
            if key[:-1] in ("odom", "imu") and key[-1].isdigit():
                self._hear(node, Odometry if key[:-1] == "odom" else Imu, one.value)
        self._publish(node, Odometry, "odometry/filtered")
        if self._value(node, "publish_tf", True):
            self._publish(node, Empty, "/tf")

    def _robot_state_publisher(self, node):
        self._hear(node, JointState, "joint_states")
        self._publish(node, Empty, "/tf")
        self._publish(node, Empty, "/tf_static")
        has_hardware = "<ros2_control" in self._value(node, "robot_description", "")
        text = String(data="hardware" if has_hardware else "plain")
        self.latched.append((node.create_publisher(String, "robot_description", LATCHED), text))

    def _controller_manager(self, node):
        """Take the description of the hardware; without one in it, no controller becomes active."""
        self.expected.add("the description of the hardware")

        def take(message):
            if message.data == "hardware":
                self.heard.add("the description of the hardware")
            else:
                self.expected.add("no other description")

        node.create_subscription(String, "robot_description", take, LATCHED)

    def _controller(self, node):
        """Take velocities and publish an odometry as the plug-in of the controller does, or the joint states."""
        ports = self.task["controllers"][node.get_name()]
        if "takes" in ports:
            qos = COMMANDS if ports["takes"] == "~/reference" else 10
            node.create_subscription(
                TwistStamped, ports["takes"], lambda message: self.arrived.append(message.twist.linear.x), qos
            )
            self._publish(node, Odometry, ports["odometry"])
            if self._value(node, "enable_odom_tf", True):
                self._publish(node, Empty, ports["tf"])
        for topic, message in ports.get("publishes", {}).items():
            self._publish(node, globals()[message], topic)

    def _move_group(self, node):
        self._hear(node, JointState, "joint_states", qos_profile_sensor_data)
        if self._value(node, "publish_robot_description_semantic", False):
            self.latched.append((node.create_publisher(String, "robot_description_semantic", LATCHED), String()))
        self._hear(self.processes[0].add("rviz", "/", []), String, "/robot_description_semantic", LATCHED)

    def spin(self, seconds, until=lambda: False):
        end = time.monotonic() + seconds
        while time.monotonic() < end and not until():
            for process in self.processes:
                process.executor.spin_once(timeout_sec=0.0005)

    def run(self):
        """Publish until all that can be heard is heard and each sender has moved the robot; then count velocities."""
        for publisher, message in self.latched:
            publisher.publish(message)
        end, moved = time.monotonic() + self.task.get("seconds", SECONDS), set()
        while time.monotonic() < end and not (self.expected <= self.heard and moved == set(self.senders)):
            self._publish_all()
            for number, name in enumerate(self.senders):
                self._send(name, SPEED + number)
            self.spin(0.05)
            moved |= {name for number, name in enumerate(self.senders) if SPEED + number in self.arrived}
        counts = {name: sum(map(self._arrives, [name] * VELOCITIES)) if name in moved else 0 for name in self.senders}
        topics = {name: self.driver.get_publishers_info_by_topic(name) for name in ("/tf", "/tf_static")}
        return {
            "arrived": counts,
            "missing": sorted(self.expected - self.heard),
            "transforms": {name: sorted(one.node_name for one in ends) for name, ends in topics.items()},
        }

    def _publish_all(self):
        for publisher, kind in self.steady:
            publisher.publish(kind())

    def _send(self, name, speed):
        publisher, kind = self.senders[name]
        message = kind()
        getattr(message, "twist", message).linear.x = speed
        publisher.publish(message)

    def _arrives(self, name):
        self._publish_all()
        self.spin(0.01)
        self.arrived.clear()
        self._send(name, SPEED)
        self.spin(1.0, lambda: SPEED in self.arrived)
        return SPEED in self.arrived

    def close(self):
        for process in self.processes:
            process.close()


def drive(task):
    """Run each variant of a graph; return what arrived in each."""
    found = []
    for variant in task["variants"]:
        # Fast DDS sometimes does not match two ends of a topic: a variant that has to be complete starts again.
        for _ in range(ATTEMPTS if "seconds" in variant else 1):
            graph = Graph({**task, **variant})
            result = graph.run()
            graph.close()
            if not result["missing"] and all(result["arrived"].values()):
                break
        found.append(result)
    return found


if __name__ == "__main__":
    given = json.load(sys.stdin)
    print(json.dumps({"parameters": parameters, "drive": drive}[given["task"]](given)))
