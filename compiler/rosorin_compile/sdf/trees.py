"""Trees: what an SDF holds as bodies, and the tree of frames that a description makes of them.

A body is a link with the frames that are attached to it. Its top is what a joint names as its child, else what the
others of the body are seen from; the others hang on what their poses are relative to, or on the top. Where the numbers
of a pose are those that the description needs, they stay as they were written.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from rosorin_compile.formats.urdf.reading import Reading, named
from rosorin_compile.model import Transform
from rosorin_compile.source.diagnostics import Span, Suggestion
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.xml.markup import Element

from .reading import Said, changed, place
from .scopes import FRAME, JOINT, LINK, Models, Node, Scope
from .words import WORLD

RULES = (
    Rule(
        "sdf-joint",
        "A joint of an SDF that no description can have, or that joins nothing.",
        "The message says what it is; `--lenient` may take another in its place.",
        Heading.READING,
    ),
)

NEAR = 1e-10  # m, and entries of rotations: what rounding leaves of nothing


SINGLE = ("revolute", "continuous", "prismatic", "fixed", "ball")
PAIRS = ("universal", "revolute2")
SCREW = "screw"
GEARBOX = "gearbox"
_NOT_CARRIED = {
    SCREW: ("turns and slides at once", "takes a continuous joint"),
    GEARBOX: ("couples two joints with each other", "leaves it out"),
}
_TYPES = (*SINGLE, *PAIRS, *_NOT_CARRIED)


class Joined(NamedTuple):
    """A joint of an SDF: its node, type and ends, the parent None for the world; where the child is at the joint."""

    node: Node
    kind: str
    parent: Node | None
    child: Node
    there: Transform


class Tree:
    """The bodies of a model, and what hangs on what."""

    def __init__(self, models: Models, top: Scope) -> None:
        self.models = models
        self.reading: Reading = models.reading
        self.top = top
        nodes = list(top.all_nodes())
        self.links = [node for node in nodes if node.kind == LINK]
        self.members = [node for node in nodes if node.kind in (LINK, FRAME)]
        self.world = _world(models, top)
        self.body = {id(node): self._body(node) for node in self.members}
        joints = [joint for node in nodes if node.kind == JOINT and (joint := self._joined(node)) is not None]
        self.joints = list(self._each_once(joints))
        self.tops = self._tops()

    def pose(self, node: Node | None) -> Transform:
        """Return where something sits in the model; None is the world."""
        return self.world.inverse() if node is None else self.models.pose(node, node.scope)

    def _body(self, node: Node) -> Node | None:
        return self.models.link_of(node, node.scope)

    def body_of(self, node: Node | None) -> Node | None:
        """Return the link that something moves with; None is the world, or nothing."""
        return None if node is None else self.body.get(id(node))

    def _joined(self, node: Node) -> Joined | None:
        """Return a joint with its ends; None after an error."""
        kind = self._kind(node.element)
        parent, child = (self._end(node, end) for end in ("parent", "child"))
        if not parent or not child or not kind:
            return None
        if child[0] is None:
            self.reading.error("sdf-joint", f"the child of {named(node.element)} is the world, which no joint moves",
                               child[1], "swap parent and child")  # fmt: skip
            return None
        if parent[0] is not None and self.body_of(parent[0]) is self.body_of(child[0]):
            message = f'{named(node.element)} joins "{child[0].name}" to the link that it is part of'
            self.reading.error("sdf-joint", message, child[1], "name another link")
            return None
        there = self.pose(node).inverse().then(self.pose(child[0]))
        return Joined(node, kind, parent[0], child[0], there)

    def _kind(self, element: Element) -> str:
        """Return the type of a joint; empty after an error, and for one that is left out."""
        attribute = element.attributes.get("type")
        if attribute is None or not attribute.value:
            self.reading.error("missing-attribute", f"{named(element)} has no type", element.span, 'add type="..."')
            return ""
        kind = attribute.value
        if kind in _NOT_CARRIED:
            why, instead = _NOT_CARRIED[kind]
            message = f'{named(element)} is of type "{kind}", which {why}: no description has that'
            if not self.reading.lenient("sdf-joint", message, attribute.span, "make it one that is read", instead):
                return ""
            self.reading.cannot_carry(f"the type {kind} of {named(element)}", attribute.span)
            return "continuous" if kind == SCREW else ""
        if kind in (*SINGLE, *PAIRS):
            return kind
        message = f'{named(element)} is of type "{kind}", which SDF does not have'
        self.reading.error("joint-type", message, attribute.span, Suggestion(kind, _TYPES))
        return ""

    def _each_once(self, joints: Iterable[Joined]) -> Iterator[Joined]:
        """Yield the joints that move a body for the first time; a second one would close a loop."""
        first: dict[int, Joined] = {}
        for joint in joints:
            body = self.body_of(joint.child)
            known = first.setdefault(id(body), joint)
            if body is None or known is joint:
                yield joint
                continue
            one, other = known.node.name, joint.node.name
            message = f'link "{body.name}" is moved by two joints, "{one}" and "{other}": a loop, or one the wrong way'
            span = joint.node.element.span
            if self.reading.lenient("two-parents", message, span, "remove one", "leaves the second out"):
                self.reading.cannot_carry(named(joint.node.element), span)

    def _end(self, node: Node, end: str) -> tuple[Node | None, Span] | None:
        """Return what one end of a joint is, None for the world, and its place; nothing after an error."""
        element = self.reading.single(node.element, end)
        if element is None or not element.text:
            message = f"{named(node.element)} has no <{end}>"
            span = (element or node.element).span
            self.reading.error("missing-element", message, span, f"add <{end}>LINK</{end}>")
            return None
        span = place(element)
        if element.text == WORLD and self.models.find(node.scope, WORLD) is None:
            return None, span
        found = self.models.asked(node.scope, element.text, span, f"the {end} of {named(node.element)}")
        if found is None:
            return None
        member = found if found.kind in (LINK, FRAME) else self.models.link_of(found, found.scope)
        if member is None:
            self.reading.error("sdf-name-unknown", f'"{element.text}" has no link', span, "name a link or a frame")
            return None
        return member, span

    def _tops(self) -> dict[int, Node]:
        """Return for each link the topmost link of its rigid body."""
        tops: dict[int, Node] = {}
        for joint in self.joints:
            body = self.body_of(joint.child)
            if body is not None:
                tops.setdefault(id(body), joint.child)
        for link in self.links:
            if id(link) in tops:
                continue
            here, seen = link, {id(link)}
            while (above := self._seen_in_body(here)) is not None and id(above) not in seen:
                seen.add(id(above))
                here = above
            tops[id(link)] = here
        return tops

    def _seen_in_body(self, node: Node) -> Node | None:
        """Return the link or frame of the same body that the pose of something is relative to; None if it is none."""
        scope, name, _ = self.models.seen_from(node)
        found = self.models.find(scope, name)
        if found is None or found.kind not in (LINK, FRAME) or self.body_of(found) is not self.body_of(node):
            return None
        return found

    def above(self, node: Node) -> Node | None:
        """Return what something hangs on within its body; None for the top of one."""
        body = self.body_of(node)
        top = self.tops.get(id(body)) if body is not None else None
        return None if top is node else self._seen_in_body(node) or top

    def roots(self) -> list[Node]:
        """Return the tops of the bodies that no joint names as its child."""
        held = {id(self.body_of(joint.child)) for joint in self.joints}
        return [self.tops[id(link)] for link in self.links if id(link) not in held]

    def local_pose(self, node: Node, parent: Node | None) -> Said:
        """Return the pose of something in what it hangs on, in its own numbers where that is what they say."""
        scope, name, span = self.models.seen_from(node)
        seen = self.models.frame(scope, name, span, node)
        above = self.pose(parent)
        if seen == above:
            return node.said
        return Said(above.inverse().then(self.pose(node)), element=node.said.element)

    def at_joint(self, joint: Joined) -> Said:
        """Return the pose of a joint's child in its parent."""
        if is_near(joint.there):
            said = self.local_pose(joint.node, joint.parent)
            if said.xyz or not self.local_pose(joint.child, joint.parent).xyz:
                return said
        return self.local_pose(joint.child, joint.parent)


