"""Explain frames and named values: where each is defined, and for every number the line of YAML that sets it."""

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

from rosorin_compile.model import Joint, Link, Pose, Publisher, Robot, Vector
from rosorin_compile.model import Transform as Rigid
from rosorin_compile.model.joint import NODE, STATIC_TRANSFORM_PUBLISHER, UNPUBLISHED
from rosorin_compile.source.diagnostics import UnknownName
from rosorin_compile.source.numbers import exact, to_fixed
from rosorin_compile.source.tree import Path, value_at

from .expand.description import ExpandedDescription
from .lower import LoweredRobot
from .origins import NameOrigin, Origin, Origins, Step, Where
from .schema import fragment_at, joint_unit, sections
from .symbols import SymbolTable

_AXES: Mapping[str | int, Sequence[str]] = {"xyz": ("x", "y", "z"), "rpy": ("roll", "pitch", "yaw")}
_KEYS_OF_JOINT = ("limit", "mimic", "dynamics", "actuator", "calibration", "safety_controller")
_USE = re.compile(r'part ".*?" used here as "(.*?)"')  # matches the message of a part instance
_DIGITS = 9  # significant digits of quaternions and degrees
_OPTICAL = "not written: an optical frame is turned like this (REP 103)"


class Number(NamedTuple):
    """A number in SI units; if no file contains the number, ``origin`` is None and ``note`` gives the reason."""

    name: str
    value: float
    unit: str
    origin: Origin | None
    note: str = ""


class Transform(NamedTuple):
    """A pose: xyz in metres, rpy in radians and degrees about fixed axes, and the quaternion as x y z w."""

    xyz: tuple[float, ...]
    rpy: tuple[float, ...]
    rpy_degrees: tuple[float, ...]
    quaternion_xyzw: tuple[float, ...]

    @classmethod
    def from_rigid(cls, rigid: Rigid) -> "Transform":
        """Convert a rigid transform; replace -0.0 with 0.0."""
        w, x, y, z = rigid.quaternion()
        values = (rigid.xyz, rigid.rpy(), tuple(map(math.degrees, rigid.rpy())), (x, y, z, w))
        return cls(*(tuple(value + 0.0 for value in row) for row in values))


class Edge(NamedTuple):
    """A transform parent -> child with joints at zero; ``transform`` is None if an external ROS node determines it."""

    parent: str
    child: str
    joint: str  # "" if an external ROS node publishes the transform
    type: str
    publisher: str
    topic: str
    when: str
    transform: Transform | None
    numbers: tuple[Number, ...]
    where: Where
    stack: tuple[Step, ...] = ()


class FramePose(NamedTuple):
    """The pose of a frame in ``root`` for a named joint pose ("": joints at zero); ``transform`` is None if unknown."""

    pose: str
    root: str
    transform: Transform | None


class Shape(NamedTuple):
    """A shape of a link; ``purpose`` is "visual" or "collision", ``where`` is the position of its entry."""

    purpose: str
    numbers: tuple[Number, ...]
    where: Where


class Explanation(NamedTuple):
    """The explanation of a frame: ``chain`` has the transforms from the root, ``others`` those by other ROS nodes."""

    name: str
    roles: tuple[str, ...]
    where: Where | None
    stack: tuple[Step, ...]
    chain: tuple[Edge, ...]
    others: tuple[Edge, ...]
    placed: tuple[FramePose, ...]
    children: tuple[str, ...]
    joint: tuple[Number, ...] = ()
    inertial: tuple[Number, ...] = ()
    shapes: tuple[Shape, ...] = ()

    @property
    def numbers(self) -> list[Number]:
        """All numbers that define the frame: in the transforms to it, and in its joint, mass and shapes."""
        edges = [edge for edge in (*self.chain[-1:], *self.others) if edge.child == self.name]
        groups = [*(edge.numbers for edge in edges), self.joint, self.inertial, *(one.numbers for one in self.shapes)]
        return [number for group in groups for number in group]


