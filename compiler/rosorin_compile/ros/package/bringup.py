"""Generate launch files for ros2_control, MoveIt and navigation, and configuration files for MoveIt."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from rosorin_compile.formats.format import HUMBLE, JAZZY
from rosorin_compile.model import Output, Robot
from rosorin_compile.rules.case import report
from rosorin_compile.source.diagnostics import Diagnostic, error, phrase

from .. import nav2, robot_localization
from ..controllers.write import COMMAND, TF, ControllerParameters, drivers, fill, namespace_of
from ..graph import DRIVER, graph_of, open_ends
from ..navigation import AMCL, SLAM, frames_of, kind_of, owners_of_map, owners_of_odom
from ..node_kinds import as_yaml, plugins
from ..parameter_files import distro_of, nodes_of
from ..ports import Role, described_by, interfaces_of, short_type
from ..srdf.planning import planning_model
from .launch import PackageFile
from .options import CONTROL, MOVEIT, NAV2, STARTS

if TYPE_CHECKING:
    from rosorin_compile.formats.format import Artifact

_URDF, _CONTROLLERS, _SRDF, _EKF = "urdf", "controllers", "srdf", "robot_localization"
_ONE_AXIS = ("revolute", "continuous", "prismatic")  # joint types that joint_limits.yaml can limit
_STAND_IN = 1.0  # assumed acceleration limit (rad/s^2 or m/s^2), MoveIt's default until Iron (moveit2#1794)
_FIRST = "joint_state_broadcaster/JointStateBroadcaster"
_MOVEIT_PACKAGES = ("configs_utils", "kinematics", "planners_ompl", "ros_move_group", "simple_controller_manager")


# (launch file, its description in README.md) by group; _OUTPUTS has the help for missing outputs.
_FILES = {
    CONTROL: ("control.launch.py", "the controller_manager with its controllers"),
    MOVEIT: ("moveit.launch.py", "MoveIt's move_group"),
    NAV2: ("navigation.launch.py", "Nav2, localisation and the filter of odometry"),
}
_OUTPUTS = {
    CONTROL: "add under outputs: a URDF with `control: jazzy` or `humble`, and `controllers: {}`",
    MOVEIT: "add `srdf: {}` under outputs",
    NAV2: "add `nav2: {}` or `robot_localization: {}` under outputs",
}
_FOR_MOVEIT = (
    PackageFile("config/joint_limits.yaml", "joint_limits.yaml", "limits of joints for MoveIt"),
    PackageFile("config/kinematics.yaml", "kinematics.yaml", "solvers of MoveIt"),
    PackageFile("config/moveit_controllers.yaml", "moveit_controllers.yaml", "controllers that MoveIt uses"),
    PackageFile("rviz/moveit.rviz", "moveit.rviz", "RViz for MoveIt"),
)


@dataclass(frozen=True)
class Bringup:
    """The nodes that a package starts in addition to the publishers of frames.

    ``starts`` are items of ``STARTS``. For each format such as "urdf", ``places`` has the path in the package, and
    ``outputs`` the entry of the section ``outputs``. ``ekf`` is the name of the robot_localization node, or "".
    """

    robot: Robot
    starts: tuple[str, ...]
    places: Mapping[str, str]
    outputs: Mapping[str, Output]
    ekf: str = ""

    @cached_property
    def _distribution(self) -> str:
        outputs = (*filter(None, [self.outputs.get(_CONTROLLERS)]), *self.robot.outputs)
        words = (one.options.get("distribution") or one.options.get("control") for one in outputs)
        return described_by(str(next(filter(None, words), JAZZY)))

    @cached_property
    def _controllers(self) -> list[ControllerParameters]:
        return fill(self.robot, self._distribution)

    def packages(self) -> Iterator[str]:
        """Yield the ROS packages of the started nodes and plugins, which package.xml has to list."""
        if CONTROL in self.starts:
            known, hardware = plugins(self._distribution), (one.plugin.partition("/")[0] for one in self.robot.control)
            yield "controller_manager"
            yield from ("hardware_interface" if one == "mock_components" else one for one in hardware)
            yield from (known[one.type] for one in self._controllers if one.type in known)
        if MOVEIT in self.starts:
            yield from (f"moveit_{name}" for name in _MOVEIT_PACKAGES)
        if NAV2 in self.starts:
            needed = (("nav2_bringup", NAV2), ("python3-yaml", NAV2), (_EKF, _EKF))
            yield from (name for name, backend in needed if backend in self.places)

    def files(self) -> Iterator[PackageFile]:
        """Yield the launch and configuration files to generate."""
        launches = [_FILES[word] for word in self.starts]
        launches += [("bringup.launch.py", "all of it")] if self.starts else []
        yield from (PackageFile(f"launch/{file}", file, about) for file, about in launches)
        yield from _FOR_MOVEIT if MOVEIT in self.starts else ()

    def values(self, main: str) -> dict[str, Any]:
        """Return the template variables; ``main`` is the path of the URDF for robot_state_publisher."""
        graph, outside = graph_of(self.robot, self.starts), {}
        for end in (end for end in graph.published if graph.nodes[end.node] == DRIVER and graph.readers(end)):
            outside[end.topic] = (end.node, short_type(end.type), end.topic)
        for end in graph.read:
            if end.port.role in (Role.IMU, Role.ODOMETRY, Role.POSE, Role.TWIST) and not graph.publishers(end):
                outside.setdefault(end.topic, ("another driver", short_type(end.type), end.topic))
        fixed = next((self.outputs[key] for key in (_CONTROLLERS, NAV2) if key in self.outputs), None)
        values: dict[str, Any] = {
            "starts": [(word, *_FILES[word]) for word in self.starts],
            "places": self.places,
            "written": as_yaml,
            "control_namespace": "",
            "navigates": NAV2 in self.starts,
            "drives": False,
            "distribution": distro_of(fixed).capitalize() if self.starts and fixed is not None else "",
            "outside": list(outside.values()) if self.starts else [],
            "teleop": None,
        }
        values |= self._localisation() if NAV2 in self.starts and NAV2 in self.places else {}
        if NAV2 in self.starts and _EKF in self.places:
            moved = robot_localization.remaps(self.robot, self.outputs[_EKF]) if CONTROL in self.starts else []
            values |= {"ekf_name": self.ekf, "ekf_remaps": moved}
        values |= self._control(main) if CONTROL in self.starts else {}
        values |= self._moveit() if MOVEIT in self.starts else {}
        return values

    def check(self) -> Iterator[Diagnostic]:
        """Report unconnected topics, hardware that only Gazebo loads, and assumed values in generated files."""
        if self.starts:
            yield from open_ends(self.robot, graph_of(self.robot, self.starts))
        for block in self.robot.control if CONTROL in self.starts else ():
            if block.plugin.partition("/")[0] in ("gz_ros2_control", "ign_ros2_control", "gazebo_ros2_control"):
                message = f'only Gazebo loads the plugin {block.plugin} of hardware block "{block.name}"'
                help = "write the package without --control, or use a plugin such as mock_components/GenericSystem"
                yield error("package-start", message, None, help)
        plain = [one for one in self.robot.outputs if one.backend == "sdf" and not one.options.get("gazebo")]
        if NAV2 in self.starts and self.robot.sensors and plain:
            message = f"no sensor in {plain[0].file} has a frame: slam_toolbox and AMCL drop the scans of Gazebo"
            yield report("package-gazebo", message, None, "gazebo: harmonic in this output")
        if names := [one["name"] for one in self._limits() if one["acceleration"] is not None]:
            message = f"config/joint_limits.yaml has assumed accelerations, 1 rad/s^2 or 1 m/s^2 ({phrase(names, 4)})"
            yield report("package-acceleration", message, None, "if the maker gives others, load them after that file")

    def _control(self, main: str) -> dict[str, Any]:
        driving, navigates = drivers(self.robot), NAV2 in self.starts and NAV2 in self.places
        commands = {driver.name: [(driver.command, COMMAND)] for driver in driving} if navigates else {}
        topics, spawned = [COMMAND if navigates else driver.topic(driver.command) for driver in driving], []
        for one in sorted(self._controllers, key=lambda one: one.type != _FIRST):
            name, remaps = one.controller.name, one.remaps + commands.get(one.controller.name, [])
            spawned.append({"name": name, "remaps": remaps, "inactive": one.controller.inactive})
        return {
            "control_namespace": namespace_of(self.outputs[_CONTROLLERS]),
            "teleop": {"topic": f"/{topics[0].lstrip('/')}", "stamped": driving[0].stamped} if driving else None,
            "humble": self._distribution == HUMBLE,
            "drives": bool(driving),
            "spawned": spawned,
            "own_description": self.places[_URDF] != main,
            "why": {TF: "it publishes there what it owns", COMMAND: "Nav2 sends velocities there"},
        }

    def _localisation(self) -> dict[str, Any]:
        output = self.outputs[NAV2]
        frames, _ = frames_of(self.robot, output)
        if frames is None or not frames.map:
            return {"slam": "False", "seen_by_slam": {}, "offered": ["True", "False"]}
        owners = owners_of_odom(self.robot, frames)
        has_section = any(kind_of(one) == SLAM for one in self.robot.publishers)
        seen = {} if has_section else nav2.slam_parameters(self.robot, output, frames)
        ever, slam = owners_of_map(frames), str(SLAM in owners and AMCL not in owners)
        is_only = has_section and ever in ({AMCL}, {SLAM})  # nobody publishes map -> odom in the other mode
        return {"slam": slam, "seen_by_slam": seen, "offered": [str(SLAM in ever)] if is_only else ["True", "False"]}

    def _moveit(self) -> dict[str, Any]:
        planning, moved, solved = planning_model(self.robot), list[tuple[Any, ...]](), list[str]()
        if planning is None:  # ``bringup`` reports the missing SRDF
            return {"solved": [], "limited": [], "moved": []}
        for one in self._controllers if _CONTROLLERS in self.outputs else ():
            joints = one.values.get("joints") or [one.values.get("joint", "")]
            if (action := interfaces_of(one.type).get("action")) and all(name in planning.joints for name in joints):
                moved.append((one.controller.name, *action, list(joints)))
        for group in planning.groups.values():
            names = planning.active(group)
            chain = planning.chain(planning.joints[names[-1]].child) if names else []
            solved += [group.name] if names and {*names} <= {joint.name for joint in chain} else []
        return {"solved": solved, "limited": list(self._limits()), "moved": moved}

    def _limits(self) -> Iterator[dict[str, Any]]:
        if (planning := planning_model(self.robot)) is None or MOVEIT not in self.starts:
            return
        acceleration = None if self._distribution == HUMBLE else _STAND_IN
        names = {name for group in planning.groups.values() for name in planning.active(group)}
        for name, joint in planning.joints.items():
            if name in names and joint.type in _ONE_AXIS:
                velocity = joint.limits_of("velocity")[1] or None
                if velocity or acceleration:
                    yield {"name": name, "velocity": velocity, "acceleration": acceleration}


def bringup(robot: Robot, placed: Mapping[str, Artifact], starts: Sequence[str]) -> tuple[Bringup, Diagnostic | None]:
    """Return (nodes that a package starts, error or None); it is an error if a node needs an output that is missing."""
    places: dict[str, str] = {}
    outputs: dict[str, Output] = {}
    named = {output.name: output for output in robot.outputs}
    for place, artifact in placed.items():
        if artifact.backend != _URDF or named[artifact.output].options.get(CONTROL):
            places.setdefault(artifact.backend, place)
            outputs.setdefault(artifact.backend, named[artifact.output])
    if MOVEIT in starts and _SRDF in outputs and (planning := planning_model(robot)) is not None:
        places["moveit_urdf"] = next((at for at, one in placed.items() if one.output == planning.urdf.name), "")
    ekf = next(iter(nodes_of(placed[places[_EKF]].text))).rpartition("/")[2] if _EKF in places else ""
    made = Bringup(robot, tuple(word for word in STARTS if word in starts), places, outputs, ekf)
    hardware = [what for key, what in ((_URDF, "the hardware"), (_CONTROLLERS, "the controllers")) if key not in places]
    missing = {
        CONTROL: " and ".join(hardware),
        MOVEIT: "" if _SRDF in outputs else "an SRDF",
        NAV2: "" if outputs.keys() & {NAV2, _EKF} else "their parameters",
    }
    wrong = next((word for word in made.starts if missing[word]), "")
    message = f"--{wrong} is for {_FILES[wrong][1]}: no output has {missing[wrong]}" if wrong else ""
    return made, error("package-start", message, None, _OUTPUTS[wrong]) if wrong else None
