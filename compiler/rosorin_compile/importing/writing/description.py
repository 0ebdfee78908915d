"""Writing: the plain tree of a robot as the files of a description, as a person would have written them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from ...diagnostic import Span
from ...emit import FORMATS
from ...project import ROOT_FILE
from ...tree import Map, Path, Seq
from ..imported import Imported
from .layout import Expression, Verbatim, layout
from .naming import Named, named, safe
from .numbers import angle_of, number
from .remarks import placed

MAX_LINES = 150  # a longer description is split into files
LINKS, JOINTS, EXTENSIONS = "links.yaml", "joints.yaml", "extensions.yaml"

_HEAD = ("rosorin_compile", "robot", "source", "include", "args", "let")
_TAIL = ("poses", "disabled_contacts", "accept", "outputs")
_FILES = {LINKS: ("materials", "links"), JOINTS: ("joints",), EXTENSIONS: ("urdf_elements",)}
_ABOUT = {
    LINKS: "The links: masses, what they look like, what they collide with.",
    JOINTS: "The joints: how the links hang together.",
    EXTENSIONS: "What the language has no word for, as it stood in the source.",
}
_NAMED_SECTIONS = ("positions", "pulses")  # of a pose: their keys are names of joints

# The order in which a person says things; what is not here comes after, in the order of the source.
_ORDER = (
    "name type parent child frame box cylinder capsule sphere mesh height_map file mass size radius length xyz "
    "rpy inertia ixx iyy izz ixy ixz iyz inertial visual collision axis limit lower upper effort velocity mimic "
    "joint multiplier offset dynamics damping friction armature calibration safety_controller material rgba "
    "texture actuator publisher optical source urdf_elements"
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


class Outputs(NamedTuple):
    """The artifacts that a description asks for: entries of its section, and by format what is not usual in it.

    ``left_out`` are the formats that it does not ask for, each with the reason.
    """

    entries: dict[str, Mapping[str, str]]
    remarks: dict[str, str]
    left_out: dict[str, str]

    @property
    def lines(self) -> list[str]:
        """The remarks as comments of the section."""
        return [*self.remarks.values(), *(f"no {name}: {reason}" for name, reason in self.left_out.items())]


def tree_of(imported: Imported) -> Map:
    """Return the tree of a source. Raises ValueError for a broken one, which has none."""
    if imported.tree is None:
        raise ValueError("a broken source has no tree")
    return imported.tree


def outputs(imported: Imported, why: str = "") -> Outputs:
    """Return what the description of a robot asks for; ``why`` it is to go without optional formats."""
    tree = tree_of(imported)
    made = Outputs({}, {}, {})
    for format in FORMATS.values():
        if format.asked is None:
            continue
        if format.optional and why:
            made.left_out[format.name] = why
            continue
        asked = format.asked(tree, imported.version, safe(tree["robot"]))
        made.entries[format.name] = asked.entry
        if asked.remark:
            made.remarks[format.name] = asked.remark
    return made


def write(imported: Imported, wanted: Outputs, schema: str = "") -> dict[str, str]:
    """Return the files of a description, text by name; the first is ``robot.yaml``.

    The tree has to be there. ``schema`` is where editors find the schema, from the folder of the files. The result is
    the same for the same tree, whatever the machine.
    """
    document = _Document(tree_of(imported)).made(wanted)
    head = [f"yaml-language-server: $schema={schema}"] if schema else []
    if sum(len(value) for value in document.values() if isinstance(value, dict)) <= MAX_LINES:
        whole = _file(ROOT_FILE, document, imported, wanted, head)
        if whole.count("\n") <= MAX_LINES:
            return {ROOT_FILE: whole}
    parts = {name: {key: document.pop(key) for key in keys if key in document} for name, keys in _FILES.items()}
    parts = {name: part for name, part in parts.items() if part}
    document["include"] = list(parts)
    files = {ROOT_FILE: _file(ROOT_FILE, _sorted(document), imported, wanted, head)}
    for name, part in parts.items():
        source = {"source": document["source"]} if "source" in document else {}
        files[name] = _file(name, {**source, **part}, imported, wanted, head)
    return files


def _file(name: str, document: dict[str, Any], imported: Imported, wanted: Outputs, head: list[str]) -> str:
    """Return the text of one file."""
    root = name == ROOT_FILE
    said = placed(imported.comments, document, head if root else [*head, _ABOUT[name]], root)
    if root and wanted.lines:
        inside = {**said.inside, ("outputs",): wanted.lines}
        said = said._replace(inside=inside)
    return layout(document, said)


def _sorted(document: dict[str, Any]) -> dict[str, Any]:
    """Return the sections of a file in the order of a description."""
    rank = {key: place for place, key in enumerate((*_HEAD, *(k for keys in _FILES.values() for k in keys)))}
    rank |= {key: 1000 + place for place, key in enumerate(_TAIL)}
    return dict(sorted(document.items(), key=lambda item: rank.get(item[0], 500)))


class _Document:
    """Turns a tree into the values of a document."""

    def __init__(self, tree: Map) -> None:
        self.tree = tree
        self.named: Named = named(tree)

    def made(self, wanted: Outputs) -> dict[str, Any]:
        """Return the document of the whole description."""
        body = {key: self.value(value, (key,), span) for key, value, span in _items(self.tree) if value}
        lets: dict[str, Any] = dict(self.named.folders)
        if self.named.scale is not None:
            lets["mesh_scale"] = self.value(self.named.scale, ("let", "mesh_scale"), None)
        document: dict[str, Any] = {"rosorin_compile": Verbatim("1"), **body}
        if lets:
            document["let"] = lets
        document["outputs"] = {name: dict(entry) for name, entry in wanted.entries.items()}
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
            return Expression(file) if file else str(value)
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            return number(value, span, angle_of(self.tree, path))
        return value

    def mapping(self, value: Map, path: Path) -> dict[str, Any]:
        """Return a mapping without what is said by default, in the order in which a person would say it."""
        made: dict[str, Any] = {}
        for key, item, span in _items(value):
            here = (*path, key)
            if not _is_default(here, item):
                found = self.value(item, here, span)
                if found or key != "dynamics":
                    made[key] = found
        if len(path) > 1 and path[-1] not in _NAMED_SECTIONS:
            made = dict(sorted(made.items(), key=lambda entry: _RANK.get(entry[0], len(_RANK))))
        return made


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
