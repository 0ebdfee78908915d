"""Build: the model made from a plain tree that has the right shape.

A tree may still mean nothing sensible (a link nobody attached, an axis of zero); that is for the rules to say. Build
reports only what keeps a value from being made at all.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..diagnostic import Diagnostic, Related, did_you_mean, error
from ..model import (
    NODE,
    ROBOT_STATE_PUBLISHER,
    SENSOR_ELEMENT,
    STATIC_TRANSFORM_PUBLISHER,
    TEMPLATE_ELEMENT,
    UNPUBLISHED,
    Actuator,
    Edge,
    Joint,
    JointPose,
    Link,
    Output,
    Pose,
    Publisher,
    Robot,
    Sensor,
    ServoGroup,
    Simulated,
    Source,
)
from ..tree import Map, Path, locate
from .elements import Frames, build_elements
from .inertials import build_inertial
from .shapes import ShapeProblem, build_shape
from .values import dynamics_of, limit_of, mimic_of, pose_of_entry, vector_of

# REP 103, "Suffix Frames": from a body frame to its image frame.
OPTICAL_RPY = (-math.pi / 2, 0.0, -math.pi / 2)

_ROBOT_STATE_PUBLISHER = Publisher(ROBOT_STATE_PUBLISHER, ROBOT_STATE_PUBLISHER)


class Built(NamedTuple):
    """The model (None after an error), where each joint, link and pose was written, and what is wrong.

    ``places`` is keyed by kind and name: ("joint", "lidar_joint") -> ("sensors", "lidar").
    """

    robot: Robot | None
    places: dict[tuple[str, str], Path]
    diagnostics: list[Diagnostic]


def build(tree: Map) -> Built:
    """Return the model of a tree that ``validate`` found nothing wrong with."""
    builder = _Builder(tree)
    robot = builder.robot()
    return Built(None if builder.diagnostics else robot, builder.places, builder.diagnostics)


class _Builder:
    """Reads one tree; collects what is wrong."""

    def __init__(self, tree: Map) -> None:
        self.tree = tree
        self.places: dict[tuple[str, str], Path] = {}
        self.diagnostics: list[Diagnostic] = []
        self.nodes = {name: _node(name, entry) for name, entry in self.section("publishers").items()}

    def section(self, name: str) -> dict[str, Any]:
        """Return a section of the tree, empty if it is left out."""
        return self.tree.get(name) or {}

    def problem(self, rule: str, message: str, path: Path, help: str = "", related: tuple[Related, ...] = ()) -> None:
        place = locate(self.tree, path)
        self.diagnostics.append(error(rule, message, place.span, help, [*related, *place.stack()]))

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

    def robot(self) -> Robot:
        tree = self.tree
        links = [self.link(name, entry or {}) for name, entry in sorted(self.section("links").items())]
        joints = [self.joint(name, entry) for name, entry in self.section("joints").items()]
        sensors: list[Sensor] = []
        for name, entry in self.section("sensors").items():
            sensor, mounts = self.sensor(name, entry)
            sensors.append(sensor)
            joints += mounts
        links += self.frames_of_sensors(sensors)
        servos = tuple(self.servo_group(name, entry) for name, entry in sorted(self.section("servos").items()))
        poses = [self.pose(name, entry, servos) for name, entry in sorted(self.section("poses").items())]
        return Robot(
            name=tree["robot"],
            links=tuple(links),
            joints=tuple(joints),
            sensors=tuple(sensors),
            edges=tuple(self.edge(index, entry) for index, entry in enumerate(tree.get("edges") or ())),
            publishers=tuple(self.nodes[name] for name in sorted(self.nodes)),
            servos=servos,
            poses=tuple(poses),
            outputs=tuple(self.output(name, entry) for name, entry in sorted(self.section("outputs").items())),
            modes=tuple(sorted(self.section("modes"))),
            disabled_contacts=tuple(
                (pair["links"][0], pair["links"][1]) for pair in tree.get("disabled_contacts") or ()
            ),
            source=_source(tree.get("source")),
        )

    def link(self, name: str, entry: dict[str, Any]) -> Link:
        path: Path = ("links", name)
        self.place("link", name, path)
        source = _source(entry.get("source"))
        visual = tuple(self.shapes(entry.get("visual") or (), (*path, "visual"), source))
        collision = tuple(self.shapes(entry.get("collision") or (), (*path, "collision"), source))
        inertial = None
        if "inertial" in entry:
            try:
                inertial = build_inertial(entry["inertial"], {"visual": visual, "collision": collision})
            except ShapeProblem as problem:
                self.misfit(problem, (*path, "inertial"), f' (link "{name}" inertial)')
        return Link(name, inertial, visual, collision, source)

    def shapes(self, entries: Any, path: Path, source: Source) -> list[Any]:
        made = []
        for index, entry in enumerate(entries):
            own = _source(entry["source"]) if "source" in entry else source
            try:
                made.append(build_shape(entry, pose_of_entry(entry), own.note if own.status == "stand_in" else ""))
            except ShapeProblem as problem:
                self.misfit(problem, (*path, index))
        return made

    def joint(self, name: str, entry: dict[str, Any]) -> Joint:
        path: Path = ("joints", name)
        self.place("joint", name, path)
        actuator = entry.get("actuator")
        return Joint(
            name=name,
            type=entry["type"],
            parent=entry["parent"],
            child=entry["child"],
            origin=pose_of_entry(entry),
            axis=vector_of(entry.get("axis"), (1.0, 0.0, 0.0)),
            limit=limit_of(entry.get("limit")),
            mimic=mimic_of(entry.get("mimic")),
            dynamics=dynamics_of(entry.get("dynamics")),
            actuator=None if actuator is None else Actuator(float(actuator["kp"]), float(actuator.get("kv", 0))),
            publisher=self.publisher(entry, path),
            source=_source(entry.get("source")),
        )

    def sensor(self, name: str, entry: dict[str, Any]) -> tuple[Sensor, list[Joint]]:
        """Return a sensor and the fixed joints of its frame and its optical frame."""
        path: Path = ("sensors", name)
        frame, source = entry["frame"], _source(entry.get("source"))
        joint = entry.get("joint", f"{frame}_joint")
        self.place("joint", joint, path)
        publisher = self.publisher(entry, path)
        mount = pose_of_entry(entry)
        mounts = [Joint(joint, "fixed", entry["parent"], frame, mount, publisher=publisher, source=source)]
        optical = entry.get("optical")
        frames = Frames(frame, mount, entry["parent"], optical["frame"] if optical else "")
        made = Sensor(name, entry["type"], frame, joint, frames.optical, source, self.elements(name, entry, frames))
        if optical is None:
            return made, mounts
        inner = (*path, "optical")
        optical_joint = optical.get("joint", f"{optical['frame']}_joint")
        self.place("joint", optical_joint, inner)
        pose = Pose(vector_of(optical.get("xyz")), vector_of(optical.get("rpy"), OPTICAL_RPY))
        if "publisher" in optical:
            publisher = self.publisher(optical, inner)
        elif publisher.kind == STATIC_TRANSFORM_PUBLISHER:
            publisher = Publisher(STATIC_TRANSFORM_PUBLISHER, f"{publisher.name}_optical")
        mounts.append(Joint(optical_joint, "fixed", frame, optical["frame"], pose, publisher=publisher, source=source))
        return made, mounts

    def elements(self, name: str, entry: dict[str, Any], frames: Frames) -> tuple[Simulated, ...]:
        """Return what a simulation has of a sensor; two elements of a kind with one name are a problem."""
        path: Path = ("sensors", name, "mjcf")
        made: list[Simulated] = []
        try:
            for element in build_elements(name, entry.get("mjcf") or (), frames):
                if element.kind != TEMPLATE_ELEMENT:
                    self.place(f"MuJoCo {element.element}", element.name, (*path, len(made)))
                if element.kind == SENSOR_ELEMENT and element.pose is not None:
                    self.place("MuJoCo site", element.site, (*path, len(made)))
                made.append(element)
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

    def publisher(self, entry: dict[str, Any], path: Path) -> Publisher:
        said = entry.get("publisher", ROBOT_STATE_PUBLISHER)
        if isinstance(said, dict):
            if "none" in said:
                return Publisher(UNPUBLISHED, about=said["none"])
            return Publisher(STATIC_TRANSFORM_PUBLISHER, said[STATIC_TRANSFORM_PUBLISHER], "tf2_ros")
        if said == ROBOT_STATE_PUBLISHER:
            return _ROBOT_STATE_PUBLISHER
        return self.node(said, (*path, "publisher"))

    def node(self, name: str, path: Path) -> Publisher:
        if name in self.nodes:
            return self.nodes[name]
        known = [*self.nodes, ROBOT_STATE_PUBLISHER]
        self.problem("unknown-publisher", f'there is no publisher "{name}"', path, did_you_mean(name, known))
        return _ROBOT_STATE_PUBLISHER

    def edge(self, index: int, entry: dict[str, Any]) -> Edge:
        path: Path = ("edges", index)
        publisher = Publisher(UNPUBLISHED)
        if "publisher" in entry:
            publisher = self.node(entry["publisher"], (*path, "publisher"))
        pose = pose_of_entry(entry) if "xyz" in entry or "rpy" in entry else None
        moving, when = entry.get("moving", True), entry.get("when", "")
        return Edge(entry["parent"], entry["child"], publisher, moving, when, pose, _source(entry.get("source")))

    def servo_group(self, name: str, entry: dict[str, Any]) -> ServoGroup:
        low, high = entry["pulse_range"]
        if not low < high:
            message = f"the pulse range goes from {low} to {high}"
            self.problem("pulse-range", message, ("servos", name, "pulse_range"), "give the smaller pulse first")
        elif not low <= entry["zero_pulse"] <= high:
            message = f"the zero pulse {entry['zero_pulse']} is outside the pulse range {low} to {high}"
            self.problem("pulse-range", message, ("servos", name, "zero_pulse"), "correct one of the two")
        flipped, source = entry.get("flipped", False), _source(entry.get("source"))
        rad = float(entry["rad_per_pulse"])
        if rad == 0:
            message = "a pulse of no angle moves nothing"
            self.problem("pulse-range", message, ("servos", name, "rad_per_pulse"), "give the angle of one pulse")
        return ServoGroup(name, tuple(entry["joints"]), rad, entry["zero_pulse"], flipped, (low, high), source)

    def pose(self, name: str, entry: dict[str, Any], servos: tuple[ServoGroup, ...]) -> JointPose:
        positions = {joint: float(value) for joint, value in sorted(entry.get("positions", {}).items())}
        pulses = dict(sorted(entry.get("pulses", {}).items()))
        for joint, pulse in pulses.items():
            path: Path = ("poses", name, "pulses", joint)
            group = next((group for group in servos if joint in group.joints), None)
            if group is None:
                known = [joint for group in servos for joint in group.joints]
                message = f'no servo group has the joint "{joint}"'
                self.problem("unknown-servo", message, path, did_you_mean(joint, known))
                continue
            low, high = group.pulse_range
            if not low <= pulse <= high:
                self.problem("pulse-range", f"the pulse {pulse} does not exist: {low} to {high}", path, "correct it")
            if joint in positions:
                self.problem("duplicate-name", f'"{joint}" has a position and a pulse', path, "give one of them")
            positions[joint] = group.radians(pulse)
        return JointPose(name, positions, pulses, _source(entry.get("source")))

    def output(self, name: str, entry: dict[str, Any]) -> Output:
        backend = entry.get("backend", "template" if "template" in entry else name)
        options = {key: value for key, value in entry.items() if key not in ("file", "backend")}
        return Output(name, backend, entry["file"], options)


def _node(name: str, entry: dict[str, Any] | None) -> Publisher:
    entry = entry or {}
    return Publisher(NODE, entry.get("node", name), entry.get("package", ""), entry.get("about", ""))


def _source(entry: dict[str, Any] | None) -> Source:
    entry = entry or {}
    return Source(entry.get("status", ""), entry.get("note", ""), entry.get("measured", ""))
