"""Render a robot with numpy as on the HTML page: floor and shadow, shapes with a z-buffer, and frames on top.

If triangles are coplanar, the first triangle is visible. Behind a translucent triangle, no other translucent triangle
is visible.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rosorin_compile.model import Box, Capsule, Cylinder, Ellipsoid, HeightMap, Mesh, Robot, Sphere, Transform, Vector
from rosorin_compile.model.colours import default_colours
from rosorin_compile.model.mesh_triangles import Colour, TriangleMesh
from rosorin_compile.source.progress import Progress

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Pixels = NDArray[np.uint8]  # (rows, columns, 4): premultiplied red, green, blue, and alpha
MeshParts = Sequence[tuple[Floats, Colour | None]]  # (triangles (n, 3, 3) in m, their colour or None) of a mesh file

_FIELD_OF_VIEW, _MARGIN = math.radians(28.0), 1.06  # vertical angle; factor for the distance (viewer/src/stage.js)
_FRAME = 2 * math.tan(_FIELD_OF_VIEW / 2)  # visible height at a distance of 1 from the camera
_FINE, _BAND = 3, 1_000_000  # samples per pixel along x and y; maximum number of samples in memory
_NEAREST, _LAST = 2**24, 2**32 - 1
_SEGMENTS, _SMOOTH = 40, 0.82  # segments of a circle; cosine of the largest angle between smooth faces
_MOST_SMOOTH = 400_000  # meshes with more triangles have flat shading
# Faces of a box: indices of the corners in the order of itertools.product, counter-clockwise from outside.
_BOX_FACES = [(4, 6, 7, 5), (2, 0, 1, 3), (6, 2, 3, 7), (0, 4, 5, 1), (1, 5, 7, 3), (2, 6, 4, 0)]
_OVERLAY = (0xE8 / 255, 0x83 / 255, 0x3A / 255, 0.35)  # RGBA of collision shapes drawn over visuals
_SUN, _SUN_COLOUR = np.array((0.25, 0.75, 1.0)) / math.sqrt(1.625), np.array((0.70, 0.645, 0.575))
# Sky light reflected by a white surface with the normal (x, y, z): coefficients of 1, x, y, z, x^2 - y^2, z^2, xy, xz
# and yz, fitted to screenshots of the page.
_SKY = np.array((0.507, 0.072, -0.194, 0.244, -0.092, 0.060, 0.049, 0.073, -0.168))
_MAP, _BLUR = 768, 8  # size of the square shadow map, and radius of the blur, in cells
_SHADOW = {"light": 0.22, "dark": 0.45}  # opacity of the shadow
# Colours of horizon, zenith, floor, grid, names and their outlines, as on the page.
THEMES = {
    "light": [[*bytes.fromhex(colour)] for colour in ("f3f5f8", "fdfdfe", "e6eaef", "b9c2cd", "1f2933", "ffffff")],
    "dark": [[*bytes.fromhex(colour)] for colour in ("171b21", "1d2229", "1f252d", "3a4450", "e6eaf0", "171b21")],
}
AXIS_COLOURS = [[*bytes.fromhex(colour)] for colour in ("e5484d", "30a46c", "3e63dd")]
_SENSOR, _EMPTY = ([0x8E, 0x4E, 0xC6], 11.0), ([0x7D, 0x8A, 0x97], 8.0)  # markers: (RGB, size in pixels)
_DOT, _ADVANCE, _LINE, _GAP = 1.45, 8.7, 11.0, 4.0  # pixels between dots, letters and lines, and before a name
# Bitmap font: space to ~ and a box, five columns per character, two hex digits per column, lowest bit at the top.
_DOTS = bytes.fromhex(
    "0000000000 00005F0000 0007000700 147F147F14 242A7F2A12 2313086462 3649562050 0008070300"
    "001C224100 0041221C00 2A1C7F1C2A 08083E0808 0080703000 0808080808 0000606000 2010080402"
    "3E5149453E 00427F4000 7249494946 2141494D33 1814127F10 2745454539 3C4A494931 4121110907"
    "3649494936 464949291E 0000140000 0040340000 0008142241 1414141414 0041221408 0201590906"
    "3E415D594E 7C1211127C 7F49494936 3E41414122 7F4141413E 7F49494941 7F09090901 3E41415173"
    "7F0808087F 00417F4100 2040413F01 7F08142241 7F40404040 7F021C027F 7F0408107F 3E4141413E"
    "7F09090906 3E4151215E 7F09192946 2649494932 03017F0103 3F4040403F 1F2040201F 3F4038403F"
    "6314081463 0304780403 6159494D43 007F414141 0204081020 004141417F 0402010204 4040404040"
    "0003070800 2054547840 7F28444438 3844444428 384444287F 3854545418 00087E0902 18A4A49C78"
    "7F08040478 00447D4000 2040403D00 7F10284400 00417F4000 7C04780478 7C08040478 3844444438"
    "FC18242418 18242418FC 7C08040408 4854545424 04043F4424 3C4040207C 1C2040201C 3C4030403C"
    "4428102844 4C9090907C 4464544C44 0008364100 0000770000 0041360800 0201020402 7F4141417F"
)


class Scene:
    """The shapes of a robot as triangles in the root frame, counter-clockwise from outside.

    ``corners`` and ``normals`` are (n, 3, 3). The columns of ``looks`` (n, 6) are red, green, blue, opacity (0 to 1),
    and flags to draw the back (as meshes are often open) and to outline the first two sides. ``bounds`` (2, 3) is the
    bounding box of all shapes, including collision shapes that are not drawn.
    """

    def __init__(
        self, robot: Robot, poses: Mapping[str, Transform], meshes: Mapping[Mesh, MeshParts], collision: bool = False
    ) -> None:
        """Collect the visuals of a robot at the given link poses and, with ``collision``, translucent collision shapes.

        By default, collision shapes are drawn only if the robot has no visuals or a mesh is missing.
        """
        made = [(np.empty((0, 3, 3)), np.empty((0, 3, 3)), np.empty((0, 6)))]
        for link in robot.links:
            own = default_colours(robot)[link.name]
            veil = (_OVERLAY if collision else own) if robot.has_looks else robot.look_of(link) or own
            lost = any(isinstance(shape.geometry, Mesh) and shape.geometry not in meshes for shape in link.visual)
            solids = [
                (solid, robot.colour(solid), robot.has_looks) for shape in link.visual for solid in shape.drawn_shapes()
            ]
            drawn = collision or lost or not robot.has_looks
            solids += [(solid, veil, drawn) for shape in link.collision for solid in shape.drawn_shapes()]
            for solid, rgba, visible in solids:
                geometry, pose = solid.geometry, poses[link.name].then(solid.pose.transform())
                is_mesh, is_box = isinstance(geometry, Mesh), isinstance(geometry, Box)
                parts = meshes.get(geometry, ()) if isinstance(geometry, Mesh) else [(_surface(geometry), None)]
                for triangles, colour in parts:
                    *hue, alpha = rgba or ((*colour, 1.0) if colour else own)
                    look = (*hue, alpha * visible, is_mesh and alpha >= 1.0, is_box)
                    corners = TriangleMesh.place(triangles, pose.rows, pose.xyz)
                    normals = TriangleMesh.place(_normals(triangles), pose.rows, (0.0, 0.0, 0.0))
                    made.append((corners, normals, np.tile(look, (len(triangles), 1))))
        corners, normals, looks = map(np.concatenate, zip(*made, strict=True))
        points = corners.reshape(-1, 3) if len(corners) else np.array([pose.xyz for pose in poses.values()])
        self.bounds = np.array([points.min(axis=0), points.max(axis=0)])
        self.size = max(math.dist(*self.bounds), 0.05)  # m
        self.corners, self.normals, self.looks = (values[looks[:, 3] > 0] for values in (corners, normals, looks))
        self.opaque = self.looks[:, 3] >= 1.0


def _surface(geometry: Box | Cylinder | Capsule | Sphere | Ellipsoid | HeightMap) -> Floats:
    if isinstance(geometry, Box | HeightMap):
        boxes = geometry.boxes() if isinstance(geometry, HeightMap) else [geometry]
        quads = np.array([[*product(*zip(box.lower, box.upper, strict=True))] for box in boxes])[:, _BOX_FACES]
    else:  # the surface of revolution of a profile (radius, z) about z, from top to bottom
        radius = 1.0 if isinstance(geometry, Ellipsoid) else geometry.radius
        half = geometry.length / 2 if isinstance(geometry, Cylinder | Capsule) else 0.0
        turn = np.linspace(0.0, math.pi / 2, _SEGMENTS // 4 + 1)
        profile = np.stack([radius * np.sin(turn), radius * np.cos(turn) + half], axis=-1)
        if isinstance(geometry, Cylinder):  # duplicate the vertices of the edge, so that its shading is sharp
            profile = np.array([(0.0, half), (radius, half), (radius * (1 + 1e-9), half)])
        profile = np.concatenate([profile, profile[::-1] * (1.0, -1.0)])
        turn = 2 * math.pi * (np.arange(_SEGMENTS + 1) % _SEGMENTS) / _SEGMENTS
        circle = np.stack([np.cos(turn), np.sin(turn), np.ones(len(turn))], axis=-1)
        p = profile[:, None, [0, 0, 1]] * circle * (geometry.radii if isinstance(geometry, Ellipsoid) else 1.0)
        quads = np.stack([p[1:, :-1], p[1:, 1:], p[:-1, 1:], p[:-1, :-1]], axis=2)
    return quads[..., [(0, 1, 2), (2, 3, 0)], :].reshape(-1, 3, 3)


def _normals(triangles: Floats) -> Floats:
    """Return vertex normals (n, 3, 3): averaged over adjacent faces where the surface is smooth, else of the face."""
    faces = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]).repeat(3, axis=0)
    size = np.linalg.norm(faces, axis=1, keepdims=True)
    flat: Floats = faces / size.clip(max(1e-6 * size.max(initial=0.0), 1e-300))  # ignore degenerate faces
    if len(triangles) > _MOST_SMOOTH:
        return flat.reshape(-1, 3, 3)
    corner = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)[1].reshape(-1)
    total = np.stack([np.bincount(corner, weights=side) for side in flat.T], axis=-1)[corner]
    mean = total / np.linalg.norm(total, axis=1, keepdims=True).clip(1e-300)
    normals: Floats = np.where((mean * flat).sum(axis=1, keepdims=True) > _SMOOTH, mean, flat)
    return normals.reshape(-1, 3, 3)


class Camera(NamedTuple):
    """A pinhole camera: position (m) and axes (right, down, forward) in the root frame, and image size in pixels.

    ``focal`` is the focal length in pixels, ``middle`` the y coordinate of the optical axis. Pixel (0, 0) is at the top
    left.
    """

    eye: Floats
    axes: Floats
    focal: float
    width: int
    height: int
    middle: float

    @staticmethod
    def fit(bounds: Floats, direction: Vector, width: int, height: int) -> Camera:
        """Return a camera that looks at a bounding box (2, 3) from ``direction``, and shows the box completely."""
        radius = max(math.dist(*bounds) / 2, 0.02)
        distance = _MARGIN * radius / math.sin(_FIELD_OF_VIEW / 2) / min(1.0, width / height)
        back = np.array(direction) / math.hypot(*direction)
        right = np.cross((0.0, 0.0, 1.0) if math.hypot(*back[:2]) > 1e-9 else (1.0, 0.0, 0.0), back)
        right /= math.hypot(*right)
        axes = np.stack([right, np.cross(right, back), -back])
        return Camera(bounds.mean(axis=0) + back * distance, axes, height / _FRAME, width, height, height / 2)

    def project(self, points: Floats) -> tuple[Floats, Floats, Floats]:
        """Project points (..., 3) in the root frame; return x and y in pixels, and the depth in m."""
        x, y, depth = np.moveaxis((points - self.eye) @ self.axes.T, -1, 0)
        return x / depth * self.focal + self.width / 2, y / depth * self.focal + self.middle, depth

    def rays(self, x: Floats, y: Floats) -> Floats:
        """Return the view directions (..., 3) of pixels in the root frame, with length 1 along the optical axis."""
        across, down = (x - self.width / 2) / self.focal, (y - self.middle) / self.focal
        directions: Floats = np.stack([across, down, np.ones_like(across)], axis=-1) @ self.axes
        return directions


class Raster:
    """Triangles on a grid of samples; the centre of a sample is at (column + 0.5, row + 0.5).

    ``area`` (n,) is twice the signed area. ``weights[:, k] @ (x, y, 1)`` is the barycentric coordinate of corner k.
    """

    def __init__(self, x: Floats, y: Floats) -> None:
        """Prepare n triangles with corners at x and y (n, 3), in units of samples."""
        next_x, last_x, next_y, last_y = (np.roll(side, turn, 1) for side in (x, y) for turn in (-1, -2))
        lines = np.stack([next_y - last_y, last_x - next_x, next_x * last_y - last_x * next_y], axis=-1)
        self.y, self.area = y, lines[..., 2].sum(axis=1)
        self.weights = lines / np.where(self.area == 0, 1.0, self.area)[:, None, None]

    def visible(self, near: Floats, columns: int, rows: int) -> Ints:
        """Draw into a z-buffer; return a key per sample that is larger for nearer triangles, or -1 for no triangle.

        ``near`` (n, 3) is the inverse depth of the corners, from 0 to 1. The low 32 bits are 2^32 - 1 - triangle index.
        """
        keys, top = np.full(rows * columns, -1, np.int64), np.ceil(self.y.min(axis=1) - 0.5).clip(0)
        bottom = np.floor(self.y.max(axis=1) - 0.5).clip(None, rows - 1)
        triangle, row = _ranges(top, np.where(self.area == 0, -1, bottom))
        a, b, c = np.moveaxis(self.weights[triangle], -1, 0)
        crossing = -(b * (row[:, None] + 0.5) + c) / np.where(a == 0, 1.0, a) - 0.5
        left = np.ceil(np.where(a > 0, crossing, -np.inf).max(axis=1) - 1e-4).clip(0)
        right = np.floor(np.where(a < 0, crossing, np.inf).min(axis=1) + 1e-4).clip(None, columns - 1)
        for part in np.array_split(np.arange(len(row)), 1 + int((right - left + 1).clip(0).sum()) // _BAND):
            number, column = _ranges(left[part], right[part])
            shown, line = triangle[part][number], row[part][number]
            corners = near[shown]
            a, b, c = (self.weights[shown] * corners[..., None]).sum(axis=1).T
            depth = a * (column + 0.5) + b * (line + 0.5) + c
            depth = np.rint(depth.clip(corners.min(axis=1), corners.max(axis=1)) * _NEAREST).astype(np.int64)
            np.maximum.at(keys, line * columns + column, (depth << 32) | (_LAST - shown))
        return keys


def _ranges(first: Floats, last: Floats) -> tuple[Ints, Ints]:
    """Return all integers of n ranges (including ``last``), as arrays of the range index and the integer."""
    counts = np.maximum(last - first + 1, 0).astype(np.int64)
    number = np.repeat(np.arange(len(counts)), counts)
    return number, np.arange(len(number)) + (first.astype(np.int64) - np.cumsum(counts) + counts)[number]


class Floor:
    """The floor below the robot, with a grid and the blurred shadow of opaque shapes."""

    def __init__(self, scene: Scene) -> None:
        self.scene, self.height = scene, scene.bounds[0, 2] - 1e-4 * scene.size
        corners = scene.corners[scene.opaque]
        flat = (corners - (corners[..., 2:] - self.height) * (_SUN / _SUN[2]))[..., :2]
        ends = np.concatenate([scene.bounds[:, :2], flat.reshape(-1, 2)])
        self.cell = max(np.ptp(ends, axis=0).max(), 1e-9) / (_MAP - 6 * _BLUR)
        self.start = ends.min(axis=0) - 3 * _BLUR * self.cell
        raster = Raster(*np.moveaxis((flat - self.start) / self.cell, -1, 0))
        covered = raster.visible(np.ones(flat.shape[:2]), _MAP, _MAP) >= 0
        self.dark = covered.reshape(_MAP, _MAP).astype(np.float64)
        for _ in range(6):  # blur with three box filters along each axis
            sums = np.cumsum(np.pad(self.dark, ((0, 0), (_BLUR + 1, _BLUR))), axis=1)
            self.dark = ((sums[:, 2 * _BLUR + 1 :] - sums[:, : -2 * _BLUR - 1]) / (2 * _BLUR + 1)).T

    def draw(self, camera: Camera, theme: str, transparent: bool) -> Floats:
        """Render floor and sky as premultiplied RGBA from 0 to 1, shape (rows, columns, 4)."""
        y, x = np.mgrid[: camera.height, : camera.width] + 0.5
        rays = camera.rays(x, y)
        slope = np.minimum(rays[..., 2:], -1e-9)
        depth = (self.height - camera.eye[2]) / slope
        points = (camera.eye + rays * depth)[..., :2]
        visible = (rays[..., 2:] < -1e-9) & (depth > 0)
        column, row = np.moveaxis(((points - self.start) / self.cell).clip(0, _MAP - 1).astype(np.int64), -1, 0)
        dark = _SHADOW[theme] * visible * self.dark[row, column, None]
        if transparent:
            return np.concatenate([np.zeros((*dark.shape[:2], 3)), dark], axis=-1)
        horizon, zenith, ground, grid = np.array(THEMES[theme][:4]) / 255.0
        sky = horizon + (zenith - horizon) * (0.5 + (camera.middle - y[..., None]) / camera.focal / _FRAME)
        offset = points - self.scene.bounds.mean(axis=0)[:2]
        fade = visible * (1.33 - np.linalg.norm(offset, axis=-1, keepdims=True) / (4.5 * self.scene.size)).clip(0, 1)
        # Compute the size (m) of a pixel on the floor along x and y, for antialiasing of the grid.
        pixel = depth / camera.focal * (abs(camera.axes[0]) + abs(camera.axes[1] - rays * camera.axes[1, 2] / slope))
        lines, step = np.zeros_like(fade), 10.0 ** round(math.log10(self.scene.size / 8))
        for opacity, width in ((0.35, step), (0.8, 10 * step)):
            share, size = abs(offset / width - np.rint(offset / width)), pixel[..., :2] / width + 1e-12
            line = (1.0 - share / size).clip(0) * (1.3 - size / 0.25).clip(0, 1)
            lines = np.maximum(lines, opacity * line.max(axis=-1, keepdims=True))
        colour = (sky + (ground + (grid - ground) * lines - sky) * fade) * (1.0 - dark)
        return np.pad(colour, ((0, 0), (0, 0), (0, 1)), constant_values=1.0)


def _colours(normals: Floats, hue: Floats) -> Floats:
    """Return the lit sRGB colours of corners (n, 3, 3), from the colours of triangles (n, 3) and corner normals."""
    x, y, z = np.moveaxis(normals, -1, 0)
    sky = np.stack([np.ones_like(x), x, y, z, x * x - y * y, z * z, x * y, x * z, y * z], axis=-1) @ _SKY
    sun = (normals @ _SUN).clip(0)
    hue = np.where(hue <= 0.04045, hue / 12.92, ((hue.clip(0.0, 1.0) + 0.055) / 1.055) ** 2.4)
    light = hue[:, None] * (sky.clip(0.05)[..., None] + _SUN_COLOUR * sun[..., None])
    # Apply the tone mapping of the HTML page, Khronos PBR Neutral.
    least = light.min(axis=-1, keepdims=True)
    light -= np.where(least < 0.08, least - 6.25 * least * least, 0.04)
    peak = light.max(axis=-1, keepdims=True).clip(0.76)
    compressed = 1.0 - 0.24 * 0.24 / (peak - 0.52)
    grey = 1.0 - 1.0 / (0.15 * (peak - compressed) + 1.0)
    light = (light * compressed / peak * (1.0 - grey) + compressed * grey).clip(0.0, 1.0)
    srgb: Floats = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return srgb


def render(scene: Scene, camera: Camera, theme: str, transparent: bool) -> Pixels:
    """Render a scene and the floor; return the pixels (rows, columns, 4)."""
    pixels, floor = np.empty((camera.height, camera.width, 4), np.uint8), Floor(scene)
    red, green, blue, opacity, two_sided, outlined = scene.looks.T
    away = ((scene.corners - camera.eye) * scene.normals).sum(axis=(1, 2)) > 0
    flip = np.where(away & (two_sided > 0), -1.0, 1.0)[:, None, None]
    colours = _colours(scene.normals * flip, np.stack([red, green, blue], axis=-1))
    x, y, depth = camera.project(scene.corners)
    near = depth.min(initial=np.inf) / depth
    front = (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) < (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])
    front |= two_sided > 0
    columns, step = camera.width * _FINE, max(1, _BAND // (camera.width * _FINE**2))
    for first in range(0, camera.height, step):
        height = min(step, camera.height - first)
        band, solid = camera._replace(height=height, middle=camera.middle - first), np.array(-1)
        inside = front & (y.max(axis=1) >= first) & (y.min(axis=1) <= first + height)
        samples = floor.draw(band, theme, transparent).repeat(_FINE, axis=0).repeat(_FINE, axis=1).reshape(-1, 4)
        for kind in (opacity >= 1.0, opacity < 1.0):
            chosen = np.nonzero(inside & kind)[0]
            raster = Raster(x[chosen] * _FINE, (y[chosen] - first) * _FINE)
            keys = raster.visible(near[chosen], columns, height * _FINE)
            places, solid = np.nonzero(keys > solid)[0], keys
            number = _LAST - (keys[places] & _LAST)
            triangle, lines = chosen[number], raster.weights[number]
            sample = np.stack([places % columns + 0.5, places // columns + 0.5, np.ones(len(places))], axis=-1)
            weights = (lines * sample[:, None]).sum(axis=-1).clip(0.0, 1.0)
            # Distance (pixels) to a side: the barycentric coordinate of the opposite corner, divided by its gradient.
            sides = (weights / np.linalg.norm(lines[..., :2], axis=-1))[:, [0, 2]].min(axis=1) / _FINE
            shade = np.where(outlined[triangle] > 0, (0.4 + sides).clip(0.7, 1.0), 1.0)
            colour = (weights[..., None] * colours[triangle]).sum(axis=1) * shade[:, None]
            colour = np.pad(colour, ((0, 0), (0, 1)), constant_values=1.0)
            samples[places] += (colour - samples[places]) * opacity[triangle, None]
        mean = samples.reshape(height, _FINE, camera.width, _FINE, 4).mean(axis=(1, 3))
        pixels[first : first + height] = np.rint(mean.clip(0.0, 1.0) * 255.0)
        Progress.step("drawing", first + height, camera.height, counted=False)
    return pixels


def draw_markers(pixels: Pixels, robot: Robot, poses: Mapping[str, Transform], camera: Camera) -> None:
    """Draw a dot at each sensor, and at each link without shapes."""
    sensors = {sensor.frame for sensor in robot.sensors}
    empty = {link.name for link in robot.links if not link.visual and not link.collision}
    for names, marker in ((empty - sensors, _EMPTY), (sensors, _SENSOR)):
        for name in sorted(names & poses.keys()):
            x, y, depth = camera.project(np.array(poses[name].xyz))
            if depth > 0:
                _draw_lines(pixels, [[(x, y), (x, y)]], *marker)


def draw_frames(pixels: Pixels, frames: Mapping[str, Transform], camera: Camera, length: float, theme: str) -> None:
    """Draw the axes (``length`` in m) and names of frames, given by their poses in the root frame."""
    names: list[tuple[float, float, float, str]] = []  # (left, width, row, name) of drawn names, in pixels
    for name, pose in frames.items():
        x, y, depth = camera.project(np.array([pose.apply(end) for end in (np.eye(4, 3, -1) * length).tolist()]))
        if depth.min() <= 0:
            continue
        for tip, colour in enumerate(AXIS_COLOURS, 1):
            _draw_lines(pixels, [[(x[0], y[0]), (x[tip], y[tip])]], colour, 2.0)
        wide, rows = len(name) * _ADVANCE, [y[0] + 3 + step * _LINE / 2 for step in sorted(range(-30, 31), key=abs)]
        places = [(left, row) for row in rows for left in (x[0] - _GAP - wide, x[0] + _GAP)]
        for left, row in places:
            near = [one for one in names if abs(row - one[2]) < _LINE and -wide - _GAP < left - one[0] < one[1] + _GAP]
            inside = 0 <= left <= camera.width - wide and _LINE / 2 <= row <= camera.height - _LINE / 2
            if inside and not near:
                break
        else:
            left, row = places[1]
        names.append((left, wide, row, name))
    for pen, colour in ((4.2, THEMES[theme][5]), (1.9, THEMES[theme][4])):
        for left, _, row, name in names:
            for number, letter in enumerate(name):
                at = 5 * (ord(letter) - ord(" ")) if " " <= letter <= "~" else len(_DOTS) - 5
                dots = [
                    (column, line) for column, line in product(range(5), range(8)) if _DOTS[at + column] >> line & 1
                ]
                points = np.array(dots).reshape(-1, 2) * _DOT + [left + number * _ADVANCE, row - 3 * _DOT]
                _draw_lines(pixels, np.stack([points, points], axis=1), colour, pen)


def _draw_lines(pixels: Pixels, lines: ArrayLike, colour: Sequence[int], pen: float) -> None:
    """Draw antialiased lines between end points (n, 2, 2), with round caps and width ``pen``, in pixels."""
    ends, size = np.array(lines, np.float64), pixels.shape[1::-1]
    low = (ends.min(axis=(0, 1), initial=1e9) - pen).clip(0, size).astype(int)
    high = (ends.max(axis=(0, 1), initial=0.0) + pen + 2).clip(0, size).astype(int)
    area, points = pixels[low[1] : high[1], low[0] : high[0]], np.mgrid[low[0] : high[0], low[1] : high[1]] + 0.5
    start, along = ends[:, 0, :, None, None], (ends[:, 1] - ends[:, 0])[..., None, None]
    share = (((points - start) * along).sum(axis=1) / (along**2).sum(axis=1).clip(1e-9)).clip(0.0, 1.0)[:, None]
    distance = np.linalg.norm(points - start - along * share, axis=1).min(axis=0, initial=1e9).T
    cover = (pen / 2 + 0.5 - distance).clip(0.0, 1.0)[..., None]
    area[:] = np.rint(area + (np.array([*colour, 255]) - area) * cover)
