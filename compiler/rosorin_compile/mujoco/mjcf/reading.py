"""The state of reading one MJCF: the compiled model, its text, the names in the description, and the tree so far."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from rosorin_compile.formats.format import cannot_carry
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, Span, count_of, phrase
from rosorin_compile.source.messages import and_here
from rosorin_compile.source.tree import Map
from rosorin_compile.source.xml.markup import Element

from . import convert
from .convert import Attributes, Node
from .source import Markup, Places

FREE, BALL, SLIDE, HINGE = range(4)


class Kept(NamedTuple):
    """An element that is kept as it is, what it is, its place, and the link that has it, if any."""

    node: Node
    tag: str
    span: Span
    link: str


class Reading:
    """One MJCF on its way into a tree.

    ``links`` and ``joints`` are sections of ``tree``. ``link_of`` is the link of each body by its index, 0 being the
    world; the world is a link only if ``ground`` is true. ``joint_of`` is the name of each hinge and slide, ``ball_of``
    that of each ball. ``servos`` are the joints of the position servos by the number of the actuator.
    """

    def __init__(self, markup: Markup, places: Places, facts: Mapping[str, Any]) -> None:
        self.markup, self.places, self.facts = markup, places, facts
        self.diagnostics: list[Diagnostic] = []
        self.tree, self.links, self.joints, self.materials = (Map(markup.root.span) for _ in range(4))
        self.link_of: dict[int, str] = {}
        self.joint_of: dict[int, str] = {}
        self.ball_of: dict[int, str] = {}
        self.material_of: dict[int, str] = {}
        self.actuator_of: dict[int, str] = {}
        self.servos: dict[int, int] = {}
        self.in_order = True  # the actuators, as an MJCF of ours has them
        self.sensor_order: list[str] = []  # names, if it is not that of an MJCF of ours
        self.stand_ins: dict[str, list[tuple[str, float, Span]]] = {}  # by the word of the limit: joint, value, place
        self.scene: list[tuple[str, Span]] = []
        self.reported: set[Element] = set()
        self.groups: dict[str, int] = {}
        self.of_scene: set[tuple[str, str]] = set()  # what is kept of the scene and of the assets, by kind and name
        self.taken: dict[str, set[str]] = {"link": set()}  # names, by kind
        self.renamed: dict[str, dict[str, str]] = {}
        self.given: dict[str, dict[int, str]] = {}
        self.elements: list[Kept] = []
        self.joints_in: dict[int, list[int]] = {}
        for index, joint in enumerate(facts["joints"]):
            self.joints_in.setdefault(joint["bodyid"], []).append(index)
        self.tops = [index for index, body in enumerate(facts["bodies"]) if index and body["parentid"] == 0]
        held = [facts["joints"][at]["type"] for top in self.tops for at in self.joints_in.get(top, ())]
        self.ground = len(self.tops) != 1 or any(kind != FREE for kind in held)
        self.free_base = not self.ground and held == [FREE]

    def unique(self, kind: str, name: str) -> str:
        """Return a name, or with a number behind it if another object of its kind has it."""
        taken, word = self.taken.setdefault(kind, set()), convert.legal(name) or "unnamed"
        given, count = word, 1
        while given in taken:
            count += 1
            given = f"{word}_{count}"
        taken.add(given)
        return given

    def name(self, kind: str, name: str, made_up: str = "", index: int = -1) -> str:
        """Return the name of an object that no other of its kind has: its own, or one that is made up."""
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
        """Keep an element as it is: in the body of a link, or at the top."""
        self.elements.append(Kept(node, tag, span, link))

    def keep_in_section(self, section: str, node: Node, tag: str, span: Span) -> None:
        self.keep({"tag": section, "attributes": {}, "inner": [node]}, tag, span)

    def elements_of(self, section: str, nodes: Sequence[Node], tag: str = "") -> list[Element]:
        """Return where each element of a section is in the text; those of attached models are found by name."""
        found = self.markup.section_elements(section, tag)
        if len(found) == len(nodes):
            return found
        names = (node["attributes"].get("name", "") for node in nodes)
        return [self.markup.find(section, name) or self.markup.root for name in names]

    def put_words(
        self,
        entry: Map,
        attributes: Attributes,
        kind: str,
        element: Element,
        what: str,
        words: Mapping[str, str] | None = None,
    ) -> None:
        """Set the keys of an entry that attributes have; report those that no key can express as lost of ``what``."""
        for name in convert.put_words(entry, attributes, kind, element, words):
            self.lost(f'"{name}" of {what}', element.span)

    def lost(self, what: str, span: Span) -> None:
        self.diagnostics.append(cannot_carry(what, span))

    def note(self, rule: str, message: str, span: Span, help: str = "", others: Sequence[Span] = ()) -> None:
        self.diagnostics.append(Diagnostic(rule, NOTE, message, span, and_here(others), help))

    def skip_scene(self, kind: str, span: Span) -> None:
        """Count an object of the world, which is not a part of the robot, for ``report_scene``."""
        self.scene.append((kind, span))

    def report_scene(self) -> None:
        if self.scene:
            counts = Counter(kind for kind, _ in self.scene)
            what = phrase([count_of(count, kind) for kind, count in counts.items()])
            message = f"{what} of the world: the scene is not a part of the robot"
            self.note("import-ignored", message, self.scene[0][1])

    def change(self, message: str, span: Span) -> None:
        self.note("import-changed", message, span)

    def add(self, section: Map, name: str, element: Element) -> Map:
        """Return a new, empty entry of a section at the place of an element."""
        entry, own = Map(element.span), element.attributes.get("name")
        section.put(name, entry, own.span if own and own.value == name else element.span, element.span)
        return entry

    def add_joint(self, name: str, kind: str, parent: str, child: str, element: Element) -> Map:
        """Return a new joint at the place of an element."""
        entry = self.add(self.joints, name, element)
        for key, value in (("type", kind), ("parent", parent), ("child", child)):
            convert.put(entry, key, value)
        return entry
