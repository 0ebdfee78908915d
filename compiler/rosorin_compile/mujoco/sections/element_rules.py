"""Rules about names and elements that only MuJoCo reads: unknown and repeated names, misplaced elements.

Names of one kind are unique in MuJoCo: links and frames both become sites, and actuators of joints and of the section
``actuators`` are both actuators. Names in raw MJCF elements are checked as well.
"""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from rosorin_compile.language import element_names as mujoco
from rosorin_compile.language.annotations import SIMULATION
from rosorin_compile.language.element_names import ACTUATOR, BODY, EQUALITY, GEOM, JOINT, KEY, MATERIAL, SENSOR, SITE
from rosorin_compile.language.schema import sections
from rosorin_compile.language.symbols import ENDS, KINDS, Symbol
from rosorin_compile.model import Robot
from rosorin_compile.model.simulation import BODY_ELEMENT, SENSOR_ELEMENT, TEMPLATE_ELEMENT
from rosorin_compile.rules.case import Case, number
from rosorin_compile.rules.urdf_elements import at_name, mjcf_texts
from rosorin_compile.source.diagnostics import Diagnostic, Help, Suggestion
from rosorin_compile.source.rule_registry import SIMULATED, rule
from rosorin_compile.source.tree import Path
from rosorin_compile.source.xml.elements import FlatElement, found_in

BALL = "ball"  # joint type with several qpos values
# Nouns for messages, by kind of MuJoCo object.
_WORDS: Mapping[str, str] = {**KINDS, KEY: "pose", "pair": "contact pair"}
_KINDS = {word: kind for kind, word in KINDS.items()}
_RULES = {JOINT: "unknown-joint", BODY: "unknown-link"}
# Kind of MuJoCo object that an entry becomes, by the kind of the entry in the schema.
_DEFINED = {"actuator": ACTUATOR, "constraint": EQUALITY}


class NameUse(NamedTuple):
    """A name in the MJCF, the kind of object that has the name, and the path in the description that defines it.

    ``key`` is true if the name is a key on that path, ``derived`` if it follows from the name of a link or joint.
    """

    kind: str
    name: str
    path: Path
    key: bool = True
    derived: bool = False


def multi_dof_joints(case: Case) -> Mapping[str, str]:
    """Return the MJCF joints with several qpos values: "ball" or "free" by name of the joint."""
    found = {joint.name: BALL for joint in case.robot.joints if joint.type == BALL}
    found |= {f"{joint.name}_R": BALL for joint in case.robot.joints if joint.type == "floating"}
    return found | {_free_joint(case.robot): "free"}


def _free_joint(robot: Robot) -> str:
    root = next((link.name for link in robot.links if link.name not in robot.joint_to), "")
    return robot.root_in_world.joint or f"{root}_free"


def _named(case: Case) -> Iterator[NameUse]:
    robot = case.robot
    for link in robot.links:
        yield NameUse(SITE, link.name, case.link(link.name), derived=True)
    for index, edge in enumerate(robot.edges):
        yield NameUse(SITE, edge.child, case.edge(index, "child"), derived=True)
    for joint in robot.joints:
        if joint.mimic:
            yield NameUse(EQUALITY, joint.mimic.name or joint.name, case.joint(joint, "mimic"), derived=True)
        if joint.actuator and joint.moves:
            yield NameUse(ACTUATOR, joint.actuator.name or joint.name, case.joint(joint, "actuator"), derived=True)
    for link in robot.links:
        for mark in link.marked:
            yield NameUse(mark.tag, mark.name, case.link(link.name, f"{mark.tag}s", mark.name))
    for sensor in robot.sensors:
        path: Path = ("sensors", sensor.name)
        for part in sensor.simulated:
            count = part.replicas.count if part.replicas else 0
            for end in [f"_{index:0{len(str(count))}}" for index in range(count)] if part.replicas else [""]:
                if part.kind == SENSOR_ELEMENT and part.pose is not None:
                    yield NameUse(SITE, part.site + end, path)
                if part.kind in (SENSOR_ELEMENT, BODY_ELEMENT):
                    yield NameUse(SENSOR if part.kind == SENSOR_ELEMENT else part.element, part.name + end, path)
    simulated = [section for section, node in sections().items() if node.topic == "simulation"]
    for one in case.definitions:
        if one.kind in _DEFINED and one.path[0] in simulated:
            yield NameUse(_DEFINED[one.kind], one.name, one.path, key=len(one.path) == 2)
    for pose in robot.poses:
        yield NameUse(KEY, pose.name, ("poses", pose.name))
    for path, text, top in mjcf_texts(case):
        for name in (name for found in found_in(text) for name in mujoco.defined_names(found, top)):
            yield NameUse(name.kind, name.name, path, key=False)


