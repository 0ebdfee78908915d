"""The section ``joints``, and the publishers of a joint: a single node, or several in different modes."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from rosorin_compile.model import STATIC_TRANSFORM_PUBLISHER, Edge, Joint, Publisher
from rosorin_compile.model.joint import AXLELESS, ROBOT_STATE_PUBLISHER, UNPUBLISHED, SafetyController
from rosorin_compile.model.sections import Section
from rosorin_compile.source.diagnostics import Help, Suggestion
from rosorin_compile.source.tree import Path

from ...lower import Lowering, entries_of, record_of

OF_THE_URDF = Publisher(ROBOT_STATE_PUBLISHER, ROBOT_STATE_PUBLISHER)
_IN_TURNS = Publisher(UNPUBLISHED, about="its publishers take turns")
# ros/kdl_parser does not support floating joints, so ros/robot_state_publisher does not publish them.
_NOT_FLOATING = Publisher(UNPUBLISHED, about="robot_state_publisher publishes no floating joint")


class Turn(NamedTuple):
    """A node that publishes a joint only in some modes; ``when`` is the condition, ``path`` the path of the entry."""

    publisher: Publisher
    when: str
    path: Path


class JointPublishers(NamedTuple):
    """The publishers of a joint: one that publishes it in every mode, and nodes that publish it in some modes.

    robot_state_publisher publishes the entire URDF in every mode, so it is never in ``turns``.
    """

    always: Publisher
    turns: tuple[Turn, ...] = ()

    def of_optical(self) -> "JointPublishers":
        """Return the publishers of a sensor's optical frame; names of static publishers get the suffix ``_optical``."""

        def second(node: Publisher) -> Publisher:
            is_static = node.kind == STATIC_TRANSFORM_PUBLISHER
            return Publisher(STATIC_TRANSFORM_PUBLISHER, f"{node.name}_optical") if is_static else node

        turns = tuple(turn._replace(publisher=second(turn.publisher)) for turn in self.turns)
        return JointPublishers(second(self.always), turns)


def _joints(tree: Mapping[str, Any], lowering: Lowering) -> None:
    for name, entry in entries_of(tree, "joints"):
        path: Path = ("joints", name)
        lowering.place_joint(name, path, entry["child"], (*path, "child"))
        by = joint_publishers(lowering, entry, path)
        safety = record_of(SafetyController, entry["safety_controller"]) if "safety_controller" in entry else None
        add_joint(lowering, record_of(Joint, entry, name=name, publisher=by.always, safety=safety), by)


def add_joint(lowering: Lowering, joint: Joint, publishing: JointPublishers) -> None:
    """Add a joint to the robot, and an edge (transform) to the frame tree for each publisher in ``turns``."""
    lowering.joints.append(joint)
    for turn in publishing.turns:
        lowering.places["edge", str(len(lowering.edges))] = turn.path
        moving = not joint.is_fixed and turn.publisher.kind != STATIC_TRANSFORM_PUBLISHER
        edge = Edge(joint.parent, joint.child, turn.publisher, moving, turn.when, joint.origin)
        lowering.edges.append(replace(edge, source=joint.source, joint=joint.name))


def node(lowering: Lowering, name: str, path: Path) -> Publisher:
    """Look up the ROS node ``name`` among the publishers of the description; report an unknown name at ``path``."""
    if name in lowering.nodes:
        return lowering.nodes[name]
    help: Help = Suggestion(name, [*lowering.nodes, ROBOT_STATE_PUBLISHER])
    if name == STATIC_TRANSFORM_PUBLISHER:
        help = f'write "{{{name}: NODE_NAME}}" to name the node'
    lowering("unknown-publisher", f'there is no publisher "{name}"', path, help)
    return OF_THE_URDF


def joint_publishers(lowering: Lowering, entry: Mapping[str, Any], path: Path) -> JointPublishers:
    """Return the publishers of a joint from the key ``publisher`` of its entry (default: robot_state_publisher)."""
    requested, here = entry.get("publisher", ROBOT_STATE_PUBLISHER), (*path, "publisher")

    def publisher(value: Any, at: Path) -> Publisher:
        if isinstance(value, dict):
            if "none" in value or "simulation" in value:
                simulated = "none" not in value
                return Publisher(UNPUBLISHED, about=value["simulation" if simulated else "none"], simulated=simulated)
            return Publisher(STATIC_TRANSFORM_PUBLISHER, value[STATIC_TRANSFORM_PUBLISHER], "tf2_ros")
        if value == ROBOT_STATE_PUBLISHER:
            return _NOT_FLOATING if entry.get("type") in AXLELESS else OF_THE_URDF
        return node(lowering, value, at)

    if not isinstance(requested, list):
        return JointPublishers(publisher(requested, here))
    items = [(item, (*here, index)) for index, item in enumerate(requested)]
    turns = [Turn(publisher(item["by"], (*at, "by")), item.get("when", ""), at) for item, at in items]
    others = tuple(turn for turn in turns if turn.publisher.kind != ROBOT_STATE_PUBLISHER)
    return JointPublishers(_IN_TURNS if len(others) == len(turns) else OF_THE_URDF, others)


SECTION: Section[Any] = Section("joints", Joint, lower=_joints, checks=("rosorin_compile.rules.joints",))
