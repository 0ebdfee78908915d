"""The state of importing an MJCF: the compiled model, the XML with all includes, assigned names, and the description.

``check_source`` finds input that must not be passed to MuJoCo, ``refusal`` reports MuJoCo's errors.
"""

import os
import posixpath
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rosorin_compile.formats.format import cannot_carry
from rosorin_compile.formats.imported_robot import ReadOptions
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, Span, error
from rosorin_compile.source.messages import and_here
from rosorin_compile.source.tree import Map
from rosorin_compile.source.xml.markup import Attribute, Document, Element, MarkupError, parse, read_source, repair

from . import convert
from .convert import Attributes, Node, Words
from .engine import HELD
from .process import Answer

FREE, BALL, SLIDE, HINGE = range(4)
MAX_DEPTH = 20  # maximum depth of nested includes
_MAKERS = ("attach", "replicate", "flexcomp", "composite")
_FILE_HELP = "put the file where the MJCF looks for it: MuJoCo wants to see every mesh and texture"
_WORDS = ("name", "class", "childclass", "file", "model", "prefix", "material", "mesh", "texture", "group")


class Markup:
    """The XML of an MJCF and of all files that it includes; ``files`` are their paths in reading order.

    As in MuJoCo 4.0.0, an include is searched in the folder of the main file, then in that of the including file. An
    attached model is the main file for its includes. ``models`` are the folders of all main files.
    """

    def __init__(self, path: Path, options: ReadOptions) -> None:
        self.allowed = [files.resolve(path).parent, *(files.resolve(folder) for folder in options.packages.values())]
        self.files: list[Path] = []
        self.documents: list[Document] = []
        self.included: dict[Element, Element] = {}
        self.models: list[Path] = []
        self.root = self._model(path, None)

    def _model(self, path: Path, requested: Span | None, above: tuple[str, ...] = ()) -> Element:
        self.models.append(path.parent)
        root, absolute = self._read(path, requested), os.path.abspath(path)
        self._follow(root, path.parent, path.parent, {absolute}, (*above, absolute))
        return root

    def _read(self, path: Path, requested: Span | None) -> Element:
        source = read_source(path, requested)
        try:
            document = parse(source)
        except MarkupError as problem:
            try:
                document = parse(repair(source))
            except MarkupError:
                raise problem from None
        self.files.append(path)
        self.documents.append(document)
        return document.root

    def _follow(self, root: Element, main: Path, folder: Path, known: set[str], above: tuple[str, ...]) -> None:
        """Read all files that ``root`` includes; ``above`` are the files that include it, to detect cycles."""
        for element in root.iter():
            file = element.attributes.get("file")
            if file is None or not file.value or element.tag not in ("include", "model"):
                continue
            name = file.value.replace("\\", "/")  # MuJoCo accepts both path separators
            is_adjacent = not files.is_file(main / name) and files.is_file(folder / name)
            path, is_model = folder / name if is_adjacent else main / name, element.tag == "model"
            absolute = os.path.abspath(path)  # MuJoCo compares paths without resolving symlinks
            rule, message, help = "", "", ""
            if not any(files.resolve(path).is_relative_to(allowed) for allowed in self.allowed):
                rule, message = "include-outside", f"{file.value} is outside the folder of the robot, and is not read"
                help = "move it there, or allow its folder: --package NAME=FOLDER"
            elif len(above) > MAX_DEPTH:
                message = f"files include each other {MAX_DEPTH} levels deep"
                rule, help = "include-too-many", "join some"
            elif absolute in above and not is_model:
                rule, message, help = "include-cycle", f"{file.value} includes itself", "remove one include"
            elif absolute in known and not is_model:
                rule, message = "mjcf-refused", f"{file.value} is included a second time: MuJoCo includes a file once"
                help = "include a copy, or use a class"
            if rule:
                raise MarkupError(error(rule, message, file.span, help))
            if not is_model:
                known.add(absolute)
                self.included[element] = self._read(path, file.span)
                self._follow(self.included[element], main, path.parent, known, (*above, absolute))
            elif absolute not in {os.path.abspath(one) for one in self.files}:
                self._model(path, file.span, above)

    def place_of(self, name: str) -> str:
        """Return the path, relative to the main file, of a mesh or texture that any of the files refers to."""
        top = Path(os.path.abspath(self.models[0]))
        if posixpath.isabs(name):
            return Path(name).relative_to(top).as_posix() if Path(name).is_relative_to(top) else name
        folder = next((folder for folder in self.models if files.is_file(folder / name)), self.models[0])
        return posixpath.normpath(posixpath.join(Path(os.path.relpath(folder, self.models[0])).as_posix(), name))

    def child_elements(self, element: Element) -> Iterator[Element]:
        """Yield the children of an element, where each include is replaced by the contents of its file."""
        for child in element.children:
            if child in self.included:
                yield from self.child_elements(self.included[child])
            else:
                yield child

    def elements_below(self, element: Element) -> Iterator[Element]:
        """Yield all descendants of an element in document order."""
        for child in self.child_elements(element):
            yield child
            yield from self.elements_below(child)

    def all_elements(self) -> list[Element]:
        return [self.root, *self.elements_below(self.root)]

    def sections(self, tag: str) -> list[Element]:
        """Return all top-level elements with a tag; MuJoCo merges several sections with the same tag."""
        return [child for child in self.child_elements(self.root) if child.tag == tag]

    def first(self, tag: str) -> Element:
        return (self.sections(tag) or [self.root])[0]

    def find(self, section: str, name: str) -> Element | None:
        elements = (element for part in self.sections(section) for element in self.elements_below(part))
        return next((element for element in elements if name and element.get("name") == name), None)

    def section_elements(self, section: str, tag: str = "") -> list[Element]:
        return [e for part in self.sections(section) for e in self.child_elements(part) if not tag or e.tag == tag]


