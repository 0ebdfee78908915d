"""rosorin-compile extract: take numbers out of meshes."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.source.diagnostics import Console, masked

from .answer import give_result
from .run import Run
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.importing.extract.factory import Factory
    from rosorin_compile.importing.extract.into import Block
    from rosorin_compile.model import HeightMap
    from rosorin_compile.source.diagnostics import Source

    from .parser import Parser

_KINDS = ("box", "oriented_box", "cylinder", "capsule", "stack", "smallest")
_STATUSES = ("calculated", "measured", "factory")


def options(command: Parser) -> None:
    """Add what this command takes."""
    ways = command.add_subparsers(required=True, metavar="WHAT", dest="what")
    for name, words, help, more in (
        (
            "boxes",
            "SOURCE ...",
            "fit boxes, oriented boxes, cylinders, capsules and stacks of boxes to meshes",
            _boxes_options,
        ),
        ("heightmap", "SOURCE ...", "compute the top surface of a mesh as heights on a grid", _heightmap_options),
        (
            "factory",
            "PACKAGE -o FOLDER",
            "extract joints, boxes and a height map from a ROS description package",
            _factory_options,
        ),
    ):
        way = ways.add_parser(name, help=help, description=f"{help[0].upper()}{help[1:]}.")
        more(way)
        way.add_result()
        way.add_given()
        way.usage = f"rosorin-compile extract {name} [options] {words}"


def _boxes_options(way: Parser) -> None:
    way.add_argument(
        "words", nargs="+", metavar="SOURCE", help="mesh files, or one robot: description, URDF, xacro, SDF or MJCF"
    )
    way.add_argument("--link", action="append", default=[], help="use only this link of the robot; repeatable")
    _section_option(way)
    way.add_argument("--shape", choices=_KINDS, default="box", help="shape to write; default: box")
    way.add_argument("--stack", type=int, default=4, metavar="N", help="number of boxes in a stack; default: 4")
    way.add_argument(
        "--axis", choices=("x", "y", "z", "auto"), default="auto", help="axis of the stack; default: auto, the best fit"
    )
    way.add_argument("--scale", default="1", metavar="S", help="scale factor of mesh files, such as 0.001, or X,Y,Z")
    way.add_argument("--digits", type=int, default=5, metavar="N", help="decimals of lengths in metres; default: 5")
    _output_options(way)


def _heightmap_options(way: Parser) -> None:
    way.add_argument("words", nargs="+", metavar="SOURCE", help="mesh files, or one robot with --link")
    way.add_argument("--link", help="link of the robot whose meshes are used")
    _section_option(way)
    way.add_argument("--frame", help="link whose frame the height map uses")
    _grid_options(way)
    way.add_argument("--bottom", action="store_true", help="also compute the lowest point in each cell")
    way.add_argument(
        "--xyz", default="0,0,0", metavar="X,Y,Z", help="position of the mesh in the frame, such as 0,0,25mm"
    )
    way.add_argument(
        "--rpy",
        default="0,0,0",
        metavar="R,P,Y",
        help="orientation of the mesh in the frame, in radians or with a unit (90deg)",
    )
    way.add_argument("--scale", default="1", metavar="S", help="scale factor of mesh files, such as 0.001, or X,Y,Z")
    way.add_argument("--into", metavar="FILE", help="replace the height map in a description file, with the same grid")
    way.add_argument(
        "--status",
        choices=_STATUSES,
        default="calculated",
        help="status of the source in the description; default: calculated",
    )
    way.add_argument("--note", help="note of the source in the description; default: the names of the meshes")
    _output_options(way)


def _factory_options(way: Parser) -> None:
    way.add_argument("words", nargs="+", metavar="PACKAGE", help="folder of a ROS description package")
    way.add_argument("-o", "--output", required=True, type="path", metavar="FOLDER", help="folder to write")
    way.add_argument("--robot", metavar="FILE", help="robot file in the package; default: the only one")
    way.add_argument("--heightmap-link", metavar="LINK", help="link whose meshes are used for the height map")
    way.add_argument(
        "--frame", metavar="LINK", help="link whose frame the height map uses; default: that of --heightmap-link"
    )
    way.add_argument("--lenient", action="store_true", help="accept violations of the specification where possible")
    _section_option(way)
    _grid_options(way)


def _section_option(way: Parser) -> None:
    way.add_argument(
        "--from",
        choices=("auto", "collision", "visual"),
        default="auto",
        dest="section",
        help="use meshes of these shapes; default: collision, else visual",
    )


def _grid_options(way: Parser) -> None:
    way.add_argument("--cell", metavar="LENGTH", help="edge length of a cell; default: 10mm")
    way.add_argument("--origin", metavar="X,Y", help="corner of the first cell; default: corner of the mesh")
    way.add_argument("--cells", metavar="NXxNY", help="number of cells along x and y; default: cover the mesh")
    way.add_argument("--size", metavar="X,Y", help="size of the grid, instead of --cells")
    way.add_argument("--spacing", metavar="LENGTH", help="maximum distance between samples; default: a third of a cell")
    way.add_argument(
        "--exact", action="store_true", help="compute the highest point in each cell exactly instead of sampling"
    )
    way.add_argument("--below", metavar="Z", help="ignore surfaces above this height")
    way.add_argument("--map-digits", type=int, default=4, metavar="N", help="decimals of heights; default: 4")
    way.add_argument(
        "--step", metavar="LENGTH", help="round heights of boxes to multiples of this length; default: the cell"
    )


def _output_options(way: Parser) -> None:
    way.add_argument("-o", "--output", type="path", metavar="FILE", help="write to a file instead of standard output")
    way.add_argument("--force", action="store_true", help="replace a file that this command did not write")


def run(options: argparse.Namespace) -> int:
    """Do what is asked for; a problem is said and is exit code 1. Raises WrongUsage for a name of nothing."""
    from rosorin_compile.importing.extract.parts import SourceProblem
    from rosorin_compile.model.mesh_triangles import ExtractProblem, NotThere, TriangleMesh

    from .extract_options import say

    ways: dict[str, Callable[[Run], int]] = {
        "boxes": _boxes,
        "heightmap": _heightmap,
        "factory": _factory,
    }
    run = Run.of(options)
    console = run.console
    try:
        TriangleMesh.needed()
        return ways[options.what](run)
    except SourceProblem as problem:
        say(console, problem.diagnostics)
    except NotThere as problem:
        said = problem.diagnostic
        raise WrongUsage(f"{said.message}; {said.help}" if said.help else said.message) from None
    except ExtractProblem as problem:
        console.show([problem.diagnostic])
    return PROBLEMS


def _boxes(run: Run) -> int:
    from rosorin_compile.importing.extract import boxes
    from rosorin_compile.importing.extract.fits import KINDS

    from .extract_options import digits, parts

    options = run.options
    if not 1 <= options.stack <= 100:
        raise WrongUsage("--stack takes 1 to 100 boxes")
    decimals = digits(options.digits, "--digits")
    fitted = boxes.fit_parts(parts(run), decimals, options.stack, options.axis)
    lines = boxes.table(fitted, KINDS)
    made = boxes.json_values(fitted, KINDS)
    return _give(options, made, _head(options) + boxes.yaml_text(fitted, options.shape), lines)


def _heightmap(run: Run) -> int:
    from rosorin_compile.importing.extract import into, writing
    from rosorin_compile.importing.extract.heightmap import make_map, summary

    from .extract_options import surface, wanted, wanted_there

    options = run.options
    as_json = options.format != "text"
    if options.into and (options.output or as_json):
        raise WrongUsage("--into edits a file; it goes with neither -o nor JSON")
    if options.bottom and (options.into or as_json):
        raise WrongUsage("--bottom goes with neither --into nor JSON; write a file with -o, and paste it")
    asked = wanted(options)
    source = block = None
    if options.into:
        source = into.read(Path(options.into))
        block = into.find_block(source, options.frame)
        asked = wanted_there(options, asked, block)
    triangles, meshes, frame = surface(run, block.link if block else options.frame)
    made, said = make_map(triangles, asked, frame)
    run.console.show(said)
    note = options.note or f"top of {', '.join(meshes)}"
    if source is not None and block is not None:
        return _replace(options, source, block, made, note)
    values = writing.driver_height_map(frame, made)
    text = _head(options) + "\n".join(writing.height_map(frame, made, options.status, note)) + "\n"
    return _give(options, values, text, [summary(made)])


def _replace(options: argparse.Namespace, source: Source, block: Block, made: HeightMap, note: str) -> int:
    """Put a height map into a description, and say what that changed."""
    from rosorin_compile.importing.extract import into, writing

    text = into.replaced(source, block, made, options.status, note)
    if text == source.text:
        print(f"{options.into}:{block.line}: height map of {block.link} unchanged")
        return FINE
    writing.replace(Path(options.into), text)
    print(f"{options.into}:{block.line}: height map of {block.link} replaced")
    for line in into.changes(block, made, options.status):
        print(f"  {line}")
    return FINE


def _factory(run: Run) -> int:
    from rosorin_compile.importing.extract import factory
    from rosorin_compile.importing.extract.parts import read_source
    from rosorin_compile.importing.extract.writing import is_made
    from rosorin_compile.output import OutputError, write_set
    from rosorin_compile.source.diagnostics import has_errors

    from .extract_options import reading, say, wanted

    options, console = run.options, run.console
    read, packages, words = reading(run)
    if len(words) != 1:
        raise WrongUsage(f"extract factory takes one PACKAGE, not {len(words)}")
    if options.frame and not options.heightmap_link:
        raise WrongUsage("--frame is that of the height map; say of which link: --heightmap-link LINK")
    package = Path(words[0])
    path = factory.robot_file(package, options.robot)
    name = factory.name_of(package)
    packages.setdefault(name, package)
    asked = factory.Asked(options.heightmap_link, options.frame, wanted(options), options.section)
    made = factory.extract(read_source(str(path), read), name, asked)
    say(console, made.diagnostics)
    try:
        write_set(Path(options.output), made.files, judge=lambda _, old, __: "replace" if is_made(old) else "refuse")
    except OutputError as problem:
        console.show([problem.diagnostic])
        return PROBLEMS
    result = {"joints": list(made.joints), "boxes": list(made.boxes), "written": _written(made, options.output)}
    give_result(options, result, lambda: "" if options.quiet else "\n".join(_told(made, options.output)))
    return PROBLEMS if has_errors(made.diagnostics) else FINE


def _written(made: Factory, folder: str) -> list[str]:
    return [str(Path(folder, file)) for file in sorted(made.files)]


def _told(made: Factory, folder: str) -> Iterator[str]:
    """Yield lines about what came of a package."""
    from rosorin_compile.importing.extract.heightmap import summary

    for what, names in (("joints", made.joints), ("boxes", list(made.boxes))):
        yield f"{what} ({len(names)}): {', '.join(names) or 'none'}"
    if made.height_map is not None:
        yield f"height map in {made.frame}: {summary(made.height_map)}"
    yield f"written: {', '.join(_written(made, folder))}"


def _head(options: argparse.Namespace) -> str:
    """Return the first line of a file: by which words it was made."""
    from rosorin_compile.importing.extract.writing import MARK

    return masked(f"{MARK} {options.what} {shlex.join(options.words)}".replace("\n", " ")) + "\n"


def _give(options: argparse.Namespace, result: object, text: str, said: Sequence[str]) -> int:
    """Write a text to the file that is asked for, else to standard output, and say on the other what it is.

    In an envelope there is the result instead, with or without a file.
    """
    from rosorin_compile.importing.extract.writing import save

    if options.format == "json":
        if options.output is not None:
            save(Path(options.output), text, options.force)
        give_result(options, result, str)
        return FINE
    said = () if options.quiet else (*said, *([f"written: {options.output}"] if options.output else []))
    if options.output is None:
        Console.give(text)
        sys.stderr.write("".join(f"{line}\n" for line in said))
        return FINE
    save(Path(options.output), text, options.force)
    for line in said:
        print(line)
    return FINE
