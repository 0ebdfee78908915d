"""Shared values: links and joints that hold the very same values, as those of one part do; one speaks for all."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from typing import Any

from rosorin_compile.model import Robot
from rosorin_compile.model.cached import of_robot
from rosorin_compile.source.diagnostics import Diagnostic


class Kinds:
    """The links or joints of a robot, each with its kind; those of one kind differ in names and places alone."""

    def __init__(self, items: Sequence[Any], kind_of: Callable[[Any], Hashable]) -> None:
        self.items = items
        self.kinds = [kind_of(item) for item in items]
        self.first: dict[Hashable, Any] = {}
        for kind, item in zip(self.kinds, items, strict=True):
            self.first.setdefault(kind, item)

    def problems(self, look: Callable[[Any], Iterable[Diagnostic]]) -> Iterator[Diagnostic]:
        """Yield what ``look`` finds wrong with each; where that is nothing with one, it is nothing with its kind."""
        wrong = {kind for kind, first in self.first.items() if any(True for _ in look(first))}
        for kind, item in zip(self.kinds, self.items, strict=True) if wrong else ():
            if kind in wrong:
                yield from look(item)


@of_robot
def links(robot: Robot) -> Kinds:
    """Return the links by their inertials and shapes: lowering makes those of one piece of the tree once."""
    return Kinds(robot.links, lambda link: (id(link.inertial), id(link.visual), id(link.collision)))


@of_robot
def joints(robot: Robot) -> Kinds:
    """Return the joints by their types, axes, limits and what moves them; not by their origins."""
    return Kinds(
        robot.joints,
        lambda joint: (
            joint.type,
            joint.axis,
            *map(id, (joint.limit, joint.mimic, joint.dynamics, joint.actuator, joint.calibration, joint.safety)),
        ),
    )
