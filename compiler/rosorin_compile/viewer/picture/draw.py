"""Draw a robot to a PNG file without a browser."""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import accumulate, pairwise, product
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.joint_values import beyond_limits, positions
from rosorin_compile.model import Mesh
from rosorin_compile.model.mesh_triangles import TriangleMesh
from rosorin_compile.output.atomic_files import OutputError, may_replace, write_file
from rosorin_compile.request import FilePath, Packages, Request, Values
from rosorin_compile.rules.publishers import check_modes, holds
from rosorin_compile.source.diagnostics import ERROR, Diagnostic, RequestError, UnknownName, error
from rosorin_compile.source.system import is_installed, pip_install
from rosorin_compile.source.units import Quantity
from rosorin_compile.viewer.frames import check_target
from rosorin_compile.viewer.page.images import mesh_names
from rosorin_compile.viewer.robot_view import RobotView, load

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rosorin_compile.model import Robot, Vector

    from .render import MeshParts

# Directions from the robot to the camera in the root frame (x forward, y left, z up), as on the HTML page.
VIEWS: Mapping[str, Vector] = {
    "iso": (1.0, -1.15, 0.75),
    "front": (1.0, 0.0, 0.06),
    "side": (0.0, -1.0, 0.06),
    "top": (0.0, -0.001, 1.0),
}
_SMALLEST, _LARGEST = 16, 8192  # smallest and largest side of a picture in pixels


@dataclass(frozen=True)
class Picture:
    """The result of ``picture``: the PNG file and its size in pixels; ``drawn`` is False after errors."""

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
    """Draw a robot to a PNG file without a browser. This needs the optional dependencies ``view``.

    ``pose``, ``joints`` and ``pulses`` are as in ``transform``, ``modes`` as in ``frames``.

    Args:
        view: The camera: ``"iso"``, ``"front"``, ``"side"``, ``"top"`` or two angles such as ``"30deg,20deg"``.
        size: Width and height in pixels.
        collision: Show the collision shapes of all links; by default, only of links without visuals.
        published_frames: Show all published frames with their names.
        frames: Additional frames to show.
        theme: ``"light"`` or ``"dark"``.
        transparent: Draw only the robot and its shadow, on a transparent background.
    """
    request, target = Request.from_arguments(robot, arguments, packages, trust=trust), Path(output)
    if not all(_SMALLEST <= side <= _LARGEST for side in size):
        raise RequestError(f"a picture has {_SMALLEST} to {_LARGEST} pixels along a side, not {size[0]}x{size[1]}")
    direction = _direction(view)
    if target.suffix.lower() != ".png":
        raise RequestError(f'{target}: unsupported picture format "{target.suffix}": use .png')
    check_target(target, force)
    (robot_view, found, inputs), failed = load(request), Picture(request.description.name, target, *size)
    if robot_view is None:
        return replace(failed, diagnostics=tuple(one for one in found if one.severity == ERROR))
    shown = robot_view.robot
    chosen = _frames(shown, frames, published_frames, check_modes(shown, modes or {}))
    needed = {"numpy": ""} | (dict.fromkeys(("trimesh", "scipy"), " of meshes") if any(mesh_names(shown)) else {})
    for package, purpose in needed.items():
        if not is_installed(package):
            help = f"{pip_install('view')} installs the packages that draw pictures"
            message = f"a picture{purpose} needs the package {package}, which is not installed"
            return replace(failed, diagnostics=(error("extra-missing", message, None, help),))
    from .render import Camera, Scene, draw_frames, draw_markers, render

    state = positions(shown, pose, joints, pulses)
    diagnostics = beyond_limits(robot_view.case, [state])
    try:
        poses = shown.poses_in_root(state)
        scene = Scene(shown, poses, _meshes(robot_view, diagnostics), collision)
        camera = Camera.fit(scene.bounds, direction, *size)
        pixels = render(scene, camera, theme, transparent)
        draw_markers(pixels, shown, poses, camera)
        named = {name: poses[name] for name in chosen or ([] if len(scene.corners) else poses)}
        draw_frames(pixels, named, camera, scene.size * (0.07 if len(scene.corners) else 0.14), theme)
        if transparent:
            pixels[..., :3] = pixels[..., :3].astype("uint16") * 255 // pixels[..., 3:].clip(1)
        pixels = pixels if transparent else pixels[..., :3]
        content = png(pixels, f" picture: the robot {shown.name}")
        write_file(target, content, inputs, None if force else may_replace)
    except OutputError as problem:
        return replace(failed, diagnostics=(*diagnostics, problem.diagnostic))
    return replace(failed, drawn=True, diagnostics=tuple(diagnostics))


