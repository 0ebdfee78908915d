"""Description: the plain tree of a robot as the files of a description, as a person would have written them.

``write`` says which file holds what, and ``named`` which values get a name
because they repeat.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from rosorin_compile.diagnostics import Span
from rosorin_compile.extending import Description, Imported, Map, Outputs, Path, Seq, expression_names

from .layout import Expression, Verbatim, angle_of, layout, number, placed, within_part

MAX_LINES = 150  # a longer description is split into files
PARTS, LINKS, JOINTS = "parts.yaml", "links.yaml", "joints.yaml"
SIMULATION, EXTENSIONS = "simulation.yaml", "extensions.yaml"
SENSORS, CONTROL, MOVEIT = "sensors.yaml", "control.yaml", "moveit.yaml"

_HEAD = ("rosorin_compile", "robot", "source", "include", "args", "let")
_TAIL = (
    *("modes", "publishers", "edges", "poses", "drive", "control", "controllers", "moveit", "disabled_contacts"),
    *("accept", "outputs"),
)
_FILES = {
    PARTS: ("parts",),
    LINKS: ("materials", "links"),
    JOINTS: ("joints",),
    SIMULATION: (
        *("root", "actuators", "tendons", "constraints", "mjcf_sensors", "contact_layers", "contact_pairs"),
        "mjcf_elements",
    ),
    SENSORS: ("sensors",),
    CONTROL: ("control",),
    EXTENSIONS: ("urdf_elements",),
    MOVEIT: ("moveit",),
}
_ABOUT = {
    PARTS: "The parts: what the robot has several times, written once; robot.yaml uses them.",
    LINKS: "The links: masses, what they look like, what they collide with.",
    JOINTS: "The joints: how the links hang together.",
    SIMULATION: "What only a simulation has: how the robot stands, what drives it, what it measures and touches.",
    SENSORS: "The sensors: what each measures, and what Gazebo has of it.",
    CONTROL: "The hardware of ros2_control.",
    EXTENSIONS: "What the language has no word for, as it stood in the source.",
    MOVEIT: "What MoveIt has to know beside the URDF: groups of joints, end effectors, pairs that it need not check.",
}
# Sections in an entry whose keys are names: of a pose, a tendon, a link.
_NAMED_SECTIONS = ("positions", "pulses", "controls", "joints", "sites", "cameras", "lights")
# And in one of these sections also others.
_NAMED_WITHIN = {
    "control": ("params", "sensors", "gpio", "transmissions", "actuators", "command", "state"),
    "sensors": ("with",),
}

# The order in which a person says things; what is not here comes after, in the order of the source.
_ORDER = (
    "name type part plugin prefix parent child frame optical box cylinder capsule sphere ellipsoid mesh height_map "
    "file mass size radius length radii xyz rpy mirror with inertia ixx iyy izz ixy ixz iyz inertial visual collision "
    "axis limit lower upper effort velocity mimic joint multiplier offset dynamics damping friction armature stiffness "
    "spring_reference calibration "
    "safety_controller material rgba texture kind tendon site links joints shapes kp kv damping_ratio gear range force "
    "layers touches contact actuator publisher optical sites cameras lights gravity_compensation source mjcf "
    "urdf_elements mjcf_elements"
)
_RANK = {key: rank for rank, key in enumerate(_ORDER.split())}

# What the language takes when nothing is said, by the last two keys of a path.
_DEFAULTS: dict[tuple[str, str], Any] = {
    ("inertia", "ixy"): 0,
    ("inertia", "ixz"): 0,
    ("inertia", "iyz"): 0,
    ("mimic", "multiplier"): 1,
    ("mimic", "offset"): 0,
    ("mesh", "scale"): [1, 1, 1],
    ("dynamics", "damping"): 0,
    ("dynamics", "friction"): 0,
    ("dynamics", "armature"): 0,
}
_POSED = ("links", "joints")  # where xyz and rpy are zero by default


def tree_of(imported: Imported) -> Map:
    """Return the tree of a source. Raises ValueError for a broken one, which has none."""
    if imported.tree is None:
        raise ValueError("a broken source has no tree")
    return imported.tree


def write(imported: Imported, wanted: Outputs, schema: str = "", split: bool | None = None) -> dict[str, str]:
    """Return the files of a description, text by name; the first is ``robot.yaml``.

    The tree has to be there. ``schema`` is where editors find the schema, from the folder of the files. ``split`` says
    whether it is several files; without it a long one is. The result is the same for the same tree, whatever the
    machine.
    """
    document = _Document(tree_of(imported)).made(wanted)
    head = [f"yaml-language-server: $schema={schema}"] if schema else []
    few = sum(len(value) for value in document.values() if isinstance(value, dict)) <= MAX_LINES
    if split is False or (split is None and few):
        whole = _file(Description.ROOT_FILE, document, imported, wanted, head)
        if split is False or whole.count("\n") <= MAX_LINES:
            return {Description.ROOT_FILE: whole}
    parts = {name: {key: document.pop(key) for key in keys if key in document} for name, keys in _FILES.items()}
    parts = {name: part for name, part in parts.items() if part}
    document["include"] = list(parts)
    files = {Description.ROOT_FILE: _file(Description.ROOT_FILE, _sorted(document), imported, wanted, head)}
    for name, part in parts.items():
        source = {"source": document["source"]} if "source" in document else {}
        files[name] = _file(name, {**source, **part}, imported, wanted, head)
    return files


def lines_of(tree: Map) -> int:
    """Return how many lines some sections of a description take."""
    made = _Document(tree)
    return layout({key: made.value(value, (key,), None) for key, value in tree.items()}).count("\n")


def _file(name: str, document: dict[str, Any], imported: Imported, wanted: Outputs, head: list[str]) -> str:
    """Return the text of one file."""
    root = name == Description.ROOT_FILE
    said = placed(imported.comments, document, head if root else [*head, _ABOUT[name]], root)
    if root and wanted.lines:
        inside = {**said.inside, ("outputs",): wanted.lines}
        said = said._replace(inside=inside)
    return layout(document, said)


def _sorted(document: dict[str, Any]) -> dict[str, Any]:
    """Return the sections of a file in the order of a description."""
    rank = {key: place for place, key in enumerate((*_HEAD, *(k for keys in _FILES.values() for k in keys)))}
    rank |= {key: 1000 + place for place, key in enumerate(_TAIL)}
    ranked = {**rank, "use": rank["joints"] + 0.5}  # they hang on links, as joints do
    return dict(sorted(document.items(), key=lambda item: ranked.get(item[0], 500)))


class _Document:
    """Turns a tree into the values of a document."""

    def __init__(self, tree: Map) -> None:
        self.tree = tree
        self.named: Named = named(tree)

    def made(self, wanted: Outputs) -> dict[str, Any]:
        """Return the document of the whole description."""
        body = {key: self.value(value, (key,), span) for key, value, span in _items(self.tree) if value}
        lets: dict[str, Any] = {**self.named.folders, **body.pop("let", {})}
        if self.named.scale is not None:
            lets["mesh_scale"] = self.value(self.named.scale, ("let", "mesh_scale"), None)
        document: dict[str, Any] = {"rosorin_compile": Verbatim("1"), **body}
        if lets:
            document["let"] = lets
        document["outputs"] = {name: _written(entry) for name, entry in wanted.entries.items()}
        return _sorted(document)

    def value(self, value: Any, path: Path, span: Span | None) -> Any:
        """Return one value as ``layout`` takes it."""
        if isinstance(value, Map):
            return self.mapping(value, path)
        if isinstance(value, Seq):
            if path[-2:] == ("mesh", "scale") and self.named.scale is not None:
                return Expression("${mesh_scale}")
            return [self.value(v, (*path, i), s) for i, (v, s) in enumerate(zip(value, value.value_spans, strict=True))]
        if isinstance(value, str):
            file = self.named.file(value) if path[-2:] == ("mesh", "file") else None
            return Expression(file) if file else value if isinstance(value, (Expression, Verbatim)) else str(value)
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            return number(value, span, angle_of(self.tree, path))
        return value

    def mapping(self, value: Map, path: Path) -> dict[str, Any]:
        """Return a mapping without what is said by default, in the order in which a person would say it."""
        made: dict[str, Any] = {}
        own = within_part(path)
        for key, item, span in _items(value):
            here = (*path, key)
            if not _is_default((*own, key), item):
                found = self.value(item, here, span)
                if found or key != "dynamics":
                    made[key] = found
        if len(own) > 1 and own[0] != "parts" and not _keeps_order(own):
            made = dict(sorted(made.items(), key=lambda entry: _RANK.get(entry[0], len(_RANK))))
        return made


def _keeps_order(path: Path) -> bool:
    """Say whether the keys at a path are names, or words of another program: they stay as they were."""
    return path[-1] in (*_NAMED_SECTIONS, *_NAMED_WITHIN.get(str(path[0]), ())) or path[2:4] == ("gazebo", "elements")


def _written(value: Any) -> Any:
    """Return an entry of the outputs as ``layout`` takes it."""
    if isinstance(value, Mapping):
        return {key: _written(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_written(item) for item in value]
    return number(value, None) if isinstance(value, (int, float)) and not isinstance(value, bool) else value


def _items(value: Map) -> Iterator[tuple[str, Any, Span | None]]:
    for key, item in value.items():
        yield key, item, value.value_spans.get(key)


def _is_default(path: Path, value: Any) -> bool:
    """Say whether a value is what the language takes when nothing is said."""
    if path[0] not in _POSED or len(path) < 3:
        return False
    if path[-1] in ("xyz", "rpy"):
        return isinstance(value, list) and not any(value)
    default = _DEFAULTS.get((str(path[-2]), str(path[-1])))
    return default is not None and not isinstance(value, bool) and bool(value == default)


MAX_NAME = 60
_FEW = 3  # fewer references to a folder are written out
_LONG = 20  # shorter folders are written out
_WORTH = 50  # so many letters less, at least, where a name stands for a folder
_SHAPES = ("visual", "collision")


class Named(NamedTuple):
    """What is named: mesh folders by name (without the slash at their end), and the scale of all meshes, if any."""

    folders: dict[str, str]
    scale: Seq | None

    def file(self, name: str) -> str | None:
        """Return a mesh file as an expression with the name of its folder, None if that has none."""
        for key, folder in self.folders.items():
            rest = name.removeprefix(f"{folder}/")
            if rest != name and (isinstance(name, Expression) or not _needs_escape(rest)):
                return f"${{{key}}}/{rest}"
        return None


def named(tree: Map) -> Named:
    """Return the values of a robot that are worth a name."""
    meshes = list(_meshes(tree))
    groups: dict[str, list[str]] = {}
    for mesh in meshes:
        file = mesh.get("file")
        if isinstance(file, str):
            groups.setdefault(_package(file), []).append(file)
    folders = {key: folder for key, files in groups.items() if (folder := _common_folder(files))}
    names: dict[str, str] = {}
    for key, folder in folders.items():
        wanted = "meshes" if len(folders) == 1 else f"{_identifier(key)}_meshes"
        names[_free(wanted, names)] = folder
    return Named(names, _common_scale(meshes))


def _meshes(tree: Map) -> Iterator[Map]:
    """Yield every mesh of a robot."""
    sections = [tree, *(part for part in (tree.get("parts") or {}).values() if isinstance(part, Map))]
    for link in (link for section in sections for link in (section.get("links") or {}).values()):
        for purpose in _SHAPES if isinstance(link, Map) else ():
            for shape in link.get(purpose) or ():
                if isinstance(shape, Map) and isinstance(shape.get("mesh"), Map):
                    yield shape["mesh"]


def _package(file: str) -> str:
    """Return the package of a mesh reference, empty for a path or another address."""
    scheme, mark, rest = file.partition("://")
    return rest.partition("/")[0] if mark and scheme in ("package", "model") else ""


def _common_folder(files: list[str]) -> str:
    """Return the longest folder that all files stand in; empty if that is none, or too short or rare for a name."""
    if len(files) < _FEW or len(set(files)) < 2:
        return ""
    first, last = min(files), max(files)
    length = next((i for i, (a, b) in enumerate(zip(first, last, strict=False)) if a != b), min(len(first), len(last)))
    folder = first[:length].rpartition("/")[0]
    saved = (len(folder) - len("${meshes}")) * len(files)
    worth = len(folder) >= _LONG and saved >= _WORTH and not folder.endswith((":", ":/"))
    return folder if worth and not _needs_escape(folder) else ""


def _needs_escape(text: str) -> bool:
    return "${" in text or "$(" in text


def _common_scale(meshes: list[Map]) -> Seq | None:
    """Return the scale that all meshes have, None if they have different ones, none, or are few."""
    scales = [mesh.get("scale") for mesh in meshes]
    first: Any = scales[0] if len(scales) >= _FEW else None
    same = isinstance(first, Seq) and all(scale == first for scale in scales) and list(first) != [1, 1, 1]
    same = same and not any(isinstance(number, str) for number in first)  # a part has its own
    return first if same else None


def _identifier(text: str) -> str:
    """Return a name for expressions that is like a text."""
    made = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_").lower()
    return made if made and not made[0].isdigit() else f"other_{made}".strip("_")


def _free(wanted: str, taken: dict[str, str]) -> str:
    """Return a name that no other value, unit or function has."""
    name, count, known = wanted, 1, expression_names()
    while name in taken or name in known.units or name in known.functions:
        count += 1
        name = f"{wanted}_{count}"
    return name
