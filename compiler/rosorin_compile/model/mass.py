"""Mass and inertia of shapes of even density, and of several bodies that move as one.

The moments of a solid are in ``shape.volume_and_moments``. Several bodies: the parallel axis theorem (C. Huygens,
J. Steiner).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

from .geometry import Pose, Transform, Vector, dot, minus, pose_of
from .link import Inertial
from .shape import Shape, volume_and_moments


def inertial_of(shapes: Sequence[Shape], *, mass: float | None = None, density: float | None = None) -> Inertial:
    """Return the inertial of shapes of even density: ``mass`` (kg) is that of all of them, or ``density`` (kg/m^3).

    The inertial of one solid is in its middle, along its axes; that of several is along the axes of the link. Overlaps
    count twice. Raises ValueError if there is no shape, one is a mesh, or a number overflows.
    """
    solids = [solid for shape in shapes for solid in shape.solids()]
    if not solids:
        raise ValueError("no shape, no mass")
    with _finite("a shape is so large that its mass is no number"):
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
    """Return the inertial of bodies that move as one: each with the pose of its link in the frame of the result.

    A single body keeps its axes, several are along those of the frame. Raises ValueError if there is none, or a number
    overflows.
    """
    if not parts:
        raise ValueError("no inertial, no mass")
    if len(parts) == 1:
        inertial, transform = parts[0]
        return replace(inertial, pose=pose_of(transform.then(inertial.pose.transform())))
    with _finite("masses so large, or so far apart, that together they are no number"):
        return _checked(_combine(parts))


@contextmanager
def _finite(message: str) -> Iterator[None]:
    """Raise ValueError instead of errors of arithmetic in the block; ``message`` is that for a number too large."""
    try:
        yield
    except OverflowError:
        raise ValueError(message) from None
    except ZeroDivisionError:
        raise ValueError("a shape is so small that its volume is no number") from None


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
    """Return an inertia (kg*m^2; xx yy zz xy xz yz along the axes of ``frame``) along the axes of the link: R I R^T."""
    if frame.rows == Transform().rows:
        return inertia
    xx, yy, zz, xy, xz, yz = inertia
    tensor = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
    a, b, c = (tuple(dot(line, row) for line in tensor) for row in frame.rows)
    r, s, t = frame.rows
    return (dot(r, a), dot(s, b), dot(t, c), dot(r, b), dot(r, c), dot(s, c))  # type: ignore[arg-type]
