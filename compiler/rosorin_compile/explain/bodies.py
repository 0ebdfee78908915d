"""Bodies: the limits of a joint, the mass and the shapes of a link, each number with its origin."""

from __future__ import annotations

from collections.abc import Iterator

from ..formatting import exact
from ..model import Box, Capsule, Cylinder, Geometry, HeightMap, Inertial, Joint, Link, Mesh, Sphere
from ..tree import Path
from .frames import Frames
from .values import Number, Shape

_OF_JOINT = ("limit", "mimic", "dynamics", "actuator", "calibration", "safety_controller")
_OF_SERVO = ("rad_per_pulse", "zero_pulse", "pulse_range")
_MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def of_joint(frames: Frames, joint: Joint) -> Iterator[Number]:
    """Yield the limits of a joint, whom it follows, what a simulation knows of it, and its servo."""
    path = frames.places["joint", joint.name]
    for key in _OF_JOINT:
        yield from frames.numbers((*path, key), joint.type in ("prismatic", "planar"))
    for group in frames.robot.servos:
        if joint.name in group.joints:
            for key in _OF_SERVO:
                for number in frames.numbers(("servos", group.name, key)):
                    yield number._replace(name=f"servo {number.name}")


def of_mass(frames: Frames, link: Link) -> Iterator[Number]:
    """Yield the numbers of an inertial, those that were calculated from shapes too."""
    path = frames.places["link", link.name]
    if path[0] != "links" or link.inertial is None:
        return
    written = [number._replace(name=_short(number.name)) for number in frames.numbers((*path, "inertial"))]
    yield from written
    if not any(number.name == "inertia ixx" for number in written):
        note = "calculated from the shapes"
        known = {number.name for number in written}
        yield from (n for n in _calculated(link.inertial, note) if n.name not in known)


def _calculated(inertial: Inertial, note: str) -> Iterator[Number]:
    yield Number("mass", inertial.mass, "kg", None, note)
    for name, value in zip("xyz", inertial.pose.xyz, strict=True):
        yield Number(f"xyz {name}", value, "m", None, note)
    for name, value in zip(("roll", "pitch", "yaw"), inertial.pose.rpy, strict=True):
        yield Number(f"rpy {name}", value, "rad", None, note)
    for name in _MOMENTS:
        yield Number(f"inertia {name}", getattr(inertial, name), "kg*m^2", None, note)


def of_shapes(frames: Frames, link: Link) -> Iterator[Shape]:
    """Yield the shapes of a link."""
    path = frames.places["link", link.name]
    for purpose, shapes in (("collision", link.collision), ("visual", link.visual)):
        for index, shape in enumerate(shapes):
            here: Path = (*path, purpose, index)
            where, _ = frames.origins.at(here)
            kind, words = _words(shape.geometry)
            if isinstance(shape.geometry, HeightMap):
                keys = [(*here, "height_map", key) for key in ("origin", "cell", "step")]
                numbers = [number for key in keys for number in frames.numbers(key)]
            else:
                numbers = [number._replace(name=_short(number.name)) for number in frames.numbers(here)]
            yield Shape(purpose, kind, words, tuple(numbers), where)


def _short(name: str) -> str:
    """Return the name of a number without that of the piece it stands in: "inertial mass" is "mass"."""
    return name.partition(" ")[2]


def _words(geometry: Geometry) -> tuple[str, str]:
    """Return the kind of a geometry, and its size in metres."""
    if isinstance(geometry, Box):
        return "box", " x ".join(exact(round(length, 12)) for length in geometry.size) + " m"
    if isinstance(geometry, (Cylinder, Capsule)):
        kind = "cylinder" if isinstance(geometry, Cylinder) else "capsule"
        return kind, f"radius {exact(geometry.radius)} m, length {exact(geometry.length)} m"
    if isinstance(geometry, Sphere):
        return "sphere", f"radius {exact(geometry.radius)} m"
    if isinstance(geometry, Mesh):
        return "mesh", geometry.file
    rows, columns = len(geometry.heights), len(geometry.heights[0])
    return "height map", f"{rows} x {columns} cells of {exact(geometry.cell)} m"
