"""Simulation: what differs in what two descriptions have for a simulation alone, value by value.

Artifacts are not compared by it: an MJCF has it in words of its own, a URDF not at all.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from typing import Any

from rosorin_compile.language.schema import sections
from rosorin_compile.model import Joint, Link, Robot, Shape
from rosorin_compile.model.sections import own_sections
from rosorin_compile.source.xml.elements import fragments

from .difference import OTHER, Item
from .values import Said, changed_values, text_of


def count_of(robot: Robot) -> int:
    """Return how many things a robot has for a simulation alone."""
    elements = (robot.mjcf_elements, *(one.mjcf_elements for one in robot.links))
    return len(_things(robot)) + sum(map(len, elements))


def compare_simulation(a: Robot, b: Robot) -> Iterator[Item]:
    """Yield what differs: what is new or gone, and of what both have each value that changed."""
    yield from changed_values("simulation", _things(a), _things(b))
    for name, one, other in _kept(a, b):
        gone, fresh = fragments(one) - fragments(other), fragments(other) - fragments(one)
        for what, counts in (("new", fresh), ("removed", gone)):
            for text in sorted(counts.elements()):
                values = (None, text) if what == "new" else (text, None)
                yield Item(OTHER, name, "mjcf_elements", f"MJCF elements of {name}: {what} {_short(text)}", *values)


def _kept(a: Robot, b: Robot) -> Iterator[tuple[str, Sequence[str], Sequence[str]]]:
    one, other = a.mjcf_elements, b.mjcf_elements
    yield "the robot", one, other
    for name in a.link:
        if name in b.link:
            yield name, a.link[name].mjcf_elements, b.link[name].mjcf_elements


_MOST = 50


def _short(text: str) -> str:
    return f"{text[:_MOST]}..." if len(text) > _MOST else text


def _things(robot: Robot) -> dict[str, Said]:
    """Return all that a robot has for a simulation, by what it is called, each as words with values.

    Entries of sections stand behind links and joints; what is said of the robot as a whole comes last.
    """
    things: dict[str, Said] = {}
    for link in robot.links:
        things |= _of_link(link)
    for joint in robot.joints:
        things |= _of_joint(joint)
    things |= _of_sections(robot, whole=False)
    for material in robot.materials:
        things |= {f"material {material.name}": words_of(material.mjcf)} if material.mjcf else {}
    for pose in robot.poses:
        values = {"base": pose.base, **pose.controls, **pose.mjcf}
        things |= {f"pose {pose.name} in simulation": words_of(values)} if words_of(values) else {}
    things |= _of_sections(robot, whole=True)
    root = words_of(robot.root_in_world)
    return things | ({"root": root} if root else {})


def _of_sections(robot: Robot, whole: bool) -> dict[str, Said]:
    """Return what sections for a simulation tell: those of entries, or those that are said of the robot as a whole."""
    things: dict[str, Said] = {}
    for section in own_sections():
        if section.describe is not None and sections()[section.name].whole == whole:
            things |= section.describe(getattr(robot, section.name))
    return things


def _of_link(link: Link) -> dict[str, Said]:
    things: dict[str, Said] = {f"{mark.tag} {mark.name}": {"link": link.name, **words_of(mark)} for mark in link.marked}
    own = {"gravity_compensation": link.gravity_compensation or None, **link.mjcf}
    things |= {f"link {link.name} in simulation": words_of(own)} if words_of(own) else {}
    for purpose in ("collision", "visual"):
        shapes: Sequence[Shape] = getattr(link, purpose)
        for index, shape in enumerate(shapes, start=1):
            values = {**words_of(shape.contact), **words_of(shape.mjcf)} if shape.contact or shape.mjcf else {}
            things |= {f"{purpose} shape {index} of {link.name} in simulation": values} if values else {}
    return things


def _of_joint(joint: Joint) -> dict[str, Said]:
    things: dict[str, Said] = {}
    if joint.actuator is not None:  # its gains are compared as those of the joint
        others = ("kp", "kv", "damping", "joint")
        values = {word: value for word, value in words_of(joint.actuator).items() if word not in others}
        values |= {"name": joint.actuator.name} if joint.actuator.name else {}
        things |= {f"actuator of {joint.name}": values} if values else {}
    if joint.mimic is not None:
        values = {word: value for word, value in words_of(joint.mimic).items() if word in ("solref", "solimp")}
        values |= {"name": joint.mimic.name} if joint.mimic.name else {}
        things |= {f"mimic of {joint.name} in simulation": values} if values else {}
    if joint.mjcf:
        things[f"joint {joint.name} in simulation"] = words_of(joint.mjcf)
    return things


def words_of(value: Any) -> dict[str, Any]:
    """Return the words of an entry and their values; what is as it is by default is left out."""
    if isinstance(value, Mapping):
        return {word: one for word, one in value.items() if text_of(one)}
    words: dict[str, Any] = {}
    for field in fields(value) if value is not None else ():
        inner = getattr(value, field.name)
        if field.name in ("name", "tag") or inner == field.default:
            continue
        if isinstance(inner, Mapping):
            words |= words_of(inner)
        elif text_of(inner):
            words[field.name] = inner
    return words
