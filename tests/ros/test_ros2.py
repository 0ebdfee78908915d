"""What a package starts, by ROS 2 itself: the parser of rcl, and rclpy nodes on DDS (wheels of PyPI).

Stand-ins take the places of the nodes, which PyPI lacks: they have the names, parameter files and remaps of the real
launch. Nav2, Gazebo, controller_manager and move_group are not run.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

from rosorin_compile.cli.main import main
from rosorin_compile.ros.parameter_files import nodes_of
from support.colcon import NEEDS_COLCON, colcon
from support.launch import read
from support.nav2_bringup import SENDERS, write_nav2_bringup
from support.packages import EXAMPLES
from support.paths import ROOT, ROSORIN, data_text
from support.ros2 import controllers_of, python_of, run_child, stand_ins

pytestmark = pytest.mark.tier("ros2")

PARTS = ("control", "moveit", "nav2")
PORTER, TURTLEBOT, UR5E = (ROOT / "examples" / name for name in ("porter", "turtlebot3_burger", "ur5e"))
ODD = (
    data_text("robots/cart_with_nav2.yaml").replace("{scan: {sensor", "{front: {sensor").replace("/scan", "/front/scan")
)
# The robots that drive, the parts of their packages, and what their drivers publish.
DRIVEN = {
    "rosorin": (ROSORIN.parent, PARTS, {"/scan": "LaserScan", "/imu": "Imu"}),
    "porter": (PORTER, PARTS, {"/scan": "LaserScan"}),
    "turtlebot3_burger": (TURTLEBOT, ("control", "nav2"), {"/scan": "LaserScan"}),
    "oddly_named_lidar": (ODD, ("control", "nav2"), {"/front/scan": "LaserScan"}),
}
STATIC = {"ur5e": (UR5E, ("control", "moveit"), {})}
DISTRIBUTIONS = ("humble", "jazzy", "kilted")


def package(folder: Path, name: str, distribution: str) -> Path:
    """Write the package of a robot for a distribution, and return it."""
    robot, parts, _ = {**DRIVEN, **STATIC}[name]
    source = folder / "robot"
    if isinstance(robot, Path):
        shutil.copytree(robot, source)
    else:
        source.mkdir()
        (source / "robot.yaml").write_text(robot, "utf-8")
    control = "humble" if distribution == "humble" else "jazzy"
    for file in source.glob("*.yaml"):
        text = file.read_text("utf-8").replace("control: jazzy", f"control: {control}")
        text = text.replace("distribution: jazzy", f"distribution: {distribution}").replace(
            "DISTRIBUTION", distribution
        )
        if distribution == "humble":  # which lacks the other controller
            text = text.replace("parallel_gripper", "position_gripper")
        if "nav2.yaml, distribution" not in text:
            text = text.replace("nav2: {file: nav2.yaml,", f"nav2: {{file: nav2.yaml, distribution: {distribution},")
        file.write_text(text, "utf-8")
    words = ["package", str(source), "-o", str(folder / name), "--name", name, *(f"--{part}" for part in parts), "-q"]
    assert main(words) == 0
    return folder / name


def parameter_files(made: Path) -> Iterator[tuple[Path, dict[str, dict[str, Any]]]]:
    """Yield the parameter files of a package with their nodes; MoveIt's files are parameters of its launch."""
    for file in (made / "config").glob("*.yaml"):
        text = file.read_text("utf-8")
        if "ros__parameters" in text:
            yield file, nodes_of(text)


@pytest.mark.parametrize("distribution", DISTRIBUTIONS)
@pytest.mark.parametrize("name", [*DRIVEN, *STATIC])
def test_parameter_files_by_the_parser_of_rcl(tmp_path: Path, name: str, distribution: str) -> None:
    python_of(distribution)
    made = package(tmp_path, name, distribution)
    files = {str(file): nodes for file, nodes in parameter_files(made)}
    assert f"{made}/config/controllers.yaml" in files
    task = {"task": "parameters", "files": {file: list(nodes) for file, nodes in files.items()}}
    found = run_child(distribution, task)
    for file, nodes in files.items():
        for node, values in nodes.items():
            taken = found[file][node]
            assert {key: taken.get(key) for key in values} == values
            wrong = [key for key, value in values.items() if type(taken[key]) is not type(value)]
            assert not wrong, (file, node)


