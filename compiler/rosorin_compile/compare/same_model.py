"""Compare two models of a robot value by value, to prove that an import lost nothing.

``diff`` compares what robots are; here every field of the model counts.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

from rosorin_compile.formats import FORMATS
from rosorin_compile.language.schema import sections
from rosorin_compile.model import Box, Ellipsoid, Joint, Link, Robot, Shape
from rosorin_compile.model.joint import Dynamics
from rosorin_compile.model.shape import Material, plain

from .diff import compare_robots
from .difference import YAML, Side
from .precision import NOISE, same_number
from .sentences import number_pair

# Where a value comes from and what is made of it says nothing about the robot.
_NOT_COMPARED = ("source", "outputs", "stand_in")
# What links, joints and shapes have that a URDF does not say.
_NOT_IN_URDF = ("publisher", "actuator", "root_in_world", "contact", "mjcf", "marked", "mjcf_elements")
_NAMED = (Link, Joint, Material)


def model_differences(
    one: Robot, other: Robot, tolerance: float = NOISE, *, carried_by_urdf: bool = False
) -> list[str]:
    """Return in which values two robots differ: the sentences of ``diff``, then each field; none for the same robot.

    Numbers may differ by ``tolerance``, absolute or relative. With ``carried_by_urdf`` only what a URDF says is
    compared, by what it means: a box is its size, and an element of XML has no line ends.
    """
    skipped = (*_NOT_COMPARED, *(_NOT_IN_URDF if carried_by_urdf else ()))
    held = _without_lacking(one, other) if carried_by_urdf else one
    values = list(_Comparison(tolerance, skipped, carried_by_urdf).values("", held, other))
    if not values:
        return []
    sides = Side("source", YAML, one), Side("result", FORMATS.published() if carried_by_urdf else YAML, other)
    return [*(item.text for item in compare_robots(*sides, tolerance, prefix="").items), *values]


def section_differences(one: Robot, other: Robot, section: str, tolerance: float = NOISE) -> list[str]:
    """Return in which values two robots differ in one section, such as ``moveit``."""
    comparison = _Comparison(tolerance, _NOT_COMPARED, by_meaning=False)
    return list(comparison.values(section, getattr(one, section), getattr(other, section)))


def _without_lacking(one: Robot, other: Robot) -> Robot:
    """Return a robot with what a URDF has no word for as another one has it."""
    urdf, known = FORMATS.published(), {field.name for field in fields(one)}
    skipped = [name for name, node in sections().items() if node.topic in urdf.lacks and name in known]
    return replace(one, sections=other.sections, **{name: getattr(other, name) for name in skipped})


class _Comparison:
    """One comparison: how exact, and of what."""

    def __init__(self, tolerance: float, skipped: tuple[str, ...], by_meaning: bool) -> None:
        self.tolerance = tolerance
        self.skipped = skipped
        self.by_meaning = by_meaning

    def values(self, where: str, one: Any, other: Any) -> Iterator[str]:
        """Yield the differences between two values of a model."""
        if type(one) is type(other) and one == other:
            return
        one, other = _without_zeros(one), _without_zeros(other)
        if self.by_meaning:
            one, other = _plain(one), _plain(other)
        if is_dataclass(one) and type(one) is type(other):
            for field in fields(one):
                first, second = getattr(one, field.name), getattr(other, field.name)
                # The URDF names every material; one that had no name has the name of its link.
                unnamed = self.by_meaning and field.name == "material" and not first
                limited = self.by_meaning and "urdf" not in field.metadata.get("formats", ("urdf",))
                if field.name not in self.skipped and not unnamed and not limited:
                    yield from self.values(f"{where} {field.name}".strip(), first, second)
        elif isinstance(one, tuple) and isinstance(other, tuple):
            yield from self.several(where, one, other)
        elif isinstance(one, Mapping) and isinstance(other, Mapping):
            for key in sorted({*one, *other}, key=str):
                yield from self.values(f"{where} {key}", one.get(key), other.get(key))
        elif not self.same(one, other):
            yield f"{where} {' -> '.join(_both(one, other))}"

    def several(self, where: str, one: tuple[Any, ...], other: tuple[Any, ...]) -> Iterator[str]:
        """Yield the differences between two tuples, in order, or by name where what they hold has one."""
        if self.by_meaning:
            one, other = (tuple(solid for item in some for solid in _solids(item)) for some in (one, other))
        if one and isinstance(one[0], _NAMED):
            yield from self.values(where, {item.name: item for item in one}, {item.name: item for item in other})
            return
        if len(one) != len(other):
            yield f"{where}: {len(one)} -> {len(other)}"
        for index, (first, second) in enumerate(zip(one, other, strict=False)):
            yield from self.values(f"{where} {index + 1}", first, second)

    def same(self, one: Any, other: Any) -> bool:
        if type(one) is float and type(other) is float and self.tolerance:
            return same_number(one, other, self.tolerance)
        return bool(one == other) and (one is None) == (other is None)


def _solids(item: Any) -> tuple[Any, ...]:
    return item.solids() if isinstance(item, Shape) else (item,)


def _plain(value: Any) -> Any:
    """Return a value in the one form that a URDF has for it."""
    if isinstance(value, Shape) and isinstance(value.geometry, Box):
        x, y, z = (size / 2 for size in value.geometry.size)
        return replace(value, geometry=Box((-x, -y, -z), (x, y, z)), pose=value.origin())
    if isinstance(value, Shape) and isinstance(value.geometry, Ellipsoid):
        return replace(value, geometry=plain(value.geometry))
    if isinstance(value, Joint) and value.type == "ball":
        return replace(value, type="floating")
    if isinstance(value, Dynamics):
        return _without_zeros(replace(value, armature=0.0, stiffness=0.0, spring_reference=0.0))
    if isinstance(value, str) and "<" in value:
        return " ".join(value.split())
    return value


def _without_zeros(value: Any) -> Any:
    """Return None for dynamics that say nothing: each of them is zero by default."""
    return None if value == Dynamics() else value


def _both(one: Any, other: Any) -> tuple[str, str]:
    """Return two different values in print."""
    if type(one) is float and type(other) is float and math.isfinite(one) and math.isfinite(other):
        return number_pair(one, other)
    return _text(one), _text(other)


def _text(value: Any) -> str:
    if is_dataclass(value):
        name = getattr(value, "name", "")
        return f"{type(value).__name__.lower()} {name}".strip()
    return "nothing" if value is None else repr(value)
