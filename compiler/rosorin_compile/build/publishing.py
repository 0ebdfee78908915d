"""Building publishers: who publishes the transform of a joint, always or in turns."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from ..diagnostic import did_you_mean
from ..model import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, UNPUBLISHED, Publisher
from ..registry import FRAMES, Rule
from ..tree import Path

RULES = (
    Rule("unknown-publisher", "A publisher is not in `publishers`.", "Correct the name, or add the node.", FRAMES),
)

# Takes the rule, the message, the path and the way out of a problem.
Problem = Callable[[str, str, Path, str], None]

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
        """Return who publishes the optical frame of a sensor that says nothing else: a static one is another node."""
        turns = tuple(turn._replace(publisher=_optical(turn.publisher)) for turn in self.turns)
        return Publishing(_optical(self.always), turns)


def _optical(publisher: Publisher) -> Publisher:
    if publisher.kind != STATIC_TRANSFORM_PUBLISHER:
        return publisher
    return Publisher(STATIC_TRANSFORM_PUBLISHER, f"{publisher.name}_optical")


def node(name: str, path: Path, nodes: Mapping[str, Publisher], problem: Problem) -> Publisher:
    """Return a node by the name that a description gives it; ``problem`` takes a name that is not known."""
    if name in nodes:
        return nodes[name]
    help = did_you_mean(name, [*nodes, ROBOT_STATE_PUBLISHER])
    problem("unknown-publisher", f'there is no publisher "{name}"', path, help)
    return OF_THE_URDF


def publishing(entry: Mapping[str, Any], path: Path, nodes: Mapping[str, Publisher], problem: Problem) -> Publishing:
    """Return who publishes the joint of an entry that stands at a path."""
    said, here = entry.get("publisher", ROBOT_STATE_PUBLISHER), (*path, "publisher")

    def one(value: Any, at: Path) -> Publisher:
        if isinstance(value, dict):
            if "none" in value:
                return Publisher(UNPUBLISHED, about=value["none"])
            return Publisher(STATIC_TRANSFORM_PUBLISHER, value[STATIC_TRANSFORM_PUBLISHER], "tf2_ros")
        if value == ROBOT_STATE_PUBLISHER:
            return _NOT_FLOATING if entry.get("type") == "floating" else OF_THE_URDF
        return node(value, at, nodes, problem)

    if not isinstance(said, list):
        return Publishing(one(said, here))
    turns = []
    for index, item in enumerate(said):
        at = (*here, index)
        turns.append(Turn(one(item["by"], (*at, "by")), item.get("when", ""), at))
    others = tuple(turn for turn in turns if turn.publisher.kind != ROBOT_STATE_PUBLISHER)
    return Publishing(IN_TURNS if len(others) == len(turns) else OF_THE_URDF, others)
