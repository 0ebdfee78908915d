"""Lower: the model made from a tree of the right shape.

Each section is lowered by its record (``sections``): those of plug-ins, those of the folders for ROS and MuJoCo, and
those in ``CORE`` here. A tree may still make no sense (a link that nothing is attached to): that is for the rules to
report. Lowering reports only what keeps a value from being made.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Hashable, Mapping
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any, NamedTuple, TypeVar

from rosorin_compile.model import STATIC_TRANSFORM_PUBLISHER, Edge, Joint, Link, Output, Publisher, Robot, Sensor
from rosorin_compile.model.drive import ROLES, Drive
from rosorin_compile.model.joint import NODE, UNPUBLISHED, Limit, SafetyController
from rosorin_compile.model.link import Source
from rosorin_compile.model.robot import JointPose
from rosorin_compile.model.sections import ENTRIES, ITEMS, ONE, Section
from rosorin_compile.model.servos import ServoGroup
from rosorin_compile.model.shape import Material
from rosorin_compile.model.simulation import Marked, Root
from rosorin_compile.source.diagnostics import Diagnostic, Related, error
from rosorin_compile.source.files import is_file
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.rule_registry import FILES, FRAMES, JOINTS, POSES, Rule
from rosorin_compile.source.tree import Map, Path, locate
from rosorin_compile.source.wording import listed

from ..accepting import accepted, names_at
from ..expand.provenance import problem_at
from ..expand.scope import Scope
from ..misnamed import name_meant
from ..schema import backend_of
from .publishing import Publishing, node, publishing
from .records import (
    Problem,
    entries_of,
    other_values,
    pose_of_entry,
    record_of,
    renamed_values,
    source_of,
    values_of,
    vector_of,
)
from .sections import lower_sections, with_sections
from .sensors import frames_of_sensors, lower_sensor
from .shapes import RULES as _OF_SHAPES
from .shapes import ShapeProblem, lower_inertial, lower_shape

T = TypeVar("T")

RULES = (
    Rule(
        "duplicate-name",
        "Two entries have the same name, in one file, in two, or by two uses of a part.",
        "Rename or remove one; give one use or include another `prefix`.",
        FILES,
    ),
    Rule("unknown-publisher", "A publisher is not in `publishers`.", "Correct the name, or add the node.", FRAMES),
    Rule(
        "drive-kind",
        "A drive says no kind of base, or several.",
        "One of `mecanum`, `differential`, `omni`, `tricycle`, `ackermann`, with its wheels.",
        JOINTS,
    ),
    Rule(
        "unknown-servo",
        "No servo group has this joint, or there is no such group.",
        "Correct the name, or add it to a group.",
        POSES,
    ),
    Rule("pulse-range", "A pulse is outside the range of its servo.", "Correct the pulse or the range.", POSES),
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
    lowering = Lowering(tree, scope)
    robot = lowering.robot()
    refused = [problem for problem in lowering.diagnostics if not accepted(tree, problem, _ACCEPTABLE)]
    return Lowered(None if refused else robot, lowering.places, lowering.diagnostics)


class Lowering:
    """The lowering of one tree: the links, joints and edges made so far, their places, and problems.

    Called, it reports a problem.
    """

    def __init__(self, tree: Map, scope: Scope | None) -> None:
        self.tree = tree
        self.scope = scope
        self.places: dict[tuple[str, str], Path] = {}
        self.frames: dict[str, tuple[str, Path]] = {}
        self.diagnostics: list[Diagnostic] = []
        # What was made of a piece of the tree, which many links and joints may share.
        self.made: dict[Hashable, Any] = {}
        self.nodes: dict[str, Publisher] = {}
        self.edges: list[Edge] = []
        self.links: list[Link] = []
        self.joints: list[Joint] = []
        self.servos: tuple[ServoGroup, ...] = ()

    def __call__(
        self, rule: str, message: str, path: Path, help: str = "", related: tuple[Related, ...] = (), key: bool = False
    ) -> None:
        """Report a problem at a path of the tree, or at the last key of the path."""
        diagnostic = problem_at(self.scope, self.tree, path, rule, message, help, related, key)
        self.diagnostics.append(replace(diagnostic, of=names_at(self.tree, path)))

    def misfit(self, problem: ShapeProblem, path: Path, where: str = "") -> None:
        self(problem.rule, problem.message + where, (*path, *problem.path), problem.help)

    def place(self, kind: str, name: str, path: Path) -> None:
        """Remember where a name is defined; a second definition is a problem."""
        taken = self.places.get((kind, name))
        if taken is None:
            self.places[kind, name] = path
            return
        related = (Related("first defined here", locate(self.tree, taken, key=True).span),)
        self("duplicate-name", f'the {kind} "{name}" is defined twice', path, "rename one", related)

    def place_joint(self, name: str, path: Path, frame: str, frame_path: Path) -> None:
        """Remember where a joint and its child frame are defined; report a frame that has a joint already."""
        taken = self.frames.setdefault(name, (frame, frame_path))
        if taken == (frame, frame_path) or taken[0] != frame:
            self.place("joint", name, path)
            return
        first = taken[1]
        related = (Related("first said here", locate(self.tree, first).span),)
        message = f'frame "{frame}" is defined twice: by {owner_of_frame(first)} and by {owner_of_frame(frame_path)}'
        help = "give each a frame of its own"
        if first[0] == "joints":
            help = f'a sensor brings the joint to its frame along: remove joint "{name}", or name another frame'
        self("duplicate-name", message, frame_path, help, related)

    def broken(self, diagnostic: Diagnostic, section: str) -> None:
        """Report a problem of the plug-in of a section, where the description has that section."""
        place = locate(self.tree, (section,), key=True)
        self.diagnostics.append(replace(diagnostic, span=place.span, related=place.stack()))

    def robot(self) -> Robot:
        """Return the robot with what sections of plug-ins add to it."""
        values, sections = lower_sections(CORE, self.tree, self, self.broken)
        values |= {"name": self.tree["robot"], "urdf_elements": self.urdf_elements(), "sections": sections}
        values |= {"links": tuple(self.links), "joints": tuple(self.joints), "edges": tuple(self.edges)}
        if "root" in values:
            values["root_in_world"] = values.pop("root")
        robot = Robot(**{name: value for name, value in values.items() if value is not None})
        return with_sections(robot, self.tree, self.broken, self.place) if sections.values else robot

    def urdf_elements(self) -> tuple[str, ...]:
        """Return the elements of XML at the top of the robot, those of its sensors after its own."""
        texts = list(self.tree.get("urdf_elements") or ())
        for name, entry in (self.tree.get("sensors") or {}).items():
            for index, text in enumerate(entry.get("urdf_elements") or ()):
                self.places["urdf_element", str(len(texts))] = ("sensors", name, "urdf_elements", index)
                texts.append(text)
        return tuple(texts)

    def once(self, key: Hashable, make: Callable[[], T]) -> T:
        """Return what is made of a piece of the tree, named by its identity, once for all that share it."""
        if key not in self.made:
            self.made[key] = make()
        known: T = self.made[key]
        return known

    def link(self, name: str, entry: dict[str, Any]) -> Link:
        """Return a link; keys that are called as a field of ``Link`` need nothing here."""
        path: Path = ("links", name)
        self.place("link", name, path)
        if not entry:
            return Link(name)
        source = source_of(entry.get("source"))
        visual = self.shapes(entry.get("visual") or (), (*path, "visual"), source)
        collision = self.shapes(entry.get("collision") or (), (*path, "collision"), source)
        inertial = None
        if "inertial" in entry:
            own = {"visual": visual, "collision": collision}
            try:
                inertial = self.once(
                    (id(entry["inertial"]), id(visual), id(collision)),
                    lambda: lower_inertial(entry["inertial"], own, lambda file: self.mesh_file(file, path)),
                )
            except ShapeProblem as problem:
                self.misfit(problem, (*path, "inertial"), f' (link "{name}" inertial)')
        marked = tuple(
            Marked(tag, one, pose_of_entry(mark or {}), other_values(mark or {}, ("xyz", "rpy", "source")))
            for key, tag in (("sites", "site"), ("cameras", "camera"), ("lights", "light"))
            for one, mark in (entry.get(key) or {}).items()
        )
        return record_of(
            Link, entry, name=name, inertial=inertial, visual=visual, collision=collision, source=source, marked=marked
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

    def shapes(self, entries: Any, path: Path, source: Source) -> tuple[Any, ...]:
        """Return the shapes of a list; of one that several links share the same ones, unless something is wrong."""
        if not entries:
            return ()
        key = (id(entries), source)
        known: tuple[Any, ...] | None = self.made.get(key)
        if known is not None:
            return known
        before, shapes = len(self.diagnostics), []
        for index, entry in enumerate(entries):
            own = source_of(entry["source"]) if "source" in entry else source
            stand_in = own.note if own.status == "stand_in" else ""
            try:
                shapes.append(lower_shape(entry, pose_of_entry(entry), stand_in, self.accepts((*path, index))))
            except ShapeProblem as problem:
                self.misfit(problem, (*path, index))
        made = tuple(shapes)
        if len(self.diagnostics) == before:
            self.made[key] = made
        else:
            self.made[id(made), "kept"] = made  # no other list gets its identity
        return made

    def accepts(self, path: Path) -> Callable[[ShapeProblem], bool]:
        """Return a function that returns True, and records the problem, if the description accepts it at a path."""

        def accept(problem: ShapeProblem) -> bool:
            refused = replace(error(problem.rule, "", None), of=names_at(self.tree, path))
            if not accepted(self.tree, refused, _ACCEPTABLE):
                return False
            self.misfit(problem, path)
            return True

        return accept

    def joint(self, name: str, entry: dict[str, Any]) -> Joint:
        """Return a joint; keys that are called as a field of ``Joint`` need nothing here."""
        path: Path = ("joints", name)
        self.place_joint(name, path, entry["child"], (*path, "child"))
        axis, limit = entry.get("axis"), entry.get("limit")
        by = publishing(entry, path, self.nodes, self)
        given: dict[str, Any] = {"axis": self.once(id(axis), lambda: vector_of(axis, (1.0, 0.0, 0.0)))}
        if limit is not None:
            given["limit"] = self.once(id(limit), lambda: record_of(Limit, limit))
        if "safety_controller" in entry:
            given["safety"] = record_of(SafetyController, entry["safety_controller"])
        joint = record_of(Joint, entry, name=name, publisher=by.always, **given)
        self.take_turns(joint, by)
        return joint

    def take_turns(self, joint: Joint, publishing: Publishing) -> None:
        """Make edges of the publishers of a joint that take turns."""
        for turn in publishing.turns:
            self.places["edge", str(len(self.edges))] = turn.path
            moving = not joint.is_fixed and turn.publisher.kind != STATIC_TRANSFORM_PUBLISHER
            turned = Edge(joint.parent, joint.child, turn.publisher, moving, turn.when, joint.origin)
            self.edges.append(replace(turned, source=joint.source, joint=joint.name))


def owner_of_frame(path: Path) -> str:
    """Return in words what defines a frame, given the path of its name: a joint, or (an optical frame of) a sensor."""
    what = "joint" if path[0] == "joints" else "sensor"
    return f'{"the optical frame of " if "optical" in path[2:] else ""}{what} "{path[1]}"'


# Sections of the core. Each function takes the tree and the lowering; sections that refer to others come after them.


def _publishers(tree: Mapping[str, Any], lowering: Lowering) -> tuple[Publisher, ...]:
    for name, entry in entries_of(tree, "publishers"):
        lowering.nodes[name] = record_of(Publisher, entry, kind=NODE, name=(entry or {}).get("node", name))
    return tuple(lowering.nodes.values())


def _edges(tree: Mapping[str, Any], lowering: Lowering) -> None:
    for index, entry in enumerate(tree["edges"]):
        publisher = Publisher(UNPUBLISHED)
        if "publisher" in entry:
            publisher = node(entry["publisher"], ("edges", index, "publisher"), lowering.nodes, lowering)
        pose = pose_of_entry(entry) if "xyz" in entry or "rpy" in entry else None
        moving = entry.get("moving", True)
        lowering.edges.append(record_of(Edge, entry, publisher=publisher, moving=moving, pose=pose, joint=""))


def _links(tree: Mapping[str, Any], lowering: Lowering) -> None:
    lowering.links += [lowering.link(name, entry or {}) for name, entry in entries_of(tree, "links")]


def _joints(tree: Mapping[str, Any], lowering: Lowering) -> None:
    lowering.joints += [lowering.joint(name, entry) for name, entry in entries_of(tree, "joints")]


def _sensors(tree: Mapping[str, Any], lowering: Lowering) -> tuple[Sensor, ...]:
    sensors = []
    for name, entry in entries_of(tree, "sensors"):
        sensor, joints = lower_sensor(lowering, name, entry)
        sensors.append(sensor)
        lowering.joints += joints
    lowering.links += frames_of_sensors(lowering, sensors)
    return tuple(sensors)


def _servos(tree: Mapping[str, Any], lowering: Lowering) -> tuple[ServoGroup, ...]:
    for name, entry in entries_of(tree, "servos"):
        low, high = entry["pulse_range"]
        if not low < high:
            message = f"the pulse range goes from {low} to {high}"
            lowering("pulse-range", message, ("servos", name, "pulse_range"), "give the smaller pulse first")
        elif not low <= entry["zero_pulse"] <= high:
            message = f"the zero pulse {entry['zero_pulse']} is outside the pulse range {low} to {high}"
            lowering("pulse-range", message, ("servos", name, "zero_pulse"), "correct one of the two")
        if float(entry["rad_per_pulse"]) == 0:
            message = "a pulse of no angle moves nothing"
            lowering("pulse-range", message, ("servos", name, "rad_per_pulse"), "give the angle of one pulse")
        group = record_of(ServoGroup, entry, name=name, flipped=entry.get("flipped", False))
        lowering.servos = (*lowering.servos, group)
    return lowering.servos


def _drive(tree: Mapping[str, Any], problem: Problem) -> Drive | None:
    entry = tree["drive"]
    kinds = [kind for kind in ROLES if kind in entry]
    if len(kinds) != 1:
        message = f"drive has one of {', '.join(ROLES)}; this one has {listed(kinds) or 'none'}"
        problem("drive-kind", message, ("drive",), "say which kind of base it is, and its wheels")
        return None
    wheels = entry[kinds[0]]
    joints = {
        role: (str(wheels[role]),) if isinstance(wheels[role], str) else tuple(map(str, wheels[role]))
        for role in ROLES[kinds[0]]
        if role in wheels
    }
    return record_of(Drive, entry, kind=kinds[0], joints=joints)


def _poses(tree: Mapping[str, Any], lowering: Lowering) -> tuple[JointPose, ...]:
    # Simulators begin at the first one, which an import keeps.
    imported = source_of(tree.get("source")).status == "imported"
    entries = tree["poses"].items() if imported else entries_of(tree, "poses")
    return tuple(_pose(name, entry, lowering) for name, entry in entries)


def _pose(name: str, entry: Mapping[str, Any], lowering: Lowering) -> JointPose:
    positions = {joint: float(value) for joint, value in sorted(entry.get("positions", {}).items())}
    pulses = dict(sorted(entry.get("pulses", {}).items()))
    for joint, position in _positions_of(name, pulses, lowering).items() if pulses else ():
        if joint in positions:
            path: Path = ("poses", name, "pulses", joint)
            lowering("duplicate-name", f'"{joint}" has a position and a pulse', path, "give one of them")
        positions[joint] = position
    base = pose_of_entry(entry["base"]) if "base" in entry else None
    controls = {actuator: float(value) for actuator, value in sorted(entry.get("controls", {}).items())}
    return record_of(JointPose, entry, name=name, positions=positions, pulses=pulses, base=base, controls=controls)


def _positions_of(pose: str, pulses: Mapping[str, int], lowering: Lowering) -> dict[str, float]:
    """Return the positions (rad or m) of the pulses of a pose, by joint."""
    positions: dict[str, float] = {}
    for joint, pulse in pulses.items():
        path: Path = ("poses", pose, "pulses", joint)
        group = next((group for group in lowering.servos if joint in group.joints), None)
        if group is None:
            known = [joint for group in lowering.servos for joint in group.joints]
            joints = lowering.tree.get("joints") or {}
            if joint in joints and not {*known} <= joints.keys():
                continue  # a servo group misspells its name, which is reported
            help = name_meant(lowering.tree, path, joint, known)
            lowering("unknown-servo", f'no servo group has the joint "{joint}"', path, help, key=True)
            continue
        low, high = group.pulse_range
        if not low <= pulse <= high:
            lowering("pulse-range", f"the pulse {pulse} does not exist: {low} to {high}", path, "correct it")
        positions[joint] = group.radians(pulse)
    return positions


def _outputs(tree: Mapping[str, Any], _: Problem) -> tuple[Output, ...]:
    return tuple(
        Output(
            name,
            entry.get("backend", backend_of(name, entry)),
            entry["file"],
            {key: value for key, value in entry.items() if key not in ("file", "backend")},
        )
        for name, entry in entries_of(tree, "outputs")
    )


def _root(tree: Mapping[str, Any], _: Problem) -> Root:
    entry = tree["root"]
    words = {"damping": "damping", "friction": "frictionloss", "armature": "armature"}
    values = values_of(entry.get("mjcf")) | renamed_values(entry, words)
    return record_of(Root, entry, values=values, placed="xyz" in entry or "rpy" in entry)


CORE: tuple[Section[Any], ...] = (
    Section("publishers", Publisher, lower=_publishers),
    Section("edges", Edge, form=ITEMS, lower=_edges),
    Section("links", Link, lower=_links),
    Section("joints", Joint, lower=_joints),
    Section("sensors", Sensor, lower=_sensors),
    Section("servos", ServoGroup, lower=_servos),
    Section("drive", Drive, form=ONE, lower=_drive),
    Section("poses", JointPose, lower=_poses),
    Section("outputs", Output, lower=_outputs),
    Section("modes", form=ENTRIES, lower=lambda tree, _: tuple(name for name, _ in entries_of(tree, "modes"))),
    Section("source", Source, form=ONE, lower=lambda tree, _: source_of(tree["source"])),
    Section(
        "materials",
        Material,
        lower=lambda tree, _: tuple(
            record_of(Material, entry, name=name) for name, entry in entries_of(tree, "materials")
        ),
    ),
    Section("root", Root, form=ONE, lower=_root),
    Section(
        "disabled_contacts",
        form=ITEMS,
        lower=lambda tree, _: tuple((pair["links"][0], pair["links"][1]) for pair in tree["disabled_contacts"]),
    ),
    Section("mjcf_elements", form=ITEMS, lower=lambda tree, _: tuple(tree["mjcf_elements"])),
)