class Places:
    """Maps the bodies, joints, geoms, sites, cameras and lights of a compiled model to XML elements, by line number."""

    def __init__(self, markup: Markup, facts: Mapping[str, Any]) -> None:
        self.markup = markup
        self.parts: dict[tuple[str, int], Element] = {("bodies", 0): markup.first("worldbody")}
        inside: dict[Element, list[Element]] = {}
        passed = Counter[tuple[Element, str]]()
        for kind, tags in {"bodies": ("body",), **HELD}.items():
            for index, thing in list(enumerate(facts[kind]))[kind == "bodies" :]:
                holder, name = self.body(thing["parentid" if kind == "bodies" else "bodyid"]), thing["name"]
                if holder not in inside:
                    containers = markup.sections("worldbody") if holder.tag == "worldbody" else [holder]
                    inside[holder] = [element for one in containers for element in self._direct(one)]
                found = [one for one in inside[holder] if one.tag in tags and one.span.line == thing["line"]]
                found = [one for one in found if one.get("name") == name] or found  # replicas have another name
                found = found or [*(one for one in inside[holder] if one.tag in _MAKERS), holder][:1]
                self.parts[kind, index] = found[min(passed[found[0], name], len(found) - 1)]
                passed[found[0], name] += 1  # a line can have several elements

    def _direct(self, container: Element) -> Iterator[Element]:
        for child in self.markup.child_elements(container):
            yield child
            if child.tag in ("frame", "replicate"):
                yield from self._direct(child)

    def body(self, index: int) -> Element:
        return self.place_of("bodies", index)

    def place_of(self, kind: str, index: int) -> Element:
        return self.parts.get((kind, index), self.markup.root)


