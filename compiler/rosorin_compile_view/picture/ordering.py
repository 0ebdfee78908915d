"""In which order polygons are drawn over each other, so that what is nearer hides what is farther.

Which one is nearer is looked up on a grid of samples, not guessed from middles: the polygon that a sample sees goes
over all others there. Polygons that go through each other, or lie in a circle, are cut by each other's planes.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from heapq import heapify, heappop, heappush
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .camera import Camera
from .painting import Model, Surfaces, in_view
from .raster import every

Floats = NDArray[np.float64]

_ROUNDS = 5  # of cutting
_NOISE = 3  # samples: an overlap of fewer is that of edges
_MOST = 20_000  # polygons; of more none is cut
_THIN = 1e-9


class Polygon(NamedTuple):
    """A flat, convex polygon: corners (k, 3) in the root frame (m), its normal and the number of its piece.

    ``sides`` says which sides, from a corner to the next, are those of an outlined face.
    """

    corners: Floats
    sides: tuple[bool, ...]
    normal: Floats
    piece: int


def surfaces_of(polygons: Sequence[Polygon]) -> Surfaces:
    """Return polygons as triangles, each with one normal all over."""
    corners, normals, faces, pieces = [], [], [], []
    for index, polygon in enumerate(polygons):
        for i in range(1, len(polygon.corners) - 1):
            corners.append(polygon.corners[[0, i, i + 1]])
            normals.append((polygon.normal,) * 3)
            faces.append(index)
            pieces.append(polygon.piece)
    face = np.array(faces, np.int64)
    made = np.array(corners).reshape(-1, 3, 3), np.array(normals).reshape(-1, 3, 3)
    return Surfaces(*made, face, np.array(pieces, np.int64), np.full(len(face), -1, np.int64), np.empty((0, 4, 3)))


def ordered(polygons: Sequence[Polygon], model: Model, camera: Camera) -> list[Polygon]:
    """Return polygons in the order in which they are drawn, the farthest first; some of them are cut."""
    found = list(polygons)
    for _ in range(_ROUNDS if len(found) <= _MOST else 0):
        over = _over(found, model, camera)
        cuts = _cuts(over, len(found))
        made = [part for index, one in enumerate(found) for part in _cut(one, [found[i] for i in cuts.get(index, ())])]
        if len(made) == len(found):
            break
        found = made
    return [found[index] for index in _sorted(_over(found, model, camera), _depths(found, camera))]


def _over(polygons: Sequence[Polygon], model: Model, camera: Camera) -> dict[int, dict[int, int]]:
    """Return for each polygon those that it hides, with the number of samples where it is seen before them."""
    surfaces = surfaces_of(polygons)
    drawn, chosen = in_view(model._replace(surfaces=surfaces), camera, 1)
    place, level, number = every(drawn, chosen, int(camera.width), int(camera.height))
    face = surfaces.face[number]
    order = np.lexsort((face, -level, place))
    place, face = place[order], face[order]
    begins = np.nonzero(np.diff(place, prepend=-1))[0]
    top = np.repeat(face[begins], np.diff(begins, append=len(place)))
    count = len(polygons)
    pair, many = np.unique(top[top != face] * count + face[top != face], return_counts=True)
    over: dict[int, dict[int, int]] = defaultdict(dict)
    for key, seen in zip(pair.tolist(), many.tolist(), strict=True):
        over[key // count][key % count] = seen
    return over


def _cuts(over: Mapping[int, Mapping[int, int]], count: int) -> dict[int, list[int]]:
    """Return which polygons are cut by the planes of which others: those that are before and behind each other."""
    cuts: dict[int, list[int]] = defaultdict(list)
    ring = _ring(over, count)
    for one in ring:
        for other, seen in over.get(one, {}).items():
            back = over.get(other, {}).get(one, 0)
            if min(seen, back) >= _NOISE and one < other:
                cuts[one].append(other)
                cuts[other].append(one)
    if not cuts and ring:  # no two of them are through each other: three or more lie in a circle
        one = max(ring, key=lambda index: sum(over.get(index, {}).values()))
        cuts[one] = [other for other, seen in over[one].items() if other in ring and seen >= _NOISE]
    return cuts


def _ring(over: Mapping[int, Mapping[int, int]], count: int) -> set[int]:
    """Return the polygons that no order has: what is left when those that nothing is before, or behind, are taken."""
    left = set(range(count))
    above: dict[int, set[int]] = {i: set(over.get(i, {})) for i in range(count)}
    under: dict[int, set[int]] = {i: set() for i in range(count)}
    for one, others in above.items():
        for other in others:
            under[other].add(one)
    for ways, back in ((above, under), (under, above)):
        free = [i for i in left if not ways[i] & left]
        while free:
            one = free.pop()
            if one not in left:
                continue
            left.discard(one)
            free += [i for i in back[one] if i in left and not ways[i] & left]
    return left


def _cut(polygon: Polygon, others: Sequence[Polygon]) -> list[Polygon]:
    """Return the parts of a polygon on both sides of the planes of others."""
    parts = [polygon]
    for other in others:
        a, b, c = other.corners[0], other.corners[1], other.corners[2]
        normal = np.cross(b - a, c - a)
        length = float(np.sqrt((normal * normal).sum()))
        if length > 0:
            parts = [half for part in parts for half in _halves(part, a, normal / length)]
    return parts


def _halves(polygon: Polygon, point: Floats, normal: Floats) -> list[Polygon]:
    corners = polygon.corners
    height = ((corners - point) * normal).sum(axis=1)
    thin = _THIN + 1e-6 * float(np.ptp(corners, axis=0).max())
    if not ((height > thin).any() and (height < -thin).any()):
        return [polygon]
    halves = []
    for sign in (1.0, -1.0):
        made: list[Floats] = []
        sides: list[bool] = []
        for i in range(len(corners)):
            j = (i + 1) % len(corners)
            here, there = sign * height[i], sign * height[j]
            if here >= 0:
                made.append(corners[i])
                sides.append(polygon.sides[i] and (there >= 0 or here > 0))
            if (here > 0 > there) or (here < 0 < there):
                made.append(corners[i] + (corners[j] - corners[i]) * (here / (here - there)))
                sides.append(polygon.sides[i] and there > 0)
        if len(made) > 2:
            halves.append(Polygon(np.array(made), tuple(sides), polygon.normal, polygon.piece))
    return halves


def _depths(polygons: Sequence[Polygon], camera: Camera) -> list[float]:
    return [float(camera.seen(polygon.corners)[2].mean()) for polygon in polygons]


def _sorted(over: Mapping[int, Mapping[int, int]], depths: Sequence[float]) -> list[int]:
    """Return polygons so that each stands behind those that it hides; where a circle is left the farthest is next."""
    count = len(depths)
    waits = [0] * count
    above: list[list[int]] = [[] for _ in range(count)]
    for one, others in over.items():
        for other, seen in others.items():
            back = over.get(other, {}).get(one, 0)
            if (seen, -one) > (back, -other):
                waits[one] += 1
                above[other].append(one)
    free = [(-depths[i], i) for i in range(count) if not waits[i]]
    heapify(free)
    held = sorted(((-depths[i], i) for i in range(count)), reverse=True)
    done = [False] * count
    made: list[int] = []
    while len(made) < count:
        while not free:
            far = held.pop()
            if not done[far[1]]:
                free.append(far)
        _, one = heappop(free)
        if done[one]:
            continue
        done[one] = True
        made.append(one)
        for other in above[one]:
            waits[other] -= 1
            if not waits[other] and not done[other]:
                heappush(free, (-depths[other], other))
    return made
