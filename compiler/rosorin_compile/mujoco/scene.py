"""scene: a world for the MJCF of a robot, so that a person who opens it in MuJoCo sees the robot in light, on a floor.

It includes the MJCF, which stays the robot and nothing else. The floor is at z = 0, where the MJCF puts a free base
(see ``model.standing``); under a robot that is held lower, it is as low as that robot reaches. The camera ``overview``
and the free one of viewers begin where the robot fills the picture. MuJoCo looks for what an included file names, such
as meshes, from the folder of the including one: both stand in one folder.

The look is that of the scenes of MuJoCo Menagerie: haze, sky, floor, light, and where the camera stands.
"""

from __future__ import annotations

import math
import posixpath
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.formats.format import Format, InRos, Proving, Writing
from rosorin_compile.model import Link, Mesh, Output, Pose, Robot, Vector
from rosorin_compile.model.geometry import unit
from rosorin_compile.rules.case import Case
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Diagnostic, error, listed
from rosorin_compile.source.numbers import six, vector
from rosorin_compile.source.rule_registry import Heading, Rule

if TYPE_CHECKING:
    from rosorin_compile.formats.templating import Templates
    from rosorin_compile.model.bounds import Bounds

RULES = (
    Rule(
        "scene-without-robot",
        "A scene does not say which MJCF is in it: the robot has none or several, or `of` names something else, or it "
        "stands in another folder.",
        "Add an output `mjcf`, or name one with `of`; write both into one folder.",
        Heading.FORMATS,
    ),
)

MJCF = "mjcf"

# Where the camera looks to, in MuJoCo's words (degrees), and how wide it sees; Menagerie's angles.
AZIMUTH, ELEVATION, FIELD_OF_VIEW = 120.0, -20.0, 45.0
# What is free around the robot in a picture, and the least that a picture shows (m).
_MARGIN = 1.15
_SMALLEST = 0.1
# What is free around the frames of a robot of meshes, and how large it is if it has one frame (m).
_AROUND, _USUAL = 1.5, 0.5
# Where the light shines to: from above, a little from the right and from the front; and from how far (extents).
_LIGHT = (-0.35, 0.25, -1.0)
_LAMP = 1.5

_INCLUDED = re.compile(r'<include file="([^"]*)"')
_NAMED = re.compile(r'\bname="([^"]*)"')


