"""Lower: make the robot from a tree that ``validate`` accepts.

Each section is converted by its record: those of plug-ins, those of the folders for ROS and MuJoCo, and ``CORE`` here.
Only what prevents a value from being made is reported; whether the robot makes sense is for the rules.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from rosorin_compile.model import Edge, Joint, Link, Output, Publisher, Robot, Sensor
from rosorin_compile.model.drive import ROLES, Drive
from rosorin_compile.model.joint import NODE, UNPUBLISHED
from rosorin_compile.model.link import Source
from rosorin_compile.model.robot import JointPose
from rosorin_compile.model.sections import ITEMS, ONE, Section
from rosorin_compile.model.servos import ServoGroup
from rosorin_compile.model.shape import Material
from rosorin_compile.model.simulation import Root
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.rule_registry import FILES, FRAMES, JOINTS, POSES, Rule
from rosorin_compile.source.tree import Map, Path
from rosorin_compile.source.wording import listed

from ..expand.scope import Scope
from ..schema import backend_of
from ..suggestions import suggest_name
from ..suppressions import accepted
from . import links
from .joints import add_frames, lower_joint, lower_sensor, node
from .lowering import Lowering
from .records import Problem, entries_of, pose_of_entry, record_of, renamed_values, source_of, values_of
from .sections import lower_sections, with_sections

RULES = (
    Rule("duplicate-name", "Two entries have the same name.", "Rename one, or use another `prefix`.", FILES),
    Rule("unknown-publisher", "A publisher is not in `publishers`.", "Correct the name, or add the node.", FRAMES),
    Rule("drive-kind", "A drive has no kind of base, or several.", "Write one, such as `differential`.", JOINTS),
    Rule("unknown-servo", "No servo group has this joint.", "Correct the name, or add it to a group.", POSES),
    Rule("pulse-range", "A pulse is outside the range of its servo.", "Correct the pulse or the range.", POSES),
)
_ACCEPTABLE = {rule.id: rule for rule in links.RULES if rule.accept}


class Lowered(NamedTuple):
    """The robot (None after an error), where each joint, link and pose is defined, and problems.

    ``places`` is keyed by kind and name: ("joint", "lidar_joint") -> ("sensors", "lidar"); an edge of a publisher of a
    joint that takes turns is named by its index in ``Robot.edges``.
    """

    robot: Robot | None
    places: dict[tuple[str, str], Path]
    diagnostics: list[Diagnostic]


def lower(tree: Map, scope: Scope | None = None) -> Lowered:
    """Return the robot of a tree without errors; ``scope``, if known, is that of its expressions."""
    lowering = Lowering(tree, scope, _ACCEPTABLE)

    def report(diagnostic: Diagnostic, section: str) -> None:
        """Report a problem of the plug-in of a section, at that section."""
        place = tree.locate((section,), key=True)
        lowering.diagnostics.append(replace(diagnostic, span=place.span, related=place.stack()))

    values, sections = lower_sections(CORE, tree, lowering, report)
    values |= {"name": tree["robot"], "urdf_elements": _urdf_elements(tree, lowering), "sections": sections}
    values |= {"links": tuple(lowering.links), "joints": tuple(lowering.joints), "edges": tuple(lowering.edges)}
    if "root" in values:
        values["root_in_world"] = values.pop("root")
    robot = Robot(**{name: value for name, value in values.items() if value is not None})
    if sections.values:
        robot = with_sections(robot, tree, report, lowering.place)
    refused = [problem for problem in lowering.diagnostics if not accepted(tree, problem, _ACCEPTABLE)]
    return Lowered(None if refused else robot, lowering.places, lowering.diagnostics)


def _urdf_elements(tree: Map, lowering: Lowering) -> tuple[str, ...]:
    texts = list(tree.get("urdf_elements") or ())
    for name, entry in (tree.get("sensors") or {}).items():
        for index, text in enumerate(entry.get("urdf_elements") or ()):
            lowering.places["urdf_element", str(len(texts))] = ("sensors", name, "urdf_elements", index)
            texts.append(text)
    return tuple(texts)


# Conversions of sections: each takes the tree and the lowering. A section is after those that it refers to.


def _publishers(tree: Mapping[str, Any], lowering: Lowering) -> tuple[Publisher, ...]:
    for name, entry in entries_of(tree, "publishers"):
        lowering.nodes[name] = record_of(Publisher, entry, kind=NODE, name=(entry or {}).get("node", name))
    return tuple(lowering.nodes.values())


def _edges(tree: Mapping[str, Any], lowering: Lowering) -> None:
    for index, entry in enumerate(tree["edges"]):
        publisher = Publisher(UNPUBLISHED)
        if "publisher" in entry:
            publisher = node(lowering, entry["publisher"], ("edges", index, "publisher"))
        pose = pose_of_entry(entry) if "xyz" in entry or "rpy" in entry else None
        moving = entry.get("moving", True)
        lowering.edges.append(record_of(Edge, entry, publisher=publisher, moving=moving, pose=pose, joint=""))


def _links(tree: Mapping[str, Any], lowering: Lowering) -> None:
    lowering.links += [links.lower_link(lowering, name, entry or {}) for name, entry in entries_of(tree, "links")]


def _joints(tree: Mapping[str, Any], lowering: Lowering) -> None:
    lowering.joints += [lower_joint(lowering, name, entry) for name, entry in entries_of(tree, "joints")]


def _sensors(tree: Mapping[str, Any], lowering: Lowering) -> tuple[Sensor, ...]:
    sensors = [lower_sensor(lowering, name, entry) for name, entry in entries_of(tree, "sensors")]
    add_frames(lowering, sensors)
    return tuple(sensors)


def _servos(tree: Mapping[str, Any], lowering: Lowering) -> tuple[ServoGroup, ...]:
    for name, entry in entries_of(tree, "servos"):
        path: Path = ("servos", name)
        low, high = entry["pulse_range"]
        if not low < high:
            message = f"the pulse range goes from {low} to {high}"
            lowering("pulse-range", message, (*path, "pulse_range"), "give the smaller pulse first")
        elif not low <= entry["zero_pulse"] <= high:
            message = f"the zero pulse {entry['zero_pulse']} is outside the pulse range {low} to {high}"
            lowering("pulse-range", message, (*path, "zero_pulse"), "correct one of the two")
        if float(entry["rad_per_pulse"]) == 0:
            message = "a pulse of no angle moves nothing"
            lowering("pulse-range", message, (*path, "rad_per_pulse"), "give the angle of one pulse")
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
    wheels = {role: entry[kinds[0]][role] for role in ROLES[kinds[0]] if role in entry[kinds[0]]}
    joints = {role: (names,) if isinstance(names, str) else tuple(map(str, names)) for role, names in wheels.items()}
    return record_of(Drive, entry, kind=kinds[0], joints=joints)


def _poses(tree: Mapping[str, Any], lowering: Lowering) -> tuple[JointPose, ...]:
    # Simulators begin at the first one, which an import keeps.
    imported = source_of(tree.get("source")).status == "imported"
    entries = tree["poses"].items() if imported else entries_of(tree, "poses")
    return tuple(_pose(name, entry, lowering) for name, entry in entries)


def _pose(name: str, entry: Mapping[str, Any], lowering: Lowering) -> JointPose:
    positions = {key: float(value) for key, value in sorted(entry.get("positions", {}).items())}
    controls = {key: float(value) for key, value in sorted(entry.get("controls", {}).items())}
    pulses = dict(sorted(entry.get("pulses", {}).items()))
    for joint, pulse in pulses.items():
        path: Path = ("poses", name, "pulses", joint)
        position = _position(joint, pulse, path, lowering)
        if position is not None:
            if joint in positions:
                lowering("duplicate-name", f'"{joint}" has a position and a pulse', path, "give one of them")
            positions[joint] = position
    base = pose_of_entry(entry["base"]) if "base" in entry else None
    return record_of(JointPose, entry, name=name, positions=positions, pulses=pulses, base=base, controls=controls)


def _position(joint: str, pulse: int, path: Path, lowering: Lowering) -> float | None:
    group = next((group for group in lowering.servos if joint in group.joints), None)
    if group is None:
        known = [joint for group in lowering.servos for joint in group.joints]
        joints = lowering.tree.get("joints") or {}
        if joint not in joints or joints.keys() >= {*known}:  # else a servo group misspells its name, which is reported
            help = suggest_name(lowering.tree, path, joint, known)
            lowering("unknown-servo", f'no servo group has the joint "{joint}"', path, help, key=True)
        return None
    low, high = group.pulse_range
    if not low <= pulse <= high:
        lowering("pulse-range", f"the pulse {pulse} does not exist: {low} to {high}", path, "correct it")
    return group.radians(pulse)


def _outputs(tree: Mapping[str, Any], _: Problem) -> tuple[Output, ...]:
    outputs = []
    for name, entry in entries_of(tree, "outputs"):
        options = {key: value for key, value in entry.items() if key not in ("file", "backend")}
        outputs.append(Output(name, entry.get("backend", backend_of(name, entry)), entry["file"], options))
    return tuple(outputs)


def _materials(tree: Mapping[str, Any], _: Problem) -> tuple[Material, ...]:
    return tuple(record_of(Material, entry, name=name) for name, entry in entries_of(tree, "materials"))


def _root(tree: Mapping[str, Any], _: Problem) -> Root:
    entry = tree["root"]
    words = {"damping": "damping", "friction": "frictionloss", "armature": "armature"}
    values = values_of(entry.get("mjcf")) | renamed_values(entry, words)
    return record_of(Root, entry, values=values, placed="xyz" in entry or "rpy" in entry)


def _disabled_contacts(tree: Mapping[str, Any], _: Problem) -> tuple[tuple[str, ...], ...]:
    return tuple(tuple(one["links"]) for one in tree["disabled_contacts"])


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
    Section("modes", lower=lambda tree, _: tuple(name for name, _ in entries_of(tree, "modes"))),
    Section("source", Source, form=ONE, lower=lambda tree, _: source_of(tree["source"])),
    Section("materials", Material, lower=_materials),
    Section("root", Root, form=ONE, lower=_root),
    Section("disabled_contacts", form=ITEMS, lower=_disabled_contacts),
    Section("mjcf", form=ITEMS, lower=lambda tree, _: tuple(tree["mjcf"])),
)
