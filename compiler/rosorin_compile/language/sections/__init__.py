"""The built-in sections of descriptions; ``SECTIONS`` defines how each is read and checked.

The folder of a section has its JSON Schema, ``schema.json``, and its conversion code unless that is short. The
``schema.json`` here has shared definitions. The dataclasses are in ``model``, the rules in ``rules``.
"""

from collections.abc import Mapping
from typing import Any

from rosorin_compile.model import Edge, Output, Publisher
from rosorin_compile.model.drive import ROLES, Drive
from rosorin_compile.model.joint import NODE, UNPUBLISHED
from rosorin_compile.model.link import Source
from rosorin_compile.model.robot import JointPose
from rosorin_compile.model.sections import Section
from rosorin_compile.model.servos import ServoGroup
from rosorin_compile.model.shape import Material
from rosorin_compile.model.simulation import Root
from rosorin_compile.source.tree import Path
from rosorin_compile.source.wording import phrase

from ..lower import Lowering, Problem, entries_of, pose_of_entry, record_of, renamed_values, values_of
from ..schema import backend_of
from ..suggestions import suggest_name
from . import joints, links, sensors
from .joints import node


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


def _servos(tree: Mapping[str, Any], lowering: Lowering) -> tuple[ServoGroup, ...]:
    for name, entry in entries_of(tree, "servos"):
        path, zero, (low, high) = ("servos", name), entry["zero_pulse"], entry["pulse_range"]
        if not low < high:
            message = f"the pulse range goes from {low} to {high}"
            lowering("pulse-range", message, (*path, "pulse_range"), "give the smaller pulse first")
        elif not low <= zero <= high:
            message = f"the zero pulse {zero} is outside the pulse range {low} to {high}"
            lowering("pulse-range", message, (*path, "zero_pulse"), "correct one of the two")
        if float(entry["rad_per_pulse"]) == 0:
            message = "the angle of one pulse is zero, so the servo never moves"
            lowering("pulse-range", message, (*path, "rad_per_pulse"), "write the angle of one pulse, in radians")
        group = record_of(ServoGroup, entry, name=name, flipped=entry.get("flipped", False))
        lowering.servos = (*lowering.servos, group)
    return lowering.servos


def _drive(tree: Mapping[str, Any], problem: Problem) -> Drive | None:
    entry = tree["drive"]
    kinds = [kind for kind in ROLES if kind in entry]
    if len(kinds) != 1:
        message = f'"drive" needs exactly one of {", ".join(ROLES)}, but has {phrase(kinds) or "none"}'
        problem("drive-kind", message, ("drive",), 'write one, as in "differential: {left: [JOINT], right: [JOINT]}"')
        return None
    wheels = {role: entry[kinds[0]][role] for role in ROLES[kinds[0]] if role in entry[kinds[0]]}
    return record_of(Drive, {**entry, "joints": wheels}, kind=kinds[0])


def _poses(tree: Mapping[str, Any], lowering: Lowering) -> tuple[JointPose, ...]:
    # Poses of an imported robot keep their order, because simulators start in the first pose.
    imported = record_of(Source, tree.get("source")).status == "imported"
    poses, joints = list[JointPose](), tree.get("joints") or {}
    group_of = {joint: group for group in reversed(lowering.servos) for joint in group.joints}
    for name, entry in tree["poses"].items() if imported else entries_of(tree, "poses"):
        positions = {key: float(value) for key, value in sorted(entry.get("positions", {}).items())}
        controls = {key: float(value) for key, value in sorted(entry.get("controls", {}).items())}
        pulses = dict(sorted(entry.get("pulses", {}).items()))
        for joint, pulse in pulses.items():
            path: Path = ("poses", name, "pulses", joint)
            if joint in group_of:
                low, high = group_of[joint].pulse_range
                if not low <= pulse <= high:
                    message = f'pulse {pulse} of joint "{joint}" is outside the range {low} to {high}'
                    lowering("pulse-range", message, path, 'correct the pulse, or "pulse_range" of the servo group')
                if joint in positions:
                    lowering("duplicate-name", f'joint "{joint}" has a position and a pulse', path, "remove either one")
                positions[joint] = group_of[joint].radians(pulse)
            elif joint not in joints or joints.keys() >= group_of.keys():  # else, a group has an unknown joint
                help = suggest_name(lowering.tree, path, joint, list(group_of))
                lowering("unknown-servo", f'no servo group has the joint "{joint}"', path, help, key=True)
        base = pose_of_entry(entry["base"]) if "base" in entry else None
        numbers = {"positions": positions, "pulses": pulses, "controls": controls}
        poses.append(record_of(JointPose, entry, name=name, base=base, **numbers))
    return tuple(poses)


def _outputs(tree: Mapping[str, Any], _: Problem) -> tuple[Output, ...]:
    outputs = []
    for name, entry in entries_of(tree, "outputs"):
        options = {key: value for key, value in entry.items() if key not in ("file", "backend")}
        outputs.append(Output(name, entry.get("backend", backend_of(name, entry)), entry["file"], options))
    return tuple(outputs)


def _root(tree: Mapping[str, Any], _: Problem) -> Root:
    entry = tree["root"]
    words = {"damping": "damping", "friction": "frictionloss", "armature": "armature"}
    values = values_of(entry.get("mjcf")) | renamed_values(entry, words)
    return record_of(Root, entry, values=values, placed="xyz" in entry or "rpy" in entry)


# A section comes after the sections that it refers to. Rules about several sections are in ``rules.check``.
_RULES = "rosorin_compile.rules"
SECTIONS: tuple[Section[Any], ...] = (
    Section("publishers", Publisher, lower=_publishers, checks=(f"{_RULES}.publishers",)),
    Section("edges", Edge, lower=_edges),
    links.SECTION,
    joints.SECTION,
    Section(
        "urdf_elements",
        lower=lambda tree, lowering: lowering.urdf_elements.extend(tree["urdf_elements"]),
        checks=(f"{_RULES}.urdf_elements",),
    ),
    sensors.SECTION,
    Section("servos", ServoGroup, lower=_servos),
    Section("drive", Drive, lower=_drive, checks=(f"{_RULES}.drive",)),
    Section("poses", JointPose, lower=_poses, checks=(f"{_RULES}.positions",)),
    Section("outputs", Output, lower=_outputs, checks=(f"{_RULES}.outputs",)),
    Section("modes", lower=lambda tree, _: tuple(name for name, _ in entries_of(tree, "modes"))),
    Section("source", Source, lower=lambda tree, _: record_of(Source, tree["source"])),
    Section(
        "materials",
        Material,
        lower=lambda tree, _: tuple(record_of(Material, one, name=name) for name, one in entries_of(tree, "materials")),
    ),
    Section("root", Root, lower=_root),
    Section("disabled_contacts", lower=lambda tree, _: tuple(tuple(one["links"]) for one in tree["disabled_contacts"])),
)
