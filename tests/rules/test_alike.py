"""One of the links and joints that are alike speaks for all, until there is something to say: then each does."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from rosorin_compile.formats.compiled import understand
from rosorin_compile.model import Joint, Link, Robot
from rosorin_compile.rules.case import joints_by_value, links_by_value
from rosorin_compile.source.diagnostics import Diagnostic, error

ROBOT = """
robot: chain
parts:
  segment:
    params: {damping: {type: number}}
    links:
      link: {inertial: {mass: 1, of: collision}, collision: [{sphere: {radius: 5 cm}}]}
    joints:
      joint: {type: continuous, parent: mount, child: link, axis: [0, 0, 1], dynamics: {damping: "${damping}"}}
links: {base_link: {}}
use:
  "${name}":
    for: {"name, parent, damping": [[a, base_link, 0.1], [b, a_link, 0.2], [c, b_link, 0.1]]}
    part: segment
    parent: ${parent}
    xyz: [0, 0, 10 cm]
    with: {damping: "${damping}"}
outputs: {urdf: {file: chain.urdf}}
"""


def asked(tell: Callable[[str], bool]) -> tuple[list[str], Callable[[Link | Joint], Iterator[Diagnostic]]]:
    """Return what looks at links and joints, and the list of those that it looked at."""
    seen: list[str] = []

    def look(one: Link | Joint) -> Iterator[Diagnostic]:
        seen.append(one.name)
        if tell(one.name):
            yield error("a-rule", one.name, None)

    return seen, look


def test_one_speaks_for_all_where_nothing_is_wrong(tmp_path: Path) -> None:
    """Of links that share their inertials and shapes one is looked at."""
    kinds = links_by_value(robot_in(tmp_path))
    seen, look = asked(lambda _: False)
    assert list(kinds.problems(look)) == []
    assert seen == ["a_link", "base_link"]


def test_each_is_told_where_something_is_wrong(tmp_path: Path) -> None:
    """What is wrong with the first of a kind may be wrong with each: all of them are looked at, in their order."""
    kinds = links_by_value(robot_in(tmp_path))
    _, look = asked(lambda name: name != "base_link")
    assert [one.message for one in kinds.problems(look)] == ["a_link", "b_link", "c_link"]


def test_joints_with_other_values_are_of_another_kind(tmp_path: Path) -> None:
    """Joints with another damping are looked at by themselves."""
    kinds = joints_by_value(robot_in(tmp_path))
    seen, look = asked(lambda _: False)
    assert list(kinds.problems(look)) == []
    assert "b_joint" in seen


def test_a_mistake_in_a_part_is_told_of_each_use(tmp_path: Path) -> None:
    """A rule that asks one of a kind first names each use of the part that has the mistake."""
    (tmp_path / "robot.yaml").write_text(ROBOT.replace("axis: [0, 0, 1]", "axis: [0, 0, 2]"))
    (told,) = [one for one in understand(tmp_path / "robot.yaml").diagnostics if one.rule == "axis-not-unit"]
    assert '"a_joint"' in told.message
    first, _, *others = [one.message for one in told.related]  # the second is the round of the loop
    assert [first, *others] == [f'part "segment" used here as "{use}"' for use in "abc"]


def robot_in(folder: Path) -> Robot:
    """Return the robot of a description in a folder."""
    (folder / "robot.yaml").write_text(ROBOT)
    lowered = understand(folder / "robot.yaml").lowered
    assert lowered is not None
    assert lowered.robot is not None
    return lowered.robot
