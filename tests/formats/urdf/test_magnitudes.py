"""Large numbers of somebody else's robot are no mistakes by themselves: what public robots have is not remarked upon.

The cases that are remarked upon are files, in tests/broken_sources.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile import read

LOOKS = ("angle-looks-like-degrees", "length-looks-like-millimetres")


def _remarks(text: str) -> list[str]:
    file = Path("robot.urdf")
    file.write_text(f'<robot name="other">{text}</robot>', "utf-8")
    reading = read(file)
    assert reading.robot is not None, reading.diagnostics
    return [one.message for one in reading.diagnostics if one.rule in LOOKS]


def _arm(*limits: tuple[str, str], kind: str = "revolute") -> str:
    links = "".join(f'<link name="l{index}"/>' for index in range(len(limits) + 1))
    joints = "".join(
        f'<joint name="j{index}" type="{kind}"><parent link="l{index}"/><child link="l{index + 1}"/>'
        f'<limit lower="{lower}" upper="{upper}" effort="1" velocity="1"/></joint>'
        for index, (lower, upper) in enumerate(limits)
    )
    return links + joints


@pytest.mark.parametrize(
    "limits",
    [
        [("-2.88", "2.88"), ("-1.92", "1.92"), ("-6.98132", "6.98132")],  # wrist of an ABB: 400 degrees
        [("-2.96", "2.96"), ("-7.85398", "7.85398")],  # of a Fanuc: 450 degrees
        [("-0.72", "0.49"), ("-9.42", "9.42"), ("-9.42477796", "9.42477796")],  # legs: one and a half turns
        [("-10", "10"), ("-10", "10"), ("-10", "10")],  # legs of another
        [("-20", "20"), ("-20", "20"), ("0", "1.3963")],  # a hand on a floating wrist
        [("-20", "20"), ("-20", "20")],  # the same without the hand
        [("-18.85", "18.85")],
        [("-100", "100"), ("-1000", "1000"), ("-1.57", "1.57")],
        [("-999999", "999999"), ("-1e+16", "1e+16")],
        [("-10.5236", "9.47639"), ("-3.0", "3.0")],
        [("-50", "50"), ("-62.8318", "62.8318"), ("-200", "200"), ("-3.0", "3.0")],  # many turns
    ],
)
@pytest.mark.usefixtures("home")
def test_limits_in_radians(limits: list[tuple[str, str]]) -> None:
    assert _remarks(_arm(*limits)) == []


@pytest.mark.usefixtures("home")
def test_degrees_among_radians_are_told() -> None:
    assert _remarks(_arm(("-2.9", "2.9"), ("-180", "180"))) != []
    assert _remarks(_arm(("-40", "55"), ("-22.5", "130"))) != []
    assert _remarks(_arm(("-2.9", "2.9"), ("-170", "170"))) != []
    assert _remarks(_arm(("-2.9", "2.9"), ("-68.7549", "80.2141"))) != []  # -1.2 and 1.4 rad


@pytest.mark.parametrize(
    "text",
    [
        '<link name="plane"><collision><origin xyz="0 0 -5"/><geometry><box size="200 200 10"/></geometry></collision>'
        "</link>",
        _arm(("0", "37.206"), kind="prismatic"),  # a portal in a hall
        _arm(("-999999", "999999"), kind="prismatic"),
        '<link name="rail"><visual><geometry><box size="30 0.05 0.05"/></geometry></visual></link><link name="cart">'
        '<visual><geometry><box size="0.5 0.5 0.2"/></geometry></visual></link><joint name="slide" type="prismatic">'
        '<parent link="rail"/><child link="cart"/><limit lower="-15" upper="15" effort="1" velocity="1"/></joint>',
        '<link name="room"/><link name="wall"><collision><geometry><box size="40.2 0.1 3"/></geometry></collision>'
        '</link><joint name="stands" type="fixed"><parent link="room"/><child link="wall"/><origin xyz="0 20 1.5"/>'
        "</joint>",
    ],
)
@pytest.mark.usefixtures("home")
def test_large_things(text: str) -> None:
    assert _remarks(text) == []


@pytest.mark.usefixtures("home")
def test_a_drawing_in_millimetres_is_told() -> None:
    box = '<visual><geometry><box size="120 80 40"/></geometry></visual>'
    text = f'<link name="a">{box}</link><link name="b">{box}</link><joint name="j" type="continuous"><parent link="a"/>'
    (message,) = _remarks(f'{text}<child link="b"/><origin xyz="0 15 60"/></joint>')
    assert message.endswith("is 120 m, larger than any robot: this looks like millimetres, and 6 more")
