"""Compute height maps: the highest point of a mesh over each cell of a grid.

In this module, x and y are in cells: cell (i, j) covers x from i to i + 1 and y from j to j + 1; z is in metres. A
triangle raises every cell whose interior it intersects. A wall exactly on a grid line intersects no interior; it is
assigned to the cell on its inner side. So a box that ends on a grid line does not fill the adjacent cells, and no wall
is lost.

A height map in a description file is edited in place; the new text is parsed to check that nothing else changed.
"""

import math
import re
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from trimesh.intersections import slice_faces_plane

from rosorin_compile.model import HeightMap
from rosorin_compile.model.mesh_triangles import ExtractProblem
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, RequestError, Source, Span
from rosorin_compile.source.load import LoadError, parse_yaml, read_utf8
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.tree import Map
from rosorin_compile.source.yaml_text import Scalar

from ..description import escape
from .shapes import round_down

Floats = NDArray[np.float64]

MAX_CELLS = 1_000_000
CHUNK = 50_000  # number of triangles that are processed at once
_MOST_PAIRS = 100_000  # number of (triangle, cell) pairs that are processed at once
_LINE = 1e-5  # tolerance (in cells) for points on a grid line; STL coordinates have only 24 significant bits
_HELP = "write it in block style without anchors and aliases; or write a file with -o FILE, and paste it"
_NOISE = 1e-6  # m, meshes that extend beyond the grid or below z = 0 by less are not reported


@dataclass(frozen=True)
class GridOptions:
    """The options of a height map, lengths in metres. Raises RequestError if options conflict or are invalid."""

    cell: float | None = None  # edge length of a cell; by default 10 mm
    origin: tuple[float, float] | None = None  # x and y of the corner with the smallest coordinates
    cells: tuple[int, int] | None = None  # number of cells along x and y; by default enough to cover the mesh
    size: tuple[float, float] | None = None  # edge lengths of the grid along x and y, instead of ``cells``
    below: float | None = None  # ignore surfaces above this height
    digits: int = 4  # decimals of heights
    step: float | None = None  # heights of boxes in artifacts are multiples of this; by default ``cell``
    bottom: bool = False  # also compute the height of the lowest point of the mesh

    def __post_init__(self) -> None:
        for name, values in {"cell": (self.cell,), "step": (self.step,), "size": self.size or ()}.items():
            if any(value is not None and not value > 0 for value in values):
                raise RequestError(f'--{name} takes lengths above zero, not "{",".join(map(str, values))}"')
        if self.cells is not None and self.size is not None:
            raise RequestError("--cells and --size exclude each other; give one")
        if not 0 <= self.digits <= 9:
            raise RequestError("--map-digits takes 0 to 9 decimals")


class Grid(NamedTuple):
    """A grid with ``cells`` (nx, ny) squares of edge length ``cell`` (m); ``origin`` (m) is its lower corner (x, y)."""

    origin: tuple[float, float]
    cell: float
    cells: tuple[int, int]


