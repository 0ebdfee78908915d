"""Names of planning groups and poses in the section ``moveit``, whether an output has it or not."""

from __future__ import annotations

from collections.abc import Iterator

from rosorin_compile.model.moveit import Group
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import Diagnostic, Heading
from rosorin_compile.source.rule_registry import rule
from rosorin_compile.source.tree import Path, exists

from . import MOVEIT

AFTER = "outputs"


@rule("moveit-unknown-group", "A name is that of no planning group.", "Correct the name.", Heading.OUTPUTS)
@rule("moveit-unknown-pose", "A state of a group is a pose that there is not.", "Correct the name.", Heading.OUTPUTS)
def planning(case: Case) -> Iterator[Diagnostic]:
    """Find planning groups and poses that a section for planners names and that are not there."""
    said = case.robot.sections[MOVEIT]
    if said is None:
        return
    groups, poses = [group.name for group in said.groups], [pose.name for pose in case.robot.poses]
    for id, kind, known, otherwise in (
        ("moveit-unknown-group", "planning group", groups, "name a group of moveit"),
        ("moveit-unknown-pose", "pose", poses, "add it to poses"),
    ):
        for one in case.mentions(kind):
            if one.name not in known:
                help = case.suggest(one.path, one.name, known, otherwise)
                yield case.problem(id, f'there is no {kind} "{one.name}", {one.what}', one.path, help)


def state_path(case: Case, group: Group, state: str) -> Path:
    """Return the path of a state of a planning group: its key, or its place in a list."""
    path: Path = ("moveit", "groups", group.name, "states")
    return (*path, state) if exists(case.tree, (*path, state)) else (*path, list(group.states or ()).index(state))
