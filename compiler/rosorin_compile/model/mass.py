"""Mass and inertia of shapes of even density: the moments of the solids, moved to their common centre of mass.

Sources: box, cylinder and sphere: D. Halliday, R. Resnick, "Fundamentals of Physics", table "Some rotational inertias";
capsule: a cylinder and two half spheres, each with its centre of mass 3/8 of the radius away from the flat side
(F. P. Beer, E. R. Johnston, "Vector Mechanics for Engineers: Statics", table of centroids of volumes). A body of
several solids: the parallel axis theorem (C. Huygens, J. Steiner).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from .geometry import Pose, Transform, Vector, dot, minus, pose_of
from .link import Inertial
from .shape import Shape, volume_and_moments


class _Solid(NamedTuple):
    """A solid: its volume (m^3), where its middle is, and its moments for a mass of 1 (m^2) along its own axes."""

    volume: float
    place: Transform
    moments: Vector


def inertial_of(shapes: Sequence[Shape], *, mass: float | None = None, density: float | None = None) -> Inertial:
    """Return the inertial of shapes of even density: ``mass`` (kg) is that of all of them, or ``density`` (kg/m^3).

    Of one solid the inertial lies in its middle, along its axes; of several along the axes of the link. Where shapes
    overlap, the overlap counts twice. Raises ValueError if there is no shape, or one without a volume: a mesh, or one
    beyond the numbers that a double holds.
    """
    try:
        made = _inertial_of(shapes, mass, density)
    except OverflowError:
        made = None
    except ZeroDivisionError:
        raise ValueError("a shape is so small that its volume is no number") from None
    if made is None or not all(map(math.isfinite, (made.mass, made.ixx, made.iyy, made.izz))):
        raise ValueError("a shape is so large that its mass is no number")
    return made


def _inertial_of(shapes: Sequence[Shape], mass: float | None, density: float | None) -> Inertial:
    placed = [solid for shape in shapes for solid in shape.solids()]
    solids = [_solid(shape) for shape in placed]
    if not solids:
        raise ValueError("no shape, no mass")
    volume = math.fsum(solid.volume for solid in solids)
    whole = density * volume if density is not None else mass
    if whole is None:
        raise ValueError("a mass or a density is needed")
    if len(solids) == 1:
        x, y, z = (whole * moment for moment in solids[0].moments)
        return Inertial(whole, placed[0].origin(), x, y, z)
    return _joined(solids, whole, volume)


def _solid(shape: Shape) -> _Solid:
    volume, moments = volume_and_moments(shape.geometry)
    return _Solid(volume, shape.origin().transform(), moments)


def _joined(solids: Sequence[_Solid], mass: float, volume: float) -> Inertial:
    """Return the inertial of several solids, along the axes of the link."""
    parts = [mass * solid.volume / volume for solid in solids]
    x, y, z = (math.fsum(m * s.place.xyz[i] for m, s in zip(parts, solids, strict=True)) / mass for i in range(3))
    terms: list[list[float]] = [[] for _ in range(6)]
    for part, solid in zip(parts, solids, strict=True):
        a, b, c = solid.place.xyz
        for total, value in zip(terms, _about(solid, (a - x, b - y, c - z)), strict=True):
            total.append(part * value)
    ixx, iyy, izz, ixy, ixz, iyz = map(math.fsum, terms)
    return Inertial(mass, Pose((x, y, z)), ixx, iyy, izz, ixy, ixz, iyz)


def _about(solid: _Solid, d: Vector) -> tuple[float, ...]:
    """Return xx yy zz xy xz yz of a solid of mass 1 (m^2) about a point from which its middle is ``d`` away."""
    rows, square = solid.place.rows, dot(d, d)

    def entry(i: int, j: int) -> float:
        turned = math.fsum(rows[i][k] * rows[j][k] * solid.moments[k] for k in range(3))
        return turned + (square if i == j else 0.0) - d[i] * d[j]

    return (entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2))


def together(parts: Sequence[tuple[Inertial, Transform]]) -> Inertial:
    """Return inertials that move as one: each with where its link sits in the frame that the result is of.

    One alone keeps its axes, several lie along those of the frame. Without any mass the inertia is about the frame.
    Raises ValueError if there is none, or the sum is beyond the numbers that a double holds.
    """
    if not parts:
        raise ValueError("no inertial, no mass")
    if len(parts) == 1:
        inertial, transform = parts[0]
        return replace(inertial, pose=pose_of(transform.then(inertial.pose.transform())))
    placed = [(inertial, transform.then(inertial.pose.transform())) for inertial, transform in parts]
    try:
        made = _together(placed)
    except OverflowError:
        made = None
    except ZeroDivisionError:
        raise ValueError("a shape is so small that its volume is no number") from None
    if made is None or not all(map(math.isfinite, (made.mass, *made.pose.xyz, made.ixx, made.iyy, made.izz))):
        raise ValueError("masses so large, or so far apart, that together they are no number")
    return made


def _together(placed: Sequence[tuple[Inertial, Transform]]) -> Inertial:
    mass = math.fsum(inertial.mass for inertial, _ in placed)
    centre: Vector = (0.0, 0.0, 0.0)
    if mass:
        x, y, z = (math.fsum(inertial.mass * place.xyz[i] for inertial, place in placed) / mass for i in range(3))
        centre = (x, y, z)
    terms: list[list[float]] = [[] for _ in range(6)]
    for inertial, place in placed:
        for total, value in zip(terms, _seen_from(inertial, place, minus(place.xyz, centre)), strict=True):
            total += value
    ixx, iyy, izz, ixy, ixz, iyz = map(math.fsum, terms)
    return Inertial(mass, Pose(centre), ixx, iyy, izz, ixy, ixz, iyz)


def _seen_from(inertial: Inertial, place: Transform, d: Vector) -> Iterator[tuple[float, ...]]:
    """Yield the terms of xx yy zz xy xz yz of an inertial about a point from which its centre of mass is ``d`` away."""
    i, rows, square = inertial, place.rows, dot(d, d)
    own = ((i.ixx, i.ixy, i.ixz), (i.ixy, i.iyy, i.iyz), (i.ixz, i.iyz, i.izz))
    for r, c in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)):
        turned = (rows[r][k] * own[k][m] * rows[c][m] for k in range(3) for m in range(3))
        yield (*turned, inertial.mass * ((square if r == c else 0.0) - d[r] * d[c]))


def principal_moments(inertial: Inertial) -> Vector:
    """Return the eigenvalues of an inertia in kg*m^2, smallest first."""
    return inertial.principal_moments


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
