"""Take the numbers of a ROS description package: joints, a box around each link, a height map.

Only numbers and names are taken; no mesh and no text of the package is copied.
"""

from __future__ import annotations

import re
from pathlib import Path

from rosorin_compile.formats import FORMATS
from rosorin_compile.model import Box
from rosorin_compile.model.mesh_triangles import ExtractProblem, TriangleMesh
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, RequestError, UnknownName, phrase
from rosorin_compile.source.files import is_file, is_folder, read_bytes
from rosorin_compile.source.progress import Progress

from ..description import _written
from ..layout import layout
from .height_map import make_height_map, summary
from .height_map_file import height_map_yaml
from .shapes import enclosing_box
from .sources import GridOptions, RobotSource

_POSE = ("type", "parent", "child", "xyz", "rpy", "axis")
_KEYS = (*_POSE, "limit", "mimic", "dynamics", "calibration", "safety_controller")
_NOT_TAKEN = ("mass-", "inertia-", "shape-")  # rules about values that are not taken
_DIGITS = 5
_MAX_BYTES = 5_000_000  # of a robot file
_ROBOT = re.compile(r"<robot\b[^>]*?\sname\s*=", re.DOTALL)
_INCLUDES = re.compile(r"<xacro:include\b[^>]*?\sfilename\s*=\s*[\"']([^\"']+)[\"']", re.DOTALL)
_CONDITION = re.compile(
    r"<xacro:(if|unless)\b[^>]*?\svalue\s*=\s*(\"[^\"]*\"|'[^']*')[^>]*>(.*?)</xacro:\1>", re.DOTALL
)
_PROPERTY = re.compile(r"<xacro:property\b[^>]*?\sname\s*=\s*[\"'](\w+)[\"'][^>]*?\svalue\s*=\s*[\"']([^\"']*)[\"']")
_VARIABLE = re.compile(r"""\$\((env|optenv|arg)\s+(\w+)[^()]*\)\s*['"]?\s*(?:[!=]=\s*['"]([^'"]*)['"])?""")


def find_robot_file(package: Path, requested: str | None) -> Path:
    """Return the requested file of a package, or the only one with a robot that no other file includes.

    Raises RequestError if there is no such package or file, else ExtractProblem.
    """
    if not is_folder(package):
        raise RequestError(f"{package} is not a folder; name the folder of a description package")
    published = FORMATS.published_format()
    formats = [one for one in FORMATS.values() if published.name in (one.name, one.becomes)]
    endings = {ending for one in formats for ending in one.endings}
    paths = [path for path in sorted(package.glob("**/*")) if path.suffix.lower() in endings and is_file(path)]
    texts = {path: read_bytes(path, _MAX_BYTES).decode("utf-8", "replace") for path in paths}
    included: set[Path] = set()
    for path, text in texts.items():
        for address in _INCLUDES.findall(text):
            # A name with an expression matches every file that fits: ${model}.xacro, $(arg model).xacro
            pieces = re.split(r"\$\{[^}]*\}|\$\([^)]*\)", address.rpartition("/")[2])
            pattern = re.compile(".+".join(map(re.escape, pieces)))
            included |= {other for other in texts if other != path and pattern.fullmatch(other.name)}
    candidates = [path for path, text in texts.items() if _ROBOT.search(text) and path not in included]
    choices = {path: choice for path in texts if path not in included and (choice := _choice(texts[path]))}
    if len(candidates) != 1:
        candidates = sorted({*candidates, *choices})
    names = [str(path.relative_to(package)) for path in candidates]
    if requested is not None:
        for path in (package / requested, Path(requested)):
            if is_file(path):
                return path
        raise UnknownName("file", requested, names, str(package))
    if len(candidates) == 1:
        return candidates[0]
    if not candidates:
        raise ExtractProblem.new("factory-robot", f"{package} has no file of a robot", "name one with --robot FILE")
    message = f"{package} has {len(names)} files of robots: {', '.join(names[:20])}"
    help = "select one with --robot FILE"
    if choices:
        message += "".join(f"; {path.relative_to(package)} {text}" for path, text in choices.items())
        help = f"use the file that chooses: --robot {next(iter(choices)).relative_to(package)}; or {help}"
    raise ExtractProblem.new("factory-robot", message, help)


