"""Prefixing: a foreign robot gets a prefix before all of its names, in elements that are kept as they are too.

``relative_files`` makes the names of its meshes and textures relative to the description.
"""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any

from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.tree import Instance, Map, Seq, Text
from rosorin_compile.source.xml.markup import TEXT, Attribute, Element, MarkupError, Remark, parse

from ..element_names import files_in, with_files
from ..schema import sections
from ..symbols import THINGS, SymbolTable
from .forms import OF_MJCF
from .placing import placed

# Elements that have a name of their own, by the element around: two arms must not have the same ones.
_OWN_NAMES = {
    ("robot", "ros2_control"),
    ("robot", "transmission"),
    ("transmission", "actuator"),
    ("ros2_control", "gpio"),
    ("ros2_control", "sensor"),
}
# Elements whose name is a word of some other program, whatever the links are called.
_WORDS = {"command_interface", "state_interface", "param", "plugin", "property"}
_NO_NAMES = ("topic", "service", "namespace", "remapping", "uri", "filename", "material")


def prefixed(tree: Map, prefix: str, via: Instance) -> tuple[Map, Counter[str]]:
    """Return the sections of an imported robot with ``prefix`` before its names; ``via`` tells how it came here.

    Also the names that were changed inside kept elements, each with how often.
    """
    fragment = Map(tree.span, via)
    for key, value in tree.items():
        if key not in sections() or not sections()[key].whole:
            fragment.put(key, value, tree.key_spans[key], tree.value_spans[key])
    names, materials = SymbolTable(fragment).names().among(THINGS), frozenset(fragment.get("materials") or ())
    fragment = placed(fragment, prefix, None, None, None, None, kept=False)
    changed: Counter[str] = Counter()
    if not prefix:
        return fragment, changed
    renamer = _Renamer(prefix, names, materials, changed)
    made = Map(fragment.span, via)
    for key, value in fragment.items():
        made.put(key, renamer.section(key, value), fragment.key_spans[key], fragment.value_spans[key])
    return made, changed


class _Renamer:
    """Renames what a part of a description cannot have: materials, accepted rules, kept elements."""

    def __init__(self, prefix: str, names: Collection[str], materials: Collection[str], changed: Counter[str]) -> None:
        self.prefix = prefix
        self.names = names
        self.materials = materials
        self.changed = changed

    def section(self, key: str, value: Any) -> Any:
        if key == "materials":
            made = Map(value.span, value.via)
            for name, entry in value.items():
                made.put(self.prefix + name, entry, value.key_spans[name], value.value_spans[name])
            return made
        return self._accepted(value) if key == "accept" else self._inside(key, value)

    def _inside(self, key: str, value: Any) -> Any:
        """Return a value with the kept elements in it renamed."""
        if isinstance(value, Map):
            made = Map(value.span, value.via)
            for name, item in value.items():
                made.put(name, self._inside(name, item), value.key_spans[name], value.value_spans[name])
            return made
        if isinstance(value, Seq):
            listed = Seq(value.span, value.via)
            for item, span in zip(value, value.value_spans, strict=True):
                listed.put(self.elements(item) if key == "urdf_elements" else self._inside("", item), span)
            return listed
        return value

    def _accepted(self, entries: Seq) -> Seq:
        """Return the entries of ``accept`` about the new names; a frame with a prefix is none of the world any more."""
        made = Seq(entries.span, entries.via)
        for entry, span in zip(entries, entries.value_spans, strict=True):
            if entry["rule"] == "owns-world-frame":
                continue
            renamed = Map(entry.span, entry.via)
            for key, value in entry.items():
                of = self._renamed(value) if key == "of" else value
                renamed.put(key, of, entry.key_spans[key], entry.value_spans[key])
            made.put(renamed, span)
        return made

    def _renamed(self, names: Seq) -> Seq:
        made = Seq(names.span)
        for name, place in zip(names, names.value_spans, strict=True):
            made.put(self.prefix + name if name in self.names else name, place)
        return made

    def elements(self, text: str) -> str:
        """Return elements of XML in which what is exactly a name of the robot has the prefix; all else is as it was."""
        before = "<robot>"
        try:
            document = parse(Source("", f"{before}{text}</robot>"))
        except MarkupError:  # deeper than what is read: it is left as it is
            return text
        places: list[int] = []
        for element in document.root.iter():
            places += self._attributes(element)
            places += self._texts(element, document.source.text)
        made = document.source.text
        for place in sorted(places, reverse=True):
            made = made[:place] + self.prefix + made[place:]
        return Text(made[len(before) : -len("</robot>")])

    def _attributes(self, element: Element) -> list[int]:
        places = []
        above = element.parent.tag if element.parent is not None else ""
        for attribute in element.attributes.values():
            if self._is_name(element, above, attribute):
                self.changed[attribute.value] += 1
                places.append(attribute.start)
        return places

    def _is_name(self, element: Element, above: str, attribute: Attribute) -> bool:
        name = attribute.name
        if not attribute.value or attribute.raw != attribute.value or _says_no_name(name):
            return False
        if name == "name" and (above, element.tag) in _OWN_NAMES:
            return True
        if name == "name" and element.tag == "material":
            return attribute.value in self.materials
        return attribute.value in self.names and not (name == "name" and element.tag in _WORDS)

    def _texts(self, element: Element, text: str) -> list[int]:
        content = element.content
        if len(content) != 1 or not isinstance(content[0], Remark) or content[0].kind != TEXT:
            return []
        name = content[0].text.strip()
        start = content[0].start
        if name not in self.names or _says_no_name(element.tag) or not text.startswith(name, start):
            return []
        self.changed[name] += 1
        return [start]


