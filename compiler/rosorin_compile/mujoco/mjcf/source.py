"""The text of an MJCF: read safely with all that it includes, so that all that MuJoCo tells has a place in it."""

from __future__ import annotations

import os
import posixpath
import shlex
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.formats.imported import ReadOptions
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Source, Span, error
from rosorin_compile.source.xml.markup import Attribute, Document, Element, MarkupError, mended, parse, read_source

MAX_DEPTH = 20  # of files that include files
_OWN = 4  # parts of the path of a folder that is somebody's own: /home/somebody/robots


class _Including(NamedTuple):
    """Who includes: the folders of its main file and of itself, what is included already, and by which files."""

    main: Path
    own: Path
    known: set[str]
    depth: int
    above: tuple[Path, ...] = ()


def _found(name: str, by: _Including) -> Path:
    """Return the file of a name: beside the main file, else beside the file that names it."""
    beside_main, beside_own = by.main / name, by.own / name
    return beside_own if not files.is_file(beside_main) and files.is_file(beside_own) else beside_main


def _absolute(path: Path) -> str:
    return os.path.abspath(path)


def _parsed(source: Source) -> Document:
    """Return a text as XML; MuJoCo reads it itself, and what it passes over is no fault. Raises MarkupError."""
    try:
        return parse(source)
    except MarkupError as problem:
        try:
            return parse(mended(source))
        except MarkupError:
            raise problem from None


_GROUPING = ("frame", "replicate")
_MAKERS = ("attach", "replicate", "flexcomp", "composite")


class Markup:
    """The main file and what it includes; ``files`` in the order of reading, ``children`` as if it were one file.

    As MuJoCo 4.0.0 finds them: an included file beside the main file, else beside the file that includes it. A model
    that is attached is a main file of its own; ``models`` are the folders of those, the main one first.
    """

    def __init__(self, path: Path, options: ReadOptions) -> None:
        self.allowed = [files.resolve(path).parent, *(files.resolve(folder) for folder in options.packages.values())]
        self.files: list[Path] = []
        self.documents: list[Document] = []
        self.included: dict[Element, Element] = {}
        self.models: list[Path] = []
        self.root = self._main(path, None, 0)

    def _main(self, path: Path, asked: Span | None, depth: int) -> Element:
        """Read a main file and all that it includes."""
        self.models.append(path.parent)
        root = self._read(path, asked)
        known = {_absolute(path)}
        for element in root.iter():
            self._follow(element, _Including(path.parent, path.parent, known, depth))
        return root

    def _read(self, path: Path, asked: Span | None) -> Element:
        document = _parsed(read_source(path, asked))
        self.files.append(path)
        self.documents.append(document)
        return document.root

    def _follow(self, element: Element, by: _Including) -> None:
        """Read the file that an element includes, and what that includes, or the model that it names."""
        file = element.attributes.get("file")
        if file is None or not file.value or element.tag not in ("include", "model"):
            return
        path = _found(file.value.replace("\\", "/"), by)  # MuJoCo takes both for a separator
        if not any(files.resolve(path).is_relative_to(folder) for folder in self.allowed):
            message = f"{file.value} lies outside the folder of the robot, and is not read"
            help = f"move it there, or allow its folder: --package {self._to_allow(path)}"
            raise MarkupError(error("include-outside", message, file.span, help))
        if by.depth == MAX_DEPTH:
            message = f"files include each other {MAX_DEPTH} levels deep"
            raise MarkupError(error("include-too-many", message, file.span, "join some"))
        if element.tag == "model":
            self._model(path, file.span, by.depth + 1)
            return
        self._check_new(file, path, by)
        by.known.add(_absolute(path))
        root = self.included[element] = self._read(path, file.span)
        for inner in root.iter():
            self._follow(inner, _Including(by.main, path.parent, by.known, by.depth + 1, (*by.above, path)))

    def _to_allow(self, path: Path) -> str:
        """Return the folder of the main file and of one outside, as --package takes it; no folder of many projects."""
        main, file = self.allowed[0], files.resolve(path)
        shared = [one for one in main.parents if file.is_relative_to(one) and len(one.parts) >= _OWN]
        if not shared or not files.is_file(path):
            return "NAME=FOLDER"
        return f"{shared[0].name}={shlex.quote(os.path.relpath(shared[0]))}"

    def _model(self, path: Path, asked: Span, depth: int) -> None:
        """Read a model that is attached, once however often it is named."""
        if _absolute(path) not in {_absolute(known) for known in self.files}:
            self._main(path, asked, depth)

    def _check_new(self, file: Attribute, path: Path, by: _Including) -> None:
        """Raise MarkupError for a file that is included already: MuJoCo goes by names, and follows no links."""
        if _absolute(path) not in by.known:
            return
        if path in by.above or _absolute(path) == _absolute(self.files[0]):
            raise MarkupError(error("include-cycle", f"{file.value} includes itself", file.span, "remove one include"))
        message = f"{file.value} is included a second time: MuJoCo includes a file once"
        raise MarkupError(error("mjcf-refused", message, file.span, "include a copy, or use a class"))

    def place_of(self, name: str) -> str:
        """Return the name of a mesh or texture as seen from the main file.

        MuJoCo names one that stands beside an included file by its whole path, and one of an attached model as that
        model does.
        """
        top = Path(os.path.abspath(self.models[0]))
        if posixpath.isabs(name):
            return Path(name).relative_to(top).as_posix() if Path(name).is_relative_to(top) else name
        folder = next((folder for folder in self.models if files.is_file(folder / name)), self.models[0])
        return posixpath.normpath(posixpath.join(Path(os.path.relpath(folder, self.models[0])).as_posix(), name))

    def children(self, element: Element) -> Iterator[Element]:
        """Yield the elements in an element, those of included files in place of the include."""
        for child in element.children:
            if child in self.included:
                yield from self.children(self.included[child])
            else:
                yield child

    def within(self, element: Element) -> Iterator[Element]:
        """Yield the elements in an element and in those, in the order of the text, without the element itself."""
        for child in self.children(element):
            yield child
            yield from self.within(child)

    def sections(self, tag: str) -> list[Element]:
        """Return the sections of a name: MuJoCo takes several of one name for one."""
        return [child for child in self.children(self.root) if child.tag == tag]

    def named(self, section: str, name: str) -> Element | None:
        """Return the element of a name in a section."""
        for part in self.sections(section):
            for element in self.within(part):
                if name and element.get("name") == name:
                    return element
        return None

    def listed(self, section: str, tag: str = "") -> list[Element]:
        """Return the elements directly in a section, in order."""
        return [e for part in self.sections(section) for e in self.children(part) if not tag or e.tag == tag]

    def everything(self) -> list[Element]:
        """Return all elements, those of included files in place of the includes."""
        return [self.root, *self.within(self.root)]


