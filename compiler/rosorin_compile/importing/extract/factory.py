"""``extract factory``: all numbers of a ROS description package: joints, a box for each part, a height map.

Only numbers and names are taken; no mesh and no sentence of the package is copied. What is missing in the package is
listed, and the rest goes on.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rosorin_compile.formats import FORMATS
from rosorin_compile.model import Box, HeightMap
from rosorin_compile.model.mesh_triangles import ExtractProblem, NotThere, TriangleMesh
from rosorin_compile.source.diagnostics import Diagnostic, did_you_mean
from rosorin_compile.source.files import is_file, is_folder, read_bytes, resolve
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.tree import Map

from . import turning, writing
from .fits import axis_aligned
from .heightmap import Wanted, make_map
from .parts import AUTO, RobotSource, part_of_link
from .writing import MARK

RULES = (Rule("factory-robot", "A package has no file of a robot, or several.", "`--robot FILE`.", Heading.MESHES),)

_KEYS = (
    "type",
    "parent",
    "child",
    "xyz",
    "rpy",
    "axis",
    "limit",
    "mimic",
    "dynamics",
    "calibration",
    "safety_controller",
)
# Rules about what is not taken.
_NOT_TAKEN = ("mass-", "inertia-", "shape-")
_ROBOT = re.compile(r"<robot\b[^>]*?\sname\s*=", re.DOTALL)
_INCLUDES = re.compile(r"<xacro:include\b[^>]*?\sfilename\s*=\s*[\"']([^\"']+)[\"']", re.DOTALL)


@dataclass(frozen=True)
class Asked:
    """What is to be made of a package; ``map_link`` None: no height map; ``frame`` None: that of the link itself."""

    map_link: str | None
    frame: str | None
    wanted: Wanted
    section: str = AUTO
    digits: int = 5


@dataclass
class Factory:
    """What came of a package: texts by file name, names of joints and boxes, the height map, and what is missing."""

    files: dict[str, str] = field(default_factory=dict)
    joints: list[str] = field(default_factory=list)
    boxes: dict[str, Box] = field(default_factory=dict)
    height_map: HeightMap | None = None
    frame: str = ""
    diagnostics: list[Diagnostic] = field(default_factory=list)


def robot_file(package: Path, asked: str | None) -> Path:
    """Return the file of the robot in a package: the one that is asked for, or the only one that there is.

    A file is that of a robot if its root names one, and no other file of the package includes it.
    Raises NotThere if there is no such package or file, else ExtractProblem.
    """
    if not is_folder(package):
        raise NotThere.of("factory-robot", f"{package} is not a folder", "name the folder of a description package")
    if asked is not None:
        path = next((path for path in (package / asked, Path(asked)) if is_file(path)), None)
        if path is None:
            help = did_you_mean(asked, [str(path.relative_to(package)) for path in _candidates(package)])
            raise NotThere.of("factory-robot", f'{package} has no file "{asked}"', help)
        return path
    files = _candidates(package)
    if len(files) == 1:
        return files[0]
    names = ", ".join(str(path.relative_to(package)) for path in files[:20])
    message = f"{package} has {len(files)} files of robots: {names}" if files else f"{package} has no file of a robot"
    raise ExtractProblem.of("factory-robot", message, "say which: --robot FILE")


def _candidates(package: Path) -> list[Path]:
    format, texts = FORMATS.published(), dict[Path, str]()
    endings = [
        ending for one in FORMATS.values() if format.name in (one.name, one.reading.becomes) for ending in one.endings
    ]
    for path in sorted(package.glob("**/*")):
        if path.suffix.lower() in endings and is_file(path):
            texts[path] = read_bytes(path, 5_000_000).decode("utf-8", "replace")
    included = {address.rpartition("/")[2] for text in texts.values() for address in _INCLUDES.findall(text)}
    return [path for path, text in texts.items() if _ROBOT.search(text) and path.name not in included]


def name_of(package: Path) -> str:
    """Return the name of a package: what its package.xml says, else that of its folder."""
    return Packages.name_of(package) or resolve(package).name


def extract(source: RobotSource, package: str, asked: Asked) -> Factory:
    """Return the numbers of a robot of a package. Raises NotThere for a link or frame that it does not have."""
    made = Factory(diagnostics=source.diagnostics)
    for link in (asked.map_link, asked.frame):
        if link is not None:
            source.link(link)
    made.joints = list(source.robot.joint)
    made.files["joints.yaml"] = _joints(source, package)
    _add_boxes(source, asked, made)
    if asked.map_link is not None:
        _add_map(source, package, asked, made)
    made.files["boxes.yaml"] = _boxes(source, package, made)
    return made


def _add_boxes(source: RobotSource, asked: Asked, made: Factory) -> None:
    """Add the box around the meshes of each link but that of the height map."""
    for index, link in enumerate(source.robot.link):
        Progress.step("measuring", index, len(source.robot.link))
        part = None if link == asked.map_link else part_of_link(source, link, asked.section)
        if part is not None:
            made.boxes[link] = axis_aligned(part.triangles, asked.digits)


def _add_map(source: RobotSource, package: str, asked: Asked, made: Factory) -> None:
    """Add the height map of a link; one without a mesh that can be read has none, which is an error that is listed."""
    link = asked.map_link or ""
    frame = asked.frame or link
    part = part_of_link(source, link, asked.section)
    if part is None:
        problem = ExtractProblem.of("height-map-empty", f"{link} has no mesh that can be read: no height map", "")
        made.diagnostics.append(problem.diagnostic)
        return
    transform = source.robot.transform(frame, link, {})
    triangles = TriangleMesh.placed(part.triangles, transform.rows, transform.xyz)
    try:
        made.height_map, diagnostics = make_map(triangles, asked.wanted, frame)
    except ExtractProblem as problem:
        made.diagnostics.append(problem.diagnostic)
        return
    made.diagnostics += diagnostics
    made.frame = frame
    note = f"top of {', '.join(part.meshes)}"
    lines = [_head("heightmap", package), *writing.height_map(frame, made.height_map, "calculated", note)]
    made.files["heightmap.yaml"] = "\n".join(lines) + "\n"


def _head(what: str, package: str) -> str:
    return f"{MARK} factory: {what} of the package {package}. Numbers only; metres, radians."


def _joints(source: RobotSource, package: str) -> str:
    """Return all joints, with the digits that the package has."""
    lines = [_head("joints", package), f"source: {writing.source('factory', f'description package {package}')}"]
    joints = source.tree.get("joints")
    lines.append("joints:" if joints else "joints: {}")
    for name, joint in joints.items() if isinstance(joints, Map) else ():
        lines.append(f"  {writing.name(name)}:")
        kept = Map(joint.span)
        for key in (*_KEYS, *joint):
            if key in _KEYS and key in joint and key not in kept:
                kept.put(key, joint[key], joint.key_spans[key], joint.value_spans[key])
        lines += turning.block(kept, "    ")
    lines += _accepted(source.tree.get("accept"))
    return "\n".join(lines) + "\n"


def _accepted(entries: Any) -> list[str]:
    """Return what the package has all the same, but for masses and shapes, which are not taken."""
    accepted = [
        turning.inline(entry, span)
        for entry, span in zip(entries or (), getattr(entries, "value_spans", ()), strict=True)
        if not entry["rule"].startswith(_NOT_TAKEN)
    ]
    return ["accept:", *(f"  - {text}" for text in accepted)] if accepted else []


def _boxes(source: RobotSource, package: str, made: Factory) -> str:
    """Return all links, those with meshes with the axis-aligned box around these."""
    note = f"boxes around the meshes of the package {package}"
    lines = [_head("boxes", package), f"source: {writing.source('calculated', note)}", "links:"]
    for link in source.robot.link:
        if link in made.boxes:
            corners = made.boxes[link]
            size = f"{{min: {writing.row(corners.lower)}, max: {writing.row(corners.upper)}}}"
            lines += [f"  {writing.name(link)}:", f"    collision: [{{box: {size}}}]"]
        elif link != made.frame:
            lines.append(f"  {writing.name(link)}: {{}}")
    return "\n".join(lines) + "\n"
