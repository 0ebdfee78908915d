"""Bodies of an SDF: links with the frames that are attached to them, and the joints between bodies.

The top of a body is what a joint names as its child, or what the other members of the body are relative to; the others
hang on what their poses are relative to, or on the top.
"""

from __future__ import annotations

from typing import NamedTuple

from rosorin_compile.model import Transform
from rosorin_compile.source.diagnostics import Span, Suggestion
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.xml.markup import Element, named, place

from .elements import WORLD
from .models import FRAME, JOINT, LINK, Models, Node, Scope, relative_to
from .reading import SdfReading, WrittenPose

RULES = (Rule("sdf-joint", "A joint of an SDF that no description can have.", "See the message.", Heading.READING),)

NEAR = 1e-10  # m, and entries of rotations: what rounding leaves of nothing
SINGLE = ("revolute", "continuous", "prismatic", "fixed", "ball")
PAIRS = ("universal", "revolute2")
_NOT_CARRIED = {
    "screw": ("turns and slides at once", "takes a continuous joint"),
    "gearbox": ("couples two joints with each other", "leaves it out"),
}


class Joined(NamedTuple):
    """A joint of an SDF: its node, type and ends, the parent None for the world; the pose of the child at the joint."""

    node: Node
    kind: str
    parent: Node | None
    child: Node
    there: Transform


