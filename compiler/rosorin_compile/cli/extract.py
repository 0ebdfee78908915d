"""rosorin-compile extract: take numbers out of meshes."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from typing import Any

import click

from rosorin_compile.source.console import Console
from rosorin_compile.source.diagnostics import Diagnostic, has_errors
from rosorin_compile.source.units import Quantity
from rosorin_compile.source.yaml_text import Scalar

from .answer import give_result
from .command import Options, Ways, combined, command, option
from .options import PATH, robot_options, words_argument
from .run import Run
from .table import entry
from .usage import FINE, PROBLEMS, WrongUsage

_LENGTH = Quantity.one("m")
_KINDS = ("box", "oriented_box", "cylinder", "capsule", "stack", "smallest")
_EXITS = "0 written, 1 errors"
_STATUSES = ("calculated", "measured", "factory")


_section_option = option(
    "--from",
    "section",
    type=click.Choice(("auto", "collision", "visual")),
    default="auto",
    help="use meshes of these shapes; default: collision, else visual",
)
_scale_option = option("--scale", default="1", metavar="S", help="scale factor of mesh files, such as 0.001, or X,Y,Z")
_grid_options = combined(
    option("--cell", metavar="LENGTH", help="edge length of a cell; default: 10mm"),
    option("--origin", metavar="X,Y", help="corner of the first cell; default: corner of the mesh"),
    option("--cells", metavar="NXxNY", help="number of cells along x and y; default: cover the mesh"),
    option("--size", metavar="X,Y", help="size of the grid, instead of --cells"),
    option("--exact", is_flag=True, hidden=True),  # of earlier versions, which sampled by default
    option("--below", metavar="Z", help="ignore surfaces above this height"),
    option("--map-digits", type=int, default=4, metavar="N", help="decimals of heights; default: 4"),
    option("--step", metavar="LENGTH", help="round heights of boxes to multiples of this length; default: the cell"),
)
_output_options = combined(
    option("-o", "--output", type=PATH, metavar="FILE", help="write to a file instead of standard output"),
    option("--force", is_flag=True, help="replace a file that this command did not write"),
)


def _run(options: Options) -> Run:
    run = Run.of(options)
    run.no_stdin(run.words, "name a file")
    return run


@command(
    "boxes",
    within="extract",
    help="fit boxes, oriented boxes, cylinders, capsules and stacks of boxes to meshes",
    exits=_EXITS,
)
@words_argument(
    "SOURCE ...",
    "mesh files, or one robot: description, URDF, xacro, SDF or MJCF",
    required=True,
    offers=("file",),
)
@option("--link", multiple=True, help="use only this link of the robot; repeatable")
@_section_option
@option("--shape", type=click.Choice(_KINDS), default="box", help="shape to write; default: box")
@option("--stack", type=int, default=4, metavar="N", help="number of boxes in a stack; default: 4")
@option(
    "--axis",
    type=click.Choice(("x", "y", "z", "auto")),
    default="auto",
    help="axis of the stack; default: auto, the best fit",
)
@_scale_option
@option("--digits", type=int, default=5, metavar="N", help="decimals of lengths in metres; default: 5")
@_output_options
@robot_options
def boxes(options: Options) -> int:
    """Fit boxes to meshes. Raises WrongUsage."""
    from rosorin_compile.api import extract_boxes

    run = _run(options)
    result = extract_boxes(
        run.words,
        **_given(run),
        links=options.link,
        section=options.section,
        scale=_scale(options.scale),
        shape=options.shape,
        stack=options.stack,
        axis=options.axis,
        digits=options.digits,
        output=options.output,
        force=options.force,
    )
    run.console.show(result.diagnostics)
    return _print(options, result.parts, result.text, result.report, result.diagnostics)


@command("heightmap", within="extract", help="compute the top surface of a mesh as heights on a grid", exits=_EXITS)
@words_argument("SOURCE ...", "mesh files, or one robot with --link", required=True, offers=("file",))
@option("--link", help="link of the robot whose meshes are used")
@_section_option
@option("--frame", help="link whose frame the height map uses")
@_grid_options
@option("--bottom", is_flag=True, help="also compute the lowest point in each cell")
@option("--xyz", default="0,0,0", metavar="X,Y,Z", help="position of the mesh in the frame, such as 0,0,25mm")
@option(
    "--rpy",
    default="0,0,0",
    metavar="R,P,Y",
    help="orientation of the mesh in the frame, in radians or with a unit (90deg)",
)
@_scale_option
@option("--into", metavar="FILE", help="replace the height map in a description file, with the same grid")
@option(
    "--status",
    type=click.Choice(_STATUSES),
    default="calculated",
    help="status of the source in the description; default: calculated",
)
@option("--note", help="note of the source in the description; default: the names of the meshes")
@_output_options
@robot_options
def heightmap(options: Options) -> int:
    """Compute a height map. Raises WrongUsage."""
    from rosorin_compile.api import extract_height_map

    run = _run(options)
    if options.format != "text" and (options.into or options.bottom):
        word, other = ("--into edits a file; it", "-o") if options.into else ("--bottom", "--into")
        raise WrongUsage(f"{word} excludes {other} and JSON")
    result = extract_height_map(
        run.words,
        **_given(run),
        **_grid(options),
        link=options.link,
        section=options.section,
        scale=_scale(options.scale),
        frame=options.frame,
        xyz=_quantities(options.xyz, "--xyz", 3),
        rpy=_quantities(options.rpy, "--rpy", 3, Quantity.one("rad")),
        bottom=options.bottom,
        into=options.into,
        status=options.status,
        note=options.note,
        output=options.output,
        force=options.force,
    )
    run.console.show(result.diagnostics)
    if options.into:
        for line in result.report:
            print(line)
        return PROBLEMS if has_errors(result.diagnostics) else FINE
    return _print(options, result.values, result.text, result.report, result.diagnostics)


@command(
    "factory",
    within="extract",
    help="extract joints, boxes and a height map from a ROS description package",
    exits=_EXITS,
)
@words_argument("PACKAGE", "folder of a ROS description package", required=True, offers=("file",))
@option("-o", "--output", required=True, type=PATH, metavar="FOLDER", help="folder to write")
@option("--robot", metavar="FILE", help="robot file in the package; default: the only one")
@option("--heightmap-link", metavar="LINK", help="link whose meshes are used for the height map")
@option("--frame", metavar="LINK", help="link whose frame the height map uses; default: that of --heightmap-link")
@option("--lenient", is_flag=True, help="accept violations of the specification where possible")
@_section_option
@_grid_options
@robot_options
def factory(options: Options) -> int:
    """Extract the numbers of a ROS description package. Raises WrongUsage."""
    from rosorin_compile.api import extract_factory

    run = _run(options)
    if len(run.words) != 1:
        raise WrongUsage(f"extract factory takes one PACKAGE, not {len(run.words)}")
    result = extract_factory(
        run.words[0],
        options.output,
        **_given(run),
        **_grid(options),
        robot=options.robot,
        height_map_link=options.heightmap_link,
        frame=options.frame,
        section=options.section,
        lenient=options.lenient,
    )
    run.console.show(result.diagnostics)
    if result.written:
        give_result(options, result, lambda: "" if options.quiet else "\n".join(result.report))
    return PROBLEMS if has_errors(result.diagnostics) else FINE


run = Ways("extract", [boxes, heightmap, factory], help=entry("extract").help)


def _given(run: Run) -> dict[str, Any]:
    """Return what the API needs to read a robot."""
    given = run.given
    return {
        "arguments": given.as_written(),
        "packages": given.packages,
        "trust": given.trust,
        "warn": run.console.ahead,
    }


def _grid(options: Options) -> dict[str, Any]:
    """Return the grid of a height map, lengths in metres. Raises WrongUsage."""
    lengths = {name: getattr(options, name) for name in ("cell", "step")}
    pairs = {name: getattr(options, name) for name in ("origin", "size")}
    others = {name: getattr(options, name) for name in ("below",)}
    return {
        **{name: None if text is None else _above_zero(text, f"--{name}") for name, text in lengths.items()},
        **{name: None if text is None else _quantities(text, f"--{name}", 2) for name, text in pairs.items()},
        **{name: None if text is None else _quantity(text, f"--{name}") for name, text in others.items()},
        "cells": None if options.cells is None else _cells(options.cells),
        "map_digits": options.map_digits,
    }


def _print(
    options: Options, result: object, text: str, report: Sequence[str], diagnostics: Sequence[Diagnostic]
) -> int:
    """Print a text that was not written to a file, and the report; return the exit code."""
    if has_errors(diagnostics):
        return PROBLEMS
    if options.format == "json":
        give_result(options, result, str)
        return FINE
    lines = [] if options.quiet else [*report, *([f"written: {options.output}"] if options.output else [])]
    if options.output is None:
        Console.give(text)
    for line in lines:
        print(line, file=sys.stderr if options.output is None else sys.stdout)
    return FINE


def _quantity(text: str, option: str, kind: Quantity = _LENGTH) -> float:
    """Return a number with or without unit in SI. Raises WrongUsage."""
    value = Scalar(text.strip() or "-").value
    right = isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    if not right or not kind.goes_with(value):
        raise WrongUsage(f'{option} takes {kind.described}, not "{text}"')
    return float(value)


def _above_zero(text: str, option: str) -> float:
    value = _quantity(text, option)
    if not value > 0:
        raise WrongUsage(f'{option} takes a length above zero, not "{text}"')
    return value


def _quantities(text: str, option: str, count: int, kind: Quantity = _LENGTH) -> tuple[float, ...]:
    """Return numbers that are separated by commas. Raises WrongUsage."""
    parts = text.split(",")
    if len(parts) != count:
        raise WrongUsage(f'{option} takes {count} numbers with commas between them, not "{text}"')
    return tuple(_quantity(part, option, kind) for part in parts)


def _scale(text: str) -> tuple[float, ...]:
    """Return the factors of a mesh along x, y and z. Raises WrongUsage."""
    parts = text.split(",")
    if len(parts) not in (1, 3):
        raise WrongUsage(f'--scale takes one number or three with commas, not "{text}"')
    factors = tuple(_quantity(part, "--scale", Quantity.one()) for part in parts) * (3 // len(parts))
    if 0 in factors:
        raise WrongUsage("--scale 0 leaves nothing of a mesh")
    return factors


def _cells(text: str) -> tuple[int, int]:
    first, cross, second = text.lower().partition("x")
    if not cross or not first.isdecimal() or not second.isdecimal() or len(text) > 20:
        raise WrongUsage(f'--cells takes two whole numbers such as 30x23, not "{text}"')
    return int(first), int(second)