def check_source(markup: Markup) -> Iterator[Diagnostic]:
    """Yield an error for infinite or NaN numbers and for pipes and devices, which MuJoCo must not load."""
    inner = [e.get(word) for e in markup.sections("compiler") for word in ("meshdir", "texturedir", "assetdir")]
    folders = dict.fromkeys(file.parent for file in markup.files)
    places = [folder / name.replace("\\", "/") for folder in folders for name in ("", *filter(None, inner))]
    for element in markup.all_elements():
        for attribute in element.attributes.values():
            name, value = attribute.name, attribute.value.replace("\\", "/")
            is_file = name.startswith("file") and value and element.tag not in ("include", "model")
            if is_file and any(files.is_special(folder / value) for folder in places):
                message = f"{attribute.value} is not a regular file"
                yield error("file-unreadable", message, attribute.span, "name a file")
            for word in attribute.words() if name not in _WORDS else ():
                if re.fullmatch(r"(?i)[-+]?(nan|inf|infinity)", word.text):
                    message = f"{name} of <{element.tag}> is {word.text}, which is not a number"
                    yield error("not-finite", message, word.span, "give a number")


def refusal(markup: Markup, answer: Answer) -> Diagnostic:
    """Return the error for a file that MuJoCo does not load, with MuJoCo's message."""
    words = " ".join(answer.refusal.split())
    for prefix in ("XML Error: ", "Error: "):
        words = words.removeprefix(prefix)
    if answer.missing:
        return error("extra-missing", words, markup.root.span, answer.help)
    help = _FILE_HELP if words.startswith("Error opening file") else answer.help
    message = words if answer.own else f"MuJoCo refuses the file: {words}"
    return error("mjcf-refused", message, place(markup, words), help)


def place(markup: Markup, message: str) -> Span:
    """Return the position in the source that a message of MuJoCo refers to, by its line number and quoted names."""
    line, tag = re.search(r"\bline (\d+)", message), re.search(r"Element '([^']+)'", message)
    quoted = set(re.findall(r"'([^']+)'", message)) - {tag[1] if tag else ""}
    found: list[tuple[int, Span]] = [(0, markup.root.span)]

    def is_quoted(own: Attribute) -> bool:
        in_folder = own.name == "file" and own.value and any(one.endswith(f"/{own.value}") for one in quoted)
        return own.name in quoted or own.value in quoted or bool(in_folder)

    for element in markup.all_elements():
        attribute = next(filter(is_quoted, element.attributes.values()), None)
        here = line is not None and element.document is markup.root.document and element.span.line == int(line[1])
        score = 4 * here + 2 * (tag is not None and element.tag == tag[1]) + 3 * (attribute is not None)
        span = element.span if attribute is None else attribute.span
        found.append((score, attribute.name_span if attribute is not None and attribute.name in quoted else span))
    return max(found, key=lambda one: one[0])[1]


