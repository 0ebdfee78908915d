"""The robot: links, joints, publishers of its frames, named poses, and outputs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, reduce
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar

from rosorin_compile.source.cache import of_robot
from rosorin_compile.source.diagnostics import UnknownName

from .geometry import Pose, Transform
from .joint import ROBOT_STATE_PUBLISHER, SEVERAL_COORDINATES, STATIC_TRANSFORM_PUBLISHER, UNPUBLISHED, Joint, Publisher
from .link import NO_SOURCE, Inertial, Link, Source, together
from .sections import Sections
from .shape import Material, Rgba, Shape
from .simulation import AT_ORIGIN, GazeboSensor, Root, SensorElement, Values

if TYPE_CHECKING:
    from pathlib import Path

    from rosorin_compile.ros.sections.control import Block
    from rosorin_compile.ros.sections.moveit import Moveit

    from .drive import Drive, DriveKinematics
    from .frame_tree import Row
    from .kinematics import Kinematics
    from .servos import ServoGroup
    from .simulation import Actuator, Entry

    Named = TypeVar("Named")


class ByName(dict[str, "Named"]):
    """A dict of entries of a ``kind`` (such as "link"). Its KeyError names the kind and suggests a similar name."""

    def __init__(self, kind: str, items: Mapping[str, Named]) -> None:
        super().__init__(items)
        self.kind = kind

    def __missing__(self, name: object) -> NoReturn:
        raise UnknownName(self.kind, str(name), self, none="the robot has none")

    def __reduce__(self) -> tuple[object, ...]:
        return (ByName, (self.kind, dict(self)))


def _grouped(pairs: Iterable[tuple[str, Named]]) -> dict[str, tuple[Named, ...]]:
    groups: dict[str, list[Named]] = {}
    for name, value in pairs:
        groups.setdefault(name, []).append(value)
    return {name: tuple(values) for name, values in groups.items()}


@dataclass(frozen=True)
class Sensor:
    """A sensor and its frames."""

    name: str
    type: str
    frame: str  # child link of ``joint``
    joint: str
    optical_frame: str = ""  # or "" for sensors without an image
    source: Source = NO_SOURCE
    simulated: tuple[SensorElement, ...] = ()
    stamps: tuple[str, ...] = ()  # frame_ids in the headers of messages that the sensor's driver publishes
    gazebo: tuple[GazeboSensor, ...] = ()


@dataclass(frozen=True)
class Edge:
    """A transform parent -> child from the section ``edges``, or of a joint whose publisher depends on the mode."""

    parent: str
    child: str
    publisher: Publisher
    moving: bool
    when: str = ""
    pose: Pose | None = None  # None if only the running node knows the pose
    source: Source = NO_SOURCE
    joint: str = ""  # name of the joint, or "" for an entry of the section ``edges``

    @property
    def topic(self) -> str:
        """The topic of the transform, or "none" if no node publishes it."""
        moving = self.moving and self.publisher.kind != STATIC_TRANSFORM_PUBLISHER
        return ("/tf" if moving else "/tf_static") if self.publisher.publishes else "none"


@dataclass(frozen=True)
class JointPose:
    """A named pose of the robot. Joints that are not in ``positions`` are at zero."""

    name: str
    positions: Mapping[str, float]  # rad or m, by joint name
    pulses: Mapping[str, int] = field(default_factory=dict)
    source: Source = NO_SOURCE
    base: Pose | None = None  # pose of a free base in the world, in simulations
    controls: Mapping[str, float] = field(default_factory=dict)  # actuator commands by actuator name, in simulations
    mjcf: Values = field(default_factory=dict)


@dataclass(frozen=True)
class Controller:
    """A ros2_control controller."""

    name: str
    type: str  # full or short name, as in the description
    params: Mapping[str, Any] = field(default_factory=dict)  # parameter values by full name (``a.b.c``)
    hardware: str = ""  # name of the <ros2_control> block with the joints of the controller, or ""
    sensor: str = ""  # name of the sensor that the controller broadcasts, or ""
    inactive: bool = False  # True if the controller is configured at startup, but activated later
    source: Source = NO_SOURCE


@dataclass(frozen=True)
class Output:
    """An artifact to generate: its format (``backend``), its file in the outputs folder, and its options."""

    name: str
    backend: str
    file: str
    options: Mapping[str, Any] = field(default_factory=dict, hash=False)


@dataclass(frozen=True, repr=False)
class Robot:
    """A robot. Links, joints and sensors are in the order of the description.

    ``mesh_files`` maps names of meshes and images to paths; names of missing files are in ``missing_meshes``.
    ``mesh_contents`` maps mesh names to (bytes, file extension) of the files that artifacts load. ``root_in_world`` is
    the pose of the root in simulations. ``sections`` has the values of plug-in sections.
    """

    name: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    sensors: tuple[Sensor, ...] = ()
    edges: tuple[Edge, ...] = ()
    publishers: tuple[Publisher, ...] = ()
    poses: tuple[JointPose, ...] = ()
    outputs: tuple[Output, ...] = ()
    modes: tuple[str, ...] = ()
    source: Source = NO_SOURCE
    materials: tuple[Material, ...] = ()
    urdf_elements: tuple[str, ...] = ()
    root_in_world: Root = AT_ORIGIN
    servos: tuple[ServoGroup, ...] = ()
    drive: Drive | None = None
    control: tuple[Block, ...] = ()
    controllers: tuple[Controller, ...] = ()
    moveit: Moveit | None = None
    disabled_contacts: tuple[tuple[str, str], ...] = ()
    actuators: tuple[Actuator, ...] = ()
    constraints: tuple[Entry, ...] = ()
    mjcf: tuple[str, ...] = ()
    sections: Sections = field(default_factory=Sections)
    missing_meshes: frozenset[str] = field(default=frozenset(), compare=False)
    mesh_files: Mapping[str, Path] = field(default_factory=dict, compare=False)
    mesh_contents: Mapping[str, tuple[bytes, str]] = field(default_factory=dict, compare=False)

    def __repr__(self) -> str:
        from rosorin_compile.source.wording import count_of

        moving = sum(not joint.is_fixed for joint in self.joints)
        links, joints = count_of(len(self.links), "link"), count_of(len(self.joints), "joint")
        joints += f" ({moving} that move{'s' if moving == 1 else ''})"
        return f"<Robot {self.name}: {links}, {joints}, {count_of(len(self.sensors), 'sensor')}>"

    def _repr_html_(self) -> str:
        from .frame_tree import html

        return html(self)

    def __getstate__(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in self.__dataclass_fields__}

    @cached_property
    def worked_out(self) -> dict[tuple[Any, ...], Any]:
        return {}

    def has_free_base(self, output: Output) -> bool:
        """Return True if the option ``base`` of an output is "free", which is the default for a robot with a drive."""
        default = "fixed" if self.drive is None else "free"
        return output.options.get("base", default) == "free" and not self.root_in_world.world

    def without_plugin_entries(self) -> Robot:
        """Return the robot without the links and other entries that plug-in sections added."""
        return self.sections.without or self

    @cached_property
    def link(self) -> Mapping[str, Link]:
        return ByName("link", {link.name: link for link in self.links})

    @cached_property
    def joint(self) -> Mapping[str, Joint]:
        return ByName("joint", {joint.name: joint for joint in self.joints})

    @cached_property
    def material(self) -> Mapping[str, Material]:
        """All materials by name, including those that visuals define. The first definition takes precedence."""
        materials = {material.name: material for material in self.materials}
        for link in self.links:
            for visual in link.visual:
                if visual.material and (visual.rgba or visual.texture):
                    materials.setdefault(visual.material, Material(visual.material, visual.rgba, visual.texture))
        return materials

    def colour(self, visual: Shape) -> Rgba | None:
        return self._look(visual).rgba

    def texture(self, visual: Shape) -> str:
        return self._look(visual).texture

    def _look(self, visual: Shape) -> Shape | Material:
        return visual if visual.rgba is not None or visual.texture else self.material.get(visual.material, visual)

    def look_of(self, link: Link) -> Rgba | None:
        return next((colour for shape in link.visual if (colour := self.colour(shape)) is not None), None)

    @property
    def has_looks(self) -> bool:
        return any(link.visual for link in self.links if link.name not in self.simulated_frames)

    def positions(self, pose: str) -> Mapping[str, float]:
        """Return the joint positions (rad or m) of a named pose. Raises KeyError if the pose does not exist."""
        return ByName("pose", {one.name: one.positions for one in self.poses})[pose]

    @cached_property
    def joint_to(self) -> Mapping[str, Joint]:
        """The parent joint of each link except the root, by link name."""
        return {joint.child: joint for joint in self.joints}

    @cached_property
    def joints_from(self) -> Mapping[str, tuple[Joint, ...]]:
        """The child joints of each link, by link name, in the order of the description."""
        return _grouped((joint.parent, joint) for joint in self.joints)

    @cached_property
    def root(self) -> str:
        return next(link.name for link in self.links if link.name not in self.joint_to)

    @cached_property
    def is_tree(self) -> bool:
        if not (self.joint_to.keys() | self.joints_from.keys()) <= self.link.keys():
            return False
        # Each link except the root has one parent joint, and the root reaches all links, so there are no cycles.
        return len(self.joint_to) == len(self.joints) == len(self.link) - 1 and len(self._down) == len(self.links)

    @cached_property
    def mimics_resolve(self) -> bool:
        """Whether each mimic joint leads, directly or through other mimic joints, to a joint without ``mimic``."""
        followers = [joint for joint in self.joints if joint.mimic]
        resolved = {joint.name for joint in self.joints if not joint.mimic}
        for _ in followers:
            resolved |= {joint.name for joint in followers if joint.mimic and joint.mimic.joint in resolved}
        return resolved == self.joint.keys()

    @property
    def has_poses(self) -> bool:
        """Whether the poses of the links can be computed: no loops, no unresolved mimic joints, no axis of zero."""
        has_axes = all(any(joint.axis) for joint in self.joints if joint.moves or joint.type == "planar")
        return self.is_tree and self.mimics_resolve and has_axes

    def walk(self) -> Iterator[Link]:
        """Yield the links depth-first from the root, children in the order of their joints."""
        return iter(self._down)

    @cached_property
    def _down(self) -> tuple[Link, ...]:
        return tuple(self.link[name] for name in self.subtree(self.root))

    @of_robot
    def joints_down(self) -> tuple[Joint, ...]:
        """Return the joints from the root down, in the depth-first order of ``walk``."""
        return tuple(self.joint_to[link.name] for link in self._down if link.name in self.joint_to)

    def chain(self, link: str) -> tuple[Joint, ...]:
        joints: list[Joint] = []
        while link in self.joint_to:
            joints.append(self.joint_to[link])
            link = joints[-1].parent
        return tuple(reversed(joints))

    def subtree(self, link: str) -> tuple[str, ...]:
        """Return the names of a link and all links below it, depth-first, even if the joints form a cycle."""
        found: dict[str, None] = {}
        waiting = [link]
        while waiting:
            name = waiting.pop()
            if name not in found:
                found[name] = None
                waiting += [joint.child for joint in reversed(self.joints_from.get(name, ()))]
        return tuple(found)

    def moves_between(self, first: str, second: str) -> bool:
        """Return True if two links can move relative to each other, False if they are rigidly connected."""
        return self._rigid_tops.get(first, first) != self._rigid_tops.get(second, second)

    @cached_property
    def _rigid_tops(self) -> Mapping[str, str]:
        tops: dict[str, str] = {}  # the topmost link that each link is rigidly connected to, by link name
        for link in self._down:
            joint = self.joint_to.get(link.name)
            tops[link.name] = tops[joint.parent] if joint is not None and joint.is_fixed else link.name
        return tops

    def fixed_neighbours(self, link: str) -> Iterator[tuple[str, Transform]]:
        """Yield (name, pose in ``link``) of links that a fixed joint connects to ``link``: children, then parent."""
        for joint in self.joints_from.get(link, ()):
            if joint.is_fixed:
                yield joint.child, joint.origin.transform()
        above = self.joint_to.get(link)
        if above is not None and above.is_fixed:
            yield above.parent, above.origin.transform().inverse()

    @cached_property
    def mode_dependent_edges(self) -> Mapping[str, tuple[Edge, ...]]:
        """The transforms of joints whose publisher depends on the mode, by joint name."""
        return _grouped((edge.joint, edge) for edge in self.edges if edge.joint)

    @cached_property
    def simulated_frames(self) -> Mapping[str, str]:
        """Map each link that exists only in simulations to the reason, in the order of ``walk``."""
        found: dict[str, str] = {}
        for joint in self.joints_down():
            if joint.publisher.simulated:
                found[joint.child] = joint.publisher.about
            elif joint.parent in found and joint.publisher.kind == UNPUBLISHED:
                found[joint.child] = found[joint.parent]
        return found

    @property
    def frames(self) -> list[str]:
        """The names of the links that are tf frames, which excludes links that exist only in simulations."""
        return [link.name for link in self.links if link.name not in self.simulated_frames]

    def frame_tree(self) -> tuple[Row, ...]:
        """Return a row for each transform: joints from the root down, then transforms that other nodes publish."""
        from .frame_tree import rows

        return rows(self)

    def joint_edges(self) -> list[Edge]:
        """Return the transforms of joints, except those to simulation-only links or with a mode-dependent publisher."""
        joints = [joint for joint in self.joints_down() if joint.child not in self.simulated_frames]
        joints = [joint for joint in joints if joint.publisher.publishes or joint.name not in self.mode_dependent_edges]
        unmeasured = Publisher(UNPUBLISHED, "nobody", about="no joint state contains its position")
        ends = ((one, unmeasured if one in self.unmeasured_joints else one.publisher) for one in joints)
        return [Edge(j.parent, j.child, publisher, j.moves_on_tf, pose=j.origin) for j, publisher in ends]

    @of_robot
    def published_by(self, kind: str) -> tuple[Joint, ...]:
        """Return the joints with this kind of publisher, such as ROBOT_STATE_PUBLISHER, in description order."""
        return tuple(joint for joint in self.joints if joint.publisher.kind == kind)

    @cached_property
    def unmeasured_joints(self) -> tuple[Joint, ...]:
        """The moving joints that robot_state_publisher publishes, but whose position no joint state contains.

        Empty if no <ros2_control> block has joints, or if the robot has no controllers.
        """
        components = [one for block in self.control for one in block.joints]
        measured = {one.name for one in components if "position" in one.states}
        broadcasters = [one.params for one in self.controllers if one.type.startswith("joint_state_broadcaster")]
        published = set[object]() if broadcasters else measured
        for params in broadcasters:
            lists = {key: value for key, value in params.items() if isinstance(value, tuple)}
            joints, interfaces, extra = (lists.get(key, ()) for key in ("joints", "interfaces", "extra_joints"))
            # joint_state_broadcaster publishes all interfaces unless both "joints" and "interfaces" are set.
            chosen = measured.intersection(joints) if "position" in interfaces else set()
            published |= {*extra, *(chosen if joints and interfaces else measured)}
        ours = self.published_by(ROBOT_STATE_PUBLISHER) if components and self.controllers else ()
        return tuple(one for one in ours if one.moves and one.mimic is None and one.name not in published)

    @of_robot
    def in_urdf(self) -> tuple[Joint, ...]:
        """Return the joints in the URDF, which robot_state_publisher publishes or which have several coordinates."""
        ours = ROBOT_STATE_PUBLISHER
        return tuple(j for j in self.joints if j.publisher.kind == ours or j.type in SEVERAL_COORDINATES)

    @property
    def asks_for_humble(self) -> bool:
        return any(output.options.get("control") == "humble" for output in self.outputs)

    def position(self, joint: Joint, positions: Mapping[str, float | Sequence[float]]) -> Any:
        """Return the position of a joint (rad or m; default 0). A mimic joint gets its position from its leader."""
        leader, factor, offset = joint, 1.0, 0.0
        while leader.mimic is not None:
            offset += factor * leader.mimic.offset
            factor *= leader.mimic.multiplier
            leader = self.joint[leader.mimic.joint]
        position = positions.get(leader.name, 0.0)
        if isinstance(position, Sequence):  # several coordinates, which a joint cannot mimic
            return position if leader is joint else offset
        return factor * position + offset

    def pose_in_root(self, link: str, positions: Mapping[str, float]) -> Transform:
        """Return the pose of a link in the root frame at joint positions (rad or m; default 0)."""
        steps = [joint.transform(self.position(joint, positions)) for joint in self.chain(link)]
        return reduce(Transform.then, steps, Transform())

    def poses_in_root(self, positions: Mapping[str, float | Sequence[float]]) -> dict[str, Transform]:
        """Return the pose of each link in the root frame, by name, at joint positions (rad or m; default 0)."""
        poses = {self.root: Transform()}
        for joint in self.joints_down():
            position = self.position(joint, positions) if joint.moves else positions.get(joint.name, 0.0)
            poses[joint.child] = poses[joint.parent].then(joint.transform(position))
        return poses

    def transform(
        self, source: str, target: str, positions: Mapping[str, float] | None = None, *, pose: str = ""
    ) -> Transform:
        """Return the pose of the link ``target`` in the link ``source``, as tf2_echo SOURCE TARGET does.

        ``pose`` is the name of a pose, and ``positions`` (rad or m, by joint name) override its values. Other joints
        are at zero, and mimic joints follow their leaders. Raises KeyError for unknown names.
        """
        for name in (name for name in (source, target) if name not in self.link):
            edges = sorted(self.edges, key=lambda edge: edge.child != name)
            owner = next((edge.publisher.name for edge in edges if name in (edge.parent, edge.child)), "")
            none = f"it is a frame of another node, {owner}"
            raise UnknownName("link", name, () if owner else self.link, none=none)
        for name in positions or ():
            _ = self.joint[name]
        state = {**(self.positions(pose) if pose else {}), **(positions or {})}
        return self.pose_in_root(source, state).inverse().then(self.pose_in_root(target, state))

    @cached_property
    def kinematics(self) -> Kinematics:
        """The forward kinematics for many joint states at once. Raises ImportError if numpy is missing."""
        from .kinematics import Kinematics

        return Kinematics(self)

    @property
    def drive_kinematics(self) -> DriveKinematics:
        """The conversion between wheel speeds and the velocity of the base. Raises ValueError without a drive."""
        from .drive import drive_kinematics

        return drive_kinematics(self)

    def with_masses(self, more: Mapping[str, Sequence[Inertial]]) -> Robot:
        """Return a copy of the robot with masses added to links; for the function ``adds`` of plug-in sections.

        ``more`` maps link names to inertials in the link frame; unknown names are ignored. Raises ValueError on
        overflow.
        """
        links = []
        for link in self.links:
            parts = [(one, Transform()) for one in (link.inertial, *more.get(link.name, ())) if one]
            links.append(replace(link, inertial=together(parts)) if more.get(link.name) else link)
        return replace(self, links=tuple(links))
