"""The smallest circle and the smallest rectangle around points of a plane."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

Point = tuple[float, float]


def smallest_circle(points: Floats) -> tuple[Point, float]:
    """Return centre and radius of the smallest circle around points (n, 2).

    Two or three points hold it. Beginning anywhere, the point that is farthest outside joins those that hold it now,
    and the smallest circle around these few is the next one; its radius grows each time, so that comes to an end.
    """
    import numpy as np

    held: list[Point] = [(float(points[0, 0]), float(points[0, 1]))]
    centre, radius = held[0], 0.0
    for _ in range(1000):
        distance = np.hypot(points[:, 0] - centre[0], points[:, 1] - centre[1])
        far = int(distance.argmax())
        if distance[far] <= radius * (1 + 1e-12) + 1e-15:
            break
        held, centre, radius = _around_few([*held, (float(points[far, 0]), float(points[far, 1]))])
    distance = np.hypot(points[:, 0] - centre[0], points[:, 1] - centre[1])
    return centre, float(distance.max())


def _around_few(points: list[Point]) -> tuple[list[Point], Point, float]:
    """Return the smallest circle around at most four points, and which of them hold it."""
    best: tuple[list[Point], Point, float] | None = None
    for count in (2, 3):
        for some in itertools.combinations(points, count):
            centre = _middle(*some) if count == 2 else _circumcentre(*some)
            if centre is None:
                continue
            radius = max(math.dist(centre, point) for point in some)
            holds = all(math.dist(centre, point) <= radius * (1 + 1e-9) + 1e-15 for point in points)
            if holds and (best is None or radius < best[2]):
                best = (list(some), centre, radius)
    if best is None:  # points that differ by rounding alone
        return points[-1:], points[-1], 0.0
    return best


def _middle(a: Point, b: Point) -> Point:
    return ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2)


def _circumcentre(a: Point, b: Point, c: Point) -> Point | None:
    """Return the point that is equally far from three others; None if they are on one line."""
    p, q, r, s = b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]
    twice = 2 * (p * s - q * r)
    if abs(twice) <= 1e-12 * math.hypot(p, q) * math.hypot(r, s):
        return None
    first, second = p * p + q * q, r * r + s * s
    return (a[0] + (s * first - q * second) / twice, a[1] + (p * second - r * first) / twice)


def smallest_rectangle(points: Floats) -> tuple[float, float]:
    """Return angle (radians, 0 to pi/2) and area of the smallest rectangle around points (n, 2).

    One of its sides lies on an edge of the convex hull (Freeman and Shapira, 1975). Of rectangles that are the same but
    for rounding, as there are many around a regular prism, that of the smallest angle is taken, on every machine and in
    every order of the points; ``trimesh.bounds.oriented_bounds_2D`` lets the rounding choose.
    """
    import numpy as np
    from scipy.spatial import ConvexHull, QhullError  # type: ignore[import-untyped,unused-ignore]

    try:
        hull = points[ConvexHull(points).vertices]
    except (QhullError, ValueError):  # all on one line
        hull = points
    edges = np.roll(hull, -1, axis=0) - hull
    angles = np.unique(np.round(np.arctan2(edges[:, 1], edges[:, 0]) % (np.pi / 2), 9))
    cosine, sine = np.cos(angles), np.sin(angles)
    along = np.outer(cosine, hull[:, 0]) + np.outer(sine, hull[:, 1])
    across = np.outer(cosine, hull[:, 1]) - np.outer(sine, hull[:, 0])
    areas = np.ptp(along, axis=1) * np.ptp(across, axis=1)
    best = int((areas <= areas.min() * (1 + 1e-9)).argmax())
    return float(angles[best]), float(areas[best])
