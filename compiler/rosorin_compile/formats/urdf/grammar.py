"""The grammar of URDF: which elements hold which, their attributes, and what numbers those are.

Both readers take it from here: ``facts``, which holds what was written against the model, and the importer (``robot``),
which reads files of others, knows the place of each number, and says what is wrong. The writer does not: a proof by a
grammar that the writer has, too, would prove less.

Defaults are those of http://wiki.ros.org/urdf/XML and ``ros/urdfdom@jazzy:urdf_parser``.
"""

from __future__ import annotations

from typing import NamedTuple


class Numbers(NamedTuple):
    """An attribute of numbers: how many, in which unit, and what each of them is where the attribute is not there.

    In a unit ``{q}`` is that of the position of the joint, ``{f}`` that of its force or torque.
    """

    many: int = 1
    unit: str = ""
    default: float = 0.0

    def unit_at(self, position: str) -> str:
        """Return the unit for a joint whose position is in rad, in m, or in nothing that is known."""
        return self.unit.format(q=position, f="N" if position == "m" else "N*m")


# Types of joints, with the units of their positions.
TYPES = {"revolute": "rad", "continuous": "rad", "prismatic": "m", "fixed": "", "floating": "", "planar": "m"}
MOVING = {kind: unit for kind, unit in TYPES.items() if unit}
SHAPES = ("box", "cylinder", "sphere", "capsule", "mesh")
CHILDREN = {
    "robot": ("link", "joint", "material"),
    "link": ("inertial", "visual", "collision"),
    "inertial": ("origin", "mass", "inertia"),
    "visual": ("origin", "geometry", "material"),
    "collision": ("origin", "geometry"),
    "geometry": SHAPES,
    "material": ("color", "texture"),
    "joint": ("origin", "parent", "child", "axis", "limit", "mimic", "dynamics", "calibration", "safety_controller"),
}
TEXTS = {
    "robot": ("name", "version"),
    "joint": ("name", "type"),
    **dict.fromkeys(("link", "visual", "collision", "material"), ("name",)),
    **dict.fromkeys(("parent", "child"), ("link",)),
    **dict.fromkeys(("mesh", "texture"), ("filename",)),
    "mimic": ("joint",),
}
_LENGTH, _POSITION, _FORCE, _DAMPING = Numbers(1, "m"), Numbers(1, "{q}"), Numbers(1, "{f}"), Numbers(1, "{f}*s/{q}")
NUMBERS = {
    "origin": {"xyz": Numbers(3, "m"), "rpy": Numbers(3, "rad"), "quat_xyzw": Numbers(4)},
    "mass": {"value": Numbers(1, "kg")},
    "inertia": dict.fromkeys(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), Numbers(1, "kg*m^2")),
    "box": {"size": Numbers(3, "m")},
    "cylinder": {"radius": _LENGTH, "length": _LENGTH},
    "sphere": {"radius": _LENGTH},
    "capsule": {"radius": _LENGTH, "length": _LENGTH},
    "mesh": {"scale": Numbers(3, "", 1.0)},
    "color": {"rgba": Numbers(4)},
    "axis": {"xyz": Numbers(3)},
    "limit": {"lower": _POSITION, "upper": _POSITION, "effort": _FORCE, "velocity": Numbers(1, "{q}/s")},
    "mimic": {"multiplier": Numbers(1, "", 1.0), "offset": _POSITION},
    "dynamics": {"damping": _DAMPING, "friction": _FORCE},
    "calibration": {"rising": _POSITION, "falling": _POSITION, "reference_position": _POSITION},
    "safety_controller": {
        "soft_lower_limit": _POSITION,
        "soft_upper_limit": _POSITION,
        "k_position": Numbers(1, "1/s"),
        "k_velocity": _DAMPING,
    },
}


def attributes(tag: str) -> tuple[str, ...]:
    """Return the attributes that an element has."""
    return (*TEXTS.get(tag, ()), *NUMBERS.get(tag, ()))
