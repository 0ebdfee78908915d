"""Height maps in an MJCF: as which boxes, or as a height field of MuJoCo's own.

What there is to know about height fields (MuJoCo 4.0.0, XMLreference "asset/hfield"):

- Elevations are those of points, with slopes between them, where a height map has cells. A point has the height of its
  highest cell, so that the field is never smaller than the body, and wider than a step by up to one cell.
- They are scaled to what is between the lowest and the highest of them; the first row is the one of the largest y.
- What is below the lowest point is a slab, which has to have a thickness. There are no holes and no wells below.
- A field may move. It collides with convex geoms, not with planes and other fields: a body of fields alone falls
  through a floor that is a plane.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from rosorin_compile.model import HeightMap, Link, Output, Pose, Shape
from rosorin_compile.model.shape import MERGED

from .omissions import has_volume

HFIELD = "hfield"
_THIN = 1e-5  # m: what stands for a thickness of zero, which MuJoCo does not take


class Field(NamedTuple):
    """A height field: points along y and x, MuJoCo's four sizes (m), elevations (m) row by row, and its place."""

    rows: int
    columns: int
    size: tuple[float, float, float, float]
    elevation: tuple[float, ...]
    pose: Pose


def form_of(output: Output) -> str:
    """Return as what an output has height maps: in a form of boxes, or ``hfield``."""
    return str(output.options.get("height_maps", MERGED))


def solids(shape: Shape, form: str) -> Sequence[Shape]:
    """Return the shapes that the geoms of a shape are: a height map as boxes in a form, or as it is."""
    return (shape,) if form == HFIELD else shape.solids(form)


def colliding(link: Link, output: Output) -> Sequence[Shape] | None:
    """Return the shapes of the geoms that a link collides with; None where one is a height field, no shape of ours."""
    form = form_of(output)
    if form == HFIELD and any(len(shape.solids()) > 1 for shape in link.collision):
        return None
    return [solid for shape in link.collision for solid in shape.solids(form) if has_volume(solid.geometry)]


def field_of(shape: Shape, grid: HeightMap) -> Field:
    """Return the height field of a height map in the frame of its link."""
    tops: dict[tuple[int, int], float] = {}
    count, across = len(grid.heights), len(grid.heights[0])
    boxes = grid.boxes()
    lowest = min((box.lower[2] for box in boxes), default=0.0)
    for box in boxes:
        (i, j), (k, n) = (_cell(grid, corner) for corner in (box.lower, box.upper))
        for x in range(i, k + 1):
            for y in range(j, n + 1):
                tops[x, y] = max(box.upper[2], tops.get((x, y), lowest))
    points = [tops.get((x, y), lowest) for y in range(across, -1, -1) for x in range(count + 1)]
    low, high = min(points), max(points)
    half = count * grid.cell / 2, across * grid.cell / 2
    size = (*half, max(high - low, _THIN), max(low - lowest, _THIN))
    middle = (grid.origin[0] + half[0], grid.origin[1] + half[1], low)
    elevation = tuple(round(point - low, 12) for point in points)
    return Field(across + 1, count + 1, size, elevation, Pose(shape.pose.transform().apply(middle), shape.pose.rpy))


def _cell(grid: HeightMap, corner: tuple[float, float, float]) -> tuple[int, int]:
    x, y = ((at - start) / grid.cell for at, start in zip(corner, grid.origin, strict=False))
    return round(x), round(y)
