"""page: one self-contained HTML file that shows the robot in a browser, without a network or any other file.

``data`` is what the page is fed with, ``html`` puts it, the program (package data, built from ``viewer/``) and the
meshes into one text. The command ``view`` serves the same page.
"""

from __future__ import annotations

import json
import re
from base64 import b64encode
from collections.abc import Mapping
from functools import cache
from html import escape
from pathlib import Path, PurePosixPath
from typing import Any

from rosorin_compile.formats.format import NODES, PLACES, SHAPES, UNPUBLISHED, Format
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Output, Robot
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, counted, first_of, listed
from rosorin_compile.source.load import json_of
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import data_folder
from rosorin_compile.source.rule_registry import Heading, Rule

from .data import Data, mesh_names, robot_data, texture_names
from .images import Side, companion_files, image_type

RULES = (
    Rule(
        "page-left-out",
        "A warning: a mesh is not in the page, because it is not found, of a kind that no browser reads, or too large;"
        " or an image is not, because a mesh names it outside of the project.",
        "`meshes: false` in the output leaves all of them out; `max_megabytes` allows more.",
        Heading.FORMATS,
    ),
)

# What the loaders of the page read, by the ending of a file.
MESHES: Mapping[str, str] = {".stl": "stl", ".obj": "obj", ".dae": "dae", ".glb": "glb"}
_SHAPES = (*MESHES, ".ply", ".msh", ".gltf")  # endings of meshes; what else is left out is an image
MAX_MEGABYTES = 40
_SHOWN = 3
_SHOWN_OF = {
    "name": "the name",
    "joints": "joints",
    "sensors": "sensors",
    "poses": "poses",
    "modes": "modes",
    "situations": "who publishes what",
    "meshes": "meshes",
    "textures": "textures",
}

# The page asks nothing from anywhere: a browser holds it to that.
_ALONE = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src {0}data: blob:; connect-src {0}data: blob:"
)
_DATA = re.compile(r'<script type="application/json" id="robot">(.*?)</script>', re.DOTALL)


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:  # noqa: ARG001
    """Return the page of a robot. Options: ``meshes`` (false: without), ``max_megabytes`` (of all meshes together)."""
    data = robot_data(robot)
    if not output.options.get("meshes", True):
        return html({"robot": data}), []
    limit = int(output.options.get("max_megabytes", MAX_MEGABYTES) * 1_000_000)
    embedding = Embedding(limit)
    embedding.take(data, robot, robot.mesh_files)
    return html({"robot": data}), [_left_out(embedding.left)] if embedding.left else []


class Embedding:
    """Meshes and images as text in a page; ``limit`` is what all of them may have in bytes, ``left`` why some are not.

    What several robots of a page share counts for each: it is in it as often.
    """

    def __init__(self, limit: int) -> None:
        self.limit = limit
        self.size = 0
        self.left: dict[str, str] = {}

    def take(self, data: Data, robot: Robot, files: Mapping[str, Path]) -> None:
        """Put the meshes and the images of a robot into its data."""
        names = list(mesh_names(robot))
        data["meshes"] = {}
        for number, name in enumerate(names):
            Progress.step("reading meshes", number, len(names))
            data["meshes"][name] = self._mesh(name, files.get(name))
        if "textures" in data:
            data["textures"] = {name: self._image(name, files.get(name)) for name in texture_names(robot)}

    def _mesh(self, name: str, file: Path | None) -> Data:
        kind = MESHES.get(PurePosixPath(name).suffix.lower())
        if kind is None or file is None:
            return self._without(name, "not found" if file is None else "no browser reads it")
        content = self._content(name, file)
        if content is None:
            return {"missing": self.left[name]}
        sides, vain = companion_files(file, content, name)
        for image, why in vain.items():
            self._without(image, why)
        made = {"format": kind, "data": b64encode(content).decode("ascii")}
        own = {side.name: taken for side in sides if (taken := self._side(side))}
        return {**made, "files": own} if own else made

    def _image(self, name: str, file: Path | None) -> Data:
        kind = image_type(file) if file is not None else ""
        if file is None or not kind:
            return self._without(name, "not found" if file is None else "no browser reads it")
        return self._side(Side(name, file, kind)) or {"missing": self.left[name]}

    def _side(self, side: Side) -> Data | None:
        content = self._content(side.name, side.file)
        return None if content is None else {"type": side.type, "data": b64encode(content).decode("ascii")}

    def _content(self, name: str, file: Path) -> bytes | None:
        """Return a file, if there is room for it."""
        try:
            content = files.read_bytes(file)
        except OSError as problem:
            self._without(name, problem.strerror or "it cannot be read")
            return None
        if self.size + len(content) > self.limit:
            self._without(name, f"more than {self.limit / 1e6:g} MB of meshes")
            return None
        self.size += len(content)
        return content

    def _without(self, name: str, why: str) -> Data:
        self.left[name] = why
        return {"missing": why}


