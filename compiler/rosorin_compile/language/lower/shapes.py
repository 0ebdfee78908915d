"""Shapes: the entry of a collision or a visual becomes a geometry at a pose, that of an inertial a mass and an inertia.

Inertials are as they were written, or those of shapes of even density.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any

from rosorin_compile.model import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    Geometry,
    HeightMap,
    Inertial,
    Mesh,
    Pose,
    Shape,
    Sphere,
    Transform,
)
from rosorin_compile.model.mass import inertial_of, together
from rosorin_compile.model.simulation import Contact
from rosorin_compile.source.rule_registry import NUMBERS, Rule
from rosorin_compile.source.wording import listed

from .records import other_values, pose_of_entry, record_of, values_of

RULES = (
    Rule(
        "shape-kind",
        "A shape is none of the kinds or two of them; a box has neither a size nor corners, or both.",
        "One kind an entry.",
        NUMBERS,
    ),
    Rule(
        "shape-size",
        "A size is not above zero; a corner `max` is not above `min`.",
        "Correct it.",
        NUMBERS,
        accept="link",
        imported="always",
    ),
    Rule(
        "height-map-rows",
        "The rows of a height map differ in length, a height is below zero, or the bottom is not below the top.",
        "Give all rows one length; heights count up from z = 0, and so does the bottom.",
        NUMBERS,
    ),
)


class ShapeProblem(Exception):
    """A shape that cannot be made; ``path`` leads to the culprit within the entry."""

    def __init__(self, rule: str, message: str, path: tuple[str | int, ...] = (), help: str = "") -> None:
        super().__init__(message)
        self.rule = rule
        self.message = message
        self.path = path
        self.help = help


def lower_shape(
    entry: Mapping[str, Any], pose: Pose, stand_in: str, accept: Callable[[ShapeProblem], bool] = lambda _: False
) -> Shape:
    """Return the shape of an entry; ``stand_in`` is what is not measured about it.

    ``accept`` says of a size that no shape has whether it is taken all the same. Raises ShapeProblem.
    """
    kinds = [kind for kind in GEOMETRIES if kind in entry]
    if len(kinds) != 1:
        given = listed(kinds) or "none of them"
        message = f"a shape has one of {', '.join(GEOMETRIES)}; this one has {given}"
        raise ShapeProblem("shape-kind", message, (), "write one entry a shape")
    kind = kinds[0]
    geometry = GEOMETRIES[kind](entry[kind])
    for problem in _sizes(kind, entry[kind]):
        if not accept(problem):
            raise problem
    contact = entry.get("contact")
    return record_of(
        Shape,
        entry,
        geometry=geometry,
        pose=pose,
        stand_in=stand_in,
        contact=None
        if contact is None
        else record_of(Contact, contact, values=other_values(contact, ("layers", "touches", "source"))),
    )


def _sizes(kind: str, entry: Mapping[str, Any]) -> Iterator[ShapeProblem]:
    """Yield what is wrong with the sizes of a primitive."""
    for key in ("radius", "length"):
        if key in entry and not entry[key] > 0:
            yield _not_positive(entry[key], kind, key)
    for key in ("size", "radii"):
        for index, size in enumerate(entry.get(key, ())):
            if not size > 0:
                yield _not_positive(size, kind, key, index)
    lower, upper = entry.get("min", ()), entry.get("max", ())
    for index, (low, high) in enumerate(zip(lower, upper, strict=True)):
        if not low < high:
            message = f"{'xyz'[index]} of max ({high:g} m) is not above that of min ({low:g} m)"
            yield ShapeProblem("shape-size", message, ("box", "max", index), "swap or correct the corners")


def _box(entry: Mapping[str, Any]) -> Box:
    if ("size" in entry) == ("min" in entry):
        raise ShapeProblem("shape-kind", "a box has either a size or the corners min and max", ("box",), "give one")
    if "size" in entry:
        x, y, z = map(float, entry["size"])
        return Box((-x / 2, -y / 2, -z / 2), (x / 2, y / 2, z / 2))
    a, b, c = map(float, entry["min"])
    d, e, f = map(float, entry["max"])
    return Box((a, b, c), (d, e, f))


def _height_map(entry: Mapping[str, Any]) -> HeightMap:
    heights = _rows(entry["heights"], "heights", "height")
    cell = _positive(entry["cell"], "height_map", "cell")
    step = _positive(entry["step"], "height_map", "step") if "step" in entry else cell
    x, y = map(float, entry["origin"])
    bottom = _bottom(entry.get("bottom", 0.0), heights)
    return HeightMap((x, y), cell, heights, step, entry.get("method", ""), bottom)


def _rows(rows: Sequence[Sequence[float]], key: str, word: str) -> tuple[tuple[float, ...], ...]:
    """Return the numbers of the cells of a height map, row by row."""
    for index, row in enumerate(rows):
        if len(row) != len(rows[0]):
            message = f"row {index + 1} has {len(row)} {word}s, the first row {len(rows[0])}"
            raise ShapeProblem("height-map-rows", message, ("height_map", key, index), "give all rows one length")
    for i, row in enumerate(rows):
        for j, number in enumerate(row):
            if number < 0:
                help = f"{word}s count up from z = 0"
                raise ShapeProblem("height-map-rows", f"a {word} is below zero", ("height_map", key, i, j), help)
    return tuple(tuple(map(float, row)) for row in rows)


def _bottom(given: Any, heights: Sequence[Sequence[float]]) -> float | tuple[tuple[float, ...], ...]:
    """Return where the body begins; a cell whose own bottom is not below its height has no body."""
    path: tuple[str | int, ...] = ("height_map", "bottom")
    if isinstance(given, (int, float)):
        if given < 0:
            raise ShapeProblem("height-map-rows", "the bottom is below zero", path, "it counts up from z = 0")
        low = min((height for row in heights for height in row if height > 0), default=math.inf)
        if given >= low:
            message = f"the bottom ({given:g} m) is not below the lowest height ({low:g} m)"
            help = "lower it, or give it as rows like those of heights"
            raise ShapeProblem("height-map-rows", message, path, help)
        return float(given)
    rows = _rows(given, "bottom", "bottom")
    sizes = [f"{len(some)} x {len(some[0])}" for some in (rows, heights)]
    if sizes[0] != sizes[1]:
        message = f"bottom has {sizes[0]} cells, heights has {sizes[1]}"
        raise ShapeProblem("height-map-rows", message, path, "give each cell of heights its bottom")
    cells = [(low, height) for pair in zip(rows, heights, strict=True) for low, height in zip(*pair, strict=True)]
    if cells and all(low >= height for low, height in cells):
        low, height = cells[0]
        message = f"the bottom ({low:g} m) is in no cell below the height ({height:g} m in the first)"
        raise ShapeProblem("height-map-rows", message, path, "lower it; bare numbers are in metres")
    return rows


def _ellipsoid(entry: Mapping[str, Any]) -> Ellipsoid:
    x, y, z = map(float, entry["radii"])
    return Ellipsoid((x, y, z))


def _mesh(entry: Mapping[str, Any]) -> Mesh:
    x, y, z = map(float, entry.get("scale", (1, 1, 1)))
    return Mesh(entry["file"], (x, y, z), entry.get("inertia", ""), values_of(entry.get("mjcf")))


def _positive(value: float, *path: str | int) -> float:
    if not value > 0:
        raise _not_positive(value, *path)
    return float(value)


def _not_positive(value: float, *path: str | int) -> ShapeProblem:
    words = " ".join(str(step) for step in path)
    return ShapeProblem("shape-size", f"{words} is {value:g} m; a size is above zero", path, "correct it")


GEOMETRIES: Mapping[str, Callable[[Mapping[str, Any]], Geometry]] = {
    "box": _box,
    "cylinder": lambda entry: Cylinder(float(entry["radius"]), float(entry["length"])),
    "capsule": lambda entry: Capsule(float(entry["radius"]), float(entry["length"])),
    "sphere": lambda entry: Sphere(float(entry["radius"])),
    "ellipsoid": _ellipsoid,
    "mesh": _mesh,
    "height_map": _height_map,
}


FindMesh = Callable[[str], FilePath | None]


def lower_inertial(entry: Mapping[str, Any], own: Mapping[str, Sequence[Shape]], find_mesh: FindMesh) -> Inertial:
    """Return the inertial of an entry; ``own`` are the shapes of its link by purpose (collision, visual).

    ``find_mesh`` returns the file of a mesh. Raises ShapeProblem, whose path leads to the culprit within the entry.
    """
    if "of" not in entry:
        if "density" in entry:
            raise ShapeProblem("ignored-key", "a density needs shapes to fill", ("density",), "add of: collision")
        moments = {key: float(value) for key, value in entry["inertia"].items()}
        return Inertial(float(entry["mass"]), pose_of_entry(entry), **moments)
    for key in ("inertia", "xyz", "rpy"):
        if key in entry:
            message = f"{key} is calculated from the shapes of the key of"
            raise ShapeProblem("wrong-value", message, (key,), "remove one of the two")
    if ("mass" in entry) == ("density" in entry):
        raise ShapeProblem("missing-key", "shapes have either a mass or a density", (), "give one of the two")
    key = "mass" if "mass" in entry else "density"
    if not entry[key] > 0:
        help = "leave inertial out for a frame without mass"
        raise ShapeProblem("mass-not-positive", f"a {key} is above zero", (key,), help)
    shapes, paths = _shapes(entry["of"], own)
    meshes = [(shape, path) for shape, path in zip(shapes, paths, strict=True) if isinstance(shape.geometry, Mesh)]
    try:
        if not meshes:
            return inertial_of(shapes, **{key: float(entry[key])})
        solids = [_mesh_inertial(shape, path, find_mesh) for shape, path in meshes]
        solids += [inertial_of([shape], density=1.0) for shape in shapes if not isinstance(shape.geometry, Mesh)]
        whole = together([(solid, Transform()) for solid in solids])
        factor = float(entry[key]) / (whole.mass if key == "mass" else 1.0)
        names = ("mass", "ixx", "iyy", "izz", "ixy", "ixz", "iyz")
        scaled: dict[str, Any] = {name: factor * getattr(whole, name) for name in names}
        return replace(whole, **scaled)
    except ValueError as problem:
        raise ShapeProblem(
            "shape-size", str(problem), ("of",), "correct the sizes; bare numbers are in metres"
        ) from None


def _shapes(wanted: Any, own: Mapping[str, Sequence[Shape]]) -> tuple[Sequence[Shape], list[tuple[str | int, ...]]]:
    """Return the shapes that an inertial is of, and their paths within its entry."""
    if isinstance(wanted, str):
        shapes = own[wanted]
        if not shapes:
            help = f"give the link a {wanted}, or list the shapes here: of: [box: {{size: [...]}}]"
            raise ShapeProblem("shape-kind", f"the link has no {wanted} shape to take the inertia of", ("of",), help)
        paths: list[tuple[str | int, ...]] = [("of",)] * len(shapes)
    else:
        shapes = [_shape(entry, index) for index, entry in enumerate(wanted)]
        paths = [("of", index) for index in range(len(shapes))]
    return shapes, paths


def _mesh_inertial(shape: Shape, path: tuple[str | int, ...], find_mesh: FindMesh) -> Inertial:
    """Return the inertial of a closed mesh of density 1 kg/m^3, in the frame of its link."""
    from rosorin_compile.model.mesh_triangles import ExtractProblem, mesh_inertial

    mesh = shape.geometry
    assert isinstance(mesh, Mesh)  # noqa: S101
    file = find_mesh(mesh.file)
    help = "list primitive shapes of the same body: of: [box: {size: [...]}], or give the inertia"
    if file is None:
        raise ShapeProblem("shape-kind", f"the volume of the mesh {mesh.file} is unknown: no such file", path, help)
    try:
        solid = mesh_inertial(file, mesh.scale)
    except ExtractProblem as problem:
        reason = problem.diagnostic.message
        message = f"the volume of the mesh {mesh.file} is unknown: {reason}"
        raise ShapeProblem("shape-kind", message, path, problem.diagnostic.help or help) from None
    return together([(solid, shape.pose.transform())])


def _shape(entry: Mapping[str, Any], index: int) -> Shape:
    try:
        return lower_shape(entry, pose_of_entry(entry), "")
    except ShapeProblem as problem:
        raise ShapeProblem(problem.rule, problem.message, ("of", index, *problem.path), problem.help) from None