class Answer(NamedTuple):
    """The requested numbers of a frame, or all numbers of an entry that defines no frame."""

    name: str
    numbers: tuple[Number, ...]


class NamedValue(NamedTuple):
    """An argument or named value, and the positions of the expressions that use it."""

    name: str
    meaning: NameOrigin
    used_by: tuple[Where, ...]


def explain(
    expanded: ExpandedDescription,
    lowered: LoweredRobot,
    arguments: Mapping[str, Any],
    names: Sequence[str],
    pose: str = "",
) -> list[Explanation | Answer | NamedValue]:
    """Explain frames, links, joints, sensors, ``use`` entries, arguments and named values of a description.

    Names of numbers ("z", "mass", "upper") in ``names`` restrict the result to these numbers. ``arguments`` are the
    values of this run. If ``pose`` names a joint pose, poses of frames are also calculated for it. Raises UnknownName.
    """
    if expanded.tree is None or expanded.scope is None or lowered.robot is None or expanded.symbols is None:
        raise ValueError("a description with errors has no meaning to explain")
    robot, origins = lowered.robot, Origins(expanded.tree, expanded.scope, arguments)
    frames = _Frames(robot, lowered.places, origins)
    explained = [section for section, node in sections().items() if node.explained is True]
    entries = {name: (section, name) for section in explained for name in expanded.tree.get(section) or ()}
    targets = {name: frames.meant_by(name) for name in names}
    shown = dict.fromkeys(target for found in targets.values() for target in found)
    answers: list[Explanation | Answer] = [frames.explanation(target, pose) for target in shown]
    others = [name for name in names if not targets[name]]
    answers += [Answer(name, tuple(_inner(frames.numbers(entries[name])))) for name in others if name in entries]
    numbers = {number.name for answer in answers for number in answer.numbers}
    words: list[str] = []
    values: list[NamedValue] = []
    for name in (name for name in others if name not in entries):
        if any(_is_called(number, name) for number in numbers):
            words.append(name)
        elif name in expanded.scope.places:
            uses = (use for use in expanded.symbols.references(("value",)) if (use.name, use.owner) == (name, ""))
            spans = dict.fromkeys(use.place.span for use in uses if use.place)
            meaning = origins.explain_name(name, "", origins.root, origins.root)
            values.append(NamedValue(name, meaning, tuple(map(origins.where, spans))))
        else:
            known = {*frames.names, *robot.joint, *entries, *expanded.scope.places, *numbers}
            known.update(sensor.name for sensor in robot.sensors)
            known.update(use for frame in frames.names for use in frames.uses(frame))
            raise UnknownName("frame, link, joint, sensor, use, value or number", name, known)
    added = tuple(f"{section} " for section in robot.sections.said)
    return [*(_selected(answer, words, added) if words else answer for answer in answers), *values]


def _is_called(number: str, word: str) -> bool:
    """Return True if the user's ``word`` selects a number: "ixx" selects "inertia ixx", "xyz" selects "x"."""
    return word in (number, number.partition("[")[0]) or word in number.split() or number in _AXES.get(word, ())


def _selected(answer: Explanation | Answer, words: Sequence[str], added: tuple[str, ...]) -> Answer:
    selected: dict[Number, None] = {}
    for word in words:
        called = [number for number in answer.numbers if _is_called(number.name, word)]
        if any(number.name == word for number in called):
            called = [n for n in called if n.name in (word, f"{word} in all") or n.name.startswith(added)]
        selected |= dict.fromkeys(called)
    return Answer(answer.name, tuple(selected))


