"""Planar and floating joints, as MuJoCo's reader of URDF and we write them: slides, then a hinge or a ball.

They are known by their names, NAME_TX and so on, and taken for one joint only if they are exactly that one: free of
limits, of friction and damping, along the axes that it has.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from ...model.geometry import Vector
from ...model.motion import plane_axes
from .numbers import unit
from .reading import BALL, HINGE, SLIDE, Reading

_SAME = 1e-12
_ENDS = {
    (SLIDE, SLIDE, HINGE): ("planar", ("_TX", "_TY", "_RZ")),
    (SLIDE, SLIDE, SLIDE, BALL): ("floating", ("_TX", "_TY", "_TZ", "_R")),
}
_ALONG: Sequence[Vector] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class Motion(NamedTuple):
    """A joint of several coordinates: its name, its type, and the normal of its plane if it has one."""

    name: str
    kind: str
    axis: Vector | None


def motion_of(reading: Reading, body: int) -> Motion | None:
    """Return the planar or floating joint that the joints of a body are, None if they are none."""
    held = [reading.facts["joints"][at] for at in reading.joints_in.get(body, ())]
    kind, ends = _ENDS.get(tuple(joint["type"] for joint in held), ("", ()))
    if not ends or any(_is_special(reading, joint) for joint in held):
        return None
    name = held[0]["name"].removesuffix(ends[0])
    if not name or [joint["name"] for joint in held] != [name + end for end in ends]:
        return None
    axis = unit(held[-1]["axis"]) if kind == "planar" else None
    along = plane_axes(axis) if axis else _ALONG
    slides = [joint["axis"] for joint in held[:-1]]
    if any(abs(a - b) > _SAME for said, own in zip(slides, along, strict=True) for a, b in zip(said, own, strict=True)):
        return None
    return Motion(name, kind, axis)


def _is_special(reading: Reading, joint: Mapping[str, Any]) -> bool:
    """Say whether a joint has what a planar or floating joint has no word for."""
    facts, dof = reading.facts, joint["dof"]
    if joint["type"] != SLIDE and any(joint["pos"]):
        return True
    shifted = joint["type"] != BALL and facts["zero"][joint["address"]] != 0
    held = any(facts[word][dof] for word in ("damping", "friction", "armature"))
    return bool(shifted or held or joint["limited"] or joint["forced"])
