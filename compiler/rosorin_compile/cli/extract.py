"""rosorin-compile extract: compute boxes and height maps from meshes."""

import math
import re
import sys
from typing import Any

import click

from rosorin_compile.importing.extract.extract import extract_boxes, extract_height_map
from rosorin_compile.importing.extract.factory import extract_factory
from rosorin_compile.source.diagnostics import RequestError
from rosorin_compile.source.units import ANGLE, LENGTH, NUMBER, Dimension, describe, dimension_of
from rosorin_compile.source.yaml_text import Scalar

from . import command as cli
from .console import FINE, PROBLEMS, give
from .run import Run, refuse_stdin


class _Numbers(click.ParamType):  # type: ignore[type-arg] # not generic before click 8.4
    """The value of an option: ``count`` numbers separated by commas, converted to SI units, or a single float.

    With ``repeats``, for the scale of a mesh, one number applies to all axes, and zero is invalid.
    """

    name = "numbers"

    def __init__(self, count: int = 1, kind: Dimension = LENGTH, positive: bool = False, repeats: bool = False) -> None:
        self.count, self.kind, self.positive, self.repeats = count, kind, positive, repeats

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str):
            return value
        parts = value.split(",") if self.count > 1 else [value]
        parts = parts * self.count if self.repeats and len(parts) == 1 else parts
        numbers = [Scalar(part.strip() or "-").value for part in parts]
        for part, number in zip(parts, numbers, strict=True):
            valid = isinstance(number, int | float) and not isinstance(number, bool) and math.isfinite(number)
            if not valid or dimension_of(number) not in (None, self.kind) or (self.positive and not number > 0):
                self.fail(f'"{part}" is not {describe(self.kind)}{" above zero" * self.positive}', param, ctx)
        if len(parts) != self.count:
            self.fail(f'"{value}" is not {self.count} numbers with commas between them', param, ctx)
        if self.repeats and not all(numbers):
            self.fail(f"{value} leaves nothing of a mesh", param, ctx)
        return tuple(map(float, numbers)) if self.count > 1 else float(numbers[0])


_SETTINGS: dict[str, Any] = {"within": "extract", "exits": "0 written, 1 errors"}
_FROM = "use meshes of these shapes; default: collision, else visual"
_section_option = cli.option("--from auto|collision|visual", "section", default="auto", help=_FROM)
_SCALE = "scale factor of mesh files, such as 0.001, or X,Y,Z; default: 1"
_scale_option = cli.option("--scale S", type=_Numbers(3, NUMBER, repeats=True), default="1", help=_SCALE)
_STEP = "round heights of boxes to multiples of this length; default: the cell"
_grid_options = cli.combine(
    cli.option("--cell LENGTH", type=_Numbers(positive=True), help="edge length of a cell; default: 10mm"),
    cli.option("--origin X,Y", type=_Numbers(2), help="corner of the first cell; default: corner of the mesh"),
    cli.option("--cells NXxNY", help="number of cells along x and y; default: cover the mesh"),
    cli.option("--size X,Y", type=_Numbers(2), help="size of the grid, instead of --cells"),
    cli.option("--below Z", type=_Numbers(), help="ignore surfaces above this height"),
    cli.option("--map-digits N", default=4, help="decimals of heights"),
    cli.option("--step LENGTH", type=_Numbers(positive=True), help=_STEP),
)
_output_option = cli.option("-o", "--output FILE", help="write to a file instead of standard output")
_output_options = cli.combine(_output_option, cli.force_option)
_ROBOT = "one robot: description, URDF, xacro, SDF or MJCF"


@cli.command("boxes", help="fit boxes, oriented boxes, cylinders, capsules and stacks of boxes to meshes", **_SETTINGS)
@cli.words_argument("SOURCE ...", f"mesh files, or {_ROBOT}", required=True, offers=("file",))
@cli.repeatable("--link", "links", help="use only this link of the robot; repeatable")
@_section_option
@cli.option("--shape box|oriented_box|cylinder|capsule|stack|smallest", default="box", help="shape to write")
@cli.option("--stack N", default=4, help="number of boxes in a stack")
@cli.option("--axis x|y|z|auto", default="auto", help="axis of the stack; default: auto, the best fit")
@_scale_option
@cli.option("--digits N", default=5, help="decimals of lengths in metres")
@_output_options
@cli.robot_options
def boxes(run: Run) -> int:
    """Fit boxes to meshes. Raises RequestError."""
    refuse_stdin(run.words)
    picked = run.pick("links section scale shape stack axis digits output force")
    result = extract_boxes(run.words, **run.read_options(), **picked)
    return _print(run, result, result.parts)


