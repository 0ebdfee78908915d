"""Convert the noise of an IMU in a ``<sensor>`` from Gazebo classic, once for all axes, to SDF, at each axis.

Up to 1.4 of SDF ``<imu>`` has ``<noise>`` with ``<rate>`` and ``<accel>``, and from 1.5 on ``<angular_velocity>`` and
``<linear_acceleration>``; readers of SDF ignore the former (``gazebosim/sdformat@sdf12:sdf/1.4/imu.sdf``).
"""

from __future__ import annotations

from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.xml.escaping import escape
from rosorin_compile.source.xml.markup import MarkupError, parse

_OF_NOISE = ("mean", "stddev", "bias_mean", "bias_stddev")
_MEASURED = {"rate": "angular_velocity", "accel": "linear_acceleration"}


def with_noise(text: str) -> str:
    """Return a sensor with the noise of an IMU at each axis."""
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
