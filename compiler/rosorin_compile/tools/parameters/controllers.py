"""Controllers of files: their types, what they need, and where they say something else than the robot."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ...diagnostics import ERROR, Diagnostic, Related, error
from ...formats.controllers.checking import against_robot, missing
from ...formats.controllers.known import known
from ...formats.controllers.types import full, of_type
from ...formats.parameters.tables import MANAGER
from ...model.control import Controller
from ...rules.case import Case
from .files import Section
from .nodes import Node


def none(files: Sequence[Sequence[Section]]) -> Diagnostic:
    """Return that files have no controllers."""
    help = f"{MANAGER}: {{ros__parameters: {{NAME: {{type: TYPE}}}}}}"
    return error("controllers-none", "no controller stands here: nothing says the type of one", files[0][0].span, help)


def check(case: Case, node: Node, distribution: str) -> Iterator[Diagnostic]:
    """Yield what is wrong with a controller; nothing of another node."""
    if not node.type:
        return
    wrong = of_type(node.shown, node.type, distribution)
    if wrong is not None:
        yield wrong.at(node.said)
    plain = {key: one.value for key, one in node.parameters.items() if not one.substituted}
    kind = full(node.type)
    knows = known(case.robot, Controller(node.name, kind, plain), kind)
    for found in missing(node.shown, node.kind if wrong is None else None, node.parameters):
        yield found.at(node.span)
    moving = any(not joint.is_fixed for joint in case.robot.joints)
    for found in against_robot(node.shown, kind, plain, knows, case.robot, ERROR):
        if found.rule == "controller-name" and not moving:
            continue  # a description of where things are mounted
        yield found.at(node.setting(found.key).span, _drive(case, found.rule))


def _drive(case: Case, rule: str) -> list[Related]:
    """Return where the robot says of its drive what a file says otherwise."""
    return [case.related("the drive of the robot", ("drive",), key=True)] if rule == "controller-differs" else []
