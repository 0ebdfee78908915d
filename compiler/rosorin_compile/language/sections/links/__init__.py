"""The section ``links``: shapes, and inertials, given as numbers or calculated from shapes of uniform density."""

import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path as FilePath
from typing import Any

from rosorin_compile.model import Inertial, Link, Transform
from rosorin_compile.model.link import NO_SOURCE, Source, inertial_of, together
from rosorin_compile.model.sections import Section
from rosorin_compile.model.shape import Box, Capsule, Cylinder, Ellipsoid, Geometry, HeightMap, Mesh, Shape, Sphere
from rosorin_compile.model.simulation import Attachment
from rosorin_compile.source.files import is_file
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.tree import Path
from rosorin_compile.source.wording import count_of, phrase

from ...lower import Lowering, LoweringError, entries_of, record_of, vector_of

_GEOMETRIES: dict[str, type[Geometry]] = {"box": Box, "cylinder": Cylinder, "capsule": Capsule, "sphere": Sphere}
_GEOMETRIES |= {"ellipsoid": Ellipsoid, "mesh": Mesh, "height_map": HeightMap}
_PER_MASS = ("mass", "ixx", "iyy", "izz", "ixy", "ixz", "iyz")
Accepts = Callable[[LoweringError], bool]
_CHECKS = ("rosorin_compile.rules.bodies", "rosorin_compile.rules.shapes")
_MARKS = {"sites": "site", "cameras": "camera", "lights": "light"}


def _links(tree: Mapping[str, Any], lowering: Lowering) -> None:
    for name, value in entries_of(tree, "links"):
        path, entry = ("links", name), value or {}
        lowering.place("link", name, path)
        source = record_of(Source, entry["source"]) if entry.get("source") else NO_SOURCE
        shapes: dict[str, tuple[Shape, ...]] = {"visual": (), "collision": ()}
        for key in [key for key in shapes if key in entry]:
            make = partial(_shapes, lowering, entry[key], (*path, key), source)
            shapes[key] = lowering.share((id(entry[key]), source), make)
        inertial = None
        if "inertial" in entry:
            with lowering.report_errors(f' ("inertial" of link "{name}")'):
                made = partial(_inertial, lowering, entry["inertial"], (*path, "inertial"), shapes)
                inertial = lowering.share((id(entry["inertial"]), *map(id, shapes.values())), made)
        marks = [(tag, *mark) for key, tag in _MARKS.items() for mark in (entry.get(key) or {}).items()]
        marked = tuple(record_of(Attachment, mark, tag=tag, name=str(label)) for tag, label, mark in marks)
        link = record_of(Link, entry, name=name, inertial=inertial, **shapes, source=source, marked=marked)
        lowering.links.append(link)


def _shapes(lowering: Lowering, entries: Any, path: Path, source: Source) -> tuple[Shape, ...]:
    shapes = []
    for index, entry in enumerate(entries or ()):
        own = record_of(Source, entry["source"]) if "source" in entry else source
        with lowering.report_errors():
            stand_in = own.note if own.status == "stand_in" else ""
            shapes.append(lower_shape(entry, (*path, index), lowering.accepts, stand_in))
    return tuple(shapes)