class _Names:
    def __init__(self, case: Case) -> None:
        self.robot = robot = case.robot
        self.is_open = any(part.kind == TEMPLATE_ELEMENT for sensor in robot.sensors for part in sensor.simulated)
        self.all = list(_named(case))
        joints = {joint.name for joint in robot.joints if joint.moves or joint.type == BALL}
        joints |= {joint.name + end for joint in robot.joints for end in ENDS.get(joint.type, ())}
        joints |= {_free_joint(robot)} if any(robot.has_free_base(output) for output in robot.outputs) else set()
        bodies = {*robot.link, *(edge.child for edge in robot.edges), "world"}
        self.by_kind = {BODY: bodies, JOINT: joints, MATERIAL: set(robot.material), GEOM: set(_shapes(case))}
        for named in self.all:
            self.by_kind.setdefault(named.kind, set()).add(named.name)

    def has(self, kind: str, name: str) -> bool:
        return name in self.by_kind.get(kind, ()) or (self.is_open and kind not in (BODY, JOINT))


def _shapes(case: Case) -> Mapping[str, Path]:
    """Return the path of each shape by the name of its geom: the name of the shape, or LINK_collision_1 and so on."""
    found: dict[str, Path] = {}
    for purpose in ("collision", "visual"):
        for link in case.robot.links:
            shapes = enumerate(getattr(link, purpose))
            solids = [(case.link(link.name, purpose, index), one) for index, shape in shapes for one in shape.solids()]
            for index, (path, solid) in enumerate(solids, start=1):
                found[f"{link.name}_{purpose}_{index}"] = path
                found.setdefault(solid.name, path)
    return found


@rule("unknown-name", help="Correct the name.", topic=SIMULATED)
def unknown_names(case: Case) -> Iterator[Diagnostic]:
    """A key refers to a site, shape, tendon, actuator, camera or another object that does not exist."""
    if not (references := [one for one in case.references if one.among]):
        return
    names, wrong = _Names(case), dict[tuple[bool, str, str], list[Symbol]]()
    for one in references:
        is_simulated = one.among == SIMULATION
        kind = _KINDS.get(one.kind, one.kind) if is_simulated else one.kind
        if not (names.has if is_simulated else case.symbols.defines)(kind, one.name):
            wrong.setdefault((is_simulated, kind, one.name), []).append(one)
    for (is_simulated, kind, name), uses in wrong.items():
        id, word = _RULES.get(kind, "unknown-name"), _WORDS.get(kind, kind)
        message = f'there is no {word} "{name}"'
        known = names.by_kind.get(kind, ()) if is_simulated else case.symbols.names_of_kinds((kind,))
        instead = f"use another {word} of the robot" if known else f"define this {word}"
        help: Help = case.suggest(uses[0].path, name, known, instead)
        if kind == JOINT and name in case.robot.joint:
            joint = case.robot.joint[name]
            parts = " or ".join(f'"{name}{end}"' for end in ENDS.get(joint.type, ()))
            id = "joint-is-fixed" if joint.is_fixed else "joint-has-no-position"
            message = f'joint "{name}" is {joint.type} and does not have exactly one position'
            help = f"name one of the joints that MuJoCo has for it: {parts}" if parts else ""
        elif kind == JOINT and name == _free_joint(case.robot):
            help = 'write "base: free" in the output of the MJCF'
        yield from case.unknown(id, message, uses, help)


@rule("name-twice", help="Rename one of them; in a part, names automatically get its prefix.", topic=SIMULATED)
def unique_names(case: Case) -> Iterator[Diagnostic]:
    """Two sites, cameras, sensors, tendons or other MuJoCo objects of one kind have the same name in the MJCF."""
    names, taken = list(_named(case)), dict[tuple[str, str], Path]()
    if any(named.kind == GEOM for named in names):
        taken |= {(GEOM, name): path for name, path in _shapes(case).items()}
    if (root := case.robot.root_in_world.joint) in case.robot.joint:
        names.append(NameUse(JOINT, root, ("root", "joint"), key=False))
        taken[JOINT, root] = case.joint(case.robot.joint[root])
    if all(named.derived or named.path[0] in ("sensors", "poses") for named in names):
        return  # other rules check that links, sensors and poses have unique names
    for named in names:
        first = taken.setdefault((named.kind, named.name), named.path)
        # The check "mjcf-actuators" of the output reports two actuators of joints with the same name.
        if first is not named.path and not named.derived and not (named.kind == ACTUATOR and named.key):
            message = f'the {_WORDS.get(named.kind, named.kind)} "{named.name}" would be defined twice in the MJCF'
            message += ", in which each link also becomes a site" if named.kind == SITE else ""
            related = [case.related_place("the other definition", first, key=len(first) == 2)]
            key = named.key and named.path[-1] == named.name
            yield case.problem("name-twice", message, named.path, related=related, key=key)


