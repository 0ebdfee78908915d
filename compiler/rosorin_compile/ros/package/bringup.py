"""Bringing up: the launch files of a package that start controllers, MoveIt and navigation, each where it is asked for.

The parameters of the nodes are artifacts: controllers.yaml, the SRDF, those of Nav2 and of robot_localization. What
MoveIt wants besides follows from the robot and is made here: solvers, limits of velocity, and who moves the joints.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.model import Robot
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, error, listed
from rosorin_compile.source.rule_registry import Heading, Rule

from ..graph import graph_of, open_ends
from .naming import CONTROL, MOVEIT, NAV2, STARTS

if TYPE_CHECKING:
    from rosorin_compile.formats.format import Artifact

    from ..srdf.planning import Planning

RULES = (
    Rule(
        "package-start",
        "A package is to start what no output is for.",
        "Add the output that the message names.",
        Heading.PACKAGES,
    ),
    Rule(
        "package-gazebo",
        "A note: Nav2 is started, and an SDF gives sensors no frames: what Gazebo publishes is in no frame of tf.",
        "`gazebo: harmonic` in the output; nothing, where the SDF is for other readers.",
        Heading.PACKAGES,
    ),
    Rule(
        "package-acceleration",
        "A note: MoveIt of Jazzy and later plans nothing for a joint without a limit of acceleration, and a "
        "description says none: `joint_limits.yaml` has a stand-in, 1 rad/s^2 or 1 m/s^2, what MoveIt of Humble takes.",
        "Nothing, if that is what you want; else give MoveIt the limits of the maker.",
        Heading.PACKAGES,
    ),
)

BRINGUP = "bringup.launch.py"
_OF_GAZEBO = ("gz_ros2_control", "ign_ros2_control", "gazebo_ros2_control")
_URDF, _CONTROLLERS, _SRDF, _NAV2, _EKF = "urdf", "controllers", "srdf", "nav2", "robot_localization"

_LAUNCH = {CONTROL: "control.launch.py", MOVEIT: "moveit.launch.py", NAV2: "navigation.launch.py"}
_ABOUT = {
    CONTROL: "the controller_manager with its controllers",
    MOVEIT: "MoveIt's move_group",
    NAV2: "Nav2, localisation and the filter of odometry",
}
_NEEDS = {
    CONTROL: ("controller_manager",),
    MOVEIT: (
        "moveit_configs_utils",
        "moveit_kinematics",
        "moveit_planners_ompl",
        "moveit_ros_move_group",
        "moveit_simple_controller_manager",
    ),
    NAV2: (),
}
_MADE = ("joint_limits.yaml", "kinematics.yaml", "moveit_controllers.yaml")
# The action that MoveIt has for a type of controller.
_ACTIONS = {
    "joint_trajectory_controller/JointTrajectoryController": ("FollowJointTrajectory", "follow_joint_trajectory"),
    "position_controllers/GripperActionController": ("GripperCommand", "gripper_cmd"),
    "effort_controllers/GripperActionController": ("GripperCommand", "gripper_cmd"),
    "parallel_gripper_action_controller/GripperActionController": ("ParallelGripperCommand", "gripper_cmd"),
}
_HUMBLE = "humble"
_OF_ONE_AXIS = ("revolute", "continuous", "prismatic")  # of others MoveIt limits each axis by a name of its own
_STAND_IN = 1.0  # rad/s^2 or m/s^2: the default of MoveIt's time parameterization until Iron (moveit2#1794)
_FIRST = "joint_state_broadcaster/JointStateBroadcaster"


class Spawned(NamedTuple):
    """A controller that is started: its name, the remaps of its topics, from and to, and whether it is active."""

    name: str
    remaps: tuple[tuple[str, str], ...]
    inactive: bool


class Limited(NamedTuple):
    """Limits of a joint for MoveIt: velocity (rad/s or m/s) and acceleration (per second), None where there is none."""

    name: str
    velocity: float | None
    acceleration: float | None


class Bringup(NamedTuple):
    """What a package starts besides the publishers: names of ``STARTS``, and the places of artifacts by their format.

    ``places`` are those in the package; ``outputs`` the names of the outputs; ``ekf`` is the node of the
    filter.
    """

    robot: Robot
    starts: tuple[str, ...]
    places: Mapping[str, str]
    outputs: Mapping[str, str]
    ekf: str = ""

    def packages(self) -> Iterator[str]:
        """Yield the packages of the nodes that are started."""
        from ..parameters.tables import plugins

        for word in self.starts:
            yield from _NEEDS[word]
        if CONTROL in self.starts:
            for block in self.robot.control:
                package = block.plugin.partition("/")[0]
                yield "hardware_interface" if package == "mock_components" else package
            known_plugins = plugins(self._distribution())
            yield from sorted({known_plugins[one.type] for one in self._filled() if one.type in known_plugins})
        if NAV2 in self.starts:
            wanted = (("nav2_bringup", _NAV2), ("python3-yaml", _NAV2), (_EKF, _EKF))
            yield from (name for name, there in wanted if there in self.places)

    def templates(self) -> dict[str, str]:
        """Return the templates of what is made, by the places of the files."""
        if not self.starts:
            return {}
        found = {f"launch/{_LAUNCH[word]}": _LAUNCH[word] for word in self.starts}
        made = {f"config/{name}": name for name in _MADE if MOVEIT in self.starts}
        return {**found, **made, f"launch/{BRINGUP}": BRINGUP}

    def contents(self) -> list[tuple[str, str]]:
        """Return the files that are made with what each is."""
        rows = [(f"launch/{_LAUNCH[word]}", _ABOUT[word]) for word in self.starts]
        rows += [(f"launch/{BRINGUP}", "all of it")] if self.starts else []
        return rows + ([("config/*.yaml", "what MoveIt wants besides the SRDF")] if MOVEIT in self.starts else [])

    def values(self, main: str) -> dict[str, Any]:
        """Return what the templates need to know; ``main`` is the place of what robot_state_publisher reads."""
        from ..parameters.values import written

        values: dict[str, Any] = {"starts": [(word, _LAUNCH[word], _ABOUT[word]) for word in self.starts]}
        values |= {"places": self.places, "ekf_name": self.ekf, "written": written}
        values["control_namespace"] = self._namespace()
        values |= {"navigates": NAV2 in self.starts, "drives": False}
        if _NAV2 in self.places:
            values |= self._localisation()
        if CONTROL in self.starts:
            values |= self._control(main)
        if MOVEIT in self.starts:
            values |= self._moveit()
        return values

    def open_ends(self, topics: Mapping[str, str]) -> list[Diagnostic]:
        """Return what keeps the nodes that are started from working; ``topics`` are those of sensors by name."""
        found = list(open_ends(self.robot, graph_of(self.robot, self.starts, topics))) if self.starts else []
        for block in self.robot.control if CONTROL in self.starts else ():
            if block.plugin.partition("/")[0] in _OF_GAZEBO:
                message = f'hardware block "{block.name}" has the plugin {block.plugin}, which Gazebo loads and '
                message += "ros2_control_node does not know: control.launch.py would end with an error"
                help = "write the package without --control and load the URDF into Gazebo, or name another plugin,"
                help += " such as mock_components/GenericSystem, by an argument of the description"
                found.append(error("package-start", message, None, help))
        if NAV2 in self.starts and self.robot.sensors:
            plain = [one for one in self.robot.outputs if one.backend == "sdf" and not one.options.get("gazebo")]
            if plain:
                message = f"in {plain[0].file} no sensor has a frame: Gazebo stamps its messages with names of its own"
                message += ", and slam_toolbox and AMCL drop scans in a frame that tf does not have"
                found.append(Diagnostic("package-gazebo", NOTE, message, help="gazebo: harmonic in this output"))
        return found

    def remarks(self) -> list[Diagnostic]:
        """Return what is to be said of what is made."""
        planning = planning_of(self.robot) if MOVEIT in self.starts else None
        names = [one.name for one in self._limits(planning) if one.acceleration is not None] if planning else []
        if not names:
            return []
        message = f"nobody says how fast joints may accelerate ({listed(names, 4)}), and MoveIt plans nothing without: "
        message += "config/joint_limits.yaml has a stand-in, 1 rad/s^2 or 1 m/s^2"
        help = "if the maker says other ones, load them after that file"
        return [Diagnostic("package-acceleration", NOTE, message, help=help)]

    def _distribution(self) -> str:
        from ..controllers.filled import distribution_of

        return distribution_of(self.robot, self.outputs.get(_CONTROLLERS, ""))

    def _namespace(self) -> str:
        """Return the namespace of the controllers that are started, empty for none."""
        if CONTROL not in self.starts:
            return ""
        output = next(one for one in self.robot.outputs if one.name == self.outputs[_CONTROLLERS])
        return str(output.options.get("namespace", "")).strip("/")

    def _filled(self) -> list[Any]:
        from ..controllers.filled import filled

        return filled(self.robot, self._distribution())

    def _control(self, main: str) -> dict[str, Any]:
        from ..controllers.filled import remaps
        from ..controllers.topics import COMMAND, TF, drivers

        output = next(one for one in self.robot.outputs if one.name == self.outputs[_CONTROLLERS])
        every = sorted(self._filled(), key=lambda one: one.type != _FIRST)
        found = remaps(self.robot, output)
        drives = drivers(self.robot)
        if NAV2 in self.starts and _NAV2 in self.places:
            for driver in drives:
                found.setdefault(driver.name, []).append((driver.command, COMMAND))
        return {
            "humble": self._distribution() == _HUMBLE,
            "drives": bool(drives),
            "spawned": [
                Spawned(one.controller.name, tuple(found.get(one.controller.name, ())), one.controller.inactive)
                for one in every
            ],
            "own_description": self.places[_URDF] != main,
            "why": {TF: "it publishes there what it owns", COMMAND: "Nav2 sends velocities there"},
        }

    def _localisation(self) -> dict[str, Any]:
        """Return whether slam_toolbox publishes map -> odom, and not AMCL, while no mode is on.

        What it has to know comes from here where it is started by hand alone: the artifact has no section for it then.
        """
        from ..nav2.write import seen_by_slam
        from ..navigation import AMCL, SLAM, frames_of, kind_of, owners_of_odom

        output = next(one for one in self.robot.outputs if one.name == self.outputs[_NAV2])
        frames, _ = frames_of(self.robot, output)
        if frames is None or not frames.map:
            return {"slam": "False"}
        kinds = owners_of_odom(self.robot, frames)
        written = any(kind_of(one) == SLAM for one in self.robot.publishers)
        seen = {} if written else seen_by_slam(self.robot, output, frames)
        return {"slam": str(SLAM in kinds and AMCL not in kinds), "seen_by_slam": seen}

    def _moveit(self) -> dict[str, Any]:
        planning = planning_of(self.robot)
        if planning is None:  # then there is no SRDF either
            return {"solved": [], "limited": [], "moved": []}
        return {
            "solved": [group.name for group in planning.groups.values() if _is_chain(planning, group.name)],
            "limited": list(self._limits(planning)),
            "moved": list(self._moved(planning)),
        }

    def _limits(self, planning: Planning) -> Iterator[Limited]:
        """Yield the limits of the joints that groups move, where there are any.

        Each has one of acceleration: else MoveIt plans nothing, but for that of Humble, which has a default.
        """
        acceleration = None if self._distribution() == _HUMBLE else _STAND_IN
        names = {name for group in planning.groups.values() for name in planning.active(group)}
        for name, joint in planning.joints.items():
            if name in names and joint.type in _OF_ONE_AXIS:
                velocity = (joint.limit.known("velocity") if joint.limit is not None else None) or None
                if velocity or acceleration:
                    yield Limited(name, velocity, acceleration)

    def _moved(self, planning: Planning) -> Iterator[tuple[str, str, str, list[str]]]:
        """Yield the controllers that MoveIt may ask: name, type and name of the action, joints."""
        if _CONTROLLERS not in self.outputs:
            return
        for one in self._filled():
            joints = one.values.get("joints") or [one.values.get("joint", "")]
            if one.type in _ACTIONS and all(name in planning.joints for name in joints):
                yield one.controller.name, *_ACTIONS[one.type], list(joints)


def _is_chain(planning: Planning, name: str) -> bool:
    """Say whether the joints that move in a group are one behind the other: what a solver of positions wants."""
    names = planning.active(planning.groups[name])
    if not names:
        return False
    last = planning.joints[names[-1]].child
    return {*names} <= {joint.name for joint in planning.chain(last)}


def bringup(robot: Robot, placed: Mapping[str, Artifact], starts: Sequence[str]) -> tuple[Bringup, Diagnostic | None]:
    """Return what a package starts, and what is wrong where no output is for it; ``placed`` are artifacts by place."""
    from ..parameters.files import nodes_of

    places: dict[str, str] = {}
    outputs: dict[str, str] = {}
    control = {output.name for output in robot.outputs if output.options.get(CONTROL)}
    for place, artifact in placed.items():
        if artifact.backend != _URDF or artifact.output in control:
            places.setdefault(artifact.backend, place)
            outputs.setdefault(artifact.backend, artifact.output)
    if MOVEIT in starts and _SRDF in outputs:
        places["moveit_urdf"] = _urdf_of_moveit(robot, placed)
    ekf = next(iter(nodes_of(placed[places[_EKF]].text))).rpartition("/")[2] if _EKF in places else ""
    made = Bringup(robot, tuple(word for word in STARTS if word in starts), places, outputs, ekf)
    for word in made.starts:
        missing = _missing(word, outputs)
        if missing:
            message = f"--{word} is for {_ABOUT[word]}: no output has {missing}"
            return made, error("package-start", message, None, _HELP[word])
    return made, None


_HELP = {
    CONTROL: "add under outputs: a URDF with `control: jazzy` or `humble`, and `controllers: {}`",
    MOVEIT: "add `srdf: {}` under outputs",
    NAV2: "add `nav2: {}` or `robot_localization: {}` under outputs",
}


def _missing(word: str, outputs: Mapping[str, str]) -> str:
    if word == CONTROL:
        missing = [
            what for key, what in ((_URDF, "the hardware"), (_CONTROLLERS, "the controllers")) if key not in outputs
        ]
        return " and ".join(missing)
    if word == MOVEIT:
        return "" if _SRDF in outputs else "an SRDF"
    return "" if outputs.keys() & {_NAV2, _EKF} else "their parameters"


def planning_of(robot: Robot) -> Planning | None:
    """Return a robot as MoveIt has it; None if it has no URDF that an SRDF could belong to."""
    from ..srdf import planning

    return planning.planning_of(robot)


def _urdf_of_moveit(robot: Robot, placed: Mapping[str, Artifact]) -> str:
    """Return the place of the URDF that the SRDF belongs to."""
    planning = planning_of(robot)
    found = (place for place, one in placed.items() if planning is not None and one.output == planning.urdf.name)
    return next(found, "")