class _Camera(NamedTuple):
    """Where a camera stands, and its axes x and y (MuJoCo: it looks along -z, y is up)."""

    position: Vector
    x: Vector
    y: Vector


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return the scene of a robot. Option: ``of``, the output of MJCF that is in it."""
    from rosorin_compile.formats.templating import comment

    of, problem = _included(robot, output)
    if of is None:
        return "", [error("scene-without-robot", *problem)]
    bounds, known = _bounds(robot, of)
    (a, b, c), (d, e, f) = bounds
    centre = ((a + d) / 2, (b + e) / 2, (c + f) / 2)
    extent = max(bounds.diagonal, _SMALLEST) if known else max(_AROUND * bounds.diagonal, _USUAL)
    camera = _camera(centre, extent)
    values = {
        "robot": robot,
        "title": comment(robot.name),
        "file": posixpath.relpath(of.file, posixpath.dirname(output.file) or "."),
        "known": known,
        "centre": vector(_rounded(centre), six),
        "extent": six(round(extent, 3)),
        "azimuth": six(AZIMUTH),
        "elevation": six(ELEVATION),
        "fovy": six(FIELD_OF_VIEW),
        "camera": vector(_rounded(camera.position), six),
        "axes": vector(_rounded((*camera.x, *camera.y), 6), six),
        "lamp": vector(_rounded([at - _LAMP * extent * way for at, way in zip(centre, _LIGHT, strict=True)]), six),
        "light": vector(_LIGHT, six),
        "ground": six(0.0 if robot.has_free_base(of) else round(min(0.0, c), 6)),
        "name": lambda name: _free(name, robot),
    }
    return templates.own("mujoco/scene.xml.jinja", values), []


def _included(robot: Robot, output: Output) -> tuple[Output | None, tuple[str, None, str]]:
    """Return the output of MJCF that is in a scene; None with what is wrong and the way out."""
    known = {one.name: one for one in robot.outputs if one.backend == MJCF}
    named = output.options.get("of")
    if named is None and not known:
        return None, (f'the robot has no MJCF for the scene "{output.name}"', None, "add an output: mjcf: {file: ...}")
    if named is None and len(known) > 1:
        names = listed(list(known))
        return None, (f'the scene "{output.name}" does not say which MJCF is in it: {names}', None, "add of: NAME")
    one = known.get(named) if named is not None else next(iter(known.values()))
    if one is None:
        names = f"one of {listed(list(known))}" if known else "an output of MJCF, which the robot has not"
        return None, (f'the scene "{output.name}" is of "{named}", which is no MJCF', None, f"name {names}")
    if posixpath.dirname(one.file) != posixpath.dirname(output.file):
        message = f"{output.file} is not in the folder of {one.file}, which it includes"
        return None, (message, None, "write both into one folder: MuJoCo looks for meshes from that of the scene")
    return one, ("", None, "")


def _bounds(robot: Robot, of: Output) -> tuple[Bounds, bool]:
    """Return the box around the robot at home, as it stands in the world, and whether that is all of it.

    Meshes that collide are measured; those that are seen take no more room where the link collides with anything.
    Where the size of one is not known, it is the box around what else is there, and all frames.
    """
    from rosorin_compile.model.bounds import Bounds
    from rosorin_compile.model.mesh_vertices import clouds_of
    from rosorin_compile.model.standing import home_of, reach, stands_at

    home, clouds = home_of(robot), clouds_of(robot, as_opened=True)
    at: Pose = stands_at(robot, home, clouds) if robot.has_free_base(of) else robot.root_in_world.pose
    solid = reach(robot, home.positions, "collision", at, clouds)
    seen = reach(robot, home.positions, "visual", at)
    boxes = [one.bounds for one in (solid, seen) if one.bounds is not None]
    known = not solid.meshes and not any(link.visual and not link.collision and _has_mesh(link) for link in robot.links)
    if not boxes or not known:
        world = at.transform()
        places = (world.then(place).xyz for place in robot.poses_in_root(dict(home.positions)).values())
        boxes += [Bounds(place, place) for place in places]
    whole = boxes[0]
    for box in boxes[1:]:
        whole = whole.join(box)
    return whole, known


def _has_mesh(link: Link) -> bool:
    return any(isinstance(shape.geometry, Mesh) for shape in link.visual)


def _camera(centre: Vector, extent: float) -> _Camera:
    """Return the camera from where a ball around a point fills the picture."""
    azimuth, elevation = math.radians(AZIMUTH), math.radians(ELEVATION)
    forward = (
        math.cos(elevation) * math.cos(azimuth),
        math.cos(elevation) * math.sin(azimuth),
        math.sin(elevation),
    )
    x = (math.sin(azimuth), -math.cos(azimuth), 0.0)
    up = unit((-forward[0] * forward[2], -forward[1] * forward[2], 1.0 - forward[2] ** 2))
    away = _MARGIN * extent / 2 / math.sin(math.radians(FIELD_OF_VIEW / 2))
    px, py, pz = (middle - away * part for middle, part in zip(centre, forward, strict=True))
    return _Camera((px, py, pz), x, up)


def _rounded(numbers: Sequence[float], digits: int = 3) -> list[float]:
    """Return numbers as a person reads them, without minus zero."""
    return [round(number, digits) + 0.0 for number in numbers]


def _free(name: str, robot: Robot) -> str:
    """Return a name that nothing of the robot has: in MuJoCo a scene and what it includes share their names."""
    taken = {mark.name for link in robot.links for mark in link.marked}
    taken |= {shape.name for link in robot.links for shape in (*link.collision, *link.visual)}
    taken |= {part.name for sensor in robot.sensors for part in sensor.simulated}
    texts = [*robot.mjcf_elements, *(text for link in robot.links for text in link.mjcf_elements)]
    taken |= {found for text in texts for found in _NAMED.findall(text)}
    while name in taken:
        name += "_"
    return name


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Yield what is wrong with the entry of a scene: which MJCF is in it."""
    of, (message, _, help) = _included(case.robot, output)
    if of is None:
        wrong = output.options.get("of", MJCF) not in {one.name for one in case.robot.outputs if one.backend == MJCF}
        key = "of" if wrong and "of" in output.options else "file"
        yield case.problem("scene-without-robot", message, ("outputs", output.name, key), help)


def _syntax(text: str) -> object:
    from rosorin_compile.source.xml.elements import canonical, tree_of

    return canonical(tree_of(text))


_HEAD = re.compile(r'<mujoco model="([^"]*) scene">\s*<!-- Generated by rosorin-compile')
_LOOKED_AT = 1_000


def robot_of(path: Path) -> str:
    """Return the robot that a scene was generated for; empty if the file is no scene. Raises OSError."""
    from html import unescape  # that of xml.sax.saxutils would load http

    found = _HEAD.match(files.read_bytes(path, _LOOKED_AT).decode("utf-8", "replace"))
    return unescape(found[1]) if found else ""


FORMAT = Format(
    name="scene",
    word="scene",
    article="a",
    about="the MJCF on a floor, in light, for MuJoCo's viewer",
    rank=31,
    covers=("robot",),
    options={
        "of": {
            "type": "string",
            "description": "The output of MJCF that is in the scene, by its name; default: the only one.",
        },
    },
    file="scene.xml",
    endings=(".xml",),
    check=check,
    write=write,
    writing=Writing(
        measures=True,
        beside=lambda text: _INCLUDED.findall(text),
    ),
    proving=Proving(
        syntax=_syntax,
    ),
    ros=InRos(
        folder="mjcf",
        robot_of=robot_of,
    ),
)
