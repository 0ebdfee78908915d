"""Renaming: a robot under other names of links and joints, at each place that names one, as the schema says.

A record of the model has the keys of the entry that it was made of as fields, and its key as ``name``; a tuple in its
place is the one list of names that the entry has. What has another form is renamed by a function of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

from rosorin_compile.language.annotations import GIVES, Node
from rosorin_compile.language.schema import sections
from rosorin_compile.model import Link, Robot, Sensor
from rosorin_compile.model.sections import Sections
from rosorin_compile.model.simulation import Renames

Rename = Callable[[str], str]


def renamed(robot: Robot, links: Mapping[str, str], joints: Mapping[str, str]) -> Robot:
    """Return a robot under other names; links and joints that are not mentioned keep theirs."""
    walk = _Walk(lambda name: links.get(name, name), lambda name: joints.get(name, name))
    known = (field.name for field in fields(robot) if field.name in sections())
    found = {name: walk.value(sections()[name], getattr(robot, name)) for name in known}
    return replace(robot, sections=walk.through(robot.sections), **found)


class _Walk:
    """Goes through values of a model beside what the schema says of them; ``of`` gives the other name by kind."""

    def __init__(self, link: Rename, joint: Rename) -> None:
        self.of = {"link": link, "joint": joint}
        self.own: Mapping[type, Callable[[Any], Any]] = {Link: self._link, Sensor: self._sensor}

    def through(self, found: Sections) -> Sections:
        """Return what sections of packages say, under other names."""
        values, said = (
            {name: self.value(sections()[name], one) for name, one in many.items()}
            for many in (found.values, found.said)
        )
        return replace(found, values=values, said=said)

    def value(self, node: Node, value: Any) -> Any:
        """Return the value of a section under new names: by its own ``renamed``, or by that of each of its entries."""
        if isinstance(value, tuple) and any(hasattr(one, "renamed") for one in value):
            return tuple(self.value(node, one) for one in value)
        rename = getattr(value, "renamed", None)
        return rename(self.of["link"], self.of["joint"]) if callable(rename) else self.at(node, value)

    def at(self, node: Node | None, value: Any) -> Any:
        """Return a value of the model under other names."""
        if node is None or node.of.isdisjoint((*self.of, GIVES)):
            return value
        if isinstance(value, str):
            return self._name(node, value)
        if isinstance(value, Mapping):
            return {self._name(node.keys, key): self.at(node.at(key), one) for key, one in value.items()}
        if isinstance(value, tuple):
            lists = (one.items for one in node.properties.values() if one is not None and one.items is not None)
            items = node.items or next(lists, None)
            return tuple(self.at(items, one) if node.keys is None else self._entry(node, one) for one in value)
        return self._record(node, value) if is_dataclass(value) else value

    def _name(self, node: Node | None, name: str) -> str:
        """Return the other name of something, if it is a link or a joint."""
        rename = self.of.get(node.names or node.gives) if node is not None else None
        return rename(name) if rename is not None else name

    def _entry(self, node: Node, entry: Any) -> Any:
        """Return an entry of what has its entries by name; of some the model has the name alone."""
        if isinstance(entry, str):
            return self._name(node.keys, entry)
        return replace(self.at(node.others, entry), name=self._name(node.keys, entry.name))

    def _record(self, node: Node, record: Any) -> Any:
        found = {field.name: self.at(node.at(field.name), getattr(record, field.name)) for field in fields(record)}
        made = replace(record, **found)
        own = self.own.get(type(record))
        return own(made) if own is not None else made

    def _link(self, one: Link) -> Link:
        names = Renames(self.of["link"], self.of["link"])
        return replace(one, marked=tuple(replace(mark, values=names.values(mark.values)) for mark in one.marked))

    def _sensor(self, one: Sensor) -> Sensor:
        link, joint = self.of["link"], self.of["joint"]
        return replace(
            one,
            optical_frame=link(one.optical_frame),
            simulated=tuple(replace(part, link=link(part.link)) for part in one.simulated),
            gazebo=tuple(
                replace(
                    part,
                    link=(joint if part.at_joint else link)(part.link),
                    stamp=link(part.stamp),
                    feels=link(part.feels),
                )
                for part in one.gazebo
            ),
        )