# MJCF elements to be written with keys of the description instead, and the help that says how.
_IN_WORDS = {
    "body": 'write it as a link, with a joint of type "fixed" if it does not move',
    "joint": 'write it in "joints" of the description',
    "freejoint": 'write "base: free" in the output of the MJCF',
    "inertial": 'write it in "inertial" of the link',
    "composite": "make its bodies links",
    "attach": "use a part, or include its file",
    "include": "write its elements here, or include its file",
    "compiler": "remove it: angles are always in radians",
}
_IN_BODIES = ("geom", "site", "camera", "light", "frame", "replicate", "flexcomp", "plugin")


@rule("mjcf-element", "MuJoCo, or another artifact, cannot take an element here.", "See the message.", SIMULATED)
@rule("unknown-in-mjcf", "`mjcf` names something that does not exist.", "Correct the name.", SIMULATED)
def mjcf_elements(case: Case) -> Iterator[Diagnostic]:
    """Report elements in `mjcf` that do not belong there, and references to unknown names."""
    if not (texts := [(path, found_in(text), top) for path, text, top in mjcf_texts(case)]):
        return
    names, own = _Names(case), f"{case.robot.name}_"
    # <replicate> and <flexcomp> append suffixes to the names of their elements.
    generated: list[tuple[str, str]] = []
    for _, elements, top in texts:
        if {"replicate", "flexcomp"} & {tag for found in elements for tag in found.tags}:
            generated += [(one.kind, one.name) for found in elements for one in mujoco.defined_names(found, top)]
    has_flexcomp = any("flexcomp" in found.tags for _, elements, _ in texts for found in elements)
    materials = {f"{own}{name}" for name in case.robot.material}  # the MJCF prefixes materials with the robot name
    names.by_kind[MATERIAL] = materials | {named.name for named in names.all if named.kind == MATERIAL}
    seen: set[tuple[str, str]] = set()
    for path, elements, top in texts:
        if wrong := next(((found, why) for found in elements if (why := _misplaced(found, top))), None):
            found, (message, help) = wrong
            yield at_name(case.problem("mjcf-element", message, path, help), found.tags[-1], found.line)
            continue
        for found, (name, kind, _, where, _) in ((it, one) for it in elements for one in mujoco.used_names(it, top)):
            is_generated = any(kind == one and name.startswith(start) for one, start in generated)
            is_generated |= kind == BODY and has_flexcomp
            is_ours = kind in (mujoco.CLASS, mujoco.MESH) and name.startswith(own)
            is_ours |= kind == mujoco.CLASS and name in ("main", case.robot.name)
            exists = names.has(kind, name) if kind != MATERIAL else name in names.by_kind[MATERIAL]
            if (kind, name) in seen or exists or is_generated or is_ours:
                continue
            seen.add((kind, name))
            word = GEOM if kind == GEOM else _WORDS.get(kind, kind)
            message = f'{where} refers to {word} "{name}", which is not in the MJCF'
            help = case.suggest(path, name, names.by_kind.get(kind, ()), f"use another {word}, or define this one")
            yield at_name(case.problem("unknown-in-mjcf", message, path, help), name, found.line)


def _misplaced(found: FlatElement, top: bool) -> tuple[str, Help] | None:
    tag, first = found.tags[-1], found.tags[0]
    is_other = top and (first == "default" or (tag == "joint" and first in ("tendon", "equality")))
    if tag in _IN_WORDS and not is_other:
        return f"<{tag}> is written as MJCF, so other artifacts would not have it", _IN_WORDS[tag]
    known, other = (mujoco.SECTIONS, _IN_BODIES) if top else (_IN_BODIES, mujoco.SECTIONS)
    if len(found.tags) > 1 or tag in known:
        return None
    help = 'write it in "mjcf_elements" of a link' if top else 'write it in the top-level key "mjcf"'
    what = "a top-level element of MJCF" if top else "an element of a body"
    return f"<{tag}> is not {what}", help if tag in other else Suggestion(tag, known, "remove it")


