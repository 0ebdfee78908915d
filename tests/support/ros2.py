"""ROS 2 from PyPI, in environments that ``JAZZY`` and ``KILTED`` name by their Python, and the nodes of a launch."""

import json
import os
import subprocess
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
import yaml

from rosorin_compile.ros.parameter_files import nodes_of
from support.launch import Started
from support.nav2_bringup import ON_TF, SENDERS, TAKES

PYTHONS = {name: os.environ.get(name.upper(), "") for name in ("jazzy", "kilted")}
CHILD = Path(__file__).with_name("ros2_child.py")
BROADCASTERS = {"joint_state_broadcaster": {"joint_states": "JointState"}, "imu_sensor_broadcaster": {"~/imu": "Imu"}}
ROLES = dict.fromkeys(SENDERS, "sender") | {"amcl": "locator", "slam_toolbox": "locator", "bt_navigator": "listener"}
ROLES |= {"ros2_control_node": "controller_manager", "ekf_node": "filter"}
ROLES |= {name: name for name in ("velocity_smoother", "collision_monitor", "robot_state_publisher", "move_group")}
NAMES = {"ros2_control_node": "controller_manager"}  # of nodes without a name in the launch file


def python_of(distribution: str) -> str:
    """Return the Python of a distribution; Humble, which PyPI lacks, has the parser of Jazzy."""
    python = PYTHONS["jazzy" if distribution == "humble" else distribution]
    if not python:
        pytest.skip(f"{distribution.upper()} does not name a Python with ros-{distribution}-rclpy of PyPI")
    return python


def run_child(distribution: str, task: dict[str, Any]) -> Any:
    """Run a task of ``ros2_child`` with a domain of its own; return its result."""
    environment = {**os.environ, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "PYTHONPATH": ""}
    worker = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
    environment["ROS_DOMAIN_ID"] = str(1 + (10 * os.getpid() + worker % 10) % 100)  # of this process alone
    command = [python_of(distribution), str(CHILD)]
    done = subprocess.run(
        command, env=environment, input=json.dumps(task), capture_output=True, text=True, check=False, timeout=300
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def stand_ins(folder: Path, nodes: list[Started]) -> Iterator[dict[str, Any]]:
    """Yield the nodes of a launch as ``ros2_child`` takes them: role, name, namespace, and arguments for rcl."""
    folder.mkdir(exist_ok=True)
    (manager,) = [node for node in nodes if node.executable == "ros2_control_node"] or [None]
    for number, node in enumerate(nodes):
        if node.executable not in ROLES and node.executable != "spawner":
            continue
        words = [word for old, new in node.remaps for word in ("-r", f"{old}:={new}")]
        role, namespace, files = ROLES.get(node.executable, "controller"), node.namespace, node.files
        name = node.name or NAMES.get(node.executable, node.executable)
        if node.executable == "spawner":
            assert manager is not None
            name, files, namespace = node.arguments[0], manager.files, manager.namespace
            words = [word for old, new in manager.remaps for word in ("-r", f"{old}:={new}")]
            words += [
                w for flag, text in pairwise(node.arguments) if flag == "--controller-ros-args" for w in text.split()
            ]
        files = list(files)
        if node.parameters and role != "controller":
            files.append(str(folder / f"{number}.yaml"))
            launch_remaps = {"/**": {"ros__parameters": node.parameters}}
            Path(files[-1]).write_text(yaml.safe_dump(launch_remaps), "utf-8")
        one = {
            "role": role,
            "name": name,
            "namespace": f"/{namespace}".rstrip("/") or "/",
            "words": words,
            "files": files,
        }
        yield one
        if name == "controller_server":  # the costmaps are nodes of their servers
            for costmap in ("local_costmap", "global_costmap"):
                yield {**one, "role": "costmap", "name": costmap, "namespace": f"/{costmap}", "words": []}


def controllers_of(file: Path) -> dict[str, dict[str, Any]]:
    """Return the topics of the controllers of a parameter file, by their types."""
    found: dict[str, dict[str, Any]] = {}
    for key, value in nodes_of(file.read_text("utf-8"))["controller_manager"].items():
        name, _, rest = key.rpartition(".")
        kind = str(value).partition("/")[0].removesuffix("_controller")
        if rest == "type" and kind in TAKES:
            takes, odometry = TAKES[kind]
            tf = "/tf" if kind in ON_TF else "~/tf_odometry"
            found[name] = {"takes": takes[True], "odometry": odometry, "tf": tf}
        elif rest == "type":
            found[name] = {"publishes": BROADCASTERS.get(kind, {})}
    return found