@NEEDS_COLCON
def test_packages_of_all_examples_build_and_pass_their_tests_on_jazzy(tmp_path: Path) -> None:
    """With ament_cmake of PyPI; their launch files are not started, for PyPI lacks ``launch``."""
    ros = python_of("jazzy")
    for name in (*DRIVEN, *STATIC):
        (tmp_path / name).mkdir()
        package(tmp_path / name, name, "jazzy")
    plain = [path for path in EXAMPLES if path.name not in (*DRIVEN, *STATIC)]
    for path in plain:
        assert main(["package", str(path), "-o", str(tmp_path / path.name), "-q"]) == 0
    count = len(DRIVEN) + len(STATIC) + len(plain)
    python = f"-DPython3_EXECUTABLE={ros}"
    assert f"{count} packages finished" in colcon(tmp_path, "build", "--cmake-args", python, ros=ros)
    colcon(tmp_path, "test", "--return-code-on-test-failure", ros=ros)
    assert f"{3 * count} tests, 0 errors, 0 failures" in colcon(tmp_path, "test-result", "--all", ros=ros)


def started(folder: Path, made: Path, name: str, distribution: str, **given: str) -> dict[str, Any]:
    shares = {name: made, "nav2_bringup": write_nav2_bringup(folder, distribution)}
    nodes = read(made / "launch/bringup.launch.py", shares, **given).nodes
    return {
        "task": "drive",
        "distribution": distribution,
        "drivers": DRIVEN[name][2],
        "controllers": controllers_of(made / "config/controllers.yaml"),
        "nodes": list(stand_ins(folder / "parameters", nodes)),
    }


@pytest.mark.parametrize("distribution", ["jazzy", "kilted"])
@pytest.mark.parametrize("name", DRIVEN)
def test_all_velocities_arrive_and_none_without_a_remap_or_a_topic(
    tmp_path: Path, name: str, distribution: str
) -> None:
    python_of(distribution)
    made = package(tmp_path, name, distribution)
    task = started(tmp_path, made, name, distribution)
    slam = started(tmp_path / "slam", made, name, distribution, slam="True")
    changes = dict(changed(tmp_path / "changed", made, task["nodes"]))
    assert changes
    apart = [{**one, "apart": True} for one in task["nodes"]]
    variants = [
        {"nodes": apart, "seconds": 10},
        {"nodes": slam["nodes"], "seconds": 10},
        {"nodes": task["nodes"], "seconds": 10},
        *({"nodes": nodes} for nodes in changes.values()),
    ]
    complete, mapping, together, *found = run_child(distribution, {**task, "variants": variants})
    for result in (complete, mapping):
        assert result["missing"] == []
        assert set(result["arrived"]) == set(SENDERS)
        assert set(result["arrived"].values()) == {20}
    assert together == complete, "nodes that share a process, as in the variants with a change"
    publishers = complete["transforms"]["/tf"]
    assert len(publishers) == len(set(publishers)), "two owners of a transform"
    unnoticed = [what for what, result in zip(changes, found, strict=True) if result == complete]
    assert not unnoticed


def changed(folder: Path, made: Path, nodes: list[dict[str, Any]]) -> Iterator[tuple[str, list[dict[str, Any]]]]:
    """Yield the nodes without one of our remaps, and with another topic in one of our parameters."""
    folder.mkdir()
    ours = {f"/{name}" for _, one in parameter_files(made) for name in one}

    def replaced(index: int, **values: Any) -> list[dict[str, Any]]:
        return [{**one, **values, "apart": True} if at == index else one for at, one in enumerate(nodes)]

    of_manager = next(one["words"] for one in nodes if one["role"] == "controller_manager")  # its controllers have them
    for index, one in enumerate(nodes):
        words = one["words"]
        full = f"{one['namespace'].rstrip('/')}/{one['name']}"
        if one["role"] in ("robot_state_publisher", "controller_manager", "controller", "filter"):
            for at in range(0, len(words), 2):
                if one["role"] != "controller" or words[at + 1] not in of_manager:
                    yield f"{full} without {words[at + 1]}", replaced(index, words=words[:at] + words[at + 2 :])
        for file in one["files"] if full in ours else ():
            tree = yaml.safe_load(Path(file).read_text("utf-8"))
            section = tree
            for part in full.strip("/").split("/"):
                section = section.get(part, {})
            for path, key, value in list(topics(section.get("ros__parameters", {}))):
                other = not value if isinstance(value, bool) else "nowhere"
                path[key] = other
                copy = folder / f"{len(list(folder.iterdir()))}.yaml"
                copy.write_text(yaml.safe_dump(tree), "utf-8")
                path[key] = value
                files = [str(copy) if old == file else old for old in one["files"]]
                yield f"{full} with {key}: {other}", replaced(index, files=files)


def topics(section: dict[str, Any]) -> Iterator[tuple[dict[str, Any], str, Any]]:
    """Yield the parameters that name topics or the type of velocities: the mapping, the key and the value."""
    for key, value in section.items():
        if isinstance(value, dict):
            yield from topics(value)
        elif key.endswith("topic") or key in ("odom0", "imu0", "enable_stamped_cmd_vel"):
            yield section, key, value