def make_height_map(triangles: Floats, request: GridOptions, frame: str) -> tuple[HeightMap, list[Diagnostic]]:
    """Compute a height map from triangles (n, 3, 3) in metres, relative to the link frame ``frame``.

    Also returns a warning for surfaces outside the grid and a note for surfaces below z = 0. The default grid is the
    smallest grid with a rounded origin that covers the mesh. Raises ExtractProblem if the height map would be empty.
    """
    method = "highest point of each triangle in each cell"
    if request.below is not None:
        triangles = cut_above(triangles, request.below)
        method += f"; nothing above {exact(request.below)} m"
        if not len(triangles):
            message = f"nothing of the mesh is below {request.below:g} m in {frame}"
            raise ExtractProblem.new("height-map-empty", message, "correct --below, --xyz or --scale")
    lower, upper = triangles.min(axis=(0, 1)).tolist(), triangles.max(axis=(0, 1)).tolist()
    cell = request.cell or 0.01
    x, y = request.origin or (round_down(lower[0], 5), round_down(lower[1], 5))
    nx, ny = (max(1, math.ceil(length / cell - 0.001)) for length in (upper[0] - x, upper[1] - y))
    if request.size is not None:
        nx, ny = (math.ceil(length / cell - 1e-6) for length in request.size)
    nx, ny = request.cells or (nx, ny)
    if min(nx, ny) < 1 or nx * ny > MAX_CELLS:
        message = f"a grid of {nx:,} x {ny:,} cells is empty, or has more than {MAX_CELLS:,}"
        help = "use a larger --cell, or a smaller grid: --cells 30x23"
        raise ExtractProblem.new("height-map-grid", message, help)
    grid = Grid((x, y), cell, (nx, ny))
    heights = surface_heights(triangles, grid)
    if not heights.any():
        message = f"the mesh has no surface above z = 0 of {frame} over the grid"
        raise ExtractProblem.new("height-map-empty", message, "correct --xyz, --rpy, --scale or --origin")
    # Round up with the tolerance of ``shapes.round_up``, but never round a positive height to zero.
    scale = 10.0**request.digits
    rounded = np.ceil(heights * scale - min(1e-7 * scale, 0.05)).clip(1) / scale
    rows = tuple(map(tuple, np.where(heights > 0, rounded, 0.0).tolist()))
    bottom = max(0.0, round_down(lower[2], request.digits)) if request.bottom else 0.0
    if bottom >= min(height for row in rows for height in row if height > 0):
        bottom = 0.0
    height_map = HeightMap(grid.origin, grid.cell, rows, request.step or grid.cell, method, bottom=bottom)
    messages, beyond = list[Diagnostic](), []
    for axis, letter in enumerate("xy"):
        end = grid.origin[axis] + grid.cells[axis] * grid.cell
        for side, distance in (("low", grid.origin[axis] - lower[axis]), ("high", upper[axis] - end)):
            if distance > max(_NOISE, 1e-3 * grid.cell):
                beyond.append(f"{distance * 1000:.1f} mm at {side} {letter}")
    if beyond:
        help = "use a larger grid: --origin and --cells, or leave both out"
        message = f"the mesh reaches beyond the grid: {', '.join(beyond)}"
        messages.append(Diagnostic("height-map-outside", WARNING, message, None, (), help))
    if lower[2] < -_NOISE:
        message = f"the mesh reaches {-lower[2] * 1000:.1f} mm below z = 0 of {frame}, where a height map begins"
        messages.append(Diagnostic("height-map-below", NOTE, message, None, (), "is --xyz right?"))
    return height_map, messages


