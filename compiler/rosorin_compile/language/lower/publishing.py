"""Lower the publishers of joints, and the pose of optical frames."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from rosorin_compile.model.geometry import Pose
from rosorin_compile.model.joint import (
    AXLELESS,
    ROBOT_STATE_PUBLISHER,
    STATIC_TRANSFORM_PUBLISHER,
    UNPUBLISHED,
    Publisher,
)
from rosorin_compile.source.diagnostics import Help, Suggestion
from rosorin_compile.source.tree import Path

from .records import Problem, vector_of

# REP 103, "Suffix Frames": from a body frame to its image frame.
OPTICAL_RPY = (-math.pi / 2, 0.0, -math.pi / 2)


def optical_pose(entry: dict[str, Any] | None) -> Pose:
    """Return where an optical frame is in that of its sensor, or would be; REP 103 says how it is turned by default."""
    said = entry or {}
    return Pose(vector_of(said.get("xyz")), vector_of(said.get("rpy"), OPTICAL_RPY))


OF_THE_URDF = Publisher(ROBOT_STATE_PUBLISHER, ROBOT_STATE_PUBLISHER)
IN_TURNS = Publisher(UNPUBLISHED, about="its publishers take turns")
# ros/kdl_parser knows no such joint, and ros/robot_state_publisher sends what kdl_parser finds.
_NOT_FLOATING = Publisher(UNPUBLISHED, about="robot_state_publisher publishes no floating joint")


class Turn(NamedTuple):
    """One entry of a list of publishers: who it is, when, and where it stands."""

    publisher: Publisher
    when: str
    path: Path


class Publishing(NamedTuple):
    """Who publishes a joint: one always, and those that publish it in some modes.

    robot_state_publisher publishes its whole URDF in every mode, so it is never one of the turns.
    """

    always: Publisher
    turns: tuple[Turn, ...] = ()

    def of_optical(self) -> Publishing:
        """Return who publishes the optical frame by default: the same, but a static publisher needs a second node."""
        turns = tuple(turn._replace(publisher=_optical(turn.publisher)) for turn in self.turns)
        return Publishing(_optical(self.always), turns)


_ALWAYS_OF_THE_URDF = Publishing(OF_THE_URDF)


def _optical(publisher: Publisher) -> Publisher:
    if publisher.kind != STATIC_TRANSFORM_PUBLISHER:
        return publisher
    return Publisher(STATIC_TRANSFORM_PUBLISHER, f"{publisher.name}_optical")


def node(name: str, path: Path, nodes: Mapping[str, Publisher], problem: Problem) -> Publisher:
    """Return a node by the name that a description gives it; ``problem`` takes a name that is not known."""
    if name in nodes:
        return nodes[name]
    help: Help = Suggestion(name, [*nodes, ROBOT_STATE_PUBLISHER])
    if name == STATIC_TRANSFORM_PUBLISHER:
        help = f"write {{{name}: NODE_NAME}}: each is a node of its own"
    problem("unknown-publisher", f'there is no publisher "{name}"', path, help)
    return OF_THE_URDF


def publishing(entry: Mapping[str, Any], path: Path, nodes: Mapping[str, Publisher], problem: Problem) -> Publishing:
    """Return who publishes the joint of an entry that stands at a path."""
    if "publisher" not in entry and entry.get("type") not in AXLELESS:  # as of nearly all
        return _ALWAYS_OF_THE_URDF
    wanted, here = entry.get("publisher", ROBOT_STATE_PUBLISHER), (*path, "publisher")

    def one(value: Any, at: Path) -> Publisher:
        if isinstance(value, dict):
            if "none" in value:
                return Publisher(UNPUBLISHED, about=value["none"])
            if "simulation" in value:
                return Publisher(UNPUBLISHED, about=value["simulation"], simulated=True)
            return Publisher(STATIC_TRANSFORM_PUBLISHER, value[STATIC_TRANSFORM_PUBLISHER], "tf2_ros")
        if value == ROBOT_STATE_PUBLISHER:
            return _NOT_FLOATING if entry.get("type") in AXLELESS else OF_THE_URDF
        return node(value, at, nodes, problem)

    if not isinstance(wanted, list):
        return Publishing(one(wanted, here))
    turns = []
    for index, item in enumerate(wanted):
        at = (*here, index)
        turns.append(Turn(one(item["by"], (*at, "by")), item.get("when", ""), at))
    others = tuple(turn for turn in turns if turn.publisher.kind != ROBOT_STATE_PUBLISHER)
    return Publishing(IN_TURNS if len(others) == len(turns) else OF_THE_URDF, others)
