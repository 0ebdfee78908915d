"""The stock nodes of Debian, run on our artifacts: robot_state_publisher, static_transform_publisher and tf2 of ROS 1.

They read the same URDF with the same urdfdom and KDL code as those of ROS 2. Everything runs on loopback, with its own
master, and is ended by its own process id. ``stock_nodes_child.py`` is the part inside ROS, run by Debian's Python.
"""

from __future__ import annotations

import json
import os
import socket
import subprocess
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

PYTHON = "/usr/bin/python3"
MASTER = "/usr/bin/rosmaster"
ROBOT_STATE_PUBLISHER = "/usr/lib/robot_state_publisher/robot_state_publisher"
STATIC_TRANSFORM_PUBLISHER = "/usr/lib/tf2_ros/static_transform_publisher"
CHILD = Path(__file__).with_name("stock_nodes_child.py")
PACKAGES = "python3-rosmaster python3-rospy python3-sensor-msgs ros-robot-state-publisher python3-tf2-ros tf2-tools"

WAIT = 20.0  # seconds until something that should come has failed to come


class StaticTransform(NamedTuple):
    """What one static_transform_publisher is started with: its name and its options as ROS 2 takes them."""

    node: str
    options: Mapping[str, str]


def installed() -> bool:
    """Say whether the nodes are on this machine."""
    return all(Path(path).exists() for path in (PYTHON, MASTER, ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER))


def run(
    urdf: str, static: Sequence[StaticTransform], states: Sequence[Mapping[str, float]], folder: Path
) -> dict[str, Any]:
    """Start the nodes, publish the joint states one after the other, and return what tf2 and the topics say.

    ``folder`` is empty and becomes home and log folder. The result has "states" (per joint state, per child frame the
    pose in the root that tf2 answers: x y z and quaternion x y z w) and "messages" (topic, node, parent, child, stamp,
    received, x y z, quaternion) in the order of their arrival.
    """
    with ExitStack() as stack:
        environment = _environment(folder)
        port = environment["ROS_MASTER_URI"].rpartition(":")[2]
        stack.enter_context(_process([PYTHON, MASTER, "--core", "-p", port], environment, folder / "master.log"))
        _await_master(int(port))
        _child(["set", "/robot_description"], urdf, environment)
        publisher = stack.enter_context(_process([ROBOT_STATE_PUBLISHER], environment, folder / "publisher.log"))
        for transform in static:
            words = [STATIC_TRANSFORM_PUBLISHER, *_positional(transform.options), f"__name:={transform.node}"]
            stack.enter_context(_process(words, environment, folder / f"{transform.node}.log"))
        asked = json.dumps({"states": states, "nodes": ["robot_state_publisher", *(t.node for t in static)]})
        answer: dict[str, Any] = json.loads(_child(["run"], asked, environment))
        assert publisher.poll() is None, (folder / "publisher.log").read_text()
        return answer


def _positional(options: Mapping[str, str]) -> list[str]:
    """Return the options of ROS 2 as the arguments of ROS 1: x y z, then yaw, pitch, roll, parent and child."""
    names = ("--x", "--y", "--z", "--yaw", "--pitch", "--roll", "--frame-id", "--child-frame-id")
    assert set(options) == set(names), options
    return [options[name] for name in names]


def _environment(folder: Path) -> dict[str, str]:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    home = {name: str(folder) for name in ("HOME", "ROS_HOME", "ROS_LOG_DIR")}
    path = {"PATH": "/usr/bin:/bin", "LANG": "C.UTF-8", "ROS_ETC_DIR": "/etc/ros", "TMPDIR": str(folder)}
    return {**path, **home, "ROS_MASTER_URI": f"http://127.0.0.1:{port}", "ROS_IP": "127.0.0.1"}


@contextmanager
def _process(words: Sequence[str], environment: Mapping[str, str], log: Path) -> Iterator[subprocess.Popen[bytes]]:
    with log.open("wb") as out:
        process = subprocess.Popen(words, env=dict(environment), stdout=out, stderr=subprocess.STDOUT)
        try:
            yield process
        finally:
            process.terminate()
            try:
                process.wait(5)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def _await_master(port: int) -> None:
    until = time.monotonic() + WAIT
    while True:
        try:
            socket.create_connection(("127.0.0.1", port), 1).close()
            return
        except OSError:
            assert time.monotonic() < until, "the master did not start"
            time.sleep(0.05)


def _child(words: Sequence[str], given: str, environment: Mapping[str, str]) -> str:
    made = subprocess.run(
        [PYTHON, os.fspath(CHILD), *words],
        input=given,
        env=dict(environment),
        capture_output=True,
        text=True,
        timeout=90,
    )
    assert made.returncode == 0, made.stderr
    return made.stdout
