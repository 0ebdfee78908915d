"""Edges: every row of the tree of frames, who publishes it, in the terms of the list of frames (``emit.frames``)."""

from __future__ import annotations

from typing import NamedTuple

from ..model import STATIC_TRANSFORM_PUBLISHER, UNPUBLISHED, Publisher, Robot

NOBODY = "nobody"
TF, TF_STATIC, NO_TOPIC = "/tf", "/tf_static", "none"


class Row(NamedTuple):
    """One transform: ``why`` says why nobody publishes it, ``when`` in which modes somebody does ("" is always).

    ``first`` is the parent in the first row of this child, by which a second one is told apart; ``joint`` and ``kind``
    are empty for the transforms of other nodes.
    """

    parent: str
    child: str
    publisher: str
    why: str
    topic: str
    when: str
    first: str
    joint: str = ""
    kind: str = ""

    @property
    def published(self) -> bool:
        """Whether tf2 knows the edge."""
        return self.topic != NO_TOPIC

    @property
    def who(self) -> str:
        """The publisher in the words of the list of frames: "nobody: why" where there is none."""
        return f"{self.publisher}: {self.why}" if self.why else self.publisher

    @property
    def style(self) -> str:
        """How the edge is drawn: moving, static or nobody."""
        return {TF: "moving", TF_STATIC: "static"}.get(self.topic, NOBODY)


def rows(robot: Robot) -> tuple[Row, ...]:
    """Return all edges: joints from the root down, then the transforms of other nodes, as the list of frames has them.

    A joint that somebody else publishes under the same parent is one edge with that transform, and named there.
    """
    first: dict[str, str] = {}
    found: list[Row] = []
    joints = robot.joints_down()
    for joint in joints:
        first.setdefault(joint.child, joint.parent)
        if joint.name in robot.turns and joint.publisher.kind == UNPUBLISHED:
            continue  # its publishers are edges below, each in its modes
        said = _publishing(joint.publisher, joint.moves_on_tf)
        found.append(Row(joint.parent, joint.child, *said, "", first[joint.child], joint.name, joint.type))
    named = {(joint.parent, joint.child): joint for joint in joints}
    for edge in robot.edges:
        first.setdefault(edge.child, edge.parent)
        said = _publishing(edge.publisher, edge.moving)
        same = named.get((edge.parent, edge.child))
        own = (same.name, same.type) if same is not None else ("", "")
        found.append(Row(edge.parent, edge.child, *said, edge.when, first[edge.child], *own))
    return tuple(found)


def _publishing(publisher: Publisher, moving: bool) -> tuple[str, str, str]:
    """Return who publishes, why nobody does, and the topic."""
    if publisher.kind == UNPUBLISHED:
        return NOBODY, " ".join(publisher.about.split()), NO_TOPIC
    return publisher.name, "", TF if moving and publisher.kind != STATIC_TRANSFORM_PUBLISHER else TF_STATIC


def publishers(edges: tuple[Row, ...]) -> tuple[str, ...]:
    """Return who publishes something, in the order of the rows; nobody is none of them."""
    return tuple(dict.fromkeys(row.publisher for row in edges if row.published))