def lower_shape(
    entry: Mapping[str, Any], path: Path = (), accepts: Accepts = lambda _: False, stand_in: str = ""
) -> Shape:
    """Convert the entry of a shape at ``path``; ``stand_in`` is a note if the dimensions are not yet measured.

    ``accepts`` returns True for size errors that the description suppresses. Raises LoweringError for other errors.
    """
    kinds = [kind for kind in _GEOMETRIES if kind in entry]
    if len(kinds) != 1:
        message = f"a shape needs exactly one of {', '.join(_GEOMETRIES)}, but this shape has {phrase(kinds) or 'none'}"
        help = "write one shape per entry" if kinds else 'add a shape, such as "sphere: {radius: 0.1}"'
        raise LoweringError("shape-kind", message, path, help)
    kind, sizes, here = kinds[0], entry[kinds[0]], (*path, kinds[0])
    given: dict[str, Any] = {}
    if kind == "box":
        if ("size" in sizes) == ("min" in sizes):
            help = 'write "size: [X, Y, Z]", or only the corners "min" and "max"'
            raise LoweringError("shape-kind", 'a box needs either "size", or "min" and "max"', here, help)
        half = [size / 2 for size in sizes.get("size", ())]
        lower, upper = sizes.get("min", [-size for size in half]), sizes.get("max", half)
        given = {"lower": vector_of(lower), "upper": vector_of(upper)}
    elif kind == "height_map":
        bottom, step = sizes.get("bottom", 0.0), float(sizes.get("step", sizes["cell"]))
        _check_heights(sizes["heights"], bottom, here)
        rows = tuple(tuple(map(float, row)) for row in bottom) if isinstance(bottom, list) else float(bottom)
        given = {"step": step, "bottom": rows}
    for problem in _wrong_sizes(sizes, here):
        if kind == "height_map" or not accepts(problem):
            raise problem
    return record_of(Shape, entry, geometry=record_of(_GEOMETRIES[kind], sizes, **given), stand_in=stand_in)


def _wrong_sizes(entry: Mapping[str, Any], path: Path) -> Iterator[LoweringError]:
    sizes: dict[Path, float] = {(key,): entry[key] for key in ("radius", "length", "cell", "step") if key in entry}
    sizes |= {(key, index): size for key in ("size", "radii") for index, size in enumerate(entry.get(key, ()))}
    for step, size in sizes.items():
        if not size > 0:
            message = f'"{step[0]}{list(step[1:]) or ""}" of the {path[-1]} is {size:g} m, but must be more than 0'
            yield LoweringError("shape-size", message, (*path, *step), "write a size in metres, or with a unit: 5 cm")
    for index, (low, high) in enumerate(zip(entry.get("min", ()), entry.get("max", ()), strict=True)):
        if not low < high:
            message = f'{"xyz"[index]} of "max" ({high:g} m) is not greater than {"xyz"[index]} of "min" ({low:g} m)'
            yield LoweringError("shape-size", message, (*path, "max", index), "swap the two values, or correct them")


def _check_heights(heights: Sequence[Sequence[float]], bottom: Any, path: Path) -> None:
    tables = {"height": heights, **({"bottom": bottom} if isinstance(bottom, list) else {})}
    for word, rows in tables.items():
        here: Path = (*path, "heights" if word == "height" else word)
        for i, row in ((i, row) for i, row in enumerate(rows) if len(row) != len(rows[0])):
            message = f"row {i + 1} has {count_of(len(row), word)}, but the first row has {len(rows[0])}"
            raise LoweringError("height-map-rows", message, (*here, i), "write rows of the same length")
        for at in ((i, j) for i, row in enumerate(rows) for j, number in enumerate(row) if number < 0):
            help = f"{word}s are measured upwards from z = 0"
            raise LoweringError("height-map-rows", f"a {word} is below zero", (*here, *at), help)
    lowest = min((height for row in heights for height in row if height > 0), default=math.inf)
    message, help = "", 'write a lower "bottom", or one bottom per cell, in rows like "heights"'
    if not isinstance(bottom, list):
        if bottom < 0:
            message, help = "the bottom is below zero", "the bottom is measured upwards from z = 0"
        elif bottom >= lowest:
            message = f"the bottom ({bottom:g} m) is not below the lowest height ({lowest:g} m)"
    elif (len(bottom), len(bottom[0])) != (len(heights), len(heights[0])):
        sizes = [f"{len(rows)} x {len(rows[0])}" for rows in (bottom, heights)]
        message = f'"bottom" has {sizes[0]} cells, but "heights" has {sizes[1]}'
        help = 'give "bottom" one number for each cell of "heights", or a single number for all cells'
    elif all(low >= high for rows in zip(bottom, heights, strict=True) for low, high in zip(*rows, strict=True)):
        first = (bottom[0][0], heights[0][0])
        message = "no cell has a bottom below its height (first cell: bottom {:g} m, height {:g} m)".format(*first)
        help = 'correct the values of "bottom"; numbers without a unit are in metres'
    if message:
        raise LoweringError("height-map-rows", message, (*path, "bottom"), help)