def _choice(text: str) -> str:
    """Return by which variables a file with includes chooses, and the values it compares them with."""
    includes = _INCLUDES.findall(text)
    conditions = [value[1:-1] for _, value, content in _CONDITION.findall(text) if "<xacro:include" in content]
    conditions += [name for name in includes if "$" in name]
    properties = {
        name: f"$({variable[1]} {variable[2]})"
        for name, value in _PROPERTY.findall(text)
        if (variable := _VARIABLE.search(value))
    }
    values: dict[str, dict[str, None]] = {}
    for condition in conditions:
        expanded = re.sub(r"\w+", lambda word: properties.get(word[0], word[0]), condition)
        for source, name, value in _VARIABLE.findall(expanded):
            kind = "argument" if source == "arg" else "environment variable"
            values.setdefault(f"the {kind} {name}", {}).update({value: None} if value else {})
    chosen = [f"{name} ({', '.join(some)})" if some else name for name, some in values.items()]
    return f"chooses by {phrase(chosen)}" if chosen else ""


def choice_of(path: Path) -> list[Diagnostic]:
    """Return a note about the variables by which a robot file chooses, if it does."""
    choice = _choice(read_bytes(path, _MAX_BYTES).decode("utf-8", "replace"))
    help = "set the environment variable, or give the argument as NAME:=VALUE"
    return [Diagnostic("factory-robot", NOTE, f"{path} {choice}", help=help)] if choice else []


def take_numbers(
    source: RobotSource, package: str, map_link: str | None, frame: str | None, grid: GridOptions, section: str
) -> tuple[dict[str, str], list[str], str]:
    """Return YAML texts by title, the links with a box, and a line about the height map, empty if there is none.

    There is no height map without ``map_link``. Raises UnknownName for a link or frame that the robot does not have;
    other problems are diagnostics of the source.
    """
    frame, texts, line = frame or map_link, dict[str, str](), ""
    for link in filter(None, (map_link, frame)):
        source.link(link)
    boxes: dict[str, Box] = {}
    for index, link in enumerate(source.robot.link):
        Progress.step("measuring", index, len(source.robot.link))
        part = None if link == map_link else source.part(link, section)
        if part is not None:
            boxes[link] = enclosing_box(part.triangles, _DIGITS)
    if map_link is not None and frame is not None:
        part = source.part(map_link, section)
        try:
            if part is None:
                raise ExtractProblem.new("height-map-empty", f"{map_link} has no mesh that can be read: no height map")
            transform = source.robot.transform(frame, map_link, {})
            triangles = TriangleMesh.place(part.triangles, transform.rows, transform.xyz)
            height_map, messages = make_height_map(triangles, grid, frame)
            note = f"top of {', '.join(part.meshes)}"
            texts["heightmap"] = height_map_yaml(frame, height_map, "calculated", note)
            line = f"height map in {frame}: {summary(height_map)}"
            source.diagnostics += messages
        except ExtractProblem as problem:
            source.diagnostics.append(problem.diagnostic)
    # Joints have all their numbers, with the accepted violations of rules about them.
    joints = {
        name: {key: _written(value) for key, value in joint.items() if key in _KEYS}
        for name, joint in (source.tree.get("joints") or {}).items()
    }
    accepted = [one for one in source.tree.get("accept") or () if not one["rule"].startswith(_NOT_TAKEN)]
    document = {"source": {"status": "factory", "note": f"description package {package}"}, "joints": joints}
    texts["joints"] = layout({**document, "accept": _written(accepted)} if accepted else document)
    links = {
        link: {"collision": [{"box": {"min": _written(box.lower), "max": _written(box.upper)}}]} if box else {}
        for link in source.robot.link
        if (box := boxes.get(link)) or not (line and link == frame)
    }
    origin = {"status": "calculated", "note": f"boxes around the meshes of the package {package}"}
    texts["boxes"] = layout({"source": origin, "links": links})
    return texts, list(boxes), line
