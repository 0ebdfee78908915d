"""Links: the rigid bodies of a robot, their inertials, and the sources of values.

Inertials of several shapes or rigidly connected bodies are combined with the parallel axis theorem.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, fields, replace
from functools import cache, cached_property
from typing import Any, ClassVar

from rosorin_compile.source.numbers import NumberFormat, exact, round_to_shortest, short

from .bounds import bounds_of
from .geometry import Pose, Transform, Vector, dot, eigenvalues, minus, pose_of
from .shape import Shape, volume_and_moments
from .simulation import Attachment, Values


def only_in(default: Any, **formats: str) -> Any:
    """Declare a dataclass field that only some formats support; ``formats`` maps these to their attribute names."""
    return field(default=default, metadata={"formats": formats})


@cache
def limited_fields(kind: type) -> Mapping[str, Mapping[str, str]]:
    """Return the fields of a dataclass that ``only_in`` declares, with their attribute names by format."""
    return {item.name: item.metadata["formats"] for item in fields(kind) if "formats" in item.metadata}


@dataclass(frozen=True)
class Source:
    """The source of a value; ``status`` is "factory", "measured", "calculated", "chosen", "imported" or "stand_in"."""

    status: str = ""
    note: str = ""
    measured: str = ""


NO_SOURCE = Source()


_THIN = 3e-3  # if smallest / largest principal moment is below this, rounding noticeably changes the dynamics
_FLAT = 1e-10  # relative margin of A + B >= C; below it, rounding may violate the inequality, which engines reject


@dataclass(frozen=True)
class Inertial:
    """A mass (kg), the pose of its centre, and its inertia (kg*m^2) about the centre along the axes of the pose."""

    mass: float
    pose: Pose
    ixx: float
    iyy: float
    izz: float
    ixy: float = 0.0
    ixz: float = 0.0
    iyz: float = 0.0

    @cached_property
    def principal_moments(self) -> Vector:
        xy, xz, yz = self.ixy, self.ixz, self.iyz
        return eigenvalues(((self.ixx, xy, xz), (xy, self.iyy, yz), (xz, yz, self.izz)))

    def printed_inertia(self, number: NumberFormat, along: Sequence[float] | None = None) -> list[str]:
        """Format the inertia with ``number``, as a list of ixx, iyy, izz, ixy, ixz, iyz.

        With ``along``, the inertia along other axes is formatted. If rounding makes it invalid, all digits are kept.
        """
        six = along or (self.ixx, self.iyy, self.izz, self.ixy, self.ixz, self.iyz)
        if number is not short:
            return list(map(number, six))
        moments, products = six[:3], six[3:]
        least, middle, most = self.principal_moments
        near = [round_to_shortest(moment) for moment in moments]
        (low, medium, high), (near_low, near_medium, near_high) = sorted(moments), sorted(near)
        is_delicate = any(products) and (least < _THIN * most or least + middle - most < _FLAT * most)
        if is_delicate or (low + medium >= high and near_low + near_medium < near_high):
            return list(map(exact, six))
        largest = max(map(abs, moments))
        return [*map(exact, near), *(exact(round_to_shortest(product, largest)) for product in products)]


@dataclass(frozen=True, repr=False)
class Link:
    """A rigid body, or only a frame if it has neither an inertial nor shapes."""

    name: str
    inertial: Inertial | None = None
    visual: tuple[Shape, ...] = ()
    collision: tuple[Shape, ...] = ()
    source: Source = NO_SOURCE
    urdf_elements: tuple[str, ...] = ()  # XML elements that are added to the URDF only
    gravity_compensation: float = only_in(0.0, mjcf="gravcomp")
    marked: tuple[Attachment, ...] = ()  # sites, cameras and lights
    mjcf: Values = field(default_factory=dict, hash=False)  # attributes of the body in the MJCF
    mjcf_elements: tuple[str, ...] = ()  # XML elements that are added to the body in the MJCF

    def __repr__(self) -> str:
        parts = [] if self.inertial is None else [f"{self.inertial.mass:.6g} kg"]
        parts += [f"{len(some)} {word}" for word in ("visual", "collision") if (some := getattr(self, word))]
        return f"<Link {self.name}: {', '.join(parts) or 'a frame'}>"

    @property
    def size(self) -> Vector | None:
        """The size (m) of the bounding box of all shapes, or None if there are no shapes or one is a mesh."""
        bounds = bounds_of((*self.collision, *self.visual))
        return None if bounds is None else bounds.size


@dataclass(frozen=True)
class DisabledCollision:
    """A pair of links that MoveIt does not check for collision."""

    ADJACENT: ClassVar[str] = "Adjacent"
    DEFAULT: ClassVar[str] = "Default"
    ALWAYS: ClassVar[str] = "Always"
    NEVER: ClassVar[str] = "Never"
    REASONS: ClassVar[tuple[str, ...]] = ("Adjacent", "Default", "Always", "Never", "User")

    links: tuple[str, str]
    reason: str = "User"  # any value that is not in ``REASONS`` counts as "User"
    nearest: float | None = None  # smallest measured distance between the links (m), negative for an overlap
    beyond: float | None = None  # the measured distances were always larger than this (m)


def inertial_of(shapes: Sequence[Shape], *, mass: float | None = None, density: float | None = None) -> Inertial:
    """Return the inertial of shapes with uniform density, from their total ``mass`` (kg) or ``density`` (kg/m^3).

    The axes are those of the shape if there is a single solid, else those of the link. Overlapping volumes count twice.
    Raises ValueError if there are no shapes, one is a mesh, or a number overflows.
    """
    solids = [solid for shape in shapes for solid in shape.solids()]
    if not solids:
        raise ValueError("no shape, no mass")
    with _finite("a shape is so large that its mass is not a number"):
        sizes = [volume_and_moments(solid.geometry) for solid in solids]
        volume = math.fsum(size for size, _ in sizes)
        total = density * volume if density is not None else mass or 0.0
        bodies = []
        for solid, (size, moments) in zip(solids, sizes, strict=True):
            share = total * size / volume if len(solids) > 1 else total
            x, y, z = (share * moment for moment in moments)
            bodies.append((Inertial(share, solid.origin(), x, y, z), Transform()))
        return _checked(bodies[0][0] if len(bodies) == 1 else replace(_combine(bodies), mass=total))


def together(parts: Sequence[tuple[Inertial, Transform]]) -> Inertial:
    """Combine inertials of bodies that are fixed to each other.

    ``parts`` has each inertial with the pose of its link in a common frame. A single inertial keeps its axes; several
    are combined along the axes of the common frame. Raises ValueError for an empty sequence, or if a number overflows.
    """
    if not parts:
        raise ValueError("no inertial, no mass")
    if len(parts) == 1:
        inertial, transform = parts[0]
        return replace(inertial, pose=pose_of(transform.then(inertial.pose.transform())))
    with _finite("the masses are too large or too far apart"):
        return _checked(_combine(parts))


@contextmanager
def _finite(message: str) -> Iterator[None]:
    try:
        yield
    except OverflowError:
        raise ValueError(message) from None
    except ZeroDivisionError:
        raise ValueError("a shape is so small that its volume is not a number") from None


def _checked(inertial: Inertial) -> Inertial:
    if not all(map(math.isfinite, (inertial.mass, *inertial.pose.xyz, inertial.ixx, inertial.iyy, inertial.izz))):
        raise OverflowError
    return inertial


def _combine(parts: Sequence[tuple[Inertial, Transform]]) -> Inertial:
    placed = [(inertial, transform.then(inertial.pose.transform())) for inertial, transform in parts]
    mass = math.fsum(inertial.mass for inertial, _ in placed)
    centre: Vector = (0.0, 0.0, 0.0)
    if mass:
        x, y, z = (math.fsum(inertial.mass * place.xyz[i] for inertial, place in placed) / mass for i in range(3))
        centre = (x, y, z)
    terms: list[list[float]] = [[] for _ in range(6)]
    for i, place in placed:
        rows, d = place.rows, minus(place.xyz, centre)
        own = ((i.ixx, i.ixy, i.ixz), (i.ixy, i.iyy, i.iyz), (i.ixz, i.iyz, i.izz))
        for total, (r, c) in zip(terms, ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)), strict=True):
            total += (rows[r][k] * own[k][m] * rows[c][m] for k in range(3) for m in range(3))
            total.append(i.mass * ((dot(d, d) if r == c else 0.0) - d[r] * d[c]))
    ixx, iyy, izz, ixy, ixz, iyz = map(math.fsum, terms)
    return Inertial(mass, Pose(centre), ixx, iyy, izz, ixy, ixz, iyz)


Inertia = tuple[float, float, float, float, float, float]  # xx yy zz xy xz yz


def along_link(inertia: Inertia, frame: Transform) -> Inertia:
    """Rotate an inertia (kg*m^2; xx yy zz xy xz yz) from the axes of ``frame`` to those of the link: R I R^T."""
    if frame.rows == Transform().rows:
        return inertia
    xx, yy, zz, xy, xz, yz = inertia
    a, b, c = (tuple(dot(line, row) for line in ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))) for row in frame.rows)
    r, s, t = frame.rows
    return (dot(r, a), dot(s, b), dot(t, c), dot(r, b), dot(r, c), dot(s, c))  # type: ignore[arg-type]
