"""Sensors of Gazebo as text: a ``<sensor>`` of SDF, which stands in a URDF for Gazebo and in an SDF."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from markupsafe import escape

from rosorin_compile.model.simulation import GazeboSensor, SdfElement
from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.numbers import NumberFormat
from rosorin_compile.source.xml.markup import MarkupError, parse

from .templating import attributes

DISTRIBUTIONS = GazeboSensor.FRAME_ELEMENTS

# The defaults of SDF, by the last two elements of a path
# (sdformat@sdf14:sdf/1.11/{sensor,lidar,camera,noise}.sdf).
SDF_DEFAULTS: Mapping[tuple[str, ...], str] = {
    ("sensor", "always_on"): "false",
    ("sensor", "visualize"): "false",
    ("sensor", "update_rate"): "0",
    ("sensor", "pose"): "0 0 0 0 0 0",
    ("horizontal", "resolution"): "1",
    ("vertical", "resolution"): "1",
    ("range", "resolution"): "0",
    ("camera", "horizontal_fov"): "1.047",
    ("image", "width"): "320",
    ("image", "height"): "240",
    ("clip", "near"): "0.1",
    ("clip", "far"): "100",
    ("imu", "enable_orientation"): "true",
    ("noise", "mean"): "0",
    ("noise", "bias_mean"): "0",
    ("noise", "bias_stddev"): "0",
}
SDF_FLAGS = ("always_on", "visualize", "enable_orientation", "enable_metrics")
SDF_TRUTH = {"1": "true", "0": "false", "True": "true", "False": "false"}


def distribution(asked: object) -> str:
    """Return which Gazebo an output asks for: ``true`` is Harmonic; empty for none."""
    return "harmonic" if asked is True else str(asked or "")


def sensor_lines(
    one: GazeboSensor, frame_id: str, number: NumberFormat, indent: str, pose: str, collisions: Sequence[str] = ()
) -> Iterator[str]:
    """Yield the lines of a sensor.

    ``frame_id`` is the element that names the frame of its messages; empty: none. ``pose`` is its <pose>, empty where
    it has none; ``collisions`` are the shapes that it feels by.
    """
    inner = indent + "  "
    yield f"{indent}<sensor{attributes(name=one.name, type=one.type)}>"
    if pose:
        yield f"{inner}{pose}"
    said = {element.name for element in one.elements} | one.without
    if one.stamp and frame_id and not said & {*DISTRIBUTIONS.values(), frame_id}:
        yield f"{inner}<{frame_id}>{escape(one.stamp)}</{frame_id}>"
    shapes = [SdfElement("collision", name) for name in collisions]
    for element in one.elements:
        yield from _lines(element, inner, number, shapes if element.name == "contact" else ())
    if collisions and "contact" not in said:
        yield from _lines(SdfElement("contact"), inner, number, shapes)
    yield f"{indent}</sensor>"


def _lines(element: SdfElement, indent: str, number: NumberFormat, more: Sequence[SdfElement] = ()) -> Iterator[str]:
    """Yield the lines of an element; ``more`` elements come first in it."""
    values = {name: _word(value, number) for name, value in element.attributes.items()}
    name = escape(element.name)
    start = f"{indent}<{name}{attributes(**values)}"
    if element.value is not None:
        yield f"{start}>{escape(_word(element.value, number))}</{name}>"
    elif not element.elements and not more:
        yield f"{start}/>"
    else:
        yield f"{start}>"
        for inner in (*more, *element.elements):
            yield from _lines(inner, indent + "  ", number)
        yield f"{indent}</{name}>"


def _word(value: float | str | bool, number: NumberFormat) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return number(value) if isinstance(value, float) else str(value)


_OF_NOISE = ("mean", "stddev", "bias_mean", "bias_stddev")
_MEASURED = {"rate": "angular_velocity", "accel": "linear_acceleration"}


def with_noise(text: str) -> str:
    """Move the noise of an IMU to each axis, for the text of a ``<sensor>`` from Gazebo classic.

    Up to version 1.4 of SDF ``<imu>`` has one ``<noise>`` with ``<rate>`` and ``<accel>``, which readers of later
    versions ignore (``gazebosim/sdformat@sdf12:sdf/1.4/imu.sdf``).
    """
    if "<imu" not in text or "<noise" not in text:
        return text
    try:
        root = parse(Source("", text)).root
    except MarkupError:  # more than one element: the rules found them well formed
        return text
    pairs = [(noise, imu) for imu in root.iter() if imu.tag == "imu" for noise in imu.children if noise.tag == "noise"]
    for noise, imu in reversed(pairs):
        if not any(child.tag in _MEASURED for child in noise.children):
            continue
        kind = next((child.text for child in noise.children if child.tag == "type"), noise.get("type")) or "gaussian"
        lines: list[str] = []
        for child in noise.children:
            what = _MEASURED.get(child.tag, "")
            if what and all(sibling.tag != what for sibling in imu.children):
                numbers = [
                    f"<{one.tag}>{escape(one.text)}</{one.tag}>" for one in child.children if one.tag in _OF_NOISE
                ]
                noisy = f'<noise type="{escape(kind)}">{"".join(numbers)}</noise>'
                lines += [f"<{what}>", *(f"  <{axis}>{noisy}</{axis}>" for axis in "xyz"), f"</{what}>"]
        before = text[: noise.start]
        indent = before.rpartition("\n")[2]
        is_alone = "\n" in before and not indent.strip()
        made = f"\n{indent}".join(lines) if is_alone else "".join(map(str.strip, lines))
        text = f"{before}{made}{text[noise.end :]}"
    return text
