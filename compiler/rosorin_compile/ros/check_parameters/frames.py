"""The frames that parameters name: they exist, somebody publishes them, and the base frame is one that moves."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from rosorin_compile.model import ROBOT_STATE_PUBLISHER
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.joints import pieces
from rosorin_compile.rules.publishers import steps_in_modes
from rosorin_compile.source.diagnostics import Diagnostic, Related, Suggestion, error, quoted

from ..parameters.tables import Key
from .nodes import DEFAULT, Node, Setting
from .owners import Claim

BASE, ODOM, MAP, SENSOR = "base", "odom", "map", "sensor"


def check(case: Case, nodes: Iterable[Node], found: Sequence[Claim]) -> Iterator[Diagnostic]:
    """Yield what is wrong with the frames that nodes name. What they publish is judged by ``owners``."""
    simulated = case.robot.simulated_frames
    known = {*case.robot.frames, *(name for edge in case.robot.edges for name in (edge.parent, edge.child))}
    claimed = {claim.node.full: {claim.parent.span, claim.child.span} for claim in found if not claim.silent}
    made = {str(claim.parent.value) for claim in found if not claim.silent}
    published = [(str(claim.parent.value), str(claim.child.value)) for claim in found if not claim.silent]
    parts = pieces([*((step.parent, step.child) for step in steps_in_modes(case)[0]), *published])
    for node in nodes:
        yield from _prefixed(node)
        for key, name, setting in _named(node):
            own = setting.given and setting.span in claimed.get(node.full, ())
            if own and setting.value not in simulated and _is_end(node, key, found):
                continue  # told, if it is wrong, with the edge
            yield from _frame(case, node, key, name, setting, known | made, parts)


def _prefixed(node: Node) -> Iterator[Diagnostic]:
    prefix = node.setting("frame_prefix") if node.kind and node.kind.name == ROBOT_STATE_PUBLISHER else None
    if prefix is not None and prefix.value and isinstance(prefix.value, str):
        message = f'"frame_prefix" of {node.shown} is "{prefix.value}": it writes that before every frame of the robot'
        message += ", and no other node does"
        yield error("parameters-frame", message, prefix.span, "remove it, or give the links of the robot these names")


def _is_end(node: Node, key: Key, found: Sequence[Claim]) -> bool:
    return any(claim.node is node and not claim.silent for claim in found) and key.frame != SENSOR


def _named(node: Node) -> Iterator[tuple[Key, str, Setting]]:
    """Yield the keys of a node that name frames, by their full names, with what holds, given or by default.

    What a filter calls the map matters where its transform begins there, which is told with the edge.
    """
    if node.kind is None:
        return
    unused = MAP if node.kind.name == "ekf" else ""
    for name, parameter in node.parameters.items():
        key = node.kind.key(name)
        held = key is not None and key.frame and key.frame != unused and not parameter.substituted
        if key is not None and held and isinstance(parameter.value, str):
            yield key, name, Setting(parameter.value, parameter.span, True)
    for key in node.kind.keys.values():
        held = key.frame and key.frame != unused and not key.many and key.default
        if held and key.name not in node.parameters:
            yield key, key.name, node.setting(key.name)


def _frame(
    case: Case, node: Node, key: Key, full: str, setting: Setting, known: set[str], parts: Sequence[set[str]]
) -> Iterator[Diagnostic]:
    if not setting.value and key.frame == SENSOR:
        return
    name = f'"{full}" of {node.shown}'
    value, assumed = str(setting.value), f" {DEFAULT}" if not setting.given else ""
    if value.startswith("/") and not (node.kind and node.kind.strips_slash):
        message = f'{name} is "{value}": tf2 refuses names of frames that begin with "/"'
        yield error("parameters-frame", message, setting.span, f'write "{value.lstrip("/")}"')
        return
    value = value.removeprefix("/")
    if key.frame == BASE:
        yield from _base(case, node, key, setting, value, parts)
    elif value not in known:
        message = f'{name} is "{value}"{assumed}: there is no such frame'
        yield error("parameters-frame", message, setting.span, Suggestion(value, known, "name a frame of the robot"))
    elif not any(value in part for part in parts) and len(known) > 1:
        message = f'{name} is "{value}"{assumed}, a frame that no node publishes'
        yield error("parameters-frame", message, setting.span, "say who publishes it", _unpublished(case, value))


def _unpublished(case: Case, frame: str) -> list[Related]:
    joint = case.robot.joint_to.get(frame) or next(iter(case.robot.joints_from.get(frame, ())), None)
    return [case.related(f'no node publishes joint "{joint.name}"', case.publisher(joint))] if joint else []


def _base(
    case: Case, node: Node, key: Key, setting: Setting, value: str, parts: Sequence[set[str]]
) -> Iterator[Diagnostic]:
    name = f'"{key.name}" of {node.shown}'
    assumed = f" {DEFAULT}" if not setting.given else ""
    odom = _odometry(case, node)
    moved = [step for step in steps_in_modes(case)[0] if step.parent == odom]
    part = next((part for part in parts if odom in part), set[str]())
    if value in part or not moved:
        return
    related = [case.related(f"{step.parent} -> {step.child} is described here", step.path) for step in moved]
    help = f"{key.name}: {moved[0].child}"
    if value in case.robot.link:
        message = f'{name} is "{value}"{assumed}, and no transform leads to it from "{odom}"'
        message += f": the odometry moves {quoted(step.child for step in moved)}"
        yield error("parameters-base", message, setting.span, help, [*related, *_unpublished(case, value)])
    else:
        message = f'{name} is "{value}"{assumed}: there is no such frame'
        yield error("parameters-frame", message, setting.span, Suggestion(value, part, instead=help), related)


def _odometry(case: Case, node: Node) -> str:
    """Return the frame that the odometry is given in: as the node says, if it is there, else as the description has it.

    That is the parent of the transform of another node that leads to the robot and hangs on no other, but for a map.
    """
    said, steps = [s.value for key, _, s in _named(node) if key.frame == ODOM], steps_in_modes(case)[0]
    parents = [step.parent for step in steps if step.edge is not None]
    if said and said[0] in parents:
        return str(said[0])
    children = {step.child for step in steps}
    moving = [step for step in steps if step.edge is not None and case.robot.edges[step.edge].moving]
    lowest = [step.parent for step in moving if step.child not in parents]
    return next((p for p in lowest if p in children), next(iter(lowest), ""))
