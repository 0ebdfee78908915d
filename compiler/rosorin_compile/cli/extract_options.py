"""What the words and options of ``extract`` mean: lengths, grids, files of meshes and links of robots."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.source.diagnostics import Console
from rosorin_compile.source.units import Quantity
from rosorin_compile.source.yaml_text import Scalar

from .command import Options
from .usage import WrongUsage

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rosorin_compile.formats.imported import ReadOptions
    from rosorin_compile.importing.extract.heightmap import Wanted
    from rosorin_compile.importing.extract.into import Block
    from rosorin_compile.importing.extract.parts import Part
    from rosorin_compile.source.diagnostics import Diagnostic

    from .run import Run

    Floats = NDArray[np.float64]

MAX_DIGITS = 9
_DEFAULT_CELL = 0.01
_LENGTH = Quantity.one("m")


def quantity(text: str, option: str, kind: Quantity = _LENGTH) -> float:
    """Return a number with or without unit in SI; ``kind`` is one of that kind. Raises WrongUsage."""
    value = Scalar(text.strip() or "-").value
    right = isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    if not right or not kind.goes_with(value):
        raise WrongUsage(f'{option} takes {kind.described}, not "{text}"')
    return float(value)


def quantities(text: str, option: str, count: int, kind: Quantity = _LENGTH) -> tuple[float, ...]:
    """Return numbers that are separated by commas. Raises WrongUsage."""
    parts = text.split(",")
    if len(parts) != count:
        raise WrongUsage(f'{option} takes {count} numbers with commas between them, not "{text}"')
    return tuple(quantity(part, option, kind) for part in parts)


def digits(count: int, option: str) -> int:
    """Return a number of decimals. Raises WrongUsage."""
    if not 0 <= count <= MAX_DIGITS:
        raise WrongUsage(f"{option} takes 0 to {MAX_DIGITS} decimals")
    return count


def scale(text: str) -> tuple[float, float, float]:
    """Return the factors of a mesh along x, y and z. Raises WrongUsage."""
    parts = text.split(",")
    if len(parts) not in (1, 3):
        raise WrongUsage(f'--scale takes one number or three with commas, not "{text}"')
    factors = [quantity(part, "--scale", Quantity.one()) for part in parts] * (3 // len(parts))
    if 0 in factors:
        raise WrongUsage("--scale 0 leaves nothing of a mesh")
    return (factors[0], factors[1], factors[2])


def wanted(options: Options) -> Wanted:
    """Return the height map that is asked for. Raises WrongUsage."""
    from rosorin_compile.importing.extract.heightmap import Wanted

    cell = _DEFAULT_CELL if options.cell is None else quantity(options.cell, "--cell")
    if not cell > 0:
        raise WrongUsage(f'--cell takes a length above zero, not "{options.cell}"')
    origin = None if options.origin is None else quantities(options.origin, "--origin", 2)
    some = {name: getattr(options, name) for name in ("spacing", "below", "step")}
    lengths = {name: None if text is None else quantity(text, f"--{name}") for name, text in some.items()}
    step = lengths["step"]
    if step is not None and not step > 0:
        raise WrongUsage(f'--step takes a length above zero, not "{options.step}"')
    return Wanted(
        cell,
        None if origin is None else (origin[0], origin[1]),
        _cells(options, cell),
        lengths["spacing"],
        options.exact,
        lengths["below"],
        digits(options.map_digits, "--map-digits"),
        step,
        getattr(options, "bottom", False),
    )


def _cells(options: Options, cell: float) -> tuple[int, int] | None:
    """Return the number of cells along x and y that --cells or --size ask for."""
    if options.cells is not None and options.size is not None:
        raise WrongUsage("--cells and --size say the same; give one")
    if options.size is not None:
        width, depth = quantities(options.size, "--size", 2)
        if not (width > 0 and depth > 0):
            raise WrongUsage(f'--size takes lengths above zero, not "{options.size}"')
        return math.ceil(width / cell - 1e-6), math.ceil(depth / cell - 1e-6)
    if options.cells is None:
        return None
    first, cross, second = options.cells.lower().partition("x")
    if not cross or not first.isdecimal() or not second.isdecimal() or len(options.cells) > 20:
        raise WrongUsage(f'--cells takes two whole numbers such as 30x23, not "{options.cells}"')
    return int(first), int(second)


def wanted_there(options: Options, asked: Wanted, block: Block) -> Wanted:
    """Return what is wanted in the place of another height map: its grid, unless the options say otherwise."""
    from rosorin_compile.importing.extract.into import grid_of

    if options.cell is not None and options.origin is not None and asked.cells is not None:
        cell, origin, cells = asked.cell, asked.origin, asked.cells
    else:
        there = grid_of(block)
        cell, origin, cells = there
        if options.cell is not None and asked.cell != cell:
            factor = cell / asked.cell
            cells = (math.ceil(cells[0] * factor - 1e-6), math.ceil(cells[1] * factor - 1e-6))
            cell = asked.cell
        origin = asked.origin or origin
        cells = _cells(options, cell) or cells
    step = asked.step if asked.step is not None else _number(block.height_map.get("step"))
    return replace(asked, cell=cell, origin=origin, cells=cells, step=step)


def _number(value: object) -> float | None:
    return float(value) if isinstance(value, int | float) and value > 0 else None


def reading(run: Run) -> tuple[ReadOptions, dict[str, Path], list[str]]:
    """Return how robots are read, the packages by name, and the words that are no arguments. Raises WrongUsage."""
    from rosorin_compile.formats.imported import ReadOptions

    run.no_stdin(run.words, "name a file")
    packages = dict(run.given.packages)
    lenient = getattr(run.options, "lenient", False)
    asked = ReadOptions(run.given.as_written(), packages, lenient, tell=run.console.ahead, trust=run.given.trust)
    return asked, packages, run.words


def parts(run: Run) -> list[Part]:
    """Return the parts that get a shape: one a mesh file, or one a link of a robot that has meshes."""
    from rosorin_compile.importing.extract.parts import part_of_link, read_source
    from rosorin_compile.model.mesh_triangles import ExtractProblem

    options, console = run.options, run.console
    read, _, words = reading(run)
    if _are_meshes(words):
        _no_robot(options)
        return _mesh_parts(options, words, console)
    source = read_source(_only(words), read)
    links = [source.link(name) for name in options.link] or list(source.robot.link)
    found = [part for link in links if (part := part_of_link(source, link, options.section)) is not None]
    say(console, source.diagnostics)
    if not found:
        message = f"{words[0]} has no link with a mesh that can be read"
        raise ExtractProblem.of("mesh-empty", message, "see above, or --from")
    return found


def surface(run: Run, frame: str | None) -> tuple[Floats, tuple[str, ...], str]:
    """Return the triangles (n, 3, 3) for a height map in its frame, the names of the meshes, and that of the frame."""
    import numpy as np

    from rosorin_compile.importing.extract.parts import part_of_link, read_source
    from rosorin_compile.model import Pose
    from rosorin_compile.model.mesh_triangles import ExtractProblem, TriangleMesh

    options, console = run.options, run.console
    read, _, words = reading(run)
    x, y, z = quantities(options.xyz, "--xyz", 3)
    roll, pitch, yaw = quantities(options.rpy, "--rpy", 3, Quantity.one("rad"))
    transform = Pose((x, y, z), (roll, pitch, yaw)).transform()
    if _are_meshes(words):
        _no_robot(options)
        found = _mesh_parts(options, words, console)
        triangles = found[0].triangles if len(found) == 1 else np.concatenate([part.triangles for part in found])
        meshes = tuple(name for part in found for name in part.meshes)
        return TriangleMesh.placed(triangles, transform.rows, transform.xyz), meshes, frame or found[0].name
    if options.link is None:
        raise WrongUsage("of which link of the robot? --link LINK")
    source = read_source(_only(words), read)
    link = source.link(options.link)
    frame = source.link(frame or link)
    part = part_of_link(source, link, options.section)
    say(console, source.diagnostics)
    if part is None:
        raise ExtractProblem.of("mesh-empty", f"{link} has no mesh that can be read", "see above, or --from")
    transform = transform.then(source.robot.transform(frame, link, {}))
    return TriangleMesh.placed(part.triangles, transform.rows, transform.xyz), part.meshes, frame


def _mesh_parts(options: Options, words: list[str], console: Console) -> list[Part]:
    from rosorin_compile.importing.extract.meshes import too_large
    from rosorin_compile.importing.extract.parts import Part
    from rosorin_compile.model.mesh_triangles import TriangleMesh

    found: list[Part] = []
    for word in words:
        mesh = TriangleMesh.load(Path(word), scale(options.scale))
        console.show(too_large(mesh))
        name = Path(word).stem
        taken = {part.name for part in found}
        if name in taken:
            raise WrongUsage(f'two meshes are called "{name}"; each part needs a name of its own')
        found.append(Part(name, mesh.triangles, (mesh.name,)))
    return found


def _are_meshes(words: list[str]) -> bool:
    """Whether the words name mesh files; else they name a robot. Raises WrongUsage for none and for a mixture."""
    from rosorin_compile.model.mesh_triangles import TriangleMesh

    kinds = {Path(word).suffix.lower().removeprefix(".") in TriangleMesh.FORMATS for word in words}
    if len(kinds) != 1:
        raise WrongUsage("name mesh files, or one robot")
    return kinds == {True}


def _no_robot(options: Options) -> None:
    if options.link:
        raise WrongUsage("--link is that of a robot; a mesh file has none")


def _only(words: list[str]) -> str:
    if len(words) != 1:
        raise WrongUsage(f"one robot at a time, not {len(words)}")
    return words[0]


def say(console: Console, diagnostics: list[Diagnostic]) -> None:
    """Print diagnostics, each once."""
    from rosorin_compile.source.diagnostics import arrange

    console.show(arrange(diagnostics))
