"""Check: the model held against rules of meaning. A rule is a function that yields what it finds wrong.

A rule trusts the shape of the tree and nothing else: the robot may have no link, two roots or a cycle. One cause gives
one message; where the same mistake would be seen by two rules, the later one in this table looks away.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

from ..accepting import ACCEPTABLE
from ..diagnostic import Diagnostic
from ..model import Robot
from ..tree import Map, Path
from . import (
    conditions,
    frames,
    inertia,
    joints,
    kinematics,
    materials,
    mimic,
    outputs,
    poses,
    publishers,
    stamps,
    stand_ins,
    tf_tree,
    values,
    xml_elements,
)
from .case import USED, Case
from .remarkable import collect

if TYPE_CHECKING:
    from ..emit import Format

__all__ = ["ACCEPTABLE", "RULES", "check"]

Rule = Callable[[Case], Iterator[Diagnostic]]

RULES: tuple[Rule, ...] = (
    kinematics.known_links,
    kinematics.known_joints,
    kinematics.one_parent,
    kinematics.no_cycle,
    kinematics.one_root,
    frames.world_frames,
    frames.optical_frames,
    joints.axes,
    joints.limits,
    joints.units,
    joints.without_effect,
    mimic.leaders,
    mimic.order,
    inertia.physical,
    conditions.legal,
    publishers.one_publisher,
    publishers.urdf_always,
    publishers.some_publisher,
    publishers.started,
    publishers.planar,
    publishers.node_names,
    tf_tree.known_frames,
    tf_tree.no_cycle,
    tf_tree.one_urdf,
    tf_tree.one_tree,
    tf_tree.one_tree_in_modes,
    stamps.known,
    poses.servos,
    poses.positions,
    outputs.backends,
    outputs.files,
    values.magnitudes,
    values.characters,
    materials.once,
    materials.known,
    xml_elements.well_formed,
    stand_ins.listed_once,
)


def check(
    robot: Robot, tree: Map, places: Mapping[tuple[str, str], Path], formats: Mapping[str, Format]
) -> list[Diagnostic]:
    """Return what is wrong with the meaning of a description, and what is worth a note.

    ``places`` leads from a joint or a link, by kind and name, to its path in the tree (see ``build``); ``formats`` are
    those that outputs may name.
    """
    case = Case(robot, tree, places, collect(tree), formats)
    return _joined(diagnostic for rule in RULES for diagnostic in rule(case))


def _joined(diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Return the diagnostics, those on one value of ``let`` that is used many times as one."""
    found: dict[object, Diagnostic] = {}
    for diagnostic in diagnostics:
        uses = tuple(related for related in diagnostic.related if related.message == USED)
        key: object = (diagnostic.rule, diagnostic.span) if uses else (len(found), diagnostic)
        if key not in found:
            found[key] = diagnostic
            continue
        first = found[key].related
        more = tuple(use for use in uses if use not in first)
        last = max(index for index, related in enumerate(first) if related.message == USED) + 1
        found[key] = found[key]._replace(related=(*first[:last], *more, *first[last:]))
    return list(found.values())