class Bodies:
    """The bodies of a model, and the joints between them."""

    def __init__(self, models: Models, top: Scope) -> None:
        self.models, self.top = models, top
        self.reading: SdfReading = models.reading
        nodes = list(top.all_nodes())
        self.links = [node for node in nodes if node.kind == LINK]
        self.members = [node for node in nodes if node.kind in (LINK, FRAME)]
        self.world = self._pose_of_model()
        self._body = {id(node): models.link_of(node) for node in self.members}
        self.joints: list[Joined] = []
        for node in nodes:
            if node.kind == JOINT:
                self._join(node)
        self._tops = self._find_tops()

    def _pose_of_model(self) -> Transform:
        """Return the pose of the frame of the model in the world."""
        pose = self.reading.single(self.top.element, "pose")
        attribute = relative_to(pose)
        if attribute is not None and attribute.value != WORLD:
            message = f'the pose of the model is relative to "{attribute.value}", which is not in the file'
            help = "leave it out: the world is what is meant"
            self.reading.error("sdf-name-unknown", message, attribute.span, help)
        return self.reading.pose(pose).transform.then(self.models.placement(self.top).inverse())

    def pose(self, node: Node | None) -> Transform:
        """Return the pose of a node in the model; None is the world."""
        return self.world.inverse() if node is None else self.models.pose(node, node.scope)

    def body_of(self, node: Node | None) -> Node | None:
        """Return the link that a node moves with, or None for the world, and after an error."""
        return None if node is None else self._body.get(id(node))

    def _join(self, node: Node) -> None:
        """Add a joint with its ends; a second joint that moves the same body would close a loop."""
        reading, kind = self.reading, self._kind(node.element)
        parent, child = (self._end(node, end) for end in ("parent", "child"))
        if not parent or not child or not kind:
            return
        if child[0] is None:
            message = f"the child of {named(node.element)} is the world, which no joint moves"
            reading.error("sdf-joint", message, child[1], "swap parent and child")
            return
        body = self.body_of(child[0])
        if parent[0] is not None and self.body_of(parent[0]) is body:
            message = f'{named(node.element)} joins "{child[0].name}" to the link that it is part of'
            reading.error("sdf-joint", message, child[1], "name another link")
            return
        first = next((one for one in self.joints if body is not None and self.body_of(one.child) is body), None)
        if first is None or body is None:
            there = self.pose(node).inverse().then(self.pose(child[0]))
            self.joints.append(Joined(node, kind, parent[0], child[0], there))
            return
        message = f'link "{body.name}" is moved by two joints, "{first.node.name}" and "{node.name}": a loop, or one'
        message += " the wrong way"
        if reading.lenient("two-parents", message, node.element.span, "remove one", "leaves the second out"):
            reading.cannot_carry(named(node.element), node.element.span)

    def _kind(self, element: Element) -> str:
        """Return the type of a joint; empty after an error, and for one that is left out."""
        kind, reading = element.get("type"), self.reading
        if kind in (*SINGLE, *PAIRS):
            return kind
        if not kind:
            reading.error("missing-attribute", f"{named(element)} has no type", element.span, 'add type="..."')
            return ""
        span, message = element.attributes["type"].span, f'{named(element)} is of type "{kind}", which'
        if kind not in _NOT_CARRIED:
            help = Suggestion(kind, (*SINGLE, *PAIRS, *_NOT_CARRIED))
            reading.error("joint-type", f"{message} SDF does not have", span, help)
            return ""
        why, instead = _NOT_CARRIED[kind]
        message += f" {why}: no description has that"
        if not reading.lenient("sdf-joint", message, span, "make it one that is read", instead):
            return ""
        reading.cannot_carry(f"the type {kind} of {named(element)}", span)
        return "continuous" if kind == "screw" else ""

    def _end(self, node: Node, end: str) -> tuple[Node | None, Span] | None:
        """Return the link or frame at an end of a joint, None for the world, with its place; None after an error."""
        element = self.reading.single(node.element, end)
        if element is None or not element.text:
            span = (element or node.element).span
            message = f"{named(node.element)} has no <{end}>"
            self.reading.error("missing-element", message, span, f"add <{end}>LINK</{end}>")
            return None
        name, span = element.text, place(element)
        if name == WORLD and self.models.find(node.scope, WORLD) is None:
            return None, span
        found = self.models.require(node.scope, name, span, f"the {end} of {named(node.element)}")
        member = found if found is None or found.kind in (LINK, FRAME) else self.models.link_of(found)
        if member is None and found is not None:
            self.reading.error("sdf-name-unknown", f'"{name}" has no link', span, "name a link or a frame")
        return None if member is None else (member, span)

    def _find_tops(self) -> dict[int, Node]:
        """Return for each link the topmost member of its body."""
        tops: dict[int, Node] = {}
        for joint in self.joints:
            tops.setdefault(id(self.body_of(joint.child)), joint.child)
        for link in self.links:
            visited = [link]
            while (above := self._base_in_body(visited[-1])) is not None and above not in visited:
                visited.append(above)
            tops.setdefault(id(link), visited[-1])
        return tops

    def _base_in_body(self, node: Node) -> Node | None:
        """Return the member of the same body that the pose of a node is relative to, or None."""
        found = self.models.find(node.scope, self.models.base(node)[0])
        if found is None or found.kind not in (LINK, FRAME) or self.body_of(found) is not self.body_of(node):
            return None
        return found

    def above(self, node: Node) -> Node | None:
        """Return the member that a node hangs on within its body, or None for the top."""
        body = self.body_of(node)
        top = self._tops.get(id(body)) if body is not None else None
        return None if top is node else self._base_in_body(node) or top

    def roots(self) -> list[Node]:
        """Return the tops of the bodies that no joint names as its child."""
        held = {id(self.body_of(joint.child)) for joint in self.joints}
        return [self._tops[id(link)] for link in self.links if id(link) not in held]

    def local_pose(self, node: Node, parent: Node | None) -> WrittenPose:
        """Return the pose of a node in what it hangs on, as written if it is written relative to that."""
        above = self.pose(parent)
        if self.models.base_pose(node) == above:
            return node.written
        return WrittenPose(above.inverse().then(self.pose(node)), element=node.written.element)

    def at_joint(self, joint: Joined) -> WrittenPose:
        """Return the pose of a joint's child in its parent."""
        child = self.local_pose(joint.child, joint.parent)
        if is_near(joint.there):
            own = self.local_pose(joint.node, joint.parent)
            return own if own.xyz or not child.xyz else child
        return child


def is_near(transform: Transform) -> bool:
    """Return True if a transform moves and turns nothing, rounding aside."""
    entries = (*sum(transform.rows, ()), *transform.xyz)
    none = (*sum(Transform().rows, ()), 0.0, 0.0, 0.0)
    return all(abs(a - b) < NEAR for a, b in zip(entries, none, strict=True))
