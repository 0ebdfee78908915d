"""Names and elements that only MuJoCo reads: references resolve, names are unique by kind, elements are in place.

MuJoCo keeps names by kind: a site of a link and the frame of another one are both sites, an actuator beside joints and
one of the section are both actuators. Names that elements of MJCF bring count as well.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from typing import Any, NamedTuple

from rosorin_compile.language import element_names as mujoco
from rosorin_compile.language.annotations import DESCRIPTION, SIMULATION
from rosorin_compile.language.element_names import (
    ACTUATOR,
    BODY,
    EQUALITY,
    GEOM,
    JOINT,
    KEY,
    MATERIAL,
    SENSOR,
    SITE,
)
from rosorin_compile.language.schema import of_topic
from rosorin_compile.language.symbols import ENDS, KINDS, Reference
from rosorin_compile.model import Robot
from rosorin_compile.model.simulation import AT_ORIGIN, BODY_ELEMENT, SENSOR_ELEMENT, TEMPLATE_ELEMENT
from rosorin_compile.source.diagnostics import Diagnostic, did_you_mean
from rosorin_compile.source.rule_registry import SIMULATED, rule
from rosorin_compile.source.tree import Path
from rosorin_compile.source.xml.elements import Found, found_in

from .case import Case, number
from .urdf_elements import at_name, mjcf_texts

BALL = "ball"  # a joint of several positions, as those of ENDS
# The words of messages for the kinds of MuJoCo.
_WORDS: Mapping[str, str] = {**KINDS, KEY: "pose", "pair": "contact pair"}
_KINDS = {word: kind for kind, word in KINDS.items()}
# The kinds of what gets its name in a section for a simulation, by the word of the schema.
_DEFINED = {"actuator": ACTUATOR, "constraint": EQUALITY}


class Named(NamedTuple):
    """A name of a kind, and where it is given; ``key`` where that is a key of the description.

    ``derived``: the MJCF derives it from the name of a link or a joint.
    """

    kind: str
    name: str
    path: Path
    key: bool = True
    derived: bool = False


def _simulates(robot: Robot) -> bool:
    """Return True if a robot has anything that names something for a simulation alone."""
    return (
        robot.root_in_world != AT_ORIGIN
        or any(pose.controls for pose in robot.poses)
        or any(getattr(robot, section) for section in of_topic("simulation") if hasattr(robot, section))
        or any(link.marked or link.mjcf_elements for link in robot.links)
    )


def several(case: Case) -> Mapping[str, str]:
    """Return the joints of the MJCF that have several positions, and what each is: a ball, or free."""
    found = {joint.name: BALL for joint in case.robot.joints if joint.type == BALL}
    found |= {f"{joint.name}_R": BALL for joint in case.robot.joints if joint.type == "floating"}
    return found | {_free_joint(case.robot): "free"}


def _free_joint(robot: Robot) -> str:
    root = next((link.name for link in robot.links if link.name not in robot.joint_to), "")
    return robot.root_in_world.joint or f"{root}_free"


class _Names:
    """All names that the MJCF of a robot has, by kind. ``open``: templates of sensors may bring others."""

    def __init__(self, case: Case) -> None:
        self.case, self.robot = case, case.robot
        self.open = any(part.kind == TEMPLATE_ELEMENT for sensor in case.robot.sensors for part in sensor.simulated)
        self.all = [*self._derived(), *self._of_sensors(), *self._of_sections()]
        for path, text, top in mjcf_texts(case):
            references = (one for found in found_in(text) for one in mujoco.given(found, top))
            self.all += [Named(one.kind, one.name, path, key=False) for one in references]

    def _derived(self) -> Iterator[Named]:
        robot, case = self.robot, self.case
        for link in robot.links:
            yield Named(SITE, link.name, case.link(link.name), derived=True)
        for index, edge in enumerate(robot.edges):
            yield Named(SITE, edge.child, case.edge(index, "child"), derived=True)
        for joint in robot.joints:
            if joint.mimic:
                yield Named(EQUALITY, joint.mimic.name or joint.name, case.joint(joint, "mimic"), derived=True)
            if joint.actuator and joint.moves:
                yield Named(ACTUATOR, joint.actuator.name or joint.name, case.joint(joint, "actuator"), derived=True)
        for link in robot.links:
            for mark in link.marked:
                yield Named(mark.tag, mark.name, case.link(link.name, f"{mark.tag}s", mark.name))

    def _of_sensors(self) -> Iterator[Named]:
        for sensor in self.robot.sensors:
            path: Path = ("sensors", sensor.name)
            for part in sensor.simulated:
                count = part.replicas.count if part.replicas else 0
                for end in [f"_{index:0{len(str(count))}}" for index in range(count)] if part.replicas else [""]:
                    if part.kind == SENSOR_ELEMENT:
                        yield Named(SENSOR, part.name + end, path)
                        yield from [Named(SITE, part.site + end, path)] if part.pose is not None else []
                    elif part.kind == BODY_ELEMENT:
                        yield Named(part.element, part.name + end, path)

    def _of_sections(self) -> Iterator[Named]:
        for section in of_topic("simulation"):
            for one in self.case.symbols.definitions(section):
                if one.kind in _DEFINED:
                    yield Named(_DEFINED[one.kind], one.name, one.path, key=len(one.path) == 2)
        for pose in self.robot.poses:
            yield Named(KEY, pose.name, ("poses", pose.name))

    @cached_property
    def by_kind(self) -> Mapping[str, Iterable[str]]:
        """The names by kind."""
        robot = self.robot
        joints = {joint.name for joint in robot.joints if joint.moves or joint.type == BALL}
        joints |= {joint.name + end for joint in robot.joints for end in ENDS.get(joint.type, ())}
        joints |= {_free_joint(robot)} if any(robot.has_free_base(output) for output in robot.outputs) else set()
        bodies = {*robot.link, *(edge.child for edge in robot.edges), "world"}
        known: dict[str, set[str]] = {BODY: bodies, JOINT: joints, MATERIAL: set(robot.material)}
        for named in self.all:
            known.setdefault(named.kind, set()).add(named.name)
        return {**known, GEOM: {*self.shapes, *known.get(GEOM, ())}}

    @cached_property
    def shapes(self) -> Mapping[str, list[Path]]:
        """The paths of the shapes of each geom: their own names, and LINK_collision_1 and so on.

        A collision shape goes before a visual one of the same name.
        """
        found: dict[str, list[Path]] = {}
        for purpose in ("collision", "visual"):
            before = frozenset(found)
            for link in self.robot.links:
                shapes = enumerate(getattr(link, purpose))
                solids = [(self.case.link(link.name, purpose, i), one) for i, shape in shapes for one in shape.solids()]
                for index, (path, solid) in enumerate(solids, start=1):
                    found[f"{link.name}_{purpose}_{index}"] = [path]
                    if solid.name and solid.name not in before and path not in found.get(solid.name, ()):
                        found.setdefault(solid.name, []).append(path)
        return found

    def has(self, kind: str, name: str) -> bool:
        """Return True if there is something of a kind under a name, or may be; several shapes lose theirs in MJCF."""
        if kind == GEOM and len(self.shapes.get(name, ())) > 1:
            return any(named.kind == GEOM and named.name == name for named in self.all)
        return name in self.by_kind.get(kind, ()) or (self.open and kind not in (BODY, JOINT))


@rule("unknown-name", help="Correct the name.", topic=SIMULATED)
def unknown_names(case: Case) -> Iterator[Diagnostic]:
    """A key names a site, shape, tendon, actuator, camera or another entry that does not exist; each name once."""
    references = [one for one in case.symbols.references() if one.among]
    named = [one for one in references if one.among == SIMULATION]
    defined = case.symbols.names() if len(named) < len(references) else None
    for one in references:
        if defined and one.among == DESCRIPTION and not defined.gives(one.kind, one.name):
            message = f'there is no {one.kind} "{one.name}", {one.what}'
            help = case.suggest(one.path, one.name, defined.among((one.kind,)), f"name a {one.kind} of the robot")
            yield case.problem("unknown-name", message, one.path, help, key=one.key)
    names = _Names(case) if named else None
    wrong: dict[tuple[str, str], list[Reference]] = {}
    for one in named:
        kind = _KINDS.get(one.kind, one.kind)
        if names and not names.has(kind, one.name):
            wrong.setdefault((kind, one.name), []).append(one)
    for (kind, _), uses in wrong.items():
        id, message, help = _worded(names or _Names(case), kind, uses[0])
        yield from case.unknown(id, message, uses, help)


def _worded(names: _Names, kind: str, use: Reference) -> tuple[str, str, str]:
    """Return the rule, the message and the help for an unknown name."""
    robot, word, name = names.robot, _WORDS.get(kind, kind), use.name
    if kind == JOINT and name in robot.joint:
        joint = robot.joint[name]
        parts = " or ".join(f'"{name}{end}"' for end in ENDS.get(joint.type, ()))
        help = f"name one of the joints that MuJoCo has for it: {parts}" if parts else ""
        id = "joint-is-fixed" if joint.is_fixed else "joint-has-no-position"
        return id, f'joint "{name}" is {joint.type} and has no single position', help
    id = {JOINT: "unknown-joint", BODY: "unknown-link"}.get(kind, "unknown-name")
    help = names.case.suggest(use.path, name, names.by_kind.get(kind, ()), f"name another {word} of the robot")
    is_base = kind == JOINT and name == _free_joint(robot)
    return id, f'there is no {word} "{name}"', "write base: free in the output of the MJCF" if is_base else help


@rule("name-twice", help="Give one of them another name; in a part, names get its prefix.", topic=SIMULATED)
def unique_names(case: Case) -> Iterator[Diagnostic]:
    """Two things of one kind have one name in the MJCF: sites, cameras, sensors, tendons, elements."""
    if not _simulates(case.robot):
        return
    names = _Names(case)
    taken: dict[tuple[str, str], Path] = {}
    if any(named.kind == GEOM for named in names.all):
        taken |= {(GEOM, name): paths[0] for name, paths in names.shapes.items()}
    root = case.robot.root_in_world.joint
    base = [Named(JOINT, root, ("root", "joint"), key=False)] if root and root in case.robot.joint else []
    taken |= {(JOINT, one.name): case.joint(case.robot.joint[root]) for one in base}
    for named in (*names.all, *base):
        first = taken.setdefault((named.kind, named.name), named.path)
        # Two actuators beside joints are a matter of the output (mjcf-actuators).
        if first is named.path or named.derived or (named.kind == ACTUATOR and named.key):
            continue
        message = f'the {_WORDS.get(named.kind, named.kind)} "{named.name}" occurs twice in the MJCF'
        if first[0] in ("links", "sensors") and len(first) == 2 and named.kind == SITE:
            message = f'the site "{named.name}" has the name of a frame, which is a site in the MJCF already'
        related = [case.related("the other one", first, key=len(first) == 2)]
        key = named.key and named.path[-1] == named.name
        yield case.problem("name-twice", message, named.path, related=related, key=key)


# --- elements of MJCF ---

# Elements for which a description has words, wherever they are, and the fix.
_IN_WORDS = {
    "body": "make it a link, with a joint of type fixed where it does not move",
    "joint": "write it under joints of the description",
    "freejoint": "write base: free in the output of the MJCF",
    "inertial": "write it under inertial of the link",
    "composite": "make its bodies links",
    "attach": "use a part, or include its file",
    "include": "write its elements here, or include its file",
}
_IN_BODIES = ("geom", "site", "camera", "light", "frame", "replicate", "flexcomp", "plugin")


@rule("mjcf-element", help="Write it as the message says.", topic=SIMULATED)
def placed(case: Case) -> Iterator[Diagnostic]:
    """`mjcf` has a body, a joint, `<compiler>`, or an element that MuJoCo does not accept at that place."""
    for path, text, top in mjcf_texts(case):
        for found in found_in(text):
            wrong = _misplaced(case, found, top)
            if wrong:
                made = case.problem("mjcf-element", wrong[0], path, wrong[1])
                yield at_name(made, found.tags[-1], found.line)
                break


def _misplaced(case: Case, found: Found, top: bool) -> tuple[str, str] | None:
    """Return the problem of where an element is, and the fix; a body of MuJoCo alone would be in no other file."""
    tag, first = found.tags[-1], found.tags[0]
    is_other = top and (first == "default" or (tag == "joint" and first in ("tendon", "equality")))
    if tag in _IN_WORDS and not is_other:
        return f"<{tag}> is in elements of MJCF: no other artifact would have it", _IN_WORDS[tag]
    if tag == "flexcomp" and case.robot.poses:
        message = "<flexcomp> adds joints that no pose places: MuJoCo refuses the keyframes"
        return message, "leave the poses to a description without it"
    if len(found.tags) > 1:
        return None
    if top and tag == "compiler":
        return "<compiler> would change what all numbers of the MJCF mean", "leave it out; angles are in radians here"
    if top and tag not in mujoco.SECTIONS:
        help = (
            "write it in a link" if tag in _IN_BODIES else did_you_mean(tag, mujoco.SECTIONS, "write a whole section")
        )
        return f"<{tag}> is no section of an MJCF", help
    if not top and tag in mujoco.SECTIONS:
        return f"<{tag}> is a section of the MJCF, and is in a link", "write it under mjcf at the top"
    if not top and tag not in _IN_BODIES:
        return f"<{tag}> is no element of a body", did_you_mean(tag, _IN_BODIES, "write one of them")
    return None


@rule("unknown-in-mjcf", help="Correct the name.", topic=SIMULATED)
def unknown_in_elements(case: Case) -> Iterator[Diagnostic]:
    """An element of `mjcf` names a body, a joint, a site, a geom, a class or the like that does not exist."""
    texts = [(path, found_in(text), top) for path, text, top in mjcf_texts(case)]
    if not texts:
        return
    names, own = _Names(case), f"{case.robot.name}_"
    # <replicate> and <flexcomp> make names: those of their elements with something behind them.
    made_of: list[tuple[str, str]] = []
    has_flexcomp = False
    for _, elements, top in texts:
        tags = {tag for found in elements for tag in found.tags}
        has_flexcomp = has_flexcomp or "flexcomp" in tags
        if tags & {"replicate", "flexcomp"}:
            made_of += [(one.kind, one.name) for found in elements for one in mujoco.given(found, top)]
    materials = {f"{own}{name}" for name in case.robot.material}  # so they are called in the MJCF
    materials |= {named.name for named in names.all if named.kind == MATERIAL}
    seen: set[tuple[str, str]] = set()
    for path, elements, top in texts:
        is_placed = not any(_misplaced(case, found, top) for found in elements)
        uses = [(found, one) for found in elements for one in mujoco.used(found, top)] if is_placed else []
        for found, one in uses:
            kind, name = one.kind, one.name
            known = materials if kind == MATERIAL else names.by_kind.get(kind, ())
            if (
                (kind, name) in seen
                or (kind == BODY and has_flexcomp)
                or (kind in (mujoco.CLASS, mujoco.MESH) and name.startswith(own))
                or (kind == mujoco.CLASS and name in ("main", case.robot.name))
                or (name in known if kind == MATERIAL else names.has(kind, name))
                or any(kind == made and name.startswith(start) for made, start in made_of)
            ):
                continue
            seen.add((kind, name))
            word = GEOM if kind == GEOM else _WORDS.get(kind, kind)
            message = f'there is no {word} "{name}", {one.where}'
            if kind == JOINT and name in case.robot.joint:
                message = f'joint "{name}", {one.where}, is no joint in the MJCF: it is {case.robot.joint[name].type}'
            help = case.suggest(path, name, known, f"name a {word} of the robot or of these elements")
            yield at_name(case.problem("unknown-in-mjcf", message, path, help), name, found.line)


# --- values of sites, cameras, lights and bodies ---

_MOVING = ("never", "allowed", "init")
# How many sizes a site of a form has; those behind them mean nothing.
_SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "ellipsoid": 3, "box": 3}


@rule("mark-value", help="Correct it as the message says.", topic=SIMULATED)
def marks(case: Case) -> Iterator[Diagnostic]:
    """A site, a camera or a light of a simulation has a value that MuJoCo refuses, or contradictory values."""
    for link in case.robot.links:
        for mark in link.marked:
            problems = {"camera": _camera, "light": _light}.get(mark.tag, _site)(mark.values)
            for key, message, help in (*problems, *(_aimed(mark.values) if mark.tag != "site" else ())):
                path = case.link(link.name, f"{mark.tag}s", mark.name, key)
                yield case.problem("mark-value", f'{mark.tag} "{mark.name}" {message}', path, help, key=True)


def _site(values: Any) -> Iterator[tuple[str, str, str]]:
    size = values.get("size")
    count = 1 if "fromto" in values else _SIZES.get(str(values.get("type", "sphere")), 0)  # fromto gives the length
    smallest = min(map(float, size[:count]), default=1.0) if isinstance(size, tuple) else 1.0
    if smallest <= 0:
        yield "size", f"has a size of {number(smallest)}", "write sizes above zero"


def _light(values: Any) -> Iterator[tuple[str, str, str]]:
    softness, direction = values.get("softness"), values.get("dir")
    if isinstance(softness, float) and not 0 <= softness <= 1:
        yield "softness", f"has a softness of {number(softness)}", "write a number from 0 to 1"
    if isinstance(direction, tuple) and not any(direction):
        yield "dir", "shines in no direction", "write one, such as [0, 0, -1]"


def _camera(values: Any) -> Iterator[tuple[str, str, str]]:
    of_chip = [word for word in ("focal", "focalpixel", "principal", "principalpixel") if word in values]
    if of_chip and "sensorsize" not in values:
        yield of_chip[0], f"has {of_chip[0]} and no sensorsize", "write sensorsize: [WIDTH, HEIGHT] of the chip, in m"
    if "fovy" in values and "sensorsize" in values:
        yield "fovy", "has fovy and sensorsize, which exclude each other", "leave one of them out"
    if "sensorsize" in values and not {"focal", "focalpixel"} & set(values):
        yield "sensorsize", "has a sensorsize and no focal length", "write focal: [X, Y], in m"
    output, resolution, fovy = values.get("output"), values.get("resolution"), values.get("fovy")
    if isinstance(output, tuple) and len(set(output)) < len(output):
        yield "output", "makes one output twice", "leave one of them out"
    if isinstance(resolution, tuple) and min(map(float, resolution)) <= 0:
        yield "resolution", "has a picture without pixels", "write numbers above zero"
    pairs = [values[word] for word in ("sensorsize", "focal", "focalpixel") if isinstance(values.get(word), tuple)]
    if any(float(size) <= 0 for pair in pairs for size in pair):
        yield "sensorsize", "has sizes that are not above zero", "write those of its data sheet"
    if isinstance(fovy, float) and not 0 < fovy < 180 and values.get("projection") != "orthographic":
        yield "fovy", f"sees {number(fovy)} degrees", "write an angle between 0 and 180 degrees"


def _aimed(values: Any) -> Iterator[tuple[str, str, str]]:
    mode = str(values.get("mode", "fixed"))
    if "target" in values and not mode.startswith("targetbody"):
        yield "target", f"has a target, and its mode is {mode}", "write mode: targetbody"
    elif mode.startswith("targetbody") and "target" not in values:
        yield "mode", "has a mode that needs a target", "write target: LINK"


@rule("body-value", help="Move it to the root link, or leave it out.", topic=SIMULATED)
def bodies(case: Case) -> Iterator[Diagnostic]:
    """A link has an attribute of a body that MuJoCo accepts of the root alone: `mocap`, `sleep`."""
    world, root = case.robot.root_in_world.world, case.robot.root_in_world.values
    others = ", ".join(sorted(set(root) - {"align", "group"}))
    if "align" in root and others:
        message = f"the root has align and {others}, which MuJoCo does not take together"
        yield case.problem("body-value", message, ("root", "mjcf", "align"), "leave it out", key=True)
    bases = {output.options.get("base", "fixed") for output in case.robot.outputs if output.backend == "mjcf"}
    for link in case.robot.links:
        path: Path = case.link(link.name, "mjcf")
        joint = case.robot.joint_to.get(link.name)
        is_root = joint is None or (world and joint.parent == case.robot.root)
        is_held = not is_root or (joint is not None and not joint.is_fixed) or ("free" in bases and not world)
        if link.mjcf.get("mocap") is True and is_held:
            message = f'link "{link.name}" has mocap: a program moves it, and a joint moves or holds it'
            help = "only the root link can, with base: fixed in the output, or a link fixed to a root that is the world"
            yield case.problem("body-value", message, (*path, "mocap"), help, key=True)
        if link.mjcf.get("sleep") in _MOVING and (not is_root or (("fixed" in bases or not bases) and not world)):
            message = f'link "{link.name}" has sleep, which only a free base can have'
            help = "write it in the root link, with base: free in the output, or leave it out"
            yield case.problem("body-value", message, (*path, "sleep"), help, key=True)
