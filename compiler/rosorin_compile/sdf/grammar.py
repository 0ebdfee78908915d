"""The grammar of SDF: elements that hold numbers, how many those are, and in which unit.

Both readers take it from here: ``facts``, which asks for what the compiler writes, and the importer (``robot``), which
has the defaults of the specification for the rest. The writer does not: a proof by a grammar that the writer has, too,
would prove less.
"""

from __future__ import annotations

INERTIA = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
PARTS_OF_LINK = ("pose", "inertial", "visual", "collision")
# The sizes of solids, with how many numbers each is.
SOLIDS = {
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "capsule": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
    "ellipsoid": {"radii": 3},
    "mesh": {"scale": 3},
}
# What an axis says in numbers, with their units: of the position of the joint {q}, of its force or torque {f}.
MOTION = {
    "limit": {"lower": "{q}", "upper": "{q}", "effort": "{f}", "velocity": "{q}/s"},
    "dynamics": {
        "damping": "{f}*s/{q}",
        "friction": "{f}",
        "spring_stiffness": "{f}/{q}",
        "spring_reference": "{q}",
    },
}
