"""Draw a robot to a PNG file, without a browser."""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import accumulate, pairwise, product
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.joint_values import beyond_limits, positions
from rosorin_compile.model import Mesh
from rosorin_compile.model.mesh_triangles import TriangleMesh
from rosorin_compile.output.atomic_files import OutputError, may_replace, write_file
from rosorin_compile.request import FilePath, Packages, Request, Values
from rosorin_compile.rules.publishers import check_modes
from rosorin_compile.source.diagnostics import ERROR, Diagnostic, RequestError, UnknownName, error
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.system import is_installed, pip_install
from rosorin_compile.source.units import Quantity
from rosorin_compile.viewer.frames import check_target
from rosorin_compile.viewer.frames_picture import TooMany, frame_trees
from rosorin_compile.viewer.page.images import mesh_names
from rosorin_compile.viewer.showing import Shown, look

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rosorin_compile.model import Robot, Transform, Vector

    from .triangles import MeshParts

# Directions to the camera in the root frame: x ahead, y left, z up; as on the page.
VIEWS: Mapping[str, Vector] = {
    "iso": (1.0, -1.15, 0.75),
    "front": (1.0, 0.0, 0.06),
    "side": (0.0, -1.0, 0.06),
    "top": (0.0, -0.001, 1.0),
}
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


def picture(
    robot: FilePath | Request,
    output: FilePath,
    arguments: Values = None,
    packages: Packages = None,
    *,
    pose: str = "",
    joints: Values = None,
    pulses: Values = None,
    view: str = "iso",
    size: tuple[int, int] = (1280, 800),
    collision: bool = False,
    published_frames: bool = False,
    frames: Sequence[str] = (),
    modes: Mapping[str, bool] | None = None,
    theme: str = "light",
    transparent: bool = False,
    force: bool = False,
    trust: bool = False,
) -> Picture:
    """Draw a robot to a PNG file, without a browser. This needs the extra ``view``.

    ``pose``, ``joints`` and ``pulses`` are as in ``transform``, ``modes`` as in ``frames``.

    Args:
        view: The camera: ``"iso"``, ``"front"``, ``"side"``, ``"top"`` or two angles such as ``"30deg,20deg"``.
        size: Width and height in pixels.
        collision: Show collision shapes of all links; by default of links without visuals only.
        published_frames: Show all published frames with their names.
        frames: Further frames to show.
        theme: ``"light"`` or ``"dark"``.
        transparent: Draw only the robot and its shadow, on a transparent background.
    """
    request, target = Request.of(robot, arguments, packages, trust=trust), Path(output)
    width, height = size
    if not all(_SMALLEST <= side <= _LARGEST for side in size):
        raise RequestError(f"a picture has {_SMALLEST} to {_LARGEST} pixels along a side, not {width}x{height}")
    direction = _direction(view)
    if target.suffix.lower() != ".png":
        raise RequestError(f'{target}: unsupported picture format "{target.suffix}": use .png')
    check_target(target, force)
    failed, looked = partial(Picture, request.description.name, target, width, height, False), look(request)
    if looked.shown is None:
        return failed(tuple(one for one in looked.diagnostics if one.severity == ERROR))
    case, shown_robot = looked.shown.case, looked.shown.robot
    chosen = _frames(shown_robot, frames, published_frames, modes or {})
    has_meshes = any(mesh_names(shown_robot))
    needed = {"numpy": ""} | (dict.fromkeys(("trimesh", "scipy"), " of meshes") if has_meshes else {})
    for package, purpose in needed.items():
        if not is_installed(package):
            help = f"{pip_install('view')} installs the packages that draw pictures"
            message = f"a picture{purpose} needs the package {package}, which is not installed"
            return failed((error("extra-missing", message, None, help),))
    check_modes(shown_robot, modes or {})
    state = positions(shown_robot, pose, joints, pulses)
    diagnostics = beyond_limits(case, [state])
    try:
        poses, how = shown_robot.poses_in_root(state), (direction, size, collision, theme, transparent)
        pixels = _pixels(looked.shown, poses, chosen, diagnostics, *how)
        file = png(pixels, f" picture: the robot {shown_robot.name}")
        write_file(target, file, looked.files, None if force else may_replace)
    except MemoryError:
        message = f"{shown_robot.name} cannot be drawn: out of memory; --collision draws simpler shapes"
        return failed((*diagnostics, error("picture-file", message, None)))
    except OutputError as problem:
        return failed((*diagnostics, problem.diagnostic))
    return Picture(shown_robot.name, target, width, height, True, tuple(diagnostics))