def _meshes(shown: RobotView, diagnostics: list[Diagnostic]) -> dict[Mesh, MeshParts]:
    found: dict[Mesh, MeshParts | None] = {}
    for link, purpose in product(shown.robot.links, ("collision", "visual")):
        for number, shape in enumerate(getattr(link, purpose)):
            if isinstance(shape.geometry, Mesh) and shape.geometry not in found:
                mesh = TriangleMesh.of_shape(shown.case, (link.name, purpose, number), shown.meshes, coloured=True)
                if isinstance(mesh, Diagnostic):
                    diagnostics.append(mesh)
                    found[shape.geometry] = None
                    continue
                ends = pairwise(accumulate((count for count, _ in mesh.colours), initial=0))
                runs = zip(ends, mesh.colours, strict=True)
                found[shape.geometry] = [(mesh.triangles[a:b], colour) for (a, b), (_, colour) in runs]
    return {mesh: parts for mesh, parts in found.items() if parts is not None}


def png(pixels: NDArray[np.uint8], comment: str = "") -> bytes:
    """Encode pixels (rows, columns, 3 or 4) as PNG (ISO/IEC 15948), with ``comment`` in the metadata."""
    rows, columns, channels = pixels.shape
    header = struct.pack(">IIBBBBB", columns, rows, 8, {3: 2, 4: 6}[channels], 0, 0, 0)
    text = b"Comment\0" + f"Generated by rosorin-compile{comment}".encode("latin-1", "replace")
    data = zlib.compress(b"".join(b"\0" + row.tobytes() for row in pixels), 9)  # filter type 0: other filters add bytes
    chunks = ((b"IHDR", header), (b"sRGB", b"\0"), (b"tEXt", text), (b"IDAT", data), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
        for kind, content in chunks
    )


def _direction(text: str) -> Vector:
    if text in VIEWS:
        return VIEWS[text]
    if "," not in text:
        raise UnknownName("view", text, (*VIEWS, "AZIMUTH,ELEVATION, such as 30deg,20deg"))
    parts = [Quantity.parse(part.strip()) for part in text.split(",")]
    angles = [float(part) for part in parts if part is not None and part.unit == "rad"]
    if len(parts) != 2 or len(angles) != 2:
        raise RequestError(f'"{text}" is not AZIMUTH,ELEVATION, such as 30deg,20deg')
    azimuth, elevation = angles
    return math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth), math.sin(elevation)


def _frames(robot: Robot, frames: Sequence[str], published: bool, modes: Mapping[str, bool]) -> list[str]:
    """Return the names of frames to show: ``frames``, and published frames if ``published``. Raises UnknownName."""
    for name in frames:
        if name not in robot.link:
            raise UnknownName("frame", name, robot.link)
    if not published:
        return list(dict.fromkeys(frames))
    states = {**dict.fromkeys(robot.modes, True), **modes}
    rows = [row for row in robot.frame_tree() if row.is_published and holds(row.when, states)]
    found = {name for row in rows for name in (row.parent, row.child)} or robot.link.keys()
    return [link.name for link in robot.links if link.name in {*found, *frames}]
