"""What extract answers as JSON: the types of its results, of which the schemas are made.

Nothing imports this module at run time.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypedDict

from .extract import ExtractedFactory


class BoxEnds(TypedDict):
    """A box by two corners."""

    min: Annotated[list[float], "metres"]
    max: Annotated[list[float], "metres"]


class Round(TypedDict):
    """A cylinder or a capsule along z; the length of a capsule is that of its middle part."""

    radius: Annotated[float, "metres"]
    length: Annotated[float, "metres"]


class _OneShape(TypedDict, total=False):
    box: BoxEnds
    cylinder: Round
    capsule: Round


class PlacedShape(_OneShape):
    """A shape around a part, or one of several, in the frame of the part: one of box, cylinder, capsule."""

    xyz: Annotated[list[float], "metres"]
    rpy: Annotated[list[float], "radians"]


class Fit(TypedDict):
    """Shapes of one kind around a part, and how well they fit."""

    shapes: list[PlacedShape]
    volume: Annotated[float, "cubic metres"]
    overhang_volume: Annotated[float | None, "of the shapes beyond the part, cubic metres; null of an open mesh"]
    sticks_out: Annotated[float, "how far the shapes stick out of the part at most, metres"]
    overlap: Annotated[float, "the share of the shapes that is the part"]
    overlap_of: Annotated[Literal["volume", "surface"], "of what that is the share"]


class FittedPart(TypedDict):
    """A part with the shapes around it."""

    meshes: list[str]
    triangles: int
    closed: Annotated[bool, "whether its meshes enclose a volume"]
    smallest: Annotated[str, "the kind with the least volume"]
    shapes: Annotated[dict[str, Fit], "by kind: box, oriented_box, cylinder, capsule, stack"]


class ExtractedHeightMap(TypedDict):
    """The top of meshes as heights on a grid."""

    frame: Annotated[str | None, "the link that it is given in"]
    origin_xy: Annotated[list[float], "the corner of the first cell, metres"]
    cell: Annotated[float, "the edge of a cell, metres"]
    method: str
    z: Annotated[list[list[float | None]], "rows along x of heights along y, metres; null where nothing is"]


ANSWERS: dict[str, Any] = {
    "extract boxes": dict[str, FittedPart],
    "extract factory": ExtractedFactory,
    "extract heightmap": ExtractedHeightMap,
}
