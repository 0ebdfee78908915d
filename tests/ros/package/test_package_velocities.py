"""The way of a velocity from Nav2 to the wheels, and of odometry and transforms back, by the nodes that are started.

Each topic is followed from node to node by its name after remaps and by its message. What nodes publish and take is
written down here, from their sources: ros-navigation/navigation2 and ros-controls/ros2_controllers, {humble, jazzy}.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from itertools import pairwise, product
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import yaml

from rosorin_compile.cli.main import main
from rosorin_compile.ros.parameter_files import nodes_of
from support.launch import Failed, Started, read
from support.nav2_bringup import NODES, ON_TF, SENDERS, TAKES, write_nav2_bringup
from support.packages import clean
from support.paths import ROOT, data_text

TWIST, STAMPED = "Twist", "TwistStamped"
NAV2_RATE = 20.0  # Hz: controller_frequency, smoothing_frequency
STAMPED_BY_DEFAULT = ("diff_drive", "tricycle", "mecanum_drive")  # on Humble

BASE = data_text("robots/package_velocities_base.yaml")
CASES_OF = yaml.safe_load(data_text("cases/velocities.yaml"))
DRIVES, EXAMPLES = CASES_OF["drives"], CASES_OF["examples"]
REST = data_text("robots/package_velocities_rest.yaml")
FILTER = "  robot_localization: {file: ekf.yaml, inputs: {odom0: {topic: ODOMETRY, uses: [vx, vyaw]}}}\n"


class Case(NamedTuple):
    """A robot to be followed: type of its controller, distribution, who owns the odometry, namespace, localisation."""

    kind: str
    distribution: str
    owner: str = "base"
    namespace: str = ""
    locator: str = "nav2_amcl"


def described(case: Case) -> str:
    if case.kind in EXAMPLES:
        folder, driven, steered = EXAMPLES[case.kind]
        text = (ROOT / "examples" / folder / "robot.yaml").read_text("utf-8").partition("\noutputs:")[0]
    else:
        two, drive, driven, steered = DRIVES[case.kind]
        text = BASE.replace("TWO", two).replace("{DRIVE}", f"{{{drive}}}")
    joints = dict.fromkeys(driven, "{command: velocity, state: [position, velocity]}")
    joints |= dict.fromkeys(steered, "{command: position, state: [position, velocity]}")
    packages = {"base": "controller_manager", "ekf": "robot_localization"}
    owner = f"{case.owner}: {{package: {packages[case.owner]}}}"
    base = "base_footprint" if case.kind in EXAMPLES else "base_link"
    words = {
        "PUBLISHERS": f"{owner}, locator: {{package: {case.locator}}}",
        "OWNER": case.owner,
        "JOINTS": ", ".join(f"{name}: {how}" for name, how in joints.items()),
        "KIND": case.kind,
        "DISTRIBUTION": case.distribution,
        "NAMESPACE": case.namespace,
        "child: base_link": f"child: {base}",
    }
    inside = f"{case.namespace}/" if case.namespace else ""
    words["ODOMETRY"] = f"{inside}base/{TAKES[case.kind][1].removeprefix('~/')}"
    rest = REST + (FILTER if case.owner == "ekf" else "")
    for word, meant in words.items():
        rest = rest.replace(word, meant)
    return text + rest


def started(folder: Path, case: Case, **given: str) -> list[Started]:
    bringup = write_nav2_bringup(folder, case.distribution)
    (folder / "car.yaml").write_text(described(case), "utf-8")
    words = ["-o", str(folder / "car"), "--name", "car", "--control", "--nav2", "-q"]
    assert main(["package", str(folder / "car.yaml"), *words]) == 0
    shares = {"car": folder / "car", "nav2_bringup": bringup}
    return read(folder / "car/launch/bringup.launch.py", shares, **given).nodes


class End(NamedTuple):
    topic: str
    message: str


def full(name: str, node: str, namespace: str) -> str:
    space = f"/{namespace.strip('/')}" if namespace.strip("/") else ""
    return name if name.startswith("/") else f"{space}/{name.replace('~', node, 1) if name.startswith('~') else name}"


def resolved(name: str, node: str, namespace: str, remaps: list[tuple[str, str]]) -> str:
    """Return the full name of a topic after remaps: the first one that fits is followed (rcl/src/rcl/remap.c)."""
    topic = full(name, node, namespace)
    for old, new in remaps:
        if full(old, node, namespace) == topic:
            return full(new, node, namespace)
    return topic


def parameters(node: Started, name: str) -> dict[str, Any]:
    """Return what files give a node: sections are known by the full name of the node."""
    space = f"{node.namespace.strip('/')}/" if node.namespace.strip("/") else ""
    found: dict[str, Any] = {}
    for file in node.files:
        found |= nodes_of(Path(file).read_text("utf-8")).get(f"{space}{name}", {})
    return found


class Wheels(NamedTuple):
    """Where the controller of the drive takes velocities, where its odometry is, and its transform: topic and ends."""

    takes: End
    odometry: str
    transform: tuple[str, str, str]


def wheels(nodes: list[Started], case: Case) -> Wheels:
    manager = next(node for node in nodes if node.executable == "ros2_control_node")
    spawner = next(node for node in nodes if node.executable == "spawner" and node.arguments[0] == "base")
    remaps = list(manager.remaps)
    for flag, text in pairwise(spawner.arguments):
        if flag == "--controller-ros-args":
            words = shlex.split(text)
            remaps = [tuple(to.split(":=")) for option, to in pairwise(words) if option == "-r"]
    keys = parameters(manager, "base")
    assert keys
    stamped = case.distribution != "humble" or keys.get("use_stamped_vel", case.kind in STAMPED_BY_DEFAULT)
    commands, odometry = TAKES[case.kind]
    place = ("base", manager.namespace, remaps)
    # By default a mecanum controller stops one cycle after each velocity.
    assert case.kind != "mecanum_drive" or keys["reference_timeout"] > 1 / NAV2_RATE
    moving = keys.get("enable_odom_tf", case.kind != "tricycle")
    tf = resolved("/tf" if case.kind in ON_TF else "~/tf_odometry", *place) if moving else ""
    taken = End(resolved(commands[stamped], *place), STAMPED if stamped else TWIST)
    ends = keys.get("odom_frame_id", "odom"), keys.get("base_frame_id", "base_link")
    assert keys.get("tf_frame_prefix_enable") is False or "tf_frame_prefix_enable" not in keys
    return Wheels(taken, resolved(odometry, *place), (tf, *ends))


def transforms(nodes: list[Started], case: Case) -> Iterator[tuple[str, str]]:
    topic, *ends = wheels(nodes, case).transform
    if topic == "/tf":
        yield tuple(ends)
    for node in nodes:
        keys = parameters(node, node.name)
        if node.executable == "ekf_node" and keys.get("publish_tf", True):
            yield keys.get("odom_frame", "odom"), keys.get("base_link_frame", "base_link")
        if node.name == "amcl" and keys.get("tf_broadcast", True):
            yield keys.get("global_frame_id", "map"), keys.get("odom_frame_id", "odom")
        if node.name == "slam_toolbox" and keys.get("transform_publish_period", 0.05):
            yield keys.get("map_frame", "map"), keys.get("odom_frame", "odom")


def ends(node: Started, case: Case) -> tuple[list[End], list[End]]:
    keys = parameters(node, node.name)
    stamped = case.distribution != "humble" and keys.get("enable_stamped_cmd_vel", case.distribution == "kilted")
    taken, sent = {
        "velocity_smoother": ("cmd_vel", "cmd_vel_smoothed"),
        "collision_monitor": (keys.get("cmd_vel_in_topic", ""), keys.get("cmd_vel_out_topic", "")),
    }.get(node.name, ("", "cmd_vel" if node.name in SENDERS else ""))

    def end(name: str) -> Iterator[End]:
        if name:
            topic = resolved(name, node.name, node.namespace, node.remaps)
            yield End(topic, STAMPED if stamped else TWIST)

    return list(end(taken)), list(end(sent))


CASES = [Case(kind, one) for kind in TAKES for one in NODES if (kind, one) != ("omni_wheel_drive", "humble")]
CASES += [Case(kind, "jazzy", "ekf") for kind in ("diff_drive", "mecanum_drive")]
CASES += [Case("mecanum_drive", one, owner, "left") for one in ("humble", "jazzy") for owner in ("base", "ekf")]


@pytest.mark.parametrize("case", CASES, ids="-".join)
def test_velocities_reach_the_wheels_and_odometry_comes_back(tmp_path: Path, case: Case) -> None:
    nodes = started(tmp_path, case)
    drive = wheels(nodes, case)
    nav2 = [node for node in nodes if node.package == "nav2"]
    for source in nav2:
        reached = set(ends(source, case)[1])
        while (
            more := {end for node in nav2 if reached & {*ends(node, case)[0]} for end in ends(node, case)[1]} - reached
        ):
            reached |= more
        assert not reached or drive.takes in reached, (source.name, reached)
    published = {drive.odometry} if case.owner == "base" else {"/odometry/filtered"}
    filters = [node for node in nodes if node.executable == "ekf_node"]
    assert len(filters) == (case.owner == "ekf")
    for node in filters:
        heard = parameters(node, node.name)["odom0"]
        assert resolved(heard, node.name, node.namespace, node.remaps) == drive.odometry
    for name in ("bt_navigator", "controller_server", "velocity_smoother"):
        node = next(one for one in nav2 if one.name == name)
        heard = resolved(parameters(node, name).get("odom_topic", "odom"), name, node.namespace, node.remaps)
        assert heard in published
    base = "base_footprint" if case.kind in EXAMPLES else "base_link"
    assert sorted(transforms(nodes, case)) == [("map", "odom"), ("odom", base)]


def test_a_namespace_that_is_not_carried_through_is_refused(tmp_path: Path) -> None:
    case = Case("diff_drive", "jazzy")
    nodes = started(tmp_path, case)
    assert {node.namespace for node in nodes} == {""}
    shares = {"car": tmp_path / "car", "nav2_bringup": tmp_path / "nav2_bringup"}
    for file, (name, value) in product(
        ("bringup", "control", "navigation"), (("namespace", "left"), ("frame_prefix", "left/"))
    ):
        said = rf"{name}:=left is not carried through: .* compiled for none; .* description.launch.py alone takes any"
        with pytest.raises(RuntimeError, match=said):
            read(tmp_path / f"car/launch/{file}.launch.py", shares, **{name: value})
    alone = read(tmp_path / "car/launch/description.launch.py", shares, namespace="left").nodes
    assert {node.namespace for node in alone} == {"left"}


def test_the_namespace_of_controllers_does_not_leak_into_nav2(tmp_path: Path) -> None:
    """Given one, nav2_bringup puts its parameters below it, and its nodes are elsewhere."""
    nodes = started(tmp_path, Case("mecanum_drive", "jazzy", "ekf", "left"))
    inside = {node.executable for node in nodes if node.namespace == "left"}
    assert inside == {"robot_state_publisher", "ros2_control_node", "spawner"}
    assert {node.namespace for node in nodes if node.executable not in inside} == {""}
    shares = {"car": tmp_path / "car"}
    control = tmp_path / "car/launch/control.launch.py"
    assert {node.namespace for node in read(control, shares, namespace="left").nodes} == {"left"}
    with pytest.raises(RuntimeError, match=r"namespace:=right .* compiled for left"):
        read(control, shares, namespace="right")
    with pytest.raises(RuntimeError, match=r"namespace:=left .* compiled for none"):  # Nav2 is in none
        started(tmp_path, Case("mecanum_drive", "jazzy", "ekf", "left"), namespace="left")


@pytest.mark.parametrize(
    ("locator", "default", "publishers"),
    [
        ("nav2_amcl", "amcl", {"amcl", "slam_toolbox"}),
        ("slam_toolbox", "slam_toolbox", {"slam_toolbox"}),
        ("some_localizer", "amcl", {"slam_toolbox"}),
    ],
)
def test_who_owns_the_map_decides_what_is_started(
    tmp_path: Path, locator: str, default: str, publishers: set[str]
) -> None:
    """AMCL is silent where it is not the owner; slam_toolbox, asked for by hand, has the frames of the robot."""
    case = Case("mecanum_drive", "jazzy", "base", "", locator)

    def started_by(**given: str) -> Started:
        nodes = started(tmp_path, case, **given)
        (one,) = [node for node in nodes if node.name in ("amcl", "slam_toolbox")]
        assert (("map", "odom") in transforms(nodes, case)) == (one.name in publishers)
        return one

    assert started_by().name == default
    if locator == "slam_toolbox":  # AMCL would be silent, and nobody would publish the edge
        with pytest.raises(Failed, match="slam"):
            started_by(slam="False")
        return
    located, mapping = started_by(slam="False"), started_by(slam="True")
    assert (located.name, mapping.name) == ("amcl", "slam_toolbox")
    assert parameters(located, "amcl")["robot_model_type"] == "nav2_amcl::OmniMotionModel"
    with pytest.raises(Failed, match="slam"):
        started_by(slam="true")  # which nav2_bringup would read as a name of Python
    frames = parameters(mapping, "slam_toolbox")
    assert frames["base_frame"] == parameters(located, "amcl")["base_frame_id"] == "base_link"


def test_what_starts_navigation_is_clean_whatever_it_starts(tmp_path: Path) -> None:
    """With Nav2, with a filter, and with both; in Python as ROS 2 packages have it."""
    found = {}
    for name, left_out in (("both", "none"), ("filter", "  nav2:"), ("nav2", "  robot_localization:")):
        case = Case("mecanum_drive", "jazzy", "ekf" if name != "nav2" else "base", "left")
        text = "".join(line for line in described(case).splitlines(True) if not line.startswith(left_out))
        (tmp_path / "car.yaml").write_text(text, "utf-8")
        words = ["-o", str(tmp_path / name), "--name", "car", "--control", "--nav2", "-q"]
        assert main(["package", str(tmp_path / "car.yaml"), *words]) == 0
        clean(*(tmp_path / name / "launch").glob("*.py"))
        found[name] = (tmp_path / name / "launch/navigation.launch.py").read_text("utf-8")
    assert ["ekf_node" in found[name] for name in ("both", "filter", "nav2")] == [True, True, False]
    assert ["nav2_bringup" in found[name] for name in ("both", "filter", "nav2")] == [True, False, True]