# Number of sizes that MuJoCo uses for a site of each type; only one if ``fromto`` defines the length.
_SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "ellipsoid": 3, "box": 3}


@rule("mark-value", help="Correct the value, or remove the key.", topic=SIMULATED)
def marks(case: Case) -> Iterator[Diagnostic]:
    """A site, camera or light has a value that MuJoCo rejects, or values that contradict each other."""
    for link in case.robot.links:
        for mark in link.marked:
            for key, message, help in _mark_problems(mark.tag, mark.values):
                path = case.link(link.name, f"{mark.tag}s", mark.name, key)
                yield case.problem("mark-value", f'{mark.tag} "{mark.name}" {message}', path, help, key=True)


def _mark_problems(tag: str, values: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    """Yield (key, message, help) for each invalid attribute of a site, camera or light."""

    def numbers(key: str) -> list[float]:
        value = values.get(key, ())
        return list(map(float, value)) if isinstance(value, tuple) else [value] if isinstance(value, float) else []

    if tag == "site":
        count = 1 if "fromto" in values else _SIZES.get(str(values.get("type", "sphere")), 0)
        if min(numbers("size")[:count], default=1.0) <= 0:
            yield "size", "has a size that is not above zero", ""
        return
    chip = [key for key in ("focal", "focalpixel", "principal", "principalpixel") if key in values]
    if any(not 0 <= value <= 1 for value in numbers("softness")):
        yield "softness", f"has a softness of {number(values['softness'])}", "write a number from 0 to 1"
    if chip and "sensorsize" not in values:
        yield chip[0], f"has {chip[0]} but no sensorsize", "write the size of the image sensor, [WIDTH, HEIGHT] in m"
    if "dir" in values and tag == "light" and not any(numbers("dir")):
        yield "dir", "has a direction of length zero", "write one, such as [0, 0, -1]"
    if "sensorsize" in values and ("fovy" in values or not {"focal", "focalpixel"} & values.keys()):
        yield "sensorsize", "has a sensorsize", "write focal: [X, Y] (m) with it, and no fovy"
    for key in ("sensorsize", "focal", "focalpixel", "resolution"):
        if any(value <= 0 for value in numbers(key)):
            yield key, f"has a {key} that is not above zero", ""
    if any(not 0 < value < 180 for value in numbers("fovy")) and values.get("projection") != "orthographic":
        yield "fovy", f"has a field of view of {number(values['fovy'])} degrees", "write an angle between 0 and 180"
    if str(values.get("mode", "")).startswith("targetbody") != ("target" in values):
        key = "target" if "target" in values else "mode"
        yield key, 'needs both "mode: targetbody" and "target: LINK", or neither', ""


@rule("body-value", help="Move the key to the root link, or remove it.", topic=SIMULATED)
def bodies(case: Case) -> Iterator[Diagnostic]:
    """A link has an attribute that MuJoCo accepts only for the root: `mocap` or `sleep`."""
    world, root = case.robot.root_in_world.world, case.robot.root_in_world.values
    others = ", ".join(sorted(set(root) - {"align", "group"}))
    if "align" in root and others:
        message = f'"root" has align and {others}, which MuJoCo does not accept together'
        yield case.problem("body-value", message, ("root", "mjcf", "align"), 'remove "align"', key=True)
    bases = {output.options.get("base", "fixed") for output in case.robot.outputs if output.backend == "mjcf"}
    for link in case.robot.links:
        joint = case.robot.joint_to.get(link.name)
        is_root = joint is None or (world and joint.parent == case.robot.root)
        is_held = not is_root or (joint is not None and not joint.is_fixed) or ("free" in bases and not world)
        problems = {}
        if link.mjcf.get("mocap") is True and is_held:
            problems["mocap"] = 'only a root link (with "base: fixed") or a link fixed to the world can have it'
        is_fixed = ("fixed" in bases or not bases) and not world
        if link.mjcf.get("sleep") in ("never", "allowed", "init") and (not is_root or is_fixed):
            problems["sleep"] = 'only the root link can have it, with "base: free" in the output'
        for key, help in problems.items():
            message = f'link "{link.name}" has {key}, which MuJoCo does not accept here'
            yield case.problem("body-value", message, case.link(link.name, "mjcf", key), help, key=True)
