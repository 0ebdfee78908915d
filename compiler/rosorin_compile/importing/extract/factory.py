"""Take the numbers of a ROS description package: joints, a box around each link, a height map.

Only numbers and names are taken; no mesh and no text of the package is copied.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rosorin_compile.formats import FORMATS
from rosorin_compile.model import Box, HeightMap
from rosorin_compile.model.mesh_triangles import ExtractProblem, NotThere, TriangleMesh
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, Suggestion, phrase
from rosorin_compile.source.files import is_file, is_folder, read_bytes
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.tree import Map, Seq

from ..layout import layout, number
from .height_map import make_height_map
from .results import MARK, height_map_yaml, numbers
from .shapes import enclosing_box
from .sources import GridOptions, RobotSource

_PLACE = ("type", "parent", "child", "xyz", "rpy", "axis")
_KEYS = (*_PLACE, "limit", "mimic", "dynamics", "calibration", "safety_controller")
_NOT_TAKEN = ("mass-", "inertia-", "shape-")  # rules about values that are not taken
_DIGITS = 5
_MAX_BYTES = 5_000_000  # of a robot file
_ROBOT = re.compile(r"<robot\b[^>]*?\sname\s*=", re.DOTALL)
_INCLUDES = re.compile(r"<xacro:include\b[^>]*?\sfilename\s*=\s*[\"']([^\"']+)[\"']", re.DOTALL)
_CONDITION = re.compile(
    r"<xacro:(if|unless)\b[^>]*?\svalue\s*=\s*(\"[^\"]*\"|'[^']*')[^>]*>(.*?)</xacro:\1>", re.DOTALL
)
_PROPERTY = re.compile(r"<xacro:property\b[^>]*?\sname\s*=\s*[\"'](\w+)[\"'][^>]*?\svalue\s*=\s*[\"']([^\"']*)[\"']")
_SOURCE = re.compile(r"\$\((env|optenv|arg)\s+(\w+)")
_COMPARISON = re.compile(r"""(\$\([^()]*\)|\b\w+\b)\s*['"]?\s*[!=]=\s*['"]([^'"]*)['"]""")


@dataclass
class FactoryNumbers:
    """The results: texts by file name, joints, boxes by link, the height map in a frame, and diagnostics."""

    files: dict[str, str] = field(default_factory=dict)
    joints: list[str] = field(default_factory=list)
    boxes: dict[str, Box] = field(default_factory=dict)
    height_map: HeightMap | None = None
    frame: str = ""
    diagnostics: list[Diagnostic] = field(default_factory=list)


def find_robot_file(package: Path, requested: str | None) -> Path:
    """Return the requested file of a package, or the only one with a robot that no other file includes.

    Raises NotThere if there is no such package or file, else ExtractProblem.
    """
    if not is_folder(package):
        raise NotThere.new("factory-robot", f"{package} is not a folder", "name the folder of a description package")
    candidates, choices = _candidates(package)
    if requested is not None:
        path = next((path for path in (package / requested, Path(requested)) if is_file(path)), None)
        if path is None:
            suggestion = Suggestion(requested, [str(path.relative_to(package)) for path in candidates])
            raise NotThere.new("factory-robot", f'{package} has no file "{requested}"', suggestion)
        return path
    if len(candidates) == 1:
        return candidates[0]
    if not candidates:
        raise ExtractProblem.new("factory-robot", f"{package} has no file of a robot", "name one with --robot FILE")
    names = ", ".join(str(path.relative_to(package)) for path in candidates[:20])
    message, help = f"{package} has {len(candidates)} files of robots: {names}", "select one with --robot FILE"
    if choices:
        entry = next(iter(choices)).relative_to(package)
        message += "".join(f"; {path.relative_to(package)} {text}" for path, text in choices.items())
        help = f"use the file that chooses: --robot {entry}; or select one with --robot FILE"
    raise ExtractProblem.new("factory-robot", message, help)


def _candidates(package: Path) -> tuple[list[Path], dict[Path, str]]:
    """Return the robot files of a package, and for files that choose between includes, how they choose."""
    published = FORMATS.published_format()
    formats = [one for one in FORMATS.values() if published.name in (one.name, one.becomes)]
    endings = {ending for one in formats for ending in one.endings}
    texts = {
        path: read_bytes(path, _MAX_BYTES).decode("utf-8", "replace")
        for path in sorted(package.glob("**/*"))
        if path.suffix.lower() in endings and is_file(path)
    }
    included: set[Path] = set()
    for path, text in texts.items():
        for address in _INCLUDES.findall(text):
            # A name with an expression matches every file that fits: ${model}.xacro, $(arg model).xacro
            pieces = re.split(r"\$\{[^}]*\}|\$\([^)]*\)", address.rpartition("/")[2])
            pattern = re.compile(".+".join(map(re.escape, pieces)))
            included |= {other for other in texts if other != path and pattern.fullmatch(other.name)}
    candidates = [path for path, text in texts.items() if _ROBOT.search(text) and path not in included]
    choices = {path: choice for path in texts if path not in included and (choice := _choice(texts[path]))}
    return (sorted({*candidates, *choices}) if len(candidates) != 1 else candidates), choices


def _choice(text: str) -> str:
    """Return by which variables a file with includes chooses, and the values it compares them with."""
    includes = _INCLUDES.findall(text)
    conditions = [value[1:-1] for _, value, content in _CONDITION.findall(text) if "<xacro:include" in content]
    conditions += [name for name in includes if "$" in name]
    origins = {name: source for name, value in _PROPERTY.findall(text) if (source := _SOURCE.search(value))}
    values: dict[str, dict[str, None]] = {}
    for condition in conditions if includes else ():
        found = [(source, "") for source in _SOURCE.finditer(condition)]
        found += [(origins[word], "") for word in re.findall(r"\w+", condition) if word in origins]
        for operand, value in _COMPARISON.findall(condition):
            if source := _SOURCE.search(operand) or origins.get(operand):
                found.append((source, value))
        for source, value in found:
            kind = "argument" if source[1] == "arg" else "environment variable"
            values.setdefault(f"the {kind} {source[2]}", {}).update({value: None} if value else {})
    chosen = [f"{name} ({', '.join(some)})" if some else name for name, some in values.items()]
    return f"chooses by {phrase(chosen)}" if chosen else ""


def choice_of(path: Path) -> list[Diagnostic]:
    """Return a note about the variables by which a robot file chooses, if it does."""
    choice = _choice(read_bytes(path, _MAX_BYTES).decode("utf-8", "replace"))
    help = "set the environment variable, or give the argument as NAME:=VALUE"
    return [Diagnostic("factory-robot", NOTE, f"{path} {choice}", None, (), help)] if choice else []


def take_numbers(
    source: RobotSource, package: str, map_link: str | None, frame: str | None, grid: GridOptions, section: str
) -> FactoryNumbers:
    """Take the numbers of a robot, without a height map if ``map_link`` is None.

    Raises NotThere for a link or frame that it does not have.
    """
    taken = FactoryNumbers(diagnostics=source.diagnostics, joints=list(source.robot.joint))
    for link in filter(None, (map_link, frame)):
        source.link(link)
    for index, link in enumerate(source.robot.link):
        Progress.step("measuring", index, len(source.robot.link))
        part = None if link == map_link else source.part(link, section)
        if part is not None:
            taken.boxes[link] = enclosing_box(part.triangles, _DIGITS)
    if map_link is not None:
        _add_height_map(source, package, (map_link, frame or map_link), grid, section, taken)
    taken.files["joints.yaml"] = _joints_yaml(source, package)
    links = {
        link: {"collision": [{"box": {"min": numbers(box.lower), "max": numbers(box.upper)}}]} if box else {}
        for link in source.robot.link
        if (box := taken.boxes.get(link)) or link != taken.frame
    }
    note = f"boxes around the meshes of the package {package}"
    boxes = {"source": {"status": "calculated", "note": note}, "links": links}
    taken.files["boxes.yaml"] = _head("boxes", package) + layout(boxes)
    return taken


def _add_height_map(
    source: RobotSource, package: str, frames: tuple[str, str], grid: GridOptions, section: str, taken: FactoryNumbers
) -> None:
    """Add the height map of a link in a frame, or a diagnostic if there is none."""
    link, frame = frames
    part = source.part(link, section)
    try:
        if part is None:
            raise ExtractProblem.new("height-map-empty", f"{link} has no mesh that can be read: no height map")
        transform = source.robot.transform(frame, link, {})
        triangles = TriangleMesh.place(part.triangles, transform.rows, transform.xyz)
        taken.height_map, messages = make_height_map(triangles, grid, frame)
    except ExtractProblem as problem:
        taken.diagnostics.append(problem.diagnostic)
        return
    taken.diagnostics += messages
    taken.frame = frame
    text = height_map_yaml(frame, taken.height_map, "calculated", f"top of {', '.join(part.meshes)}")
    taken.files["heightmap.yaml"] = _head("heightmap", package) + text


def _head(title: str, package: str) -> str:
    return f"{MARK} factory: {title} of the package {package}. Numbers only; metres, radians.\n"


def _joints_yaml(source: RobotSource, package: str) -> str:
    """Return all joints with the digits of the package, and the accepted violations of rules about them."""
    joints, accepted = source.tree.get("joints") or {}, source.tree.get("accept")
    document: dict[str, Any] = {
        "source": {"status": "factory", "note": f"description package {package}"},
        "joints": {name: {key: _plain(joint, key) for key in joint if key in _KEYS} for name, joint in joints.items()},
    }
    entries = [entry for entry in accepted or () if not entry["rule"].startswith(_NOT_TAKEN)]
    if entries:
        document["accept"] = [{key: _plain(entry, key) for key in entry} for entry in entries]
    return _head("joints", package) + layout(document)


def _plain(holder: Map | Seq, key: Any) -> Any:
    """Return a value of a tree as ``layout`` takes it, numbers as they are written in the source."""
    value = holder[key]
    if isinstance(value, Map):
        return {inner: _plain(value, inner) for inner in value}
    if isinstance(value, Seq):
        return [_plain(value, index) for index in range(len(value))]
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return number(value)
    return value if isinstance(value, bool) else str(value)