def _inertial(lowering: Lowering, entry: Mapping[str, Any], path: Path, own: Mapping[str, Sequence[Shape]]) -> Inertial:
    if "of" not in entry:
        if "density" in entry:
            at = (*path, "density")
            raise LoweringError("ignored-key", "a density needs shapes", at, 'add "of: collision"')
        return record_of(Inertial, {**entry, **entry["inertia"]})
    for key in (key for key in ("inertia", "xyz", "rpy") if key in entry):
        message = f'"{key}" is calculated from the shapes that "of" names'
        raise LoweringError("wrong-value", message, (*path, key), "remove one of the two")
    if ("mass" in entry) == ("density" in entry):
        raise LoweringError("missing-key", '"of" needs either "mass" or "density"', path, "write one of the two")
    key = "mass" if "mass" in entry else "density"
    if not entry[key] > 0:
        help = 'remove "inertial" if the link is a frame without mass'
        raise LoweringError("mass-not-positive", f"the {key} is not above zero", (*path, key), help)
    here = (*path, "of")
    if isinstance(entry["of"], str):
        shapes, paths = own[entry["of"]], [here] * len(own[entry["of"]])
        if not shapes:
            help = f'give the link a {entry["of"]}, or list the shapes here: "of: [{{box: {{size: [...]}}}}]"'
            raise LoweringError("shape-kind", f"the link has no {entry['of']} shape to take the inertia of", here, help)
    else:
        paths = [(*here, index) for index in range(len(entry["of"]))]
        shapes = [lower_shape(item, at) for item, at in zip(entry["of"], paths, strict=True)]
    try:
        if not any(isinstance(shape.geometry, Mesh) for shape in shapes):
            return inertial_of(shapes, **{key: float(entry[key])})
        meshes_first = sorted(zip(shapes, paths, strict=True), key=lambda pair: not isinstance(pair[0].geometry, Mesh))
        solids = [_solid(lowering, shape, at) for shape, at in meshes_first]
        total = together([(solid, Transform()) for solid in solids])
    except ValueError as problem:
        help = "correct the sizes; numbers without a unit are in metres"
        raise LoweringError("shape-size", str(problem), here, help) from None
    factor = float(entry[key]) / (total.mass if key == "mass" else 1.0)
    return replace(total, **{name: factor * getattr(total, name) for name in _PER_MASS})


def _solid(lowering: Lowering, shape: Shape, path: Path) -> Inertial:
    from rosorin_compile.model.mesh_triangles import ExtractProblem, mesh_inertial

    mesh = shape.geometry
    if not isinstance(mesh, Mesh):
        return inertial_of([shape], density=1.0)
    # Search the folders of the file that defines the link, of the main file, and of the imported robot ("source").
    here, first = (FilePath(span.source.path) for span in (lowering.tree.locate(path[:2]).span, lowering.tree.span))
    folders, packages = [here.parent, first.parent], Packages({}, os.environ, here)
    folders.append(first.parent / (lowering.tree.get("source") or {}).get("folder", ""))
    found = (packages.resolve(mesh.file, folder) for folder in folders)
    file = next((file for file in found if file is not None and is_file(file)), None)
    message = f"the volume of the mesh {mesh.file} is unknown: "
    help = "list primitive shapes of the same body: of: [box: {size: [...]}], or give the inertia"
    if file is None:
        raise LoweringError("shape-kind", f"{message}no such file", path, help)
    try:
        if (file, mesh.scale) not in lowering.solids:
            lowering.solids[file, mesh.scale] = mesh_inertial(file, mesh.scale)
    except ExtractProblem as problem:
        found_help = problem.diagnostic.help or help
        raise LoweringError("shape-kind", message + problem.diagnostic.message, path, found_help) from None
    return together([(lowering.solids[file, mesh.scale], shape.pose.transform())])


SECTION: Section[Any] = Section("links", Link, lower=_links, checks=_CHECKS)
