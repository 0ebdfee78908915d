"""rosorin-compile picture: draw a robot into a PNG, without a browser."""

from __future__ import annotations

import argparse
import re
from collections.abc import Mapping, Sequence
from itertools import accumulate, pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.model import Mesh
from rosorin_compile.source.diagnostics import Console, Progress, error, pip_install
from rosorin_compile.source.installing import is_installed
from rosorin_compile.source.units import Quantity

from .answer import give_result
from .run import Run
from .understanding import mode_states
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.model import Robot, Transform, Vector
    from rosorin_compile.viewer.picture.triangles import MeshParts
    from rosorin_compile.viewer.showing import Shown

    from .parser import Parser

_USAGE = "rosorin-compile picture ROBOT -o FILE"
_SIZE = re.compile(r"([0-9]{1,5})[xX]([0-9]{1,5})")
_SMALLEST, _LARGEST = 16, 8192  # pixels


def options(command: Parser) -> None:
    """Add the options of this command."""
    command.add_robot()
    command.add_argument(
        "-o", "--output", type="path", required=True, metavar="FILE", help="picture to write: FILE.png"
    )
    command.add_argument("--force", action="store_true", help="replace a file that this command did not write")
    state = command.add_argument_group("joint positions (default: zero)")
    state.add_argument("--pose", default="", metavar="POSE", help="named pose of the description")
    for option, dest, form, help in (
        ("--joint", "joints", "JOINT=VALUE", "position, such as 30deg, 5cm or 1,2,30deg; overrides --pose"),
        ("--pulse", "pulses", "JOINT=PULSE", "pulse sent to the servo; overrides --pose"),
    ):
        state.add_argument(option, action="append", default=[], metavar=form, dest=dest, help=help)
    look = command.add_argument_group("appearance")
    look.add_argument(
        "--from",
        dest="view",
        default="iso",
        metavar="VIEW",
        help="camera: iso, front, side, top or AZIMUTH,ELEVATION (30deg,20deg); default: iso",
    )
    look.add_argument("--size", default="1280x800", metavar="WxH", help="size in pixels; default: 1280x800")
    look.add_argument(
        "--collision", action="store_true", help="show collision shapes of all links; default: of links without visuals"
    )
    look.add_argument("--frames", action="store_true", help="show published frames with their names")
    look.add_argument(
        "--frame",
        action="append",
        default=[],
        metavar="FRAME",
        dest="chosen",
        help="show a frame; repeatable",
    )
    command.add_modes("on", look)
    look.add_argument(
        "--theme", choices=("light", "dark"), default="light", help="colours of background and floor; default: light"
    )
    look.add_argument(
        "--transparent", action="store_true", help="draw only the robot and its shadow, on a transparent background"
    )
    command.add_result()
    command.add_given()


def run(options: argparse.Namespace) -> int:
    """Write a picture of a robot."""
    from rosorin_compile.output import OutputError, may_replace, write_file
    from rosorin_compile.source.load import LoadError
    from rosorin_compile.viewer.showing import look

    value = next((word for word in options.words if "=" in word and ":=" not in word), None)
    if value is not None:
        raise WrongUsage(f"write --joint {value} for a position, --pulse {value} for a pulse")
    target, size, direction = Path(options.output), _size(options.size), _direction(options.view)
    _check(target, options.force)
    run, description = Run.alone(options, "a picture shows one robot", _USAGE)
    console = run.console
    try:
        looked = look(run.given, description, console)
    except LoadError as problem:
        console.show([problem.diagnostic])
        return PROBLEMS
    console.show([diagnostic for diagnostic in looked.diagnostics if diagnostic.severity == "error"])
    if looked.shown is None:
        console.warn(f"{description.name}: a robot with errors is not drawn")
        return PROBLEMS
    robot = looked.shown.robot
    frames = _frames(robot, options)
    missing = _missing_package(robot)
    if missing:
        help = f"{pip_install('view')} installs the packages that draw pictures"
        message = f"a picture{missing[1]} needs the package {missing[0]}, which is not installed"
        console.show([error("extra-missing", message, None, help)])
        return PROBLEMS
    state = run.positions(looked.shown.case)
    if state is None:
        return PROBLEMS
    try:
        file = _picture(looked.shown, robot.poses_in_root(state), frames, direction, size, options, console)
        write_file(target, file, looked.files, None if options.force else may_replace)
    except MemoryError:
        console.warn(f"{robot.name} cannot be drawn: out of memory; --collision draws simpler shapes")
        return PROBLEMS
    except OutputError as problem:
        console.show([problem.diagnostic])
        return PROBLEMS
    width, height = size
    console.say(f"{robot.name}: {target}, {width} x {height}")
    give_result(options, {"robot": robot.name, "file": str(target), "width": width, "height": height}, str)
    return FINE


def _picture(
    shown: Shown,
    poses: Mapping[str, Transform],
    frames: Sequence[str],
    direction: Vector,
    size: tuple[int, int],
    options: argparse.Namespace,
    console: Console,
) -> bytes:
    """Return the PNG file of a robot whose links have these poses in the root frame."""
    from rosorin_compile.viewer.picture.camera import Box, Camera
    from rosorin_compile.viewer.picture.labels import draw_frames
    from rosorin_compile.viewer.picture.png import png
    from rosorin_compile.viewer.picture.render import THEMES, Scene, render
    from rosorin_compile.viewer.picture.triangles import pieces

    def progress(done: int, total: int) -> None:
        Progress.step("drawing", done, total, counted=False)

    robot, theme = shown.robot, THEMES[options.theme]
    visual = robot.has_looks
    found = pieces(robot, poses, _meshes(shown, console), visual, options.collision or not visual)
    corners = [corner for piece in found for corner in (piece.box.lower, piece.box.upper)]
    box = Box.around(corners or [pose.xyz for pose in poses.values()])
    camera = Camera.fitted(box, direction, *size)
    pixels = render(Scene.of(found, box, theme), camera, options.transparent, progress)
    has_shapes = any(piece.visible for piece in found)
    chosen = frames or ([] if has_shapes else list(poses))
    axis_scale = max(box.diagonal, 0.05) * (1.0 if has_shapes else 2.0)
    draw_frames(pixels, {name: poses[name] for name in chosen}, camera, axis_scale, theme)
    return png(pixels, f" picture: the robot {robot.name}")