@cli.command("heightmap", help="compute the top surface of a mesh as heights on a grid", **_SETTINGS)
@cli.words_argument("SOURCE ...", "mesh files, or one robot with --link", required=True, offers=("file",))
@cli.option("--link", help="link of the robot whose meshes are used")
@_section_option
@cli.option("--frame", help="link whose frame the height map uses")
@_grid_options
@cli.flag("--bottom", help="also compute the lowest point of the mesh")
@cli.option("--xyz X,Y,Z", type=_Numbers(3), default="0,0,0", help="position of the mesh, such as 0,0,25mm")
@cli.option("--rpy R,P,Y", type=_Numbers(3, ANGLE), default="0,0,0", help="orientation of the mesh, such as 0,0,90deg")
@_scale_option
@cli.option("--into FILE", help="replace the height map in a description file, with the same grid")
@cli.option("--status calculated|measured|factory", default="calculated", help="status of the source")
@cli.option("--note", help="note of the source in the description; default: the names of the meshes")
@_output_options
@cli.robot_options
def heightmap(run: Run) -> int:
    """Compute a height map from meshes. Raises RequestError."""
    refuse_stdin(run.words)
    if run.format != "text" and (run.into or run.bottom):
        raise RequestError(f"{'--into' if run.into else '--bottom'} excludes --format {run.format}")
    picked = run.pick("link section scale frame xyz rpy bottom into status note output force")
    result = extract_height_map(run.words, **run.read_options(), **_grid(run), **picked)
    if not run.into:
        return _print(run, result, result.values)
    failed = run.show(result)
    print("".join(f"{line}\n" for line in result.report), end="")
    return PROBLEMS if failed else FINE


@cli.command("factory", help="extract joints, boxes and a height map from a ROS description package", **_SETTINGS)
@cli.words_argument("PACKAGE", "folder of a ROS description package", required=True, offers=("file",))
@cli.option("-o", "--output FOLDER", required=True, help="folder to write")
@cli.option("--robot FILE", help="robot file in the package; default: the only one")
@cli.option("--heightmap-link LINK", "height_map_link", help="link whose meshes are used for the height map")
@cli.option("--frame LINK", help="link whose frame the height map uses; default: that of --heightmap-link")
@cli.flag("--lenient", help="accept violations of the specification where possible")
@_section_option
@_grid_options
@cli.robot_options
def factory(run: Run) -> int:
    """Extract joints, boxes and a height map from a ROS description package. Raises RequestError."""
    refuse_stdin(run.words)
    if len(run.words) != 1:
        raise RequestError(f"extract factory takes one PACKAGE, not {len(run.words)}")
    picked = run.pick("robot height_map_link frame section lenient")
    result = extract_factory(run.words[0], run.output, **run.read_options(), **_grid(run), **picked)
    failed = run.show(result)
    if result.written:
        run.give(result, lambda: "" if run.quiet else "\n".join(result.report))
    return PROBLEMS if failed else FINE


_HELP = cli.BUILT_IN["commands"]["extract"].help
run = click.Group("extract", commands={"boxes": boxes, "heightmap": heightmap, "factory": factory}, help=_HELP)


def _print(run: Run, result: Any, value: object) -> int:
    if run.show(result):
        return PROBLEMS
    if run.format == "json":
        return run.give(value)
    if run.output is None:
        give(result.text)
    for line in () if run.quiet else (*result.report, *([f"written: {run.output}"] if run.output else [])):
        print(line, file=sys.stderr if run.output is None else sys.stdout)
    return FINE


def _grid(run: Run) -> dict[str, Any]:
    if (cells := re.fullmatch(r"([0-9]{1,9})[xX]([0-9]{1,9})", run.cells or "0x0")) is None:
        raise RequestError(f'--cells takes two whole numbers such as 30x23, not "{run.cells}"')
    grid = run.pick("cell step below origin size map_digits")
    return {**grid, "cells": (int(cells[1]), int(cells[2])) if run.cells else None}
