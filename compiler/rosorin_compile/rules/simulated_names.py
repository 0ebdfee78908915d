"""Names in what only a simulation has: what each section mentions is there, and no two things of a kind share a name.

MuJoCo keeps names by kind: a site of a link and the frame of another one are both sites, an actuator beside a joint and
one of the section are both actuators. What elements of MJCF bring counts as well.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

from rosorin_compile.language import element_names
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
    TENDON,
)
from rosorin_compile.language.schema import of_topic
from rosorin_compile.language.symbols import ENDS, KINDS, Reference, SymbolTable
from rosorin_compile.model import Robot
from rosorin_compile.model.simulation import AT_ORIGIN, BODY_ELEMENT, SENSOR_ELEMENT, TEMPLATE_ELEMENT
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.rule_registry import SIMULATED, rule
from rosorin_compile.source.tree import Path
from rosorin_compile.source.xml.elements import found_in

from .case import Case

BALL = "ball"  # a joint of several positions, as those of ENDS
# How a kind is called here, and what MuJoCo calls what is called otherwise here.
WORDS: Mapping[str, str] = {**KINDS, KEY: "pose", "pair": "contact pair"}
_KINDS = {word: kind for kind, word in KINDS.items()}
# What gets its name in a section for a simulation, by the word of the schema.
_GIVEN = {"actuator": ACTUATOR, "tendon": TENDON, "constraint": EQUALITY}
_GIVEN |= {"sensor of MuJoCo": SENSOR, "contact pair": "pair"}
_MAX_RELATED = 3


class Named(NamedTuple):
    """A name of a kind, and where it is given; ``key`` where that is a key of the description."""

    kind: str
    name: str
    path: Path
    key: bool = True


def simulates(robot: Robot) -> bool:
    """Say whether a robot has anything that names something for a simulation alone."""
    if robot.root_in_world != AT_ORIGIN or any(pose.controls for pose in robot.poses):
        return True
    if any(getattr(robot, section) for section in of_topic("simulation") if hasattr(robot, section)):
        return True
    return any(link.marked or link.mjcf_elements for link in robot.links)


def several(case: Case) -> Mapping[str, str]:
    """Return the joints of the MJCF that have several positions, and what each is: a ball, or free."""
    found = {joint.name: BALL for joint in case.robot.joints if joint.type == BALL}
    found |= {f"{joint.name}_R": BALL for joint in case.robot.joints if joint.type == "floating"}
    return found | {free_joint(case.robot): "free"}


def free_joint(robot: Robot) -> str:
    """Return the name of the joint of a base that moves."""
    root = next((link.name for link in robot.links if link.name not in robot.joint_to), "")
    return robot.root_in_world.joint or f"{root}_free"


class Names:
    """All names that the MJCF of a robot has, by kind. ``open``: templates of sensors may bring others."""

    def __init__(self, case: Case) -> None:
        self.case = case
        self.robot = case.robot
        parts = [part for sensor in self.robot.sensors for part in sensor.simulated]
        self.open = any(part.kind == TEMPLATE_ELEMENT for part in parts)

    @cached_property
    def given(self) -> list[Named]:
        """The names of all kinds but links, joints and shapes, which have rules of their own; in their order."""
        return [*self._of_links(), *self._of_sensors(), *self._of_sections(), *self._of_elements()]

    @cached_property
    def by_kind(self) -> Mapping[str, set[str]]:
        """The names by kind, without those of shapes."""
        robot = self.robot
        frames = {*robot.link, *(edge.child for edge in robot.edges)}
        known: dict[str, set[str]] = {BODY: {*frames, "world"}, SITE: set(frames), JOINT: self._joints()}
        for named in self.given:
            known.setdefault(named.kind, set()).add(named.name)
        known.setdefault(MATERIAL, set()).update(robot.material)
        known.setdefault(EQUALITY, set()).update(
            joint.mimic.name or joint.name for joint in robot.joints if joint.mimic
        )
        known.setdefault(ACTUATOR, set()).update(
            joint.actuator.name or joint.name for joint in robot.joints if joint.actuator and joint.moves
        )
        return known

    @cached_property
    def shapes(self) -> Mapping[str, int]:
        """The names of the geoms of shapes, and how many have each: their own, and LINK_collision_1 and so on.

        What collides goes before what is seen under the same name.
        """
        counts: dict[str, int] = {}
        plain: dict[str, int] = {}
        for purpose in ("collision", "visual"):
            before = frozenset(counts)
            for link in self.robot.links:
                solids = (solid for shape in getattr(link, purpose) for solid in shape.solids())
                for index, solid in enumerate(solids, start=1):
                    made = f"{link.name}_{purpose}_{index}"
                    plain[made] = 1
                    if solid.name and solid.name not in before:
                        counts[solid.name] = counts.get(solid.name, 0) + 1
        for named in self.given:
            if named.kind == GEOM:
                counts[named.name] = 1
        return plain | counts

    def has(self, kind: str, name: str) -> bool:
        """Say whether there is something of a kind under a name, or may be."""
        if kind == GEOM:
            return name in self.shapes or self.open
        return name in self.by_kind.get(kind, ()) or (self.open and kind not in (BODY, JOINT))

    def of(self, kind: str) -> Iterable[str]:
        """Return the names of a kind."""
        return self.shapes if kind == GEOM else self.by_kind.get(kind, ())

    def _joints(self) -> set[str]:
        robot = self.robot
        names = {joint.name for joint in robot.joints if joint.moves or joint.type == BALL}
        names |= {joint.name + end for joint in robot.joints for end in ENDS.get(joint.type, ())}
        if any(robot.has_free_base(output) for output in robot.outputs):
            names.add(free_joint(robot))
        return names

    def _of_links(self) -> Iterator[Named]:
        for link in self.robot.links:
            for mark in link.marked:
                yield Named(mark.tag, mark.name, self.case.link(link.name, f"{mark.tag}s", mark.name))

    def _of_sensors(self) -> Iterator[Named]:
        for sensor in self.robot.sensors:
            for part in sensor.simulated:
                path: Path = ("sensors", sensor.name)
                count = part.replicas.count if part.replicas else 0
                for end in [f"_{number:0{len(str(count))}}" for number in range(count)] if part.replicas else [""]:
                    if part.kind == SENSOR_ELEMENT:
                        yield Named(SENSOR, part.name + end, path)
                        if part.pose is not None:
                            yield Named(SITE, part.site + end, path)
                    elif part.kind == BODY_ELEMENT:
                        yield Named(part.element, part.name + end, path)

    def _of_sections(self) -> Iterator[Named]:
        for section in of_topic("simulation"):
            for one in self.case.symbols.definitions(section):
                if one.kind in _GIVEN:
                    yield Named(_GIVEN[one.kind], one.name, one.path, key=len(one.path) == 2)
        for pose in self.robot.poses:
            yield Named(KEY, pose.name, ("poses", pose.name))

    def _of_elements(self) -> Iterator[Named]:
        for path, text, top in kept(self.case):
            for found in found_in(text):
                for one in element_names.given(found, top):
                    yield Named(one.kind, one.name, path, key=False)


def kept(case: Case) -> Iterator[tuple[Path, str, bool]]:
    """Yield the elements of MJCF that a robot keeps, each with its path, and whether it is a section of the file."""
    texts = case.robot.mjcf_elements
    for index, text in enumerate(texts):
        yield ("mjcf_elements", index), text, True
    for link in case.robot.links:
        for index, text in enumerate(link.mjcf_elements):
            yield case.link(link.name, "mjcf_elements", index), text, False


@rule(
    "unknown-name",
    "What only a simulation has names a site, a shape, a tendon, an actuator or a camera that there is not; "
    "or an entry names another one that there is not.",
    "Correct the name.",
    SIMULATED,
)
def unknown_names(case: Case) -> Iterator[Diagnostic]:
    """Names in the sections for a simulation; each name that there is not once, however often it is used."""
    said = [one for one in case.symbols.references() if one.among]
    yield from _unknown(case, [one for one in said if one.among == DESCRIPTION])
    named = [one for one in said if one.among == SIMULATION]
    if not named:
        return
    names = Names(case)
    wrong: dict[tuple[str, str], list[Reference]] = {}
    for one in named:
        kind = _KINDS.get(one.kind, one.kind)
        several = kind == GEOM and names.shapes.get(one.name, 0) > 1
        if several or not names.has(kind, one.name):
            wrong.setdefault((kind, one.name), []).append(one)
    for (kind, name), (first, *others) in wrong.items():
        also, same = case.also(first.path, ((one.path, one.what, one.key) for one in others), first.key)
        for path, what, related in ((first.path, first.what, also[:_MAX_RELATED]), *((*one, []) for one in same)):
            id, message, help = _said(names, kind, name, what, path)
            yield case.problem(id, message, path, help, related=related, key=first.key)


def _unknown(case: Case, named: Sequence[Reference]) -> Iterator[Diagnostic]:
    """Yield what names no entry of the description, where the schema says that it names one."""
    if not named:
        return
    names = SymbolTable(case.tree).names()
    for one in named:
        if not names.gives(one.kind, one.name):
            message = f'there is no {one.kind} "{one.name}", {one.what}'
            help = case.suggest(one.path, one.name, names.among((one.kind,)), f"name a {one.kind} of the robot")
            yield case.problem("unknown-name", message, one.path, help, key=one.key)


def _said(names: Names, kind: str, name: str, what: str, path: Path) -> tuple[str, str, str]:
    """Return the rule, the message and the way out for a name that there is not."""
    robot, word = names.robot, WORDS.get(kind, kind)
    if kind == JOINT and name in robot.joint:
        joint = robot.joint[name]
        if joint.is_fixed:
            return "joint-is-fixed", f'joint "{name}", {what}, is fixed', "name a joint that moves"
        parts = " or ".join(f'"{name}{end}"' for end in ENDS[joint.type])
        message = f'joint "{name}", {what}, is {joint.type} and has no single position'
        return "joint-has-no-position", message, f"name one of the joints that MuJoCo has for it: {parts}"
    if kind == GEOM and names.shapes.get(name, 0) > 1:
        message = f'several shapes are called "{name}", {what}: in the MJCF none of them has that name'
        return "unknown-name", message, "name one as LINK_collision_1 or LINK_visual_1, by its place in its link"
    if kind == JOINT and name == free_joint(robot):
        message = f'there is no joint "{name}", {what}: the base of every output is fixed'
        return "unknown-joint", message, "say base: free in the output of the MJCF"
    id = {JOINT: "unknown-joint", BODY: "unknown-link"}.get(kind, "unknown-name")
    otherwise = f"name a {word} of the robot" if word[0] not in "aei" else f"name an {word} of the robot"
    return id, f'there is no {word} "{name}", {what}', names.case.suggest(path, name, names.of(kind), otherwise)


@rule(
    "name-twice",
    "Two things of one kind have one name in the MJCF: two sites, two cameras, two sensors, a tendon and one among "
    "`mjcf_elements`.",
    "Give one of them another name.",
    SIMULATED,
)
def once(case: Case) -> Iterator[Diagnostic]:
    """Names that MuJoCo would find twice; two actuators beside joints are a matter of the output (mjcf-actuators)."""
    if not simulates(case.robot):
        return
    names = Names(case)
    taken = _taken(case)
    if any(named.kind == GEOM for named in names.given):
        taken |= {(GEOM, name): path for name, path in _own_shapes(case).items()}
    for named in names.given:
        first = taken.setdefault((named.kind, named.name), named.path)
        if first is not named.path and not (named.kind == ACTUATOR and named.key):
            yield _twice(case, named, first)
    root = case.robot.root_in_world.joint
    if root and root in case.robot.joint:
        yield _twice(case, Named(JOINT, root, ("root", "joint"), False), case.joint(case.robot.joint[root]))


def _taken(case: Case) -> dict[tuple[str, str], Path]:
    """Return the names that links and joints bring to other kinds, and where those stand."""
    taken: dict[tuple[str, str], Path] = {(SITE, link.name): case.link(link.name) for link in case.robot.links}
    for index, edge in enumerate(case.robot.edges):
        taken.setdefault((SITE, edge.child), case.edge(index, "child"))
    for joint in case.robot.joints:
        if joint.mimic is not None:
            taken.setdefault((EQUALITY, joint.mimic.name or joint.name), case.joint(joint, "mimic"))
        if joint.actuator is not None and joint.moves:
            taken.setdefault((ACTUATOR, joint.actuator.name or joint.name), case.joint(joint, "actuator"))
    return taken


def _own_shapes(case: Case) -> Mapping[str, Path]:
    """Return where the names of geoms come from that shapes have."""
    places: dict[str, Path] = {}
    for link in case.robot.links:
        for purpose in ("collision", "visual"):
            number = 0
            for index, shape in enumerate(getattr(link, purpose)):
                path = case.link(link.name, purpose, index)
                for solid in shape.solids():
                    number += 1
                    places[f"{link.name}_{purpose}_{number}"] = path
                    places.setdefault(solid.name, path)
    return places


def _twice(case: Case, named: Named, taken: Path) -> Diagnostic:
    word = WORDS.get(named.kind, named.kind)
    what = f'the {word} "{named.name}" is there twice in the MJCF'
    if taken[0] in ("links", "sensors") and len(taken) == 2 and named.kind == SITE:
        what = f'the site "{named.name}" has the name of a frame, which is a site in the MJCF already'
    key = named.key and named.path[-1] == named.name
    related = [case.related("the other one", taken, key=len(taken) == 2)]
    help = "give one of them another name"
    if named.path[-2] == "mjcf_elements":
        help += "; in a part, names of its elements get its prefix"
    return case.problem("name-twice", what, named.path, help, related=related, key=key)
