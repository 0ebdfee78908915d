"""rosorin-compile extract: compute boxes and height maps from meshes."""

from __future__ import annotations

import math
import sys
from typing import Any

import click

from rosorin_compile.cli.console import Console
from rosorin_compile.source.diagnostics import RequestError, has_errors
from rosorin_compile.source.units import ANGLE, LENGTH, NUMBER, Dimension, describe, dimension_of
from rosorin_compile.source.yaml_text import Scalar

from . import command as cli
from .answer import FINE, PROBLEMS, give_result
from .run import Run, refuse_stdin
from .table import entry

_SETTINGS: dict[str, Any] = {"within": "extract", "exits": "0 written, 1 errors"}
_section_option = cli.option(
    "--from",
    "section",
    type=click.Choice(("auto", "collision", "visual")),
    default="auto",
    help="use meshes of these shapes; default: collision, else visual",
)
_scale_option = cli.option(
    "--scale", default="1", metavar="S", help="scale factor of mesh files, such as 0.001, or X,Y,Z"
)
_grid_options = cli.combined(
    cli.option("--cell", metavar="LENGTH", help="edge length of a cell; default: 10mm"),
    cli.option("--origin", metavar="X,Y", help="corner of the first cell; default: corner of the mesh"),
    cli.option("--cells", metavar="NXxNY", help="number of cells along x and y; default: cover the mesh"),
    cli.option("--size", metavar="X,Y", help="size of the grid, instead of --cells"),
    # Of earlier versions, which sampled the surface; heights are exact now.
    cli.option("--exact", is_flag=True, hidden=True),
    cli.option("--spacing", hidden=True),
    cli.option("--below", metavar="Z", help="ignore surfaces above this height"),
    cli.option("--map-digits", type=int, default=4, metavar="N", help="decimals of heights; default: 4"),
    cli.option(
        "--step", metavar="LENGTH", help="round heights of boxes to multiples of this length; default: the cell"
    ),
)
_output_option = cli.path_option("-o", "--output", metavar="FILE", help="write to a file instead of standard output")


@cli.command("boxes", help="fit boxes, oriented boxes, cylinders, capsules and stacks of boxes to meshes", **_SETTINGS)
@cli.words_argument(
    "SOURCE ...", "mesh files, or one robot: description, URDF, xacro, SDF or MJCF", required=True, offers=("file",)
)
@cli.option("--link", multiple=True, help="use only this link of the robot; repeatable")
@_section_option
@cli.choice(
    "--shape",
    ("box", "oriented_box", "cylinder", "capsule", "stack", "smallest"),
    default="box",
    help="shape to write; default: box",
)
@cli.option("--stack", type=int, default=4, metavar="N", help="number of boxes in a stack; default: 4")
@cli.choice("--axis", ("x", "y", "z", "auto"), default="auto", help="axis of the stack; default: auto, the best fit")
@_scale_option
@cli.option("--digits", type=int, default=5, metavar="N", help="decimals of lengths in metres; default: 5")
@_output_option
@cli.force_option
@cli.robot_options
def boxes(options: cli.Options) -> int:
    """Fit boxes to meshes. Raises RequestError."""
    from rosorin_compile import api

    run = _run(options)
    result = api.extract_boxes(
        run.words,
        **run.read_options(),
        **options.pick("section shape stack axis digits output force"),
        links=options.link,
        scale=_scale(options.scale),
    )
    return _print(run, result, result.parts)


@cli.command("heightmap", help="compute the top surface of a mesh as heights on a grid", **_SETTINGS)
@cli.words_argument("SOURCE ...", "mesh files, or one robot with --link", required=True, offers=("file",))
@cli.option("--link", help="link of the robot whose meshes are used")
@_section_option
@cli.option("--frame", help="link whose frame the height map uses")
@_grid_options
@cli.flag("--bottom", help="also compute the lowest point in each cell")
@cli.option("--xyz", default="0,0,0", metavar="X,Y,Z", help="position of the mesh in the frame, such as 0,0,25mm")
@cli.option(
    "--rpy",
    default="0,0,0",
    metavar="R,P,Y",
    help="orientation of the mesh in the frame, in radians or with a unit (90deg)",
)
@_scale_option
@cli.option("--into", metavar="FILE", help="replace the height map in a description file, with the same grid")
@cli.choice(
    "--status",
    ("calculated", "measured", "factory"),
    default="calculated",
    help="status of the source in the description; default: calculated",
)
@cli.option("--note", help="note of the source in the description; default: the names of the meshes")
@_output_option
@cli.force_option
@cli.robot_options
def heightmap(options: cli.Options) -> int:
    """Compute a height map. Raises RequestError."""
    from rosorin_compile import api

    run = _run(options)
    if options.format != "text" and (options.into or options.bottom):
        word, other = ("--into edits a file; it", "-o") if options.into else ("--bottom", "--into")
        raise RequestError(f"{word} excludes {other} and JSON")
    result = api.extract_height_map(
        run.words,
        **run.read_options(),
        **_grid(options),
        **options.pick("link section frame bottom into status note output force"),
        scale=_scale(options.scale),
        xyz=_numbers(options.xyz, "--xyz", 3),
        rpy=_numbers(options.rpy, "--rpy", 3, ANGLE),
    )
    if options.into:
        failed = run.show(result)
        for line in result.report:
            print(line)
        return PROBLEMS if failed else FINE
    return _print(run, result, result.values)


