"""Sections that packages bring: their values, made of the tree by the schema and the fields of their records."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from functools import cache
from typing import Any

from rosorin_compile.model import Robot
from rosorin_compile.model.sections import ENTRIES, ITEMS, NO_SECTIONS, SECTIONS, Section, Sections, section_named
from rosorin_compile.source.diagnostics import Diagnostic, did_you_mean
from rosorin_compile.source.plugins import aside, failed
from rosorin_compile.source.tree import Map, Path

from ..annotations import sections
from ..mentions import givers, mentions
from ..schema import fragment_at, resolve, schema
from ..section_registry import plugged
from .entries import Problem
from .plainly import named_records, plain, record_of

Tell = Callable[[Diagnostic, str], None]
Place = Callable[[str, str, Path], None]


def lower_own_sections(tree: Mapping[str, Any], problem: Problem) -> dict[str, Any]:
    """Return the values of the sections in ``model.sections.SECTIONS`` that a description has, by name."""
    made = {}
    for name in SECTIONS:
        lower = section_named(name).lower if tree.get(name) is not None else None
        if lower is not None and (value := lower(tree, problem)):
            made[name] = value
    return made


def lower_sections(tree: Mapping[str, Any], tell: Tell) -> Sections:
    """Return the contents and the values of the sections of plug-ins.

    ``tell`` takes what is wrong with the plug-in of a section, and the name of that; it has no value then.
    """
    there = [name for name in _without_fields() if tree.get(name) is not None]
    if not there:
        return NO_SECTIONS
    values: dict[str, Any] = {}
    said = {name: completed(schema()["properties"][name], plain(tree[name])) for name in there}
    for plugin, section in plugged().sections:
        if section.name in said:
            try:
                with aside(plugin):
                    values[section.name] = _value(section, said[section.name])
            except (Exception, SystemExit) as fault:
                tell(failed(plugin, fault), section.name)
    return Sections(values, said)


@cache
def _without_fields() -> tuple[str, ...]:
    """Return the sections of packages: the model has no value of them, and the schema says that they are compared."""
    known = {field.name for field in fields(Robot)}
    return tuple(name for name, node in sections().items() if node.compared and name not in known)


def with_sections(robot: Robot, tree: Map, tell: Tell, place: Place) -> Robot:
    """Return a robot with what its sections add to it; ``tell`` as in ``lower_sections``.

    ``place`` takes the kind and the name of each link and joint that is added, and where it is said. A section that
    names a link or a joint that is not there adds nothing: the rules tell that.
    """
    made = robot
    for plugin, section in plugged().sections:
        if section.adds is not None and section in robot.sections and is_resolved(made, tree, section.name):
            before = made
            try:
                with aside(plugin):
                    made = _sound(section.adds(made, robot.sections[section]), made)
            except (Exception, SystemExit) as fault:
                tell(failed(plugin, fault), section.name)
            _place(before, made, tree, section.name, place)
    return made if made is robot else replace(made, sections=replace(robot.sections, without=robot))


def _place(before: Robot, made: Robot, tree: Map, section: str, place: Place) -> None:
    """Say where the links and joints are said that a section has added; a joint with the link that it leads to."""
    said = {(kind, name): path for kind, name, path in givers(tree, section)}
    links = Counter(link.name for link in made.links) - Counter(link.name for link in before.links)
    for name in links.elements():
        place("link", name, said.get(("link", name), (section,)))
    twice = {name for name, count in Counter(link.name for link in made.links).items() if count > 1}
    joints = Counter(joint.name for joint in made.joints) - Counter(joint.name for joint in before.joints)
    for joint in reversed(made.joints):
        if joints[joint.name] > 0 and joint.child not in twice:  # which is told already
            joints[joint.name] -= 1
            path = said.get(("joint", joint.name)) or said.get(("link", joint.child)) or (section,)
            place("joint", joint.name, path)


def is_resolved(robot: Robot, tree: Map, section: str) -> bool:
    """Say whether all links and joints that a section names are there."""
    there = {"link": robot.link, "joint": robot.joint}
    named = mentions(tree, there.keys(), section)
    return all(one.name in there[one.kind] for one in named)


def _sound(made: object, before: Robot) -> Robot:
    """Return what a section has made of a robot. Raises TypeError or ValueError for what is none."""
    if not isinstance(made, Robot):
        raise TypeError(f"what a section adds to is a Robot again, not {str(made)[:60]!r}")
    types = fragment_at(("joints", "*", "type"))["enum"]
    names, known = {link.name for link in made.links}, {id(joint) for joint in before.joints}
    for joint in (one for one in made.joints if id(one) not in known):
        for end in (joint.parent, joint.child):
            if end not in names:
                raise ValueError(f'it adds joint "{joint.name}" at link "{end}", which there is not')
        if joint.type not in types:
            raise ValueError(f'it adds joint "{joint.name}" of type "{joint.type}"; {did_you_mean(joint.type, types)}')
    return made


def _value(section: Section[Any], said: Any) -> Any:
    """Return the value of a section of what is said in it."""
    if section.form == ENTRIES:
        return named_records(section.entry, said)
    if section.form == ITEMS:
        return tuple(record_of(section.entry, entry) for entry in said)
    return record_of(section.entry, said)


def completed(fragment: Mapping[str, Any], value: Any) -> Any:
    """Return a plain value with what the schema says by default; an entry that is left empty is a mapping."""
    said = resolve(dict(fragment))
    if isinstance(value, tuple):
        return tuple(completed(said.get("items", {}), one) for one in value)
    properties, others = said.get("properties", {}), said.get("additionalProperties")
    if value is None and (properties or isinstance(others, Mapping)):
        value = {}
    if not isinstance(value, Mapping):
        return value
    defaults = {key: one["default"] for key, one in properties.items() if "default" in resolve(dict(one))}
    inner = {key: properties.get(key, others if isinstance(others, Mapping) else {}) for key in (*defaults, *value)}
    return {key: completed(inner[key], value.get(key, defaults.get(key))) for key in inner}
