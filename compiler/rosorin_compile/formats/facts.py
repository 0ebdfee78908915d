"""Facts: what is said of a robot, thing by thing, by its model and by its artifacts.

All call a thing by the same name and put it in the same terms, so that a fact of the URDF and one of the MJCF can be
compared; readers of XML share parsing and numbers with their printed precision:

==========  ==========================================================================================================
frame       by child link: "parent", "origin x|y|z" in the parent (m), "roll|pitch|yaw" (rad; see ``angles``)
joint       by joint: "type", "child", "axis x|y|z", "lower|upper|velocity|effort", "damping|friction|armature",
            "mimic joint|multiplier|offset"
link        by link: "mass", "centre of mass x|y|z", "inertia xx|yy|zz|xy|xz|yz" about the centre of mass along the axes
            of the link, "collision shapes"; of each shape "collision 1 geometry", "collision 1 origin x", "collision 1
            roll", "collision 1 size x" (full extents); the same with "visual"
==========  ==========================================================================================================
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, TypeVar

from rosorin_compile.model import Box, Transform, Vector
from rosorin_compile.model.geometry import Rows

if TYPE_CHECKING:
    Made = TypeVar("Made")

AXES = ("x", "y", "z")
INERTIA = ("xx", "yy", "zz", "xy", "xz", "yz")
_ORIGIN = tuple(f"origin {axis}" for axis in AXES)
_CENTRE = tuple(f"centre of mass {axis}" for axis in AXES)
_MOMENTS = tuple(f"inertia {name}" for name in INERTIA)
# The names of the sizes of a shape: full extents and full lengths in metres, as in URDF; of a mesh a bare factor.
SIZES = {
    "box": ("size x", "size y", "size z"),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
    "sphere": ("radius",),
    "ellipsoid": ("size x", "size y", "size z"),
    "mesh": ("scale x", "scale y", "scale z"),
}
# What a rotation loses on its way through a quaternion or a matrix and back, in radians; measured: below 1e-15.
ROTATION_ROUNDING = 1e-12

# Numbers of frames that are no farther apart (m, rotation entries) are one: rounding alone.
_NEAR = 1e-13
# Three coordinates may be off at once.
_ROOT_THREE = 3**0.5
COLLISION, VISUAL = "collision", "visual"

_UPRIGHT = Transform().rows
NO_TOLERANCE: Vector = (0.0, 0.0, 0.0)

Six = tuple[float, float, float, float, float, float]


class Solid(NamedTuple):
    """A shape in the frame of its link: full sizes and middle (m), rotation, and what else an artifact says of it.

    Sizes of a mesh are factors. ``tolerance`` is how well the lengths are known (m), ``turn_tolerance`` how well the
    entries of the rotation.
    """

    kind: str
    sizes: tuple[float, ...]
    centre: Vector
    rows: Rows
    words: tuple[str, ...]
    tolerance: float
    turn_tolerance: float = 0.0

    @property
    def box(self) -> Box | None:
        """The solid as a box whose edges are along the axes of its link; None if it is no such box."""
        if self.kind != "box" or self.rows != _UPRIGHT or len(self.sizes) != 3:
            return None
        x, y, z = self.centre
        a, b, c = (size / 2 for size in self.sizes)
        return Box((x - a, y - b, z - c), (x + a, y + b, z + c))


# Where -pi ends and +pi begins.
PI_CUT = 2e-6
