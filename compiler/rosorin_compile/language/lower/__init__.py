"""Lower: the model made from a plain tree that has the right shape.

A tree may still mean nothing sensible (a link nobody attached, an axis of zero); that is for the rules to say. Lowering
reports only what keeps a value from being made at all.

``_Builder`` goes through the sections of the tree, with the help of ``entries`` (what becomes one value) and ``shapes``
(geometries and inertias). Below it stand the two things that take more than that: who publishes a joint, always or in
turns (``publishing``), and what a simulation has of a sensor (``lower_elements``).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from rosorin_compile.model import (
    STATIC_TRANSFORM_PUBLISHER,
    Edge,
    Joint,
    Link,
    Output,
    Pose,
    Publisher,
    Robot,
    Sensor,
)
from rosorin_compile.model.geometry import pose_of
from rosorin_compile.model.joint import UNPUBLISHED
from rosorin_compile.model.link import Source
from rosorin_compile.model.simulation import (
    BODY_ELEMENT,
    SENSOR_ELEMENT,
    TEMPLATE_ELEMENT,
    GazeboSensor,
    Replicas,
    Simulated,
)
from rosorin_compile.source.diagnostics import Diagnostic, Related, error
from rosorin_compile.source.files import is_file
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.rule_registry import FILES, FRAMES, Rule
from rosorin_compile.source.tree import Map, Path, locate
from rosorin_compile.source.wording import listed

from ..accepting import accepted, names_at
from ..expand.scope import Scope
from ..expand.tracing import problem_at
from ..schema import backend_of
from .drive import drive_of
from .entries import (
    actuator_of,
    attribute_of,
    calibration_of,
    dynamics_of,
    entries_of,
    limit_of,
    material_of,
    mimic_of,
    node_of,
    safety_of,
    source_of,
    texts_of,
    values_of,
)
from .in_place import sensor_in_place
from .plainly import pose_of_entry, vector_of
from .publishing import Publishing, node, optical_pose, publishing
from .sdf import Frames, around_shapes, lower_gazebo, moved
from .sections import lower_own_sections, lower_sections, with_sections
from .servos import pose_of_joints, servos_of
from .shapes import RULES as _OF_SHAPES
from .shapes import ShapeProblem, lower_inertial, lower_shape
from .simulation import marked_of, root_of

if TYPE_CHECKING:
    T = TypeVar("T")

RULES = (
    Rule(
        "duplicate-name",
        "Two entries have the same name, in one file, in two, or by two uses of a part.",
        "Rename or remove one; give one use or include another `prefix`.",
        FILES,
    ),
    Rule("unknown-publisher", "A publisher is not in `publishers`.", "Correct the name, or add the node.", FRAMES),
)

# The problems of lowering that a description may accept.
_ACCEPTABLE = {rule.id: rule for rule in _OF_SHAPES if rule.accept}


class Lowered(NamedTuple):
    """The model (None after an error), where each joint, link and pose was written, and what is wrong.

    ``places`` is keyed by kind and name: ("joint", "lidar_joint") -> ("sensors", "lidar"); an edge that is the turn of
    a joint's publisher has its index in ``Robot.edges`` for a name.
    """

    robot: Robot | None
    places: dict[tuple[str, str], Path]
    diagnostics: list[Diagnostic]


def lower(tree: Map, scope: Scope | None = None) -> Lowered:
    """Return the model of a tree that ``validate`` found nothing wrong with.

    ``scope`` is what the names in its expressions stood for; None if nobody knows.
    """
    lowering = _Lowering(tree, scope)
    robot = lowering.robot()
    refused = [problem for problem in lowering.diagnostics if not accepted(tree, problem, _ACCEPTABLE)]
    return Lowered(None if refused else robot, lowering.places, lowering.diagnostics)


class _Lowering:
    """Reads one tree; collects what is wrong."""

    def __init__(self, tree: Map, scope: Scope | None) -> None:
        self.tree = tree
        self.scope = scope
        self.places: dict[tuple[str, str], Path] = {}
        self.frames: dict[str, tuple[str, Path]] = {}
        self.diagnostics: list[Diagnostic] = []
        # What was made of a piece of the tree, which many links and joints may share.
        self.made: dict[Hashable, Any] = {}
        self.links: dict[str, Link] = {}
        self.nodes = {name: node_of(name, entry) for name, entry in entries_of(tree, "publishers")}
        self.edges = [self.edge(index, entry) for index, entry in enumerate(tree.get("edges") or ())]

    def section(self, name: str) -> dict[str, Any]:
        """Return a section of the tree, empty if it is left out."""
        return self.tree.get(name) or {}

    def problem(
        self, rule: str, message: str, path: Path, help: str = "", related: tuple[Related, ...] = (), key: bool = False
    ) -> None:
        diagnostic = problem_at(self.scope, self.tree, path, rule, message, help, related, key)
        self.diagnostics.append(replace(diagnostic, of=names_at(self.tree, path)))

    def misfit(self, problem: ShapeProblem, path: Path, where: str = "") -> None:
        self.problem(problem.rule, problem.message + where, (*path, *problem.path), problem.help)

    def place(self, kind: str, name: str, path: Path) -> None:
        """Remember where a name was given; a name that is taken is a problem."""
        taken = self.places.get((kind, name))
        if taken is None:
            self.places[kind, name] = path
            return
        related = (Related("first defined here", locate(self.tree, taken, key=True).span),)
        self.problem("duplicate-name", f'the {kind} "{name}" is defined twice', path, "rename one", related)

    def place_joint(self, name: str, path: Path, frame: str, said: Path) -> None:
        """Remember where a joint and its child frame were written; tell it if that frame was written before."""
        taken = self.frames.setdefault(name, (frame, said))
        if taken == (frame, said) or taken[0] != frame:
            self.place("joint", name, path)
            return
        first = taken[1]
        related = (Related("first said here", locate(self.tree, first).span),)
        message = f'frame "{frame}" is defined twice: by {owner_of_frame(first)} and by {owner_of_frame(said)}'
        help = "give each a frame of its own"
        if first[0] == "joints":
            help = f'a sensor brings the joint to its frame along: remove joint "{name}", or name another frame'
        self.problem("duplicate-name", message, said, help, related)

    def broken(self, diagnostic: Diagnostic, section: str) -> None:
        """Tell what is wrong with the plug-in of a section, where the description has that."""
        place = locate(self.tree, (section,), key=True)
        self.diagnostics.append(replace(diagnostic, span=place.span, related=place.stack()))

    def robot(self) -> Robot:
        """Return the robot with what sections of packages add to it."""
        robot = self.described()
        return with_sections(robot, self.tree, self.broken, self.place) if robot.sections.values else robot

    def described(self) -> Robot:
        """Return the robot as it is said."""
        tree = self.tree
        links = [self.link(name, entry or {}) for name, entry in entries_of(tree, "links")]
        self.links = {link.name: link for link in links}
        joints = [self.joint(name, entry) for name, entry in entries_of(tree, "joints")]
        sensors: list[Sensor] = []
        for name, entry in entries_of(tree, "sensors"):
            sensor, mounts = self.sensor(name, entry)
            sensors.append(sensor)
            joints += mounts
        links += self.frames_of_sensors(sensors)
        servos = servos_of(tree, self.problem)
        drive = drive_of(tree, self.problem) if tree.get("drive") is not None else None
        own = lower_own_sections(tree, self.problem)
        source = source_of(tree.get("source"))
        # Simulators begin at the first one.
        entries = self.section("poses").items() if source.status == "imported" else entries_of(tree, "poses")
        poses = [pose_of_joints(name, entry, servos, tree, self.problem) for name, entry in entries]
        return Robot(
            name=tree["robot"],
            links=tuple(links),
            joints=tuple(joints),
            sensors=tuple(sensors),
            edges=tuple(self.edges),
            publishers=tuple(self.nodes.values()),
            poses=tuple(poses),
            outputs=tuple(self.output(name, entry) for name, entry in entries_of(tree, "outputs")),
            modes=tuple(name for name, _ in entries_of(tree, "modes")),
            source=source,
            materials=tuple(material_of(name, entry) for name, entry in entries_of(tree, "materials")),
            urdf_elements=self.top_elements(),
            root_in_world=root_of(tree.get("root") or {}),
            servos=servos,
            drive=drive,
            disabled_contacts=tuple(
                (pair["links"][0], pair["links"][1]) for pair in tree.get("disabled_contacts") or ()
            ),
            mjcf_elements=tuple(tree.get("mjcf_elements") or ()),
            sections=lower_sections(tree, self.broken),
            **own,
        )

    def top_elements(self) -> tuple[str, ...]:
        """Return the elements of XML at the top of the robot, those of its sensors behind its own."""
        texts = list(texts_of(self.tree))
        for name, entry in self.section("sensors").items():
            for index, text in enumerate(texts_of(entry)):
                self.places["urdf_element", str(len(texts))] = ("sensors", name, "urdf_elements", index)
                texts.append(text)
        return tuple(texts)

    def link(self, name: str, entry: dict[str, Any]) -> Link:
        path: Path = ("links", name)
        self.place("link", name, path)
        source = source_of(entry.get("source"))
        visual = self.shapes(entry.get("visual") or (), (*path, "visual"), source)
        collision = self.shapes(entry.get("collision") or (), (*path, "collision"), source)
        inertial = None
        if "inertial" in entry:
            key = (id(entry["inertial"]), id(visual), id(collision))
            try:
                inertial = self.once(
                    key,
                    lambda: lower_inertial(
                        entry["inertial"],
                        {"visual": visual, "collision": collision},
                        lambda file: self.mesh_file(file, path),
                    ),
                )
            except ShapeProblem as problem:
                self.misfit(problem, (*path, "inertial"), f' (link "{name}" inertial)')
        simulated = marked_of(entry) if entry else ()
        return Link(
            name,
            inertial,
            visual,
            collision,
            source,
            texts_of(entry),
            float(entry.get("gravity_compensation", 0)),
            simulated,
            values_of(entry.get("mjcf")),
            tuple(entry.get("mjcf_elements") or ()),
        )

    def mesh_file(self, name: str, path: Path) -> FilePath | None:
        """Return the file of a mesh of a link: relative to the description that has the link, or in a package."""
        first = FilePath(self.tree.span.source.path)
        places = [FilePath(self.tree.locate(path).span.source.path), first]
        folders = [place.parent for place in places]
        source = self.tree.get("source")
        if isinstance(source, Map) and isinstance(source.get("folder"), str):
            folders.append(first.parent / source["folder"])
        found = (Packages({}, os.environ, places[0]).resolve(name, folder) for folder in folders)
        return next((file for file in found if file is not None and is_file(file)), None)

    def once(self, key: Hashable, make: Callable[[], T]) -> T:
        """Return what is made of a piece of the tree, named by its identity, once for all that share it."""
        if key not in self.made:
            self.made[key] = make()
        known: T = self.made[key]
        return known

    def shapes(self, entries: Any, path: Path, source: Source) -> tuple[Any, ...]:
        """Return the shapes of a list; of one that several links share the same ones, unless something is wrong."""
        if not entries:
            return ()
        key = (id(entries), source)
        known: tuple[Any, ...] | None = self.made.get(key)
        if known is not None:
            return known
        before = len(self.diagnostics)
        made = tuple(self.shapes_of(entries, path, source))
        if len(self.diagnostics) == before:
            self.made[key] = made
        else:
            self.made[id(made), "kept"] = made  # no other list gets its identity
        return made

    def shapes_of(self, entries: Any, path: Path, source: Source) -> list[Any]:
        made = []
        for index, entry in enumerate(entries):
            own = source_of(entry["source"]) if "source" in entry else source
            stand_in = own.note if own.status == "stand_in" else ""
            try:
                made.append(lower_shape(entry, pose_of_entry(entry), stand_in, self.taken((*path, index))))
            except ShapeProblem as problem:
                self.misfit(problem, (*path, index))
        return made

    def taken(self, path: Path) -> Callable[[ShapeProblem], bool]:
        """Return what says whether the description accepts a problem of the shape at a path; it is taken down then."""

        def accept(problem: ShapeProblem) -> bool:
            refused = replace(error(problem.rule, "", None), of=names_at(self.tree, path))
            if not accepted(self.tree, refused, _ACCEPTABLE):
                return False
            self.misfit(problem, path)
            return True

        return accept

    def joint(self, name: str, entry: dict[str, Any]) -> Joint:
        path: Path = ("joints", name)
        self.place_joint(name, path, entry["child"], (*path, "child"))
        axis, limit = entry.get("axis"), entry.get("limit")
        by = publishing(entry, path, self.nodes, self.problem)
        joint = Joint(
            name=name,
            type=entry["type"],
            parent=entry["parent"],
            child=entry["child"],
            origin=pose_of_entry(entry),
            axis=self.once(id(axis), lambda: vector_of(axis, (1.0, 0.0, 0.0))),
            limit=self.once(id(limit), lambda: limit_of(limit)) if limit is not None else None,
            mimic=mimic_of(entry.get("mimic")),
            dynamics=dynamics_of(entry.get("dynamics")),
            actuator=actuator_of(entry.get("actuator")),
            publisher=by.always,
            source=source_of(entry.get("source")),
            calibration=calibration_of(entry.get("calibration")),
            safety=safety_of(entry.get("safety_controller")),
            urdf_elements=texts_of(entry),
            mjcf=values_of(entry.get("mjcf")),
        )
        self.take_turns(joint, by)
        return joint

    def take_turns(self, joint: Joint, publishing: Publishing) -> None:
        """Make edges of the publishers of a joint that take turns."""
        for turn in publishing.turns:
            self.places["edge", str(len(self.edges))] = turn.path
            moving = not joint.is_fixed and turn.publisher.kind != STATIC_TRANSFORM_PUBLISHER
            turned = Edge(joint.parent, joint.child, turn.publisher, moving, turn.when, joint.origin)
            self.edges.append(replace(turned, source=joint.source, joint=joint.name))

    def sensor(self, name: str, entry: dict[str, Any]) -> tuple[Sensor, list[Joint]]:
        """Return a sensor and the fixed joints of its frame and its optical frame, those that are not there already."""
        if "parent" not in entry:
            return sensor_in_place(self, name, entry)
        path: Path = ("sensors", name)
        frame, source = entry["frame"], source_of(entry.get("source"))
        joint = entry.get("joint", f"{frame}_joint")
        self.place_joint(joint, path, frame, (*path, "frame"))
        by = publishing(entry, path, self.nodes, self.problem)
        mount = pose_of_entry(entry)
        mounts = [Joint(joint, "fixed", entry["parent"], frame, mount, publisher=by.always, source=source)]
        self.take_turns(mounts[0], by)
        optical = entry.get("optical") or None
        pose = optical_pose(optical)
        named, turned = optical["frame"] if optical else "", entry.get("optical") is False
        frames = Frames(frame, mount, entry["parent"], named, joint, pose, turned)
        own = [] if by.always.simulated else [frame, frames.optical] if optical else [frame]
        stamps = tuple(entry.get("stamps", own))
        simulated = self.elements(name, entry, frames)
        gazebo = self.gazebo(name, entry, frames)
        made = Sensor(name, entry["type"], frame, joint, frames.optical, source, simulated, stamps, gazebo)
        return made, [*mounts, self.to_optical(made, optical, pose, by)] if optical else mounts

    def to_optical(self, sensor: Sensor, optical: dict[str, Any], pose: Pose, by: Publishing) -> Joint:
        """Return the fixed joint from the frame of a sensor, which ``by`` publishes, to its optical frame."""
        path: Path = ("sensors", sensor.name, "optical")
        joint = optical.get("joint", f"{optical['frame']}_joint")
        self.place_joint(joint, path, optical["frame"], (*path, "frame"))
        by = publishing(optical, path, self.nodes, self.problem) if "publisher" in optical else by.of_optical()
        made = Joint(joint, "fixed", sensor.frame, optical["frame"], pose, publisher=by.always, source=sensor.source)
        self.take_turns(made, by)
        return made

    def elements(self, name: str, entry: dict[str, Any], frames: Frames) -> tuple[Simulated, ...]:
        """Return what a simulation has of a sensor; two elements of a kind with one name are a problem."""
        path: Path = ("sensors", name, "mjcf")
        made: list[Simulated] = []
        try:
            for unmoved in lower_elements(name, entry.get("mjcf") or (), frames):
                element = around_shapes(moved(unmoved, entry.get("gazebo"), frames), self.links)
                if element.kind != TEMPLATE_ELEMENT:
                    self.place(f"MuJoCo {element.element}", element.name, (*path, len(made)))
                if element.kind == SENSOR_ELEMENT and element.pose is not None:
                    self.place("MuJoCo site", element.site, (*path, len(made)))
                made.append(element)
        except ShapeProblem as problem:
            self.misfit(problem, path, f' (sensor "{name}")')
        return tuple(made)

    def gazebo(self, name: str, entry: dict[str, Any], frames: Frames) -> tuple[GazeboSensor, ...]:
        """Return what Gazebo has of a sensor; two with one name are a problem."""
        path: Path = ("sensors", name, "gazebo")
        made: list[GazeboSensor] = []
        try:
            for one in lower_gazebo(name, entry.get("gazebo") or (), frames):
                self.place("Gazebo sensor", one.name, (*path, len(made)))
                made.append(one)
        except ShapeProblem as problem:
            self.misfit(problem, path, f' (sensor "{name}")')
        return tuple(made)

    def frames_of_sensors(self, sensors: list[Sensor]) -> list[Link]:
        """Return a link for each sensor frame that ``links`` does not mention."""
        made = []
        for sensor in sensors:
            for frame, key in ((sensor.frame, ("frame",)), (sensor.optical_frame, ("optical", "frame"))):
                if frame and ("link", frame) not in self.places:
                    self.place("link", frame, ("sensors", sensor.name, *key))
                    made.append(Link(frame, source=sensor.source))
        return made

    def edge(self, index: int, entry: dict[str, Any]) -> Edge:
        path: Path = ("edges", index)
        publisher = Publisher(UNPUBLISHED)
        if "publisher" in entry:
            publisher = node(entry["publisher"], (*path, "publisher"), self.nodes, self.problem)
        pose = pose_of_entry(entry) if "xyz" in entry or "rpy" in entry else None
        moving, when = entry.get("moving", True), entry.get("when", "")
        return Edge(entry["parent"], entry["child"], publisher, moving, when, pose, source_of(entry.get("source")))

    def output(self, name: str, entry: dict[str, Any]) -> Output:
        backend = entry.get("backend", backend_of(name, entry))
        options = {key: value for key, value in entry.items() if key not in ("file", "backend")}
        return Output(name, backend, entry["file"], options)


def owner_of_frame(path: Path) -> str:
    """Return in words what says a frame: the path of the name in a joint, a sensor, or the optical frame of one."""
    what = "joint" if path[0] == "joints" else "sensor"
    return f'{"the optical frame of " if "optical" in path[2:] else ""}{what} "{path[1]}"'


# What a simulation can still do with.
MAX_COPIES = 100_000

_KINDS = (SENSOR_ELEMENT, BODY_ELEMENT, TEMPLATE_ELEMENT)


def lower_elements(sensor: str, entries: Sequence[Mapping[str, Any]], frames: Frames) -> Iterator[Simulated]:
    """Yield the elements of a sensor. Raises ShapeProblem, whose path leads to the culprit within the entries."""
    for index, entry in enumerate(entries):
        try:
            yield _element(sensor, entry, frames)
        except ShapeProblem as problem:
            raise ShapeProblem(problem.rule, problem.message, (index, *problem.path), problem.help) from None


def _element(sensor: str, entry: Mapping[str, Any], frames: Frames) -> Simulated:
    kinds = [kind for kind in _KINDS if kind in entry]
    if len(kinds) != 1:
        message = f"an element of mjcf has one of {', '.join(_KINDS)}; this one has {listed(kinds) or 'none'}"
        raise ShapeProblem("missing-key", message, (), "write one entry an element")
    if "section" in entry and kinds[0] != TEMPLATE_ELEMENT:
        raise ShapeProblem("ignored-key", "only a template has a section", ("section",), "remove it")
    link, pose = _place(entry, frames)
    suffix = entry.get("name")
    return Simulated(
        kind=kinds[0],
        element=entry[kinds[0]],
        name=sensor if suffix is None else f"{sensor}_{suffix}",
        link=link,
        pose=pose,
        attributes={name: attribute_of(value) for name, value in sorted(entry.get("attributes", {}).items())},
        replicas=_replicas(entry["replicate"]) if "replicate" in entry else None,
        section=entry.get("section", ""),
    )


def _place(entry: Mapping[str, Any], frames: Frames) -> tuple[str, Pose | None]:
    """Return the link of an element, and where it sits in it; None is at the frame of the link."""
    own = pose_of_entry(entry) if any(key in entry for key in ("xyz", "rpy", "replicate")) else None
    frame = entry.get("frame", "sensor")
    if frame == "sensor":
        return frames.sensor, own
    if frame == "parent":
        mount = frames.mount.transform()
        return frames.parent, frames.mount if own is None else pose_of(mount.then(own.transform()))
    if not frames.optical and frames.turned:
        turn = frames.optical_pose.transform()
        return frames.sensor, pose_of(turn if own is None else turn.then(own.transform()))
    if not frames.optical:
        raise ShapeProblem("missing-key", "the sensor has no optical frame", ("frame",), "give it one: optical")
    return frames.optical, own


def _replicas(entry: Mapping[str, Any]) -> Replicas:
    if not 1 <= entry["count"] <= MAX_COPIES:
        message = f"a count is 1 to {MAX_COPIES:,}, not {entry['count']}"
        raise ShapeProblem("wrong-value", message, ("replicate", "count"), "correct it")
    step = pose_of_entry(entry)
    if sum(angle != 0 for angle in step.rpy) > 1:
        # MuJoCo multiplies the angles by the number of the copy, which is no steady turn where there are several.
        message = "copies turn about one axis: one of roll, pitch, yaw"
        raise ShapeProblem("wrong-value", message, ("replicate", "rpy"), "turn the element itself with its own rpy")
    return Replicas(entry["count"], step)