def surface_heights(triangles: Floats, grid: Grid) -> Floats:
    """Return the maximum height in metres over each cell, shape (nx, ny); 0 for cells without a surface above z = 0."""
    heights = np.zeros(grid.cells[0] * grid.cells[1])
    for start in range(0, len(triangles), CHUNK):
        scaled = triangles[start : start + CHUNK].copy()
        scaled = scaled[(scaled[:, :, 2] > 0).any(axis=1)]
        scaled[:, :, :2] = (scaled[:, :, :2] - np.array(grid.origin)) / grid.cell
        normals = np.cross(scaled[:, 1] - scaled[:, 0], scaled[:, 2] - scaled[:, 0])
        for axis in range(2):
            lower, upper = scaled[:, :, axis].min(axis=1), scaled[:, :, axis].max(axis=1)
            on_line = (upper - lower <= 2 * _LINE) & (np.floor(lower - _LINE) != np.floor(upper + _LINE))
            scaled[on_line, :, axis] -= 3 * _LINE * np.sign(normals[on_line, axis])[:, None]
        lower, upper = scaled[:, :, :2].min(axis=1), scaled[:, :, :2].max(axis=1)
        first = np.floor(lower + _LINE).clip(0, grid.cells).astype(np.int64)
        across = (np.ceil(upper - _LINE).clip(0, grid.cells).astype(np.int64) - first).clip(0)
        within = ((across == 1) & (lower >= 0) & (upper <= np.array(grid.cells))).all(axis=1)
        np.maximum.at(heights, first[within, 0] * grid.cells[1] + first[within, 1], scaled[within, :, 2].max(axis=1))
        across[within] = 0
        # To limit memory, process in chunks all pairs of a triangle and a cell that may intersect.
        ends = np.cumsum(across[:, 0] * across[:, 1])
        for pair in range(0, int(ends[-1]) if len(ends) else 0, _MOST_PAIRS):
            number = np.arange(pair, min(pair + _MOST_PAIRS, int(ends[-1])))
            owner = np.searchsorted(ends, number, side="right")
            step = number - (ends[owner] - across[owner, 0] * across[owner, 1])
            cell = first[owner] + np.stack([step // across[owner, 1], step % across[owner, 1]], axis=1)
            np.maximum.at(heights, cell[:, 0] * grid.cells[1] + cell[:, 1], _highest(scaled[owner], cell))
        Progress.step("sampling", min(start + CHUNK, len(triangles)), len(triangles))
    return heights.reshape(grid.cells)


def _highest(triangles: Floats, cells: NDArray[np.int64]) -> Floats:
    """Return the maximum height (n,) of each triangle (n, 3, 3) over its cell (n, 2), -inf if it misses the cell.

    The highest point is a corner of the triangle, an intersection of an edge with a side of the cell, or above a corner
    of the cell. Grid lines do not belong to the interior of a cell.
    """
    middle, half = cells + 0.5, 0.5 - _LINE
    inside = (np.abs(triangles[:, :, :2] - middle[:, None, :]) <= half).all(axis=2)
    highest: Floats = np.where(inside, triangles[:, :, 2], -np.inf).max(axis=1)
    for first, second in ((0, 1), (1, 2), (2, 0)):
        start, way = triangles[:, first], triangles[:, second] - triangles[:, first]
        for axis in range(2):
            other, crosses = 1 - axis, way[:, axis] != 0
            for side in (-half, half):
                share = (middle[:, axis] + side - start[:, axis]) / np.where(crosses, way[:, axis], 1.0)
                place = start[:, other] + share * way[:, other]
                on_side = crosses & (share >= 0) & (share <= 1) & (np.abs(place - middle[:, other]) <= half)
                highest = np.maximum(highest, np.where(on_side, start[:, 2] + share * way[:, 2], -np.inf))
    # Compute the heights above the corners of the cell; a vertical triangle has no such height.
    start, edges = triangles[:, 0], triangles[:, 1:] - triangles[:, :1]
    (p, q), (r, s) = edges[:, 0, :2].T, edges[:, 1, :2].T
    area = p * s - q * r
    is_flat = np.abs(area) > 1e-12 * (np.hypot(p, q) * np.hypot(r, s))
    area = np.where(is_flat, area, 1.0)
    for corner in ((-half, -half), (-half, half), (half, -half), (half, half)):
        x, y = (middle + np.array(corner) - start[:, :2]).T
        second, third = (x * s - y * r) / area, (y * p - x * q) / area
        above = is_flat & (second >= -1e-12) & (third >= -1e-12) & (second + third <= 1 + 1e-12)
        height = start[:, 2] + second * edges[:, 0, 2] + third * edges[:, 1, 2]
        highest = np.maximum(highest, np.where(above, height, -np.inf))
    return highest


def cut_above(triangles: Floats, limit: float) -> Floats:
    """Clip triangles (n, 3, 3) at z = ``limit`` (m) and return the part below."""
    faces = np.arange(3 * len(triangles)).reshape(-1, 3)
    points, faces, _ = slice_faces_plane(triangles.reshape(-1, 3), faces, [0, 0, -1], [0, 0, limit])
    pieces: Floats = points[faces].reshape(-1, 3, 3)
    pieces[:, :, 2] = np.minimum(pieces[:, :, 2], limit)
    return pieces


def summary(height_map: HeightMap) -> str:
    """Summarize a height map in one line."""
    heights = [height for row in height_map.heights for height in row]
    above = [height for height in heights if height > 0]
    size = f"{len(height_map.heights)} x {len(height_map.heights[0])} cells of {height_map.cell * 1000:g} mm"
    start = f"from x {height_map.origin[0]:g}, y {height_map.origin[1]:g}"
    return f"{size} {start}; {len(above)} of {len(heights)} have a height, {min(above):g} to {max(above):g} m"


def height_map_yaml(link: str, height_map: HeightMap, status: str, note: str) -> str:
    """Format a YAML section ``links`` in which the link ``link`` has the height map as a collision shape."""
    cell, bottom = _length(height_map.cell), height_map.bottom
    lines = [
        f"origin: {_row(height_map.origin)}",
        f"cell: {cell}",
        *([f"step: {_length(height_map.step)}"] if height_map.step != height_map.cell else []),
        f"method: {Scalar(height_map.method).in_quotes()}",
        f"heights:           # one row per {cell} of x, one number per {cell} of y; 0 means no body",
        *(f"  - {_row(heights)}" for heights in height_map.heights),
        *([f"bottom: {_length(bottom)}"] if isinstance(bottom, float) and bottom else []),
    ]
    body = "".join(f"          {line}\n" for line in lines)
    head = f"links:\n  {Scalar(escape(link)).as_text(True)}:\n    collision:\n      - height_map:\n"
    return f"{head}{body}        {_source_line(status, note)}\n"


def _row(values: Iterable[float]) -> str:
    return f"[{', '.join(map(exact, values))}]"


def _length(value: float) -> str:
    millimetres = float(f"{value * 1000:.12g}")
    return f"{exact(millimetres)} mm" if millimetres / 1000 == value else exact(value)


def _source_line(status: str, note: str) -> str:
    return f"source: {{status: {status}, note: {Scalar(note).in_quotes()}}}"


@dataclass(frozen=True)
class MapEntry:
    """A height map in a description file: its link, its index in the list ``collision``, and that list item."""

    source: Source
    link: str
    index: int
    collision: Map

    def complete(self, grid: GridOptions) -> GridOptions:
        """Copy the unset options of ``grid`` from this map. Raises ExtractProblem if a value is not a number."""
        values: Map = self.collision["height_map"]
        try:
            x, y = map(float, values["origin"])
            cell = float(values["cell"])
            step = float(values.get("step", cell))
            size = len(values["heights"]) * cell, len(values["heights"][0]) * cell
        except (KeyError, IndexError, TypeError, ValueError):
            message = f"the height map of {self.link} is not written in numbers"
            raise ExtractProblem.new("extract-into", message, _HELP) from None
        cell, origin, step = grid.cell or cell, grid.origin or (x, y), grid.step or step
        return replace(grid, cell=cell, origin=origin, size=None if grid.cells else grid.size or size, step=step)


def find_map(path: Path, link: str | None) -> MapEntry:
    """Return the height map in a description file or in its link ``link``. Raises SourceError if not exactly one."""
    source = read_utf8(path, str(path))
    tree = parse_yaml(source)
    links = tree.get("links") if isinstance(tree, Map) else None
    maps = [
        MapEntry(source, name, index, collision)
        for name, entry in (links.items() if isinstance(links, Map) else ())
        for index, collision in enumerate((isinstance(entry, Map) and entry.get("collision")) or ())
        if isinstance(collision, Map) and isinstance(collision.get("height_map"), Map)
    ]
    matching = [one for one in maps if link in (None, one.link)]
    if len(matching) == 1:
        return matching[0]
    count = f"{len(matching)} height maps" if matching else "no height map"
    of_link = f' of the link "{link}"' if link is not None else ""
    message = f"{source.path} has {count}{of_link} under links: (existing: {', '.join(m.link for m in maps) or 'none'})"
    raise ExtractProblem.new("extract-into", message, "name its link: --frame LINK; or write a file: -o FILE")


def replace_map(entry: MapEntry, new: HeightMap, status: str, note: str) -> str:
    """Return the text of the file of ``entry`` with its height map replaced. Raises ExtractProblem if impossible."""
    old, spans = entry.collision["height_map"], entry.collision.key_spans
    values: dict[str, Any] = {"origin": list(new.origin), "cell": new.cell, "method": new.method, "step": new.step}
    if "step" not in old and new.step == new.cell:
        del values["step"]
    texts = {"origin": _row(new.origin), "method": Scalar(new.method).in_quotes()}
    texts = {key: texts.get(key) or _length(value) for key, value in values.items() if old.get(key) != value}
    lines = [line.rstrip("\r") for line in entry.source.text.split("\n")]
    indent = " " * (min(span.column for span in old.key_spans.values()) - 1)
    heights = [f"{indent}  - {_row(heights)}" for heights in new.heights]
    edits = [_edit(lines, old.key_spans["heights"], "heights:", heights)]
    edits += [_edit(lines, old.key_spans[key], f"{key}: {text}") for key, text in texts.items() if key in old]
    top = spans["height_map"].line
    edits.append((top, top, [f"{indent}{key}: {text}" for key, text in texts.items() if key not in old]))
    if "source" in spans:
        edits.append(_edit(lines, spans["source"], _source_line(status, note)))
    else:
        end, column = _block_end(lines, spans["height_map"]), spans["height_map"].column
        edits.append((end, end, [" " * (column - 1) + _source_line(status, note)]))
    for start, stop, new_lines in sorted(edits, key=lambda edit: edit[:2], reverse=True):
        lines[start:stop] = new_lines
    text = ("\r\n" if "\r\n" in entry.source.text else "\n").join(lines)
    expected = parse_yaml(entry.source)
    collision = expected["links"][entry.link]["collision"][entry.index]
    collision["height_map"].update(values, heights=[list(row) for row in new.heights])
    collision["source"] = {"status": status, "note": note}
    with suppress(LoadError):
        if parse_yaml(Source(entry.source.path, text)) == expected:
            return text
    message = f"the height map of {entry.link} in {entry.source.path} is written in a way that cannot be edited"
    raise ExtractProblem.new("extract-into", message, _HELP, spans["height_map"])


def _edit(lines: list[str], key: Span, text: str, below: Sequence[str] = ()) -> tuple[int, int, list[str]]:
    """Return (start, end, new lines) for replacing a YAML key and value; a comment after the key is kept."""
    first = lines[key.line - 1]
    comment = re.search(r"\s+#.*$", first)
    head = first[: key.column - 1] + text + (comment[0] if comment else "")
    return key.line - 1, _block_end(lines, key), [head, *below]


def _block_end(lines: list[str], key: Span) -> int:
    end = key.line
    for number in range(key.line, len(lines)):
        content = lines[number].lstrip()
        depth = len(lines[number]) - len(content)
        if content and not content.startswith("#"):
            if depth < key.column - 1 or (depth == key.column - 1 and not content.startswith("- ")):
                break
            end = number + 1
    return end