def _says_no_name(word: str) -> bool:
    """Say whether an element or attribute of this name never holds the name of a link or joint."""
    return any(part in word.lower() for part in _NO_NAMES)


# An address, an absolute path, or one with the letter of a drive.
_ABSOLUTE = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*:|/|\\\\")
_ARTIFACTS = "outputs"  # they are files too, of another kind
_NAMES = "mjcf"  # has names of textures, not files


def relative_files(tree: Map) -> list[str]:
    """Return the relative names of mesh and texture files in the tree of a robot, each once, in their order."""
    sections = [value for key, value in tree.items() if key != _ARTIFACTS]
    names = [node[key] for section in sections for node, key in _places(section)]
    kept = [file for text in _kept(tree) for file in files_in(text) if not _ABSOLUTE.match(file)]
    return list(dict.fromkeys([*names, *kept]))


def moved(tree: Map, folder: str) -> Map:
    """Return the tree of a robot in which ``folder`` stands before the relative names of mesh and texture files."""
    before = f"{folder.rstrip('/')}/"
    return with_files_named(tree, lambda name: name if _ABSOLUTE.match(name) else before + name)


def with_files_named(tree: Map, name: Callable[[str], str]) -> Map:
    """Return the tree of a robot in which each name of a mesh or texture file is what ``name`` makes of it."""
    made = Map(tree.span, tree.via)
    for key, value in tree.items():
        value = value if key == _ARTIFACTS else _copied(value, name, key)
        made.put(key, value, tree.key_spans[key], tree.value_spans[key])
    return made


def from_one_folder(base: Path, places: Mapping[str, str]) -> tuple[Path, dict[str, str]]:
    """Return the nearest folder, ``base`` or one above it, that has some files, and what they are called from there.

    ``places`` are absolute paths by the names that the files have so far.
    """
    top = Path(os.path.commonpath([base, *places.values()]))
    return top, {name: Path(os.path.relpath(path, top)).as_posix() for name, path in places.items()}


def _copied(node: Any, name: Callable[[str], str], under: str = "") -> Any:
    if isinstance(node, Map):
        made = Map(node.span, node.via)
        for key, value in node.items():
            is_file = under != _NAMES and _is_file(node, key)
            made.put(
                key, name(value) if is_file else _copied(value, name, key), node.key_spans[key], node.value_spans[key]
            )
        return made
    if isinstance(node, Seq):
        listed = Seq(node.span, node.via)
        for item, span in zip(node, node.value_spans, strict=True):
            listed.put(_copied(item, name, under), span)
        return listed
    if under == OF_MJCF and isinstance(node, str):
        return with_files(node, name)
    return node


def _places(node: Any, under: str = "") -> list[tuple[Map, str]]:
    """Return the maps and keys whose values are relative names of files."""
    if isinstance(node, Map):
        own = [(node, key) for key in node if under != _NAMES and _is_relative(node, key)]
        return own + [place for key, value in node.items() for place in _places(value, key)]
    return [place for item in node for place in _places(item, under)] if isinstance(node, Seq) else []


def _kept(node: Any, under: str = "") -> list[str]:
    """Return the elements of MJCF that are kept as they are."""
    if isinstance(node, Map):
        return [text for key, value in node.items() for text in _kept(value, key)]
    if isinstance(node, Seq):
        return [text for item in node for text in _kept(item, under)]
    return [node] if under == OF_MJCF and isinstance(node, str) else []


def _is_relative(node: Map, key: str) -> bool:
    """Say whether a value is the relative name of a file."""
    return _is_file(node, key) and not _ABSOLUTE.match(node[key])


def _is_file(node: Map, key: str) -> bool:
    """Say whether a value is the name of a file: ``file`` of a mesh, or a ``texture``."""
    return key in ("file", "texture") and isinstance(node[key], str)
