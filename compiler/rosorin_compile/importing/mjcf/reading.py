"""What is known while an MJCF is read: the compiled model, its text, the names that were given, and the tree so far."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ...diagnostic import NOTE, WARNING, Diagnostic, Related, Span
from ...registry import READING, Rule
from ...tree import Map
from ...wording import counted
from ..imported import LeftOut, cannot_carry
from ..markup import Element
from .planting import Names, put
from .source import Markup, Places

if TYPE_CHECKING:
    from .motion import Motion

RULES = (
    Rule(
        "import-changed",
        "A note: something is carried over, but not as the file says it: under another name, counted from another "
        "zero.",
        topic=READING,
    ),
    Rule("mjcf-warning", "A warning of MuJoCo's own about the file.", "As MuJoCo says.", READING),
)

FREE, BALL, SLIDE, HINGE = range(4)
_SHOWN = 6  # places named of one thing


class Reading:
    """One MJCF on its way into a tree.

    ``links`` and ``joints`` are sections of ``tree``. ``link_of`` is the link of each body by its index, 0 being the
    world; the world is a link only if ``ground`` is true. ``joint_of`` is the name of each hinge and slide,
    ``ball_of`` the names of the joints of each ball, and ``motion_of`` the planar or floating joint of a body.
    """

    def __init__(self, markup: Markup, places: Places, facts: Mapping[str, Any]) -> None:
        self.markup = markup
        self.places = places
        self.facts = facts
        self.diagnostics: list[Diagnostic] = []
        self.left_out: list[LeftOut] = []
        self.tree = Map(markup.root.span)
        self.links = Map(markup.root.span)
        self.joints = Map(markup.root.span)
        self.link_names, self.joint_names, self.material_names = Names(), Names(), Names()
        self.link_of: dict[int, str] = {}
        self.joint_of: dict[int, str] = {}
        self.material_of: dict[int, str] = {}
        self.ball_of: dict[int, list[str]] = {}
        self.motion_of: dict[int, Motion] = {}
        self.joints_in: dict[int, list[int]] = {}
        for index, joint in enumerate(facts["joints"]):
            self.joints_in.setdefault(joint["body"], []).append(index)
        self.tops = [index for index, body in enumerate(facts["bodies"]) if index and body["parent"] == 0]
        held = [facts["joints"][at]["type"] for top in self.tops for at in self.joints_in.get(top, ())]
        self.ground = len(self.tops) != 1 or any(kind != FREE for kind in held)
        self.free_base = not self.ground and held == [FREE]

    def lost(self, what: str, span: Span, help: str = "", many: bool = False, others: Sequence[Span] = ()) -> None:
        """Say that something of the robot is not in the tree; ``many`` if ``what`` is a plural."""
        message = f"{what} {'are' if many else 'is'} not carried over"
        related = [Related("and here", other) for other in others[:_SHOWN]]
        if len(others) > _SHOWN:
            related.append(Related(f"and in {counted(len(others) - _SHOWN, 'more place')}", None))
        self.diagnostics.append(cannot_carry(what, span, help)._replace(message=message, related=tuple(related)))
        self.left_out.append(LeftOut(what, span))

    def ignored(self, what: str, span: Span) -> None:
        """Say that something was passed over that is no part of the robot."""
        self.diagnostics.append(Diagnostic("import-ignored", NOTE, what, span))

    def changed(self, what: str, span: Span) -> None:
        """Say that something is in the tree, but otherwise than the file says it."""
        self.diagnostics.append(Diagnostic("import-changed", NOTE, what, span))

    def warned(self, what: str, span: Span) -> None:
        """Pass on a warning of MuJoCo's own."""
        self.diagnostics.append(Diagnostic("mjcf-warning", WARNING, what, span))

    def new_link(self, name: str, element: Element) -> Map:
        """Return a new, empty link that stands where ``element`` is."""
        made = Map(element.span)
        said = element.attributes.get("name")
        self.links.put(name, made, said.span if said and said.value == name else element.span, element.span)
        return made

    def new_joint(self, name: str, kind: str, parent: str, child: str, element: Element) -> Map:
        """Return a new joint that stands where ``element`` is."""
        made = Map(element.span)
        said = element.attributes.get("name")
        self.joints.put(name, made, said.span if said and said.value == name else element.span, element.span)
        put(made, "type", kind)
        put(made, "parent", parent)
        put(made, "child", child)
        return made