class _Frames:
    def __init__(self, robot: Robot, places: Mapping[tuple[str, str], Path], origins: Origins) -> None:
        self.robot, self.places, self.origins = robot, places, origins
        ends = [name for edge in robot.edges for name in (edge.parent, edge.child)]
        self.names = list(dict.fromkeys([*(link.name for link in robot.links), *ends]))

    def uses(self, frame: str) -> list[str]:
        place = self.places.get(("link", frame))
        stack = self.origins.place_of(place)[1] if place is not None else ()
        names = [use[1] for step in reversed(stack) if (use := _USE.match(step.message))]
        return ["_".join(names[: count + 1]) for count in range(len(names))]

    def meant_by(self, name: str) -> list[str]:
        found = [name] if name in self.names else []
        found += [sensor.frame for sensor in self.robot.sensors if sensor.name == name]
        found += [joint.child for joint in self.robot.joints if joint.name == name]
        return list(dict.fromkeys(found or [frame for frame in self.names if name in self.uses(frame)]))

    def explanation(self, name: str, pose: str) -> Explanation:
        robot, chain, roles = self.robot, self._chain(name), tuple(self._roles(name))
        placed = tuple(self._placed(name, chain, pose) for pose in dict.fromkeys(("", pose)))
        joints = [joint.child for joint in robot.joints_from.get(name, ())]
        children = tuple(dict.fromkeys([*joints, *(edge.child for edge in robot.edges if edge.parent == name)]))
        if name not in robot.link:
            return Explanation(name, roles, None, (), chain, (), placed, children)
        where, stack = self.origins.place_of(self.places["link", name])
        joint, link = robot.joint_to.get(name), robot.link[name]
        numbers = () if joint is None else tuple(self._numbers_of_joint(joint))
        mass, shapes = tuple(self._numbers_of_mass(link)), tuple(self._shapes(link))
        others = self._edges_to(name)
        return Explanation(name, roles, where, stack, chain, others, placed, children, numbers, mass, shapes)

    def _roles(self, name: str) -> Iterator[str]:
        link, joint = self.robot.link.get(name), self.robot.joint_to.get(name)
        if link is None:
            yield "frame of other nodes"
        else:
            yield "link" if link.inertial is not None or link.visual or link.collision else "frame"
        for sensor in self.robot.sensors:
            for frame, what in ((sensor.frame, "frame"), (sensor.optical_frame, "optical frame")):
                if frame == name:
                    yield f'{what} of the sensor "{sensor.name}" ({sensor.type})'
        if joint is not None or link is not None:
            yield "root" if joint is None else f'child of the joint "{joint.name}"'

    def _chain(self, frame: str) -> tuple[Edge, ...]:
        visited: set[str] = set()
        below: list[Edge] = []
        while frame not in self.robot.link:
            edges = () if frame in visited else self._edges_to(frame)
            if not edges:
                return tuple(below)
            visited.add(frame)
            frame = edges[0].parent
            below = [*(edge for edge in edges if edge.parent == frame), *below]
        return (*map(self._edge_of_joint, self.robot.chain(frame)), *below)

    def _placed(self, frame: str, chain: Sequence[Edge], pose: str) -> FramePose:
        positions = self.robot.positions(pose) if pose else {}
        root, found = chain[0].parent if chain else frame, Rigid()
        for ends in dict.fromkeys((edge.parent, edge.child) for edge in chain):
            joint = self.robot.joint_to.get(ends[1])
            if joint is not None and joint.parent == ends[0]:
                found = found.then(joint.transform(self.robot.position(joint, positions)))
                continue
            poses = {edge.pose for edge in self.robot.edges if (edge.parent, edge.child) == ends}
            step = poses.pop()
            if step is None or poses:
                return FramePose(pose, root, None)
            found = found.then(step.transform())
        return FramePose(pose, root, Transform.from_rigid(found))

    def _edge_of_joint(self, joint: Joint) -> Edge:
        path = self.places["joint", joint.name]
        numbers = list(self._pose(path, joint.origin))
        if path[0] in self.robot.sections.said:  # a plug-in section may calculate the numbers
            numbers = [number._replace(origin=None, note=f"of {path[0]}") for number in numbers]
        if joint.moves or joint.type == "planar":
            numbers += self._vector((*path, "axis"), joint.axis, "")
        topic = "" if joint.publisher.kind == UNPUBLISHED else "/tf" if joint.moves_on_tf else "/tf_static"
        in_turns = joint.name in self.robot.mode_dependent_edges
        publisher = "published in turns" if in_turns else _in_words(joint.publisher)
        ends = (joint.parent, joint.child, joint.name, joint.type)
        transform = Transform.from_rigid(joint.transform())
        return Edge(*ends, publisher, topic, "", transform, tuple(numbers), *self.origins.place_of(path))

    def _edges_to(self, frame: str) -> tuple[Edge, ...]:
        found = []
        for index, edge in [(index, edge) for index, edge in enumerate(self.robot.edges) if edge.child == frame]:
            path: Path = self.places["joint", edge.joint] if edge.joint else ("edges", index)
            transform = None if edge.pose is None else Transform.from_rigid(edge.pose.transform())
            numbers = () if edge.pose is None else tuple(self._pose(path, edge.pose))
            ends = (edge.parent, frame, "", "", _in_words(edge.publisher), "/tf" if edge.moving else "/tf_static")
            found.append(Edge(*ends, edge.when, transform, numbers, *self.origins.place_of(path)))
        return tuple(found)

    def _pose(self, path: Path, pose: Pose) -> Iterator[Number]:
        yield from self._vector((*path, "xyz"), pose.xyz, "m")
        yield from self._vector((*path, "rpy"), pose.rpy, "rad", _OPTICAL if path[-1] == "optical" else "not written")

    def _vector(self, path: Path, values: Vector, unit: str, note: str = "not written") -> Iterator[Number]:
        names = _AXES.get(path[-1]) or [f"{path[-1]} {axis}" for axis in "xyz"]
        for index, value in enumerate(values):
            origin = self.origins.origin_of((*path, index))
            yield Number(names[index], value, unit, origin, "" if origin else note)

    def numbers(self, path: Path, joint: Joint | None = None) -> Iterator[Number]:
        leader = self.robot.joint.get(joint.mimic.joint) if joint is not None and joint.mimic is not None else None
        slides, leads = (one is not None and one.type in ("prismatic", "planar") for one in (joint, leader))

        def below(here: Path, value: object) -> Iterator[Number]:
            if isinstance(value, list) and any(isinstance(item, list) for item in value):
                return  # a height map has too many numbers to list
            if isinstance(value, (dict, list)):
                for key, item in value.items() if isinstance(value, dict) else enumerate(value):
                    yield from below((*here, key), item)
            elif isinstance(value, (int, float)) and not isinstance(value, bool):
                unit = joint_unit(here, slides, leads if leader is not None else None) or ""
                yield Number(_name_of(here[len(path) - 1 :]), float(value), unit, self.origins.origin_of(here))

        return below(path, value_at(self.origins.tree, path))

    def _entries_naming(self, kind: str, name: str, section: str) -> list[Path]:
        references = SymbolTable(self.origins.tree).references((kind,), section)
        return list(dict.fromkeys(reference.path[:-1] for reference in references if reference.name == name))

    def _numbers_of_joint(self, joint: Joint) -> Iterator[Number]:
        path = self.places["joint", joint.name]
        for key in () if path[0] in self.robot.sections.said else _KEYS_OF_JOINT:
            yield from self.numbers((*path, key), joint)
        for section, node in sections().items():
            if isinstance(node.explained, str):
                for name in sorted({str(path[1]) for path in self._entries_naming("joint", joint.name, section)}):
                    for key in fragment_at((section, "*"))["properties"]:
                        for number in self.numbers((section, name, key)):
                            yield number._replace(name=f"{node.explained} {number.name}")

    def _numbers_of_mass(self, link: Link) -> Iterator[Number]:
        path = self.places["link", link.name]
        before = self.robot.without_plugin_entries().link.get(link.name)
        inertial = before.inertial if before is not None else None
        if path[0] == "links" and inertial is not None:
            written = {number.name: number for number in _inner(self.numbers((*path, "inertial")))}
            yield from written.values()
            calculated = {"mass": (inertial.mass, "kg")}
            for key, values, unit in (("xyz", inertial.pose.xyz, "m"), ("rpy", inertial.pose.rpy, "rad")):
                calculated |= {f"{key} {axis}": (value, unit) for axis, value in zip(_AXES[key], values, strict=True)}
            moments = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
            calculated |= {f"inertia {name}": (getattr(inertial, name), "kg*m^2") for name in moments}
            for name, value in calculated.items() if "inertia ixx" not in written else ():
                if name not in written:
                    yield Number(name, *value, None, "calculated from the shapes")
        if link.inertial is not None and link.inertial != inertial:
            for section in self.robot.sections.said:
                for path in self._entries_naming("link", link.name, section):
                    for number in self.numbers(path):
                        yield number._replace(name=f"{' '.join(map(str, path[:-1]))} {number.name}".strip())
            yield Number("mass in all", link.inertial.mass, "kg", None, "with what is added to it")

    def _shapes(self, link: Link) -> Iterator[Shape]:
        for purpose, shapes in (("collision", link.collision), ("visual", link.visual)):
            for index in range(len(shapes)):
                here: Path = (*self.places["link", link.name], purpose, index)
                yield Shape(purpose, tuple(_inner(self.numbers(here))), self.origins.place_of(here)[0])


