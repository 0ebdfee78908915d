"""One of the links and joints that are alike speaks for all, until there is something to say: then each does."""

from __future__ import annotations

from pathlib import Path

from rosorin_compile.formats.load_robot import understand

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


def test_a_mistake_in_a_part_is_told_of_each_use(tmp_path: Path) -> None:
    """A rule that asks one of a kind first names each use of the part that has the mistake."""
    (tmp_path / "robot.yaml").write_text(ROBOT.replace("axis: [0, 0, 1]", "axis: [0, 0, 2]"))
    (told,) = [one for one in understand(tmp_path / "robot.yaml").diagnostics if one.rule == "axis-not-unit"]
    assert '"a_joint"' in told.message
    first, _, *others = [one.message for one in told.related]  # the second is the round of the loop
    assert [first, *others] == [f'part "segment" used here as "{use}"' for use in "abc"]
