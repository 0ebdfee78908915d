"""Draw a robot to a PNG file, without a browser."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import accumulate, pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.model import Mesh
from rosorin_compile.model.mesh_triangles import TriangleMesh
from rosorin_compile.output import OutputError, may_replace, write_file
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import ERROR, Diagnostic, RequestError, did_you_mean, error
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.system import is_installed, pip_install
from rosorin_compile.source.units import Quantity
from rosorin_compile.viewer.frame_trees import TooMany, frame_trees
from rosorin_compile.viewer.frames import check_target
from rosorin_compile.viewer.page.data import mesh_names
from rosorin_compile.viewer.showing import Shown, look

if TYPE_CHECKING:
    from rosorin_compile.model import Robot, Transform, Vector
    from rosorin_compile.model.kinematics import Position
    from rosorin_compile.request import Request

    from .triangles import MeshParts

_SMALLEST, _LARGEST = 16, 8192  # pixels


@dataclass(frozen=True)
class Picture:
    """A PNG file of a robot that was written, with its size in pixels. Without ``drawn`` there are errors."""

    robot: str
    file: Path
    width: int
    height: int
    drawn: bool = field(default=False, repr=False)
    diagnostics: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True)
class Look:
    """The appearance of a picture.

    ``view`` is "iso", "front", "side", "top" or two angles such as "30deg,20deg", ``size`` width and height in pixels.
    ``collision`` shows the collision shapes of all links, ``published_frames`` all frames that are published in
    ``modes``, ``frames`` further ones. ``theme`` is "light" or "dark".
    """

    view: str = "iso"
    size: tuple[int, int] = (1280, 800)
    collision: bool = False
    published_frames: bool = False
    frames: Sequence[str] = ()
    modes: Mapping[str, bool] = field(default_factory=dict)
    theme: str = "light"
    transparent: bool = False


State = Callable[[Case], "tuple[Mapping[str, Position], Sequence[Diagnostic]]"]


def draw(request: Request, target: Path, state: State, appearance: Look, force: bool = False) -> Picture:
    """Write a picture of a robot whose joints have the positions that ``state`` returns.

    A file that this tool did not write is replaced with ``force`` only. Raises RequestError.
    """
    width, height = size = _checked(appearance.size)
    direction = _direction(appearance.view)
    if target.suffix.lower() != ".png":
        raise RequestError(f'{target}: unsupported picture format "{target.suffix}": use .png')
    check_target(target, force)
    failed = partial(Picture, request.description.name, target, width, height, False)
    looked = look(request)
    if looked.shown is None:
        return failed(tuple(one for one in looked.diagnostics if one.severity == ERROR))
    robot = looked.shown.robot
    frames = _frames(robot, appearance)
    missing = _missing_package(robot)
    if missing:
        help = f"{pip_install('view')} installs the packages that draw pictures"
        message = f"a picture{missing[1]} needs the package {missing[0]}, which is not installed"
        return failed((error("extra-missing", message, None, help),))
    positions, beyond = state(looked.shown.case)
    diagnostics = list(beyond)
    try:
        poses = robot.poses_in_root(positions)
        file = _picture(looked.shown, poses, frames, direction, size, appearance, diagnostics)
        write_file(target, file, looked.files, None if force else may_replace)
    except MemoryError:
        message = f"{robot.name} cannot be drawn: out of memory; --collision draws simpler shapes"
        return failed((*diagnostics, error("picture-file", message, None)))
    except OutputError as problem:
        return failed((*diagnostics, problem.diagnostic))
    return Picture(robot.name, target, width, height, True, tuple(diagnostics))


def _picture(
    shown: Shown,
    poses: Mapping[str, Transform],
    frames: Sequence[str],
    direction: Vector,
    size: tuple[int, int],
    look: Look,
    diagnostics: list[Diagnostic],
) -> bytes:
    """Return the PNG file of a robot whose links have these poses in the root frame."""
    from .camera import Box, Camera
    from .labels import draw_frames
    from .png import png
    from .render import THEMES, Scene, render
    from .triangles import pieces

    def progress(done: int, total: int) -> None:
        Progress.step("drawing", done, total, counted=False)

    robot, theme = shown.robot, THEMES[look.theme]
    visual = robot.has_looks
    found = pieces(robot, poses, _meshes(shown, diagnostics), visual, look.collision or not visual)
    corners = [corner for piece in found for corner in (piece.box.lower, piece.box.upper)]
    box = Box.around(corners or [pose.xyz for pose in poses.values()])
    camera = Camera.fitted(box, direction, *size)
    pixels = render(Scene.of(found, box, theme), camera, look.transparent, progress)
    has_shapes = any(piece.visible for piece in found)
    chosen = frames or ([] if has_shapes else list(poses))
    axis_scale = max(box.diagonal, 0.05) * (1.0 if has_shapes else 2.0)
    draw_frames(pixels, {name: poses[name] for name in chosen}, camera, axis_scale, theme)
    return png(pixels, f" picture: the robot {robot.name}")


def _meshes(shown: Shown, diagnostics: list[Diagnostic]) -> dict[Mesh, MeshParts]:
    """Return the meshes of a robot that can be read, and report the others once each."""
    loaded: dict[Mesh, TriangleMesh | Diagnostic] = {}
    for link in shown.robot.links:
        for purpose in ("collision", "visual"):
            for number, shape in enumerate(getattr(link, purpose)):
                if isinstance(shape.geometry, Mesh) and shape.geometry not in loaded:
                    place = (link.name, purpose, number)
                    loaded[shape.geometry] = TriangleMesh.of_shape(shown.case, place, shown.meshes, coloured=True)
    diagnostics.extend([mesh for mesh in loaded.values() if isinstance(mesh, Diagnostic)])
    found: dict[Mesh, MeshParts] = {}
    for name, mesh in loaded.items():
        if not isinstance(mesh, Diagnostic):
            ends = pairwise([0, *accumulate(count for count, _ in mesh.colours)])
            colours = [colour for _, colour in mesh.colours]
            found[name] = [(mesh.triangles[a:b], colour) for (a, b), colour in zip(ends, colours, strict=True)]
    return found


def _missing_package(robot: Robot) -> tuple[str, str] | None:
    """Return a package that is not installed and what it is needed for, or None."""
    if not is_installed("numpy"):
        return "numpy", ""
    if any(mesh_names(robot)):
        for name in ("trimesh", "scipy"):
            if not is_installed(name):
                return name, " of meshes"
    return None


def _checked(size: tuple[int, int]) -> tuple[int, int]:
    """Return width and height in pixels. Raises RequestError."""
    if not all(_SMALLEST <= side <= _LARGEST for side in size):
        text = "x".join(map(str, size))
        raise RequestError(f"a picture has {_SMALLEST} to {_LARGEST} pixels along a side, not {text}")
    return size


def _direction(text: str) -> Vector:
    """Return the direction to the camera of a named view, or of two angles. Raises RequestError."""
    from .camera import VIEWS, from_angles

    if text in VIEWS:
        return VIEWS[text]
    parts = [Quantity.parse(part.strip()) for part in text.split(",")]
    if len(parts) == 1:
        raise RequestError(f'there is no view "{text}"; {did_you_mean(text, VIEWS)}, or AZIMUTH,ELEVATION: 30deg,20deg')
    angles = [float(part) for part in parts if part is not None and part.unit == "rad"]
    if len(parts) != 2 or len(angles) != 2:
        raise RequestError(f'"{text}" is not AZIMUTH,ELEVATION, such as 30deg,20deg')
    return from_angles(*angles)


def _frames(robot: Robot, look: Look) -> list[str]:
    """Return the names of the frames to show. Raises RequestError."""
    for name in look.frames:
        if name not in robot.link:
            raise RequestError(f'there is no frame "{name}"; {did_you_mean(name, robot.link)}')
    if not look.published_frames:
        return list(dict.fromkeys(look.frames))
    published = _published(robot, look.modes)
    return [link.name for link in robot.links if link.name in published or link.name in look.frames]


def _published(robot: Robot, modes: Mapping[str, bool]) -> set[str]:
    """Return the frames that are published in modes; all of a robot of which nobody publishes any."""
    try:
        found = frame_trees(robot, modes)
        edges = found[0].edges if found else ()
    except TooMany:
        edges = robot.frame_tree()
    published = {name for edge in edges if edge.published for name in (edge.parent, edge.child)}
    return published or {link.name for link in robot.links}