def _name_of(steps: Path) -> str:
    words = str(steps[0])
    for before, step in pairwise(steps):
        axes = _AXES.get(before, ())
        at_axis = isinstance(step, int) and step < len(axes)
        words += f" {axes[int(step)] if at_axis else step}" if at_axis or isinstance(step, str) else f"[{step}]"
    return words


def _inner(numbers: Iterable[Number]) -> Iterator[Number]:
    """Yield numbers without the first word of their names: "inertial mass" becomes "mass"."""
    return (number._replace(name=number.name.partition(" ")[2]) for number in numbers)


def _in_words(publisher: Publisher) -> str:
    if publisher.simulated:
        return f"of simulations alone: {publisher.about}"
    if publisher.kind == UNPUBLISHED:
        return f"no node publishes it: {publisher.about}".removesuffix(": ")
    static = "the static_transform_publisher " if publisher.kind == STATIC_TRANSFORM_PUBLISHER else ""
    about = f" ({publisher.about})" if publisher.kind == NODE and publisher.about else ""
    return f"published by {static}{publisher.name}{about}"


def lines(found: Explanation | Answer | NamedValue) -> Iterator[str]:
    """Yield the lines that ``rosorin-compile explain`` prints for a result."""
    if isinstance(found, NamedValue):
        yield from _meanings([found.meaning], 0)
        yield "  used by:" if found.used_by else "  nothing uses it"
        yield from (f"    {_place(where)}  {where.text}" for where in found.used_by)
        return
    if isinstance(found, Answer):
        yield found.name
        yield from _numbers(found.numbers, ()) if found.numbers else ("    has none of these numbers",)
        return
    yield f"{found.name}: {', '.join(found.roles)}"
    if found.where is not None:
        yield f"  {_place(found.where)}"
        yield from _stack(found.stack, 2)
    if found.children:
        yield f"  carries {', '.join(found.children)}"
    yield ""
    if found.chain:
        yield f"From {found.chain[0].parent} to {found.name}, moving joints at zero:"
        yield from (line for edge in found.chain for line in _edge(edge))
    if found.others:
        yield "Other nodes place it as well:"
        yield from (line for edge in found.others for line in _edge(edge))
    for placed in found.placed if found.chain else ():
        pose = f'in the pose "{placed.pose}"' if placed.pose else "with all joints at zero"
        yield f"{found.name} in {placed.root}, {pose}:"
        if placed.transform is None:
            yield "  not known: another node alone knows an edge of the chain"
        else:
            titles = ("xyz", "rpy", "", "quaternion x y z w")
            for title, row, unit in zip(titles, placed.transform, (" m", " rad", " deg", ""), strict=True):
                yield f"  {title:18}  {_row(row)}{unit}"
        yield ""
    if found.joint:
        yield f"Joint {found.chain[-1].joint}:"
        yield from (*_numbers(found.joint, found.chain[-1].stack), "")
    if found.inertial:
        yield from ("Mass:", *_numbers(found.inertial, found.stack), "")
    if found.shapes:
        yield "Shapes:"
        for shape in found.shapes:
            yield f"  {shape.purpose}  {_place(shape.where)}  {shape.where.text}"
            yield from _numbers(shape.numbers, found.stack)
        yield ""