def _meshes(shown: Shown, console: Console) -> dict[Mesh, MeshParts]:
    """Return the meshes of a robot that can be read, and report the others once each."""
    from rosorin_compile.model.mesh_triangles import TriangleMesh
    from rosorin_compile.source.diagnostics import Diagnostic

    loaded: dict[Mesh, TriangleMesh | Diagnostic] = {}
    for link in shown.robot.links:
        for purpose in ("collision", "visual"):
            for number, shape in enumerate(getattr(link, purpose)):
                if isinstance(shape.geometry, Mesh) and shape.geometry not in loaded:
                    place = (link.name, purpose, number)
                    loaded[shape.geometry] = TriangleMesh.of_shape(shown.case, place, shown.meshes, coloured=True)
    console.show([mesh for mesh in loaded.values() if isinstance(mesh, Diagnostic)])
    found: dict[Mesh, MeshParts] = {}
    for name, mesh in loaded.items():
        if not isinstance(mesh, Diagnostic):
            ends = pairwise([0, *accumulate(count for count, _ in mesh.colours)])
            colours = [colour for _, colour in mesh.colours]
            found[name] = [(mesh.triangles[a:b], colour) for (a, b), colour in zip(ends, colours, strict=True)]
    return found


def _missing_package(robot: Robot) -> tuple[str, str] | None:
    """Return a package that is not installed and what it is needed for, or None."""
    from rosorin_compile.viewer.page.data import mesh_names

    if not is_installed("numpy"):
        return "numpy", ""
    if any(mesh_names(robot)):
        for name in ("trimesh", "scipy"):
            if not is_installed(name):
                return name, " of meshes"
    return None


def _size(text: str) -> tuple[int, int]:
    """Return width and height in pixels. Raises WrongUsage."""
    match = _SIZE.fullmatch(text)
    if match is None:
        raise WrongUsage(f'"{text}" is not WIDTHxHEIGHT in pixels, such as 1280x800')
    width, height = int(match[1]), int(match[2])
    if not (_SMALLEST <= width <= _LARGEST and _SMALLEST <= height <= _LARGEST):
        raise WrongUsage(f"a picture has {_SMALLEST} to {_LARGEST} pixels along a side, not {text}")
    return width, height


def _direction(text: str) -> Vector:
    """Return the direction to the camera of a named view, or of two angles. Raises WrongUsage."""
    from rosorin_compile.source.diagnostics import did_you_mean
    from rosorin_compile.viewer.picture.camera import VIEWS, from_angles

    if text in VIEWS:
        return VIEWS[text]
    parts = [Quantity.parse(part.strip()) for part in text.split(",")]
    if len(parts) == 1:
        raise WrongUsage(f'there is no view "{text}"; {did_you_mean(text, VIEWS)}, or AZIMUTH,ELEVATION: 30deg,20deg')
    angles = [float(part) for part in parts if part is not None and part.unit == "rad"]
    if len(parts) != 2 or len(angles) != 2:
        raise WrongUsage(f'"{text}" is not AZIMUTH,ELEVATION, such as 30deg,20deg')
    return from_angles(*angles)


def _check(target: Path, force: bool) -> None:
    """Raise WrongUsage if the picture must not be written to that file."""
    from rosorin_compile.output import may_replace

    if target.suffix.lower() != ".png":
        raise WrongUsage(f'{target}: unsupported picture format "{target.suffix}": use .png')
    try:
        exists, is_file = target.exists() or target.is_symlink(), target.is_file()
        ours = force or not is_file or may_replace(target)
    except OSError:
        return  # it is reported when the file is written
    if exists and not is_file:
        raise WrongUsage(f"{target} cannot be written: it is not a regular file")
    if not ours:
        raise WrongUsage(f"{target} exists and was not written by this tool: name another file, or add --force")


def _frames(robot: Robot, options: argparse.Namespace) -> list[str]:
    """Return the names of the frames to show. Raises WrongUsage."""
    from rosorin_compile.source.diagnostics import did_you_mean

    modes = mode_states(robot, options.modes)
    for name in options.chosen:
        if name not in robot.link:
            raise WrongUsage(f'there is no frame "{name}"; {did_you_mean(name, robot.link)}')
    if not options.frames:
        return list(dict.fromkeys(options.chosen))
    published = _published(robot, modes)
    return [link.name for link in robot.links if link.name in published or link.name in options.chosen]


def _published(robot: Robot, modes: Mapping[str, bool]) -> set[str]:
    """Return the frames that are published in modes; all of a robot of which nobody publishes any."""
    from rosorin_compile.viewer.drawing.situations import TooMany, situations

    try:
        found = situations(robot, modes)
        edges = found[0].edges if found else ()
    except TooMany:
        edges = robot.frame_tree()
    published = {name for edge in edges if edge.published for name in (edge.parent, edge.child)}
    return published or {link.name for link in robot.links}