def left_out(left: Mapping[str, str]) -> str:
    """Return which meshes and images a page does not show, and why."""
    images = [name for name in left if PurePosixPath(name).suffix.lower() not in _SHAPES]
    kind = "mesh" if not images else "texture" if len(images) == len(left) else "file"
    return f"{counted(len(left), kind)} ({first_of(list(left), _SHOWN)}): {', '.join(dict.fromkeys(left.values()))}"


def _left_out(left: Mapping[str, str]) -> Diagnostic:
    """Return the warning about meshes that the page does not show."""
    help = "meshes: false leaves out all; max_megabytes: NUMBER allows more"
    return Diagnostic("page-left-out", WARNING, f"the page does not show {left_out(left)}", help=help)


def html(data: Data, live: str = "") -> str:
    """Return the page that shows what ``data`` says.

    ``live`` is a name for this version of it: the page asks the server that it came from for newer ones. Only such a
    page may have no robot yet.
    """
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    policy = _ALONE.format("'self' " if live else "")
    name = escape(str(data["robot"]["name"] if data["robot"] else "rosorin-compile"))
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        "<!-- Generated by rosorin-compile from the description of the robot; edits here are lost. -->\n"
        f"<title>{name}</title>\n<style>\n{_part('page.css')}</style>\n</head>\n"
        f'<body data-live="{live}">\n<div id="app"></div>\n'
        f'<script type="application/json" id="robot">{_in_script(text)}</script>\n'
        f"<script>\n{_part('page.js')}</script>\n</body>\n</html>\n"
    )


@cache
def _part(name: str) -> str:
    """Return a part of the page that ships with the tool, as it may stand in an element."""
    text = files.read_text(data_folder("viewer") / name)
    return re.sub(r"</(?=script|style)", r"<\\/", text, flags=re.IGNORECASE)


def _in_script(text: str) -> str:
    """Return JSON that may stand in a script: nothing in it begins a tag, and no letter ends a line of JavaScript."""
    for letter in "<>&\u2028\u2029":
        text = text.replace(letter, f"\\u{ord(letter):04x}")
    return text


def data_of(text: str) -> Any:
    """Return the data of a page. Raises ValueError if it is none of ours."""
    found = _DATA.search(text)
    if found is None:
        raise ValueError("the page holds no robot")
    return json_of(found[1])


def differ(old: str, new: str) -> str:
    """Return what differs between what two pages show; ``old`` may be damaged."""
    try:
        data_of(old)["robot"]["links"]
    except (KeyError, TypeError, ValueError):
        return "the committed file is damaged and compared as text alone"
    try:
        before, after = data_of(old)["robot"], data_of(new)["robot"]
        found = [what for key, what in _SHOWN_OF.items() if before.get(key) != after.get(key)]
        found += [f"shapes of {first_of(names, _SHOWN)}" for names in [_reshaped(before, after)] if names]
    except (KeyError, TypeError, ValueError):
        return ""
    if found:
        return f"what the page shows differs: {listed(found)}"
    return "the page shows the same robot, by another version of its program" if before == after else ""


def _reshaped(before: Data, after: Data) -> list[str]:
    """Return the links whose shapes or places of mass are others."""
    known = {link["name"]: link for link in before["links"]}
    return [link["name"] for link in after["links"] if known.get(link["name"]) != link]


FORMAT = Format(
    name="page",
    word="page of a robot",
    article="a",
    about="the robot to look at, in a browser",
    rank=90,
    covers=(
        *PLACES,
        *NODES,
        *UNPUBLISHED,
        *SHAPES,
        *("links.inertial", "links.visual.rgba", "links.visual.texture", "links.visual.material", "materials.rgba"),
        *("robot", "joints.type", "joints.axis"),
        *("joints.limit.lower", "joints.limit.upper", "joints.mimic.joint", "joints.mimic.multiplier"),
        *("joints.mimic.offset", "sensors.type", "sensors.joint", "sensors.gazebo.xyz", "sensors.gazebo.rpy", "servos"),
        *("poses.positions", "poses.pulses", "edges.parent", "edges.child", "edges.publisher", "edges.moving"),
        *("edges.when", "publishers.node"),
    ),
    options={
        "meshes": {"type": "boolean", "description": "Whether the meshes are in the page; default true."},
        "max_megabytes": {
            "type": "number",
            "exclusiveMinimum": 0,
            "description": f"How much all meshes of the page may have together; default {MAX_MEGABYTES}.",
        },
    },
    file="{}.html",
    endings=(".html",),
    write=write,
    embeds=True,
    schema="page",
    data=data_of,
    differ=differ,
    shown=False,
    folder="doc",
)