def _edge(edge: Edge) -> Iterator[str]:
    joint = f"{edge.joint}, {edge.type}, " if edge.joint else ""
    where = (f" on {edge.topic}" if edge.topic else "") + (f", when {edge.when}" if edge.when else "")
    yield f"  {edge.parent} -> {edge.child}: {joint}{edge.publisher}{where}"
    yield f"    {_place(edge.where)}"
    yield from _stack(edge.stack, 4)
    if edge.transform is None:
        yield "    the numbers are known only to that node"
    else:
        yield from _numbers(edge.numbers, edge.stack)
        yield f"    quaternion x y z w  {_row(edge.transform.quaternion_xyzw)}"
    yield ""


def _numbers(numbers: Sequence[Number], known: Sequence[Step]) -> Iterator[str]:
    rows = []
    for number in _merge_zeros(numbers):
        degrees = f" ({to_fixed(math.degrees(number.value), 6)} deg)" if number.unit == "rad" and number.value else ""
        value, source = f"{exact(number.value)} {number.unit}".rstrip() + degrees, number.note
        if number.origin is not None:
            where, combined = number.origin.where, "of the pose in the part and that of its mount"
            source = combined if number.origin.parts else f"{_place(where)}  {where.text}"
        rows.append((number.name, value, source, list(_details(number.origin, known)) if number.origin else []))
    width, value_width = (max((len(row[column]) for row in rows), default=0) for column in (0, 1))
    for (name, value, source, details), following in zip(rows, [*(row[3] for row in rows[1:]), []], strict=False):
        yield f"    {name:{width}}  {value:{value_width}}  {source}".rstrip()
        yield from details if details != following else ()