def _world(models: Models, top: Scope) -> Transform:
    """Return where the frame of a model is in the world."""
    pose = models.reading.single(top.element, "pose")
    attribute = None if pose is None else pose.attributes.get("relative_to") or pose.attributes.get("frame")
    if attribute is not None and attribute.value not in ("", WORLD):
        message = f'the pose of the model is relative to "{attribute.value}", which is not in the file'
        models.reading.error("sdf-name-unknown", message, attribute.span, "leave it out: the world is what is meant")
    return models.numbers.pose(pose).transform.then(models.placement(top).inverse())


def is_near(one: Transform) -> bool:
    """Say whether a transform is none, rounding aside."""
    return is_unturned(one) and all(abs(value) < NEAR for value in one.xyz)


def is_unturned(one: Transform) -> bool:
    """Say whether a transform turns nothing, rounding aside."""
    pairs = zip(sum(one.rows, ()), sum(Transform().rows, ()), strict=True)
    return all(abs(a - b) < NEAR for a, b in pairs)


def is_along(one: Sequence[float], axis: Sequence[float]) -> bool:
    """Say whether a way is along an axis, rounding aside."""
    (a, b, c), (x, y, z) = one, axis
    return max(abs(b * z - c * y), abs(c * x - a * z), abs(a * y - b * x)) < NEAR


def named_twice(nodes: Iterable[Node], taken: set[str], reading: Reading) -> None:
    """Give each link, frame or joint the name that a description can have, and that no other has."""
    for node in nodes:
        first = node.scope.prefix + node.name.removesuffix(f" ({node.kind})")
        name = first.replace("::", "_")
        while name in taken:
            name += "_"
        taken.add(name)
        node.called = name
        if name != first:
            why = "no name leads into a model here" if "::" in first else "something else has its name"
            changed(reading, f'the {node.kind} "{first}" is called "{name}": {why}', node.element.span)
