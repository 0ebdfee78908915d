"""Others: publishers, transforms of other nodes, named poses, sensors and elements for URDF."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import reduce

from rosorin_compile.formats import FORMATS, Fact, Value
from rosorin_compile.language.schema import sections
from rosorin_compile.model import Edge, Publisher, Robot
from rosorin_compile.model.joint import UNPUBLISHED
from rosorin_compile.model.robot import JointPose
from rosorin_compile.model.sections import own_sections

from .difference import OTHER, Item, Side
from .drive import compare_drive
from .joints import differ, unit_of
from .pairing import Pairing
from .plainly import compare_rest, either
from .proof.elements import Context, Key, context_of, meanings, spelt
from .servos import compare_servos
from .simulation import compare_simulation
from .values import text_of
from .wording import contacts_change, number_change, value_change

_MOST = 50

_SECTIONS = "sections"  # those of ``model.sections.SECTIONS``, each by its own topic

Compare = Callable[[Pairing, tuple[Side, Side]], Iterator[Item]]

# What compares each topic beside links and joints, in the order in which it is told; "rest" is what has none.
_COMPARED: Mapping[str, Compare] = {
    "publisher": lambda pairing, _: _publishers(pairing),
    "edge": lambda pairing, _: _edges(pairing),
    "pose": lambda pairing, _: _poses(pairing),
    "servo": compare_servos,
    "simulation": lambda pairing, _: compare_simulation(pairing.a.robot, pairing.b.robot),
    "sensor": lambda pairing, _: _sensors(pairing.a.robot, pairing.b.robot),
    "drive": lambda pairing, _: compare_drive(pairing),
    _SECTIONS: lambda *_: iter(()),
    "rest": compare_rest,
    "contact": lambda pairing, _: _disabled_contacts(pairing),
    "urdf_elements": lambda pairing, _: _elements(pairing),
}


def compare_others(pairing: Pairing, sides: tuple[Side, Side], unsaid: frozenset[str]) -> Iterator[Item]:
    """Yield what differs beside links and joints; ``unsaid`` is what is not compared."""
    for topic, compare in _COMPARED.items():
        if topic == _SECTIONS:
            for section in own_sections():
                if section.compare is not None and sections()[section.name].topic not in unsaid:
                    yield from section.compare(pairing, sides)
        elif topic not in unsaid:
            yield from compare(pairing, sides)


def _disabled_contacts(pairing: Pairing) -> Iterator[Item]:
    """Yield the pairs of links that are new or gone, as one difference."""
    robots = pairing.a.robot, pairing.b.robot
    old, new = ({" - ".join(sorted(pair)) for pair in robot.disabled_contacts} for robot in robots)
    if old != new:
        text = contacts_change(sorted(new - old), sorted(old - new)).text
        yield Item(OTHER, "contacts", "contacts", text, ", ".join(sorted(old)), ", ".join(sorted(new)))


def _text(publisher: Publisher) -> str:
    if publisher.simulated:
        return "simulations"
    return "nobody" if publisher.kind == UNPUBLISHED else publisher.name


def _published(name: str, old: Publisher, new: Publisher) -> Item:
    names = _text(old), _text(new)
    text = value_change(Fact("frame", name, "publisher").about, Value(names[0]), Value(names[1])).text
    return Item(OTHER, name, "publisher", text, *names)


def _publishers(pairing: Pairing) -> Iterator[Item]:
    for name in pairing.shared:
        mine, theirs = pairing.a.robot.joint_to.get(name), pairing.b.robot.joint_to.get(name)
        if mine is None or theirs is None:
            continue
        old, new = mine.publisher, theirs.publisher
        if (old.kind, old.name, old.simulated) != (new.kind, new.name, new.simulated):
            yield _published(name, old, new)


def _edges(pairing: Pairing) -> Iterator[Item]:
    old, new = _by_name(pairing.a.robot.edges), _by_name(pairing.b.robot.edges)
    yield from either("transform", old, new)
    for name in old:
        if name not in new:
            continue
        one, other = old[name], new[name]
        if _text(one.publisher) != _text(other.publisher):
            yield _published(name, one.publisher, other.publisher)
        if (one.pose, one.moving) != (other.pose, other.moving):
            said = _place(one, other), _place(other, one)
            yield Item(OTHER, name, "origin", f"{name}: {said[0]} -> {said[1]}", *said)


def _by_name(edges: tuple[Edge, ...]) -> dict[str, Edge]:
    return {f"{e.parent} -> {e.child}{f' when {e.when}' if e.when else ''}": e for e in edges}


def _place(edge: Edge, other: Edge) -> str:
    """Return where an edge is in words, with the digits that tell it from another one."""
    motion = "moving" if edge.moving else "static"
    return f"{motion} {text_of(edge.pose, other.pose)}" if edge.pose else f"{motion}, numbers not known"


def _poses(pairing: Pairing) -> Iterator[Item]:
    a, b = pairing.a.robot, pairing.b.robot
    old: dict[str, JointPose] = {pose.name: pose for pose in a.poses}
    new: dict[str, JointPose] = {pose.name: pose for pose in b.poses}
    yield from either("pose", old, new)
    for name in old:
        if name not in new:
            continue
        for joint in a.joints_down():
            # A follower is where its leader puts it.
            if not joint.moves or joint.mimic is not None or joint.name not in b.joint:
                continue
            values = old[name].positions.get(joint.name, 0.0), new[name].positions.get(joint.name, 0.0)
            if differ(pairing.a, pairing.b, joint.name, values, pairing.tolerance, 1.0):
                unit = unit_of(joint, joint.name)
                text = str(number_change(Fact("pose", name, joint.name).about, *values, unit))
                yield Item(OTHER, name, f"pose {joint.name}", text, *values, unit)


def _sensors(a: Robot, b: Robot) -> Iterator[Item]:
    """Yield what differs in the types and frames of sensors."""
    old, new = {sensor.name: sensor for sensor in a.sensors}, {sensor.name: sensor for sensor in b.sensors}
    yield from either("sensor", old, new)
    for name in old:
        for quantity in ("type", "frame", "optical_frame"):
            if name not in new:
                continue
            before, after = str(getattr(old[name], quantity)), str(getattr(new[name], quantity))
            if before != after:
                text = f"sensor {name} {quantity.replace('_', ' ')} {before or 'none'} -> {after or 'none'}"
                yield Item(OTHER, name, quantity, text, before, after)


def _elements(pairing: Pairing) -> Iterator[Item]:
    a, b = pairing.a.robot, pairing.b.robot
    context = context_of(a, a.asks_for_humble or b.asks_for_humble)
    places = [("the robot", a.urdf_elements, b.urdf_elements)]
    places += [(n, a.link[n].urdf_elements, b.link[n].urdf_elements) for n in a.link if n in b.link]
    places += [(n, a.joint[n].urdf_elements, b.joint[n].urdf_elements) for n in a.joint if n in b.joint]
    for name, mine, theirs in places:
        whole = name == "the robot"
        if mine == theirs and not whole:
            continue
        old, new = meanings(mine, context), meanings(theirs, context)
        lost, found = old - new, new - old
        if whole:
            lost, found = lost - _brought(b, context), found - _brought(a, context)
            lost, found = lost | (_always(a, b, context) - new), found | (_always(b, a, context) - old)
        gone, fresh = sorted(map(spelt, lost.elements())), sorted(map(spelt, found.elements()))
        if not gone and not fresh:
            continue
        parts = [
            f"{len(texts)} {word} ({_short(texts[0])})" for texts, word in ((fresh, "new"), (gone, "removed")) if texts
        ]
        text = f"URDF elements of {name}: {', '.join(parts)}"
        yield Item(OTHER, name, "urdf_elements", text, "; ".join(gone) or None, "; ".join(fresh) or None)


def _brought(robot: Robot, context: Context) -> Counter[Key]:
    """Return the elements that outputs of a robot make of what its description says in words."""
    return meanings([text for texts in _by_output(robot) for text in texts], context)


def _always(robot: Robot, other: Robot, context: Context) -> Counter[Key]:
    """Return the elements that every output of a description brings, where the other robot is a file and has none."""
    made = [] if other.outputs else [meanings(texts, context) for texts in _by_output(robot)]
    return reduce(lambda one, two: one & two, made) if made else Counter()


def _by_output(robot: Robot) -> list[Sequence[str]]:
    known = [(FORMATS[output.backend], output) for output in robot.outputs if output.backend in FORMATS]
    return [one.writing.brings(robot, output) for one, output in known if one.writing.brings]


def _short(text: str) -> str:
    return f"{text[:_MOST]}..." if len(text) > _MOST else text