def _details(origin: Origin, known: Sequence[Step]) -> Iterator[str]:
    for part in origin.parts:
        yield f"        {_place(part.where)}  {part.where.text}"
        yield from _meanings(part.names, 10)
    yield from _meanings(origin.names, 8)
    yield from (f"        {_place(where)}: taken over by {where.text}" for where in origin.expressions)
    yield from _stack(origin.stack, 8) if origin.stack != tuple(known) else ()


def _merge_zeros(numbers: Sequence[Number]) -> Iterator[Number]:
    while numbers:
        three = numbers[:3]
        names = " ".join(number.name for number in three)
        merge = names in ("x y z", "roll pitch yaw") and all(n.origin is None and n.value == 0 for n in three)
        yield three[0]._replace(name=names) if merge else three[0]
        numbers = numbers[3 if merge else 1 :]


def _row(values: Sequence[float]) -> str:
    return "  ".join(to_fixed(value, _DIGITS) for value in values)


def _meanings(names: Sequence[NameOrigin], indent: int) -> Iterator[str]:
    for meaning in names:
        place = f"  {_place(meaning.where)}  {meaning.where.text}" if meaning.where else ""
        value = f" = {meaning.value}" if meaning.value else ""
        yield f"{'':{indent}}{meaning.name}{value}: {meaning.given_by}{place}".rstrip()
        yield from _meanings(meaning.names, indent + 2)


def _stack(stack: Sequence[Step], indent: int) -> Iterator[str]:
    return (f"{'':{indent}}{_place(step.where)}: {step.message}" for step in stack)


def _place(where: Where) -> str:
    return f"{where.file}:{where.line}:{where.column}"