@cli.command("factory", help="extract joints, boxes and a height map from a ROS description package", **_SETTINGS)
@cli.words_argument("PACKAGE", "folder of a ROS description package", required=True, offers=("file",))
@cli.path_option("-o", "--output", required=True, metavar="FOLDER", help="folder to write")
@cli.option("--robot", metavar="FILE", help="robot file in the package; default: the only one")
@cli.option("--heightmap-link", metavar="LINK", help="link whose meshes are used for the height map")
@cli.option("--frame", metavar="LINK", help="link whose frame the height map uses; default: that of --heightmap-link")
@cli.flag("--lenient", help="accept violations of the specification where possible")
@_section_option
@_grid_options
@cli.robot_options
def factory(options: cli.Options) -> int:
    """Extract the numbers of a ROS description package. Raises RequestError."""
    from rosorin_compile import api

    run = _run(options)
    if len(run.words) != 1:
        raise RequestError(f"extract factory takes one PACKAGE, not {len(run.words)}")
    result = api.extract_factory(
        run.words[0],
        options.output,
        **run.read_options(),
        **_grid(options),
        **options.pick("robot frame section lenient"),
        height_map_link=options.heightmap_link,
    )
    failed = run.show(result)
    if result.written:
        run.give(result, lambda: "" if options.quiet else "\n".join(result.report))
    return PROBLEMS if failed else FINE


_ABOUT = entry("extract")
run = cli.CommandGroup(
    "extract", commands={"boxes": boxes, "heightmap": heightmap, "factory": factory}, help=_ABOUT.help if _ABOUT else ""
)


def _run(options: cli.Options) -> Run:
    run = Run.of(options)
    refuse_stdin(run.words, "name a file")
    return run


def _print(run: Run, result: Any, value: object) -> int:
    """Print a text that was not written to a file, and the report; return the exit code."""
    options = run.options
    run.console.show(result.diagnostics)
    if has_errors(result.diagnostics):
        return PROBLEMS
    if options.format == "json":
        return give_result(options, value, str)
    lines = [] if options.quiet else [*result.report, *([f"written: {options.output}"] if options.output else [])]
    if options.output is None:
        Console.give(result.text)
    for line in lines:
        print(line, file=sys.stderr if options.output is None else sys.stdout)
    return FINE


def _grid(options: cli.Options) -> dict[str, Any]:
    """Return the grid of a height map, lengths in metres. Raises RequestError."""
    grid: dict[str, Any] = {"map_digits": options.map_digits, "cells": None}
    for name, count in (("cell", 1), ("step", 1), ("below", 1), ("origin", 2), ("size", 2)):
        text = getattr(options, name)
        numbers = None if text is None else _numbers(text, f"--{name}", count)
        if numbers is not None and name in ("cell", "step") and not numbers[0] > 0:
            raise RequestError(f'--{name} takes a length above zero, not "{text}"')
        grid[name] = numbers[0] if numbers is not None and count == 1 else numbers
    if options.cells is not None:
        first, cross, second = options.cells.lower().partition("x")
        if not cross or not first.isdecimal() or not second.isdecimal() or len(options.cells) > 20:
            raise RequestError(f'--cells takes two whole numbers such as 30x23, not "{options.cells}"')
        grid["cells"] = int(first), int(second)
    return grid


def _numbers(text: str, name: str, count: int, kind: Dimension = LENGTH) -> tuple[float, ...]:
    """Return numbers with or without units, separated by commas, in SI. Raises RequestError."""
    parts = text.split(",") if count > 1 else [text]
    if len(parts) != count:
        raise RequestError(f'{name} takes {count} numbers with commas between them, not "{text}"')
    found = []
    for part in parts:
        value = Scalar(part.strip() or "-").value
        valid = isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
        if not valid or dimension_of(value) not in (None, kind):
            raise RequestError(f'{name} takes {describe(kind)}, not "{part}"')
        found.append(float(value))
    return tuple(found)


def _scale(text: str) -> tuple[float, ...]:
    """Return the factors of a mesh along x, y and z. Raises RequestError."""
    count = text.count(",") + 1
    if count not in (1, 3):
        raise RequestError(f'--scale takes one number or three with commas, not "{text}"')
    factors = _numbers(text, "--scale", count, NUMBER) * (3 // count)
    if 0 in factors:
        raise RequestError("--scale 0 leaves nothing of a mesh")
    return factors