def _pixels(
    shown: Shown,
    poses: Mapping[str, Transform],
    frames: Sequence[str],
    diagnostics: list[Diagnostic],
    direction: Vector,
    size: tuple[int, int],
    collision: bool,
    theme_name: str,
    transparent: bool,
) -> NDArray[np.uint8]:
    """Return the picture of a robot whose links have these poses in the root frame."""
    import numpy as np

    from .labels import EMPTY, SENSOR, draw_frames, draw_markers
    from .render import THEMES, Camera, Scene, render
    from .triangles import pieces

    robot, theme = shown.robot, THEMES[theme_name]
    found = pieces(robot, poses, _meshes(shown, diagnostics), robot.has_looks, collision or not robot.has_looks)
    corners = np.concatenate([piece.bounds for piece in found] or [np.array([pose.xyz for pose in poses.values()])])
    bounds = np.array([corners.min(axis=0), corners.max(axis=0)])
    camera = Camera.fit(bounds, direction, *size)
    progress = partial(Progress.step, "drawing", counted=False)
    pixels = render(Scene(found, bounds, theme), camera, transparent, progress)
    sensors = {sensor.frame for sensor in robot.sensors}
    empty = [link.name for link in robot.links if not link.visual and not link.collision and link.name not in sensors]
    for names, marker in ((empty, EMPTY), (sorted(sensors & poses.keys()), SENSOR)):
        draw_markers(pixels, [poses[name].xyz for name in names], camera, marker)
    has_shapes = any(piece.visible for piece in found)
    chosen = frames or ([] if has_shapes else list(poses))
    axis_scale = max(math.dist(*bounds), 0.05) * (1.0 if has_shapes else 2.0)
    draw_frames(pixels, {name: poses[name] for name in chosen}, camera, axis_scale, theme)
    return pixels


def _meshes(shown: Shown, diagnostics: list[Diagnostic]) -> dict[Mesh, MeshParts]:
    """Return the meshes of a robot that can be read, and report the others once each."""
    first: dict[Mesh, tuple[str, str, int]] = {}  # where a mesh is named first
    for link, purpose in product(shown.robot.links, ("collision", "visual")):
        for number, shape in enumerate(getattr(link, purpose)):
            if isinstance(shape.geometry, Mesh):
                first.setdefault(shape.geometry, (link.name, purpose, number))
    found: dict[Mesh, MeshParts] = {}
    for name, place in first.items():
        mesh = TriangleMesh.of_shape(shown.case, place, shown.meshes, coloured=True)
        if isinstance(mesh, Diagnostic):
            diagnostics.append(mesh)
            continue
        ends = pairwise([0, *accumulate(count for count, _ in mesh.colours)])
        found[name] = [(mesh.triangles[a:b], hue) for (a, b), (_, hue) in zip(ends, mesh.colours, strict=True)]
    return found


def png(pixels: NDArray[np.uint8], comment: str = "") -> bytes:
    """Return pixels (rows, columns, 3 or 4) as a PNG file (ISO/IEC 15948), with this tool's name and a comment."""
    rows, columns, channels = pixels.shape
    header = struct.pack(">IIBBBBB", columns, rows, 8, {3: 2, 4: 6}[channels], 0, 0, 0)
    text = b"Comment\0" + f"Generated by rosorin-compile{comment}".encode("latin-1", "replace")
    data = zlib.compress(b"".join(b"\0" + row.tobytes() for row in pixels), 9)  # filters make such pictures larger
    chunks = ((b"IHDR", header), (b"sRGB", b"\0"), (b"tEXt", text), (b"IDAT", data), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
        for kind, content in chunks
    )


def _direction(text: str) -> Vector:
    """Return the direction to the camera of a named view, or of two angles. Raises RequestError."""
    if text in VIEWS:
        return VIEWS[text]
    parts = [Quantity.parse(part.strip()) for part in text.split(",")]
    if len(parts) == 1:
        raise UnknownName("view", text, (*VIEWS, "AZIMUTH,ELEVATION, such as 30deg,20deg"))
    angles = [float(part) for part in parts if part is not None and part.unit == "rad"]
    if len(parts) != 2 or len(angles) != 2:
        raise RequestError(f'"{text}" is not AZIMUTH,ELEVATION, such as 30deg,20deg')
    azimuth, elevation = angles
    return math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth), math.sin(elevation)


def _frames(robot: Robot, frames: Sequence[str], published: bool, modes: Mapping[str, bool]) -> list[str]:
    """Return the names of the frames to show: these, and all ``published`` ones. Raises RequestError."""
    for name in frames:
        if name not in robot.link:
            raise UnknownName("frame", name, robot.link)
    if not published:
        return list(dict.fromkeys(frames))
    try:
        edges = [row for tree in frame_trees(robot, modes)[:1] for row in tree.edges]
    except TooMany:
        edges = list(robot.frame_tree())
    found = {name for edge in edges if edge.published for name in (edge.parent, edge.child)} or robot.link.keys()
    return [link.name for link in robot.links if link.name in {*found, *frames}]