class ImportState:
    """The state of converting an MJCF to a description (``tree``, with its sections ``links`` and ``joints``).

    ``link_of`` has the link of each body id. Body 0, the world, is a link only if ``ground`` is true. ``joint_of`` has
    the name of each hinge and slide by joint id, ``ball_of`` that of each ball. ``servos`` has the joint id of each
    position servo by actuator id.
    """

    def __init__(self, markup: Markup, places: Places, facts: Mapping[str, Any]) -> None:
        self.markup, self.places, self.facts = markup, places, facts
        self.diagnostics: list[Diagnostic] = []
        self.tree, self.links, self.joints, self.materials = (Map(markup.root.span) for _ in range(4))
        self.link_of, self.joint_of, self.ball_of = dict[int, str](), dict[int, str](), dict[int, str]()
        self.material_of, self.actuator_of, self.servos = dict[int, str](), dict[int, str](), dict[int, int]()
        self.in_order = True  # False if the export would reorder the actuators
        self.sensor_order: list[str] = []  # names in the order of the file if the export would change it
        self.stand_ins: dict[str, list[tuple[str, float, Span]]] = {}  # placeholder limits (joint, value, source span)
        self.scene: list[tuple[str, Span]] = []  # (tag, span) of world objects that are not imported
        self.reported: set[Element] = set()
        self.groups: dict[str, int] = {}
        self.of_scene: set[tuple[str, str]] = set()  # (kind, name) of scene objects and assets that are kept as XML
        self.taken: dict[str, set[str]] = {"link": set()}  # reserved names by kind of object
        self.renamed: dict[str, dict[str, str]] = {}
        self.given: dict[str, dict[int, str]] = {}
        # Elements kept as XML: (node, description for messages, source position, link or "" for the top level).
        self.elements: list[tuple[Node, str, Span, str]] = []
        self.joints_in: dict[int, list[int]] = {}
        for index, joint in enumerate(facts["joints"]):
            self.joints_in.setdefault(joint["bodyid"], []).append(index)
        self.tops = [index for index, body in enumerate(facts["bodies"]) if index and body["parentid"] == 0]
        held = [facts["joints"][at]["type"] for top in self.tops for at in self.joints_in.get(top, ())]
        self.ground = len(self.tops) != 1 or any(kind != FREE for kind in held)
        self.free_base = not self.ground and held == [FREE]

    def unique(self, kind: str, name: str) -> str:
        """Reserve a name for an object of a kind and return it, with a number appended if it is already taken."""
        taken, word = self.taken.setdefault(kind, set()), convert.legal(name) or "unnamed"
        names = (f"{word}_{count}" if count > 1 else word for count in range(1, len(taken) + 2))
        given = next(one for one in names if one not in taken)
        taken.add(given)
        return given

    def name(self, kind: str, name: str, made_up: str = "", index: int = -1) -> str:
        """Reserve a unique name for an object: its ``name`` in the file, or ``made_up`` if that is empty."""
        given = self.unique(kind, name or made_up)
        if index >= 0:
            self.given.setdefault(kind, {})[index] = given
        self.rename(kind, name, given)
        return given

    def rename(self, kind: str, name: str, given: str) -> None:
        if name and given != name:
            self.renamed.setdefault(kind, {})[name] = given

    def name_of(self, kind: str, name: str) -> str:
        return self.renamed.get(kind, {}).get(name) or convert.legal(name)

    def keep(self, node: Node, tag: str, span: Span, link: str = "") -> None:
        """Keep a node as XML in a link or at the top level of the description; ``tag`` describes it in a message."""
        self.elements.append((node, tag, span, link))

    def keep_in_section(self, section: str, node: Node, tag: str, span: Span) -> None:
        self.keep({"tag": section, "attributes": {}, "inner": [node]}, tag, span)

    def elements_of(self, section: str, nodes: Sequence[Node], tag: str = "") -> list[Element]:
        """Return the XML element of each node of a section; elements of attached models are found by name."""
        found = self.markup.section_elements(section, tag)
        if len(found) == len(nodes):
            return found
        names = (node["attributes"].get("name", "") for node in nodes)
        return [self.markup.find(section, name) or self.markup.root for name in names]

    def put_words(
        self, entry: Map, attributes: Attributes, kind: str, element: Element, what: str, words: Words = None
    ) -> None:
        """Set keys of an entry from attributes, and report attributes without a key; ``what`` names the element."""
        for name in convert.put_words(entry, attributes, kind, element, words):
            self.report_lost(f'"{name}" of {what}', element.span)

    def report_lost(self, what: str, span: Span) -> None:
        self.diagnostics.append(cannot_carry(what, span))

    def note(self, rule: str, message: str, span: Span, help: str = "", others: Sequence[Span] = ()) -> None:
        self.diagnostics.append(Diagnostic(rule, NOTE, message, span, and_here(others), help))

    def change(self, message: str, span: Span) -> None:
        self.note("import-changed", message, span)

    def add(self, section: Map, name: str, element: Element) -> Map:
        """Add an empty entry to a section, at the source position of an element, and return it."""
        entry, own = Map(element.span), element.attributes.get("name")
        section.put(name, entry, own.span if own and own.value == name else element.span, element.span)
        return entry

    def add_joint(self, name: str, kind: str, parent: str, child: str, element: Element) -> Map:
        entry = self.add(self.joints, name, element)
        for key, value in (("type", kind), ("parent", parent), ("child", child)):
            convert.put_value(entry, key, value)
        return entry
