"""The noise of an IMU in a ``<sensor>``: once for all axes in Gazebo classic, at each axis in SDF.

Up to 1.4 of SDF ``<imu>`` has ``<noise>`` with ``<rate>`` and ``<accel>``, and from 1.5 on ``<angular_velocity>`` and
``<linear_acceleration>``; readers of SDF pass over the former (``gazebosim/sdformat@sdf12:sdf/1.4/imu.sdf``).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import TYPE_CHECKING

from ..diagnostics import Source
from .escaping import escape

if TYPE_CHECKING:
    from .markup import Element

_OF_NOISE = ("mean", "stddev", "bias_mean", "bias_stddev")
_MEASURED = {"rate": "angular_velocity", "accel": "linear_acceleration"}


def with_noise(text: str) -> str:
    """Return a sensor in which the noise of an IMU stands at each axis; all other text as it is."""
    if "<imu" not in text or "<noise" not in text:
        return text
    from .markup import MarkupError, parse  # few robots have such elements

    try:
        root = parse(Source("", text)).root
    except MarkupError:  # more than one element: the rules found them well formed
        return text
    found = [(noise, imu) for imu in root.iter() if imu.tag == "imu" for noise in imu.children if noise.tag == "noise"]
    for noise, imu in reversed(found):
        if any(child.tag in _MEASURED for child in noise.children):
            before = text[: noise.start]
            indent = before.rpartition("\n")[2]
            lines = list(_axes(noise, {child.tag for child in imu.children}))
            alone = "\n" in before and not indent.strip()
            made = f"\n{indent}".join(lines) if alone else "".join(map(str.strip, lines))
            text = f"{before}{made}{text[noise.end :]}"
    return text


def _axes(noise: Element, own: Collection[str]) -> Iterator[str]:
    """Yield the lines of what an IMU measures with noise, but for that which it says at its axes already."""
    kind = next((child.text for child in noise.children if child.tag == "type"), noise.get("type"))
    for child in noise.children:
        what = _MEASURED.get(child.tag, "")
        if what and what not in own:
            said = [f"<{one.tag}>{escape(one.text)}</{one.tag}>" for one in child.children if one.tag in _OF_NOISE]
            inner = f'<noise type="{escape(kind or "gaussian")}">{"".join(said)}</noise>'
            yield from (f"<{what}>", *(f"  <{axis}>{inner}</{axis}>" for axis in "xyz"), f"</{what}>")
