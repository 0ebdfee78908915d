"""Sensors of Gazebo as text: a ``<sensor>`` of SDF, which stands in a URDF for Gazebo and in an SDF."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from markupsafe import Markup

from ..model import GazeboSensor, SdfElement
from ..numbers import NumberFormat
from .templating import attributes

CLASSIC = "classic"
# Who reads the sensor, and the element that names the frame of its messages there. SDF up to 1.11 has no word for it;
# in Gazebo classic a plug-in says it.
DISTRIBUTIONS = {"harmonic": "gz_frame_id", "fortress": "ignition_frame_id", CLASSIC: ""}
# What Gazebo classic calls the sensors that Gazebo has, and the element of a lidar (gazebo11:gazebo/sensors).
_CLASSIC_TYPES = {"gpu_lidar": "ray", "rgbd_camera": "depth", "depth_camera": "depth", "navsat": "gps"}
_CLASSIC_ELEMENTS = {"lidar": "ray"}


def distribution(asked: object) -> str:
    """Return which Gazebo an output asks for: ``true`` is Harmonic; empty for none."""
    return "harmonic" if asked is True else str(asked or "")


def in_classic(one: GazeboSensor) -> GazeboSensor:
    """Return a sensor as Gazebo classic calls it."""
    elements = (replace(item, name=_CLASSIC_ELEMENTS.get(item.name, item.name)) for item in one.elements)
    return replace(one, type=_CLASSIC_TYPES.get(one.type, one.type), elements=tuple(elements))


def sensor_lines(
    one: GazeboSensor, frame_id: str, number: NumberFormat, indent: str, pose: Markup, collisions: Sequence[str] = ()
) -> Iterator[Markup]:
    """Yield the lines of a sensor.

    ``frame_id`` is the element that names the frame of its messages; empty: none. ``pose`` is its <pose>, empty where
    it has none; ``collisions`` are the shapes that it feels by.
    """
    inner = indent + "  "
    yield Markup("{}<sensor{}>").format(indent, attributes(name=one.name, type=one.type))
    if pose:
        yield Markup("{}{}").format(inner, pose)
    said = {element.name for element in one.elements} | one.without
    if one.stamp and frame_id and not said & {*DISTRIBUTIONS.values(), frame_id}:
        yield Markup("{0}<{1}>{2}</{1}>").format(inner, frame_id, one.stamp)
    shapes = [SdfElement("collision", name) for name in collisions]
    for element in one.elements:
        yield from _lines(element, inner, number, shapes if element.name == "contact" else ())
    if collisions and "contact" not in said:
        yield from _lines(SdfElement("contact"), inner, number, shapes)
    yield Markup("{}</sensor>").format(indent)


def _lines(element: SdfElement, indent: str, number: NumberFormat, more: Sequence[SdfElement] = ()) -> Iterator[Markup]:
    """Yield the lines of an element; ``more`` elements come first in it."""
    values = attributes(**{name: _word(value, number) for name, value in element.attributes.items()})
    if element.value is not None:
        form = Markup("{0}<{1}{2}>{3}</{1}>")
        yield form.format(indent, element.name, values, _word(element.value, number))
    elif not element.elements and not more:
        yield Markup("{}<{}{}/>").format(indent, element.name, values)
    else:
        yield Markup("{}<{}{}>").format(indent, element.name, values)
        for inner in (*more, *element.elements):
            yield from _lines(inner, indent + "  ", number)
        yield Markup("{}</{}>").format(indent, element.name)


def _word(value: float | str | bool, number: NumberFormat) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return number(value) if isinstance(value, float) else str(value)