class Places:
    """Where each body, joint, geom, site, camera and light of the compiled model stands in the text."""

    def __init__(self, markup: Markup, facts: Mapping[str, Any]) -> None:
        self.markup = markup
        self.bodies: dict[int, Element] = {0: (markup.sections("worldbody") or [markup.root])[0]}
        self.exact: set[tuple[str, int]] = set()
        self.parts: dict[tuple[str, int], Element] = {}
        children: dict[int, list[int]] = {}
        for index, body in enumerate(facts["bodies"]):
            if index:
                children.setdefault(body["parent"], []).append(index)
        held = {kind: _by_body(facts[kind]) for kind in _TAGS}
        waiting: list[tuple[int, Sequence[Element]]] = [(0, markup.sections("worldbody"))]
        while waiting:
            index, containers = waiting.pop()
            for kind, tags in _TAGS.items():
                matched = self._match(containers, tags, [(at, facts[kind][at]) for at in held[kind].get(index, ())])
                self.parts |= {(kind, at): element for at, element in matched.items()}
            below = self._match(containers, ("body",), [(at, facts["bodies"][at]) for at in children.get(index, ())])
            self.bodies |= below
            waiting += [(at, [element]) for at, element in below.items()]

    def _match(
        self, containers: Sequence[Element], tags: Sequence[str], wanted: list[tuple[int, Mapping[str, Any]]]
    ) -> dict[int, Element]:
        """Return the element of each object: by order where nothing is repeated, else by name, else what holds it."""
        if not wanted:
            return {}
        elements = [element for container in containers for element in self._direct(container, tags)]
        if len(elements) == len(wanted):
            return {at: element for (at, _), element in zip(wanted, elements, strict=True)}
        holders = [e for c in containers for e in self.markup.within(c) if e.tag in _MAKERS]
        nameless = [element for element in elements if not element.get("name")]
        fallback = [*nameless, *holders, *containers, self.markup.root][0]
        names = {element.get("name"): element for element in elements}
        return {at: _called(names, thing["name"]) or fallback for at, thing in wanted}

    def _direct(self, container: Element, tags: Sequence[str]) -> Iterator[Element]:
        """Yield the elements of a body itself, not of the bodies in it."""
        for child in self.markup.children(container):
            if child.tag in tags:
                yield child
            elif child.tag in _GROUPING:
                yield from self._direct(child, tags)

    def body(self, index: int) -> Element:
        """Return the element of a body."""
        return self.bodies.get(index, self.markup.root)

    def of(self, kind: str, index: int) -> Element:
        """Return the element of a joint, geom, site or camera (``kind`` is the plural)."""
        return self.parts.get((kind, index), self.markup.root)


_TAGS = {
    "joints": ("joint", "freejoint"),
    "geoms": ("geom",),
    "sites": ("site",),
    "cameras": ("camera",),
    "lights": ("light",),
}


def _by_body(entries: Sequence[Mapping[str, Any]]) -> dict[int, list[int]]:
    held: dict[int, list[int]] = {}
    for index, entry in enumerate(entries):
        held.setdefault(entry["body"], []).append(index)
    return held


def _called(names: Mapping[str, Element], name: str) -> Element | None:
    """Return the element of a name; a replica's name is that of its element and a number."""
    if not name:
        return None
    return names.get(name) or names.get(name.rstrip("0123456789")) or None


def spans_of(attribute: Attribute | None, values: Sequence[float], span: Span) -> list[Span]:
    """Return the places of numbers: those of the digits of an attribute that says the very values, else ``span``."""
    words = attribute.words() if attribute else []
    if len(words) == len(values) and all(says(word.text, value) for word, value in zip(words, values, strict=True)):
        return [word.span for word in words]
    return [span] * len(values)


def says(text: str, value: float) -> bool:
    """Say whether a word is this very number."""
    try:
        return float(text) == value
    except ValueError:
        return False
