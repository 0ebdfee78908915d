"""A misspelt word in a part is told once, at its place, however often the part is used and whether it is mirrored."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from rosorin_compile.formats.compiled import understand
from rosorin_compile.source.diagnostics import ERROR, Diagnostic

pytestmark = pytest.mark.slow

# A word in <> is a key that only stands there; one in [[ ]] names something of the part, or the frame it sits on.
PART = """\
parts:
  arm:
    <params>:
      length: {<type>: length, <default>: 10 cm}
    <links>:
      base:
        <inertial>: {<mass>: 1 kg, <inertia>: {ixx: 1, iyy: 1, izz: 1}}
        <collision>: [{<box>: {<size>: [0.1, 0.1, "${length}"]}, <xyz>: [0, 0, 5 cm]}]
        <sites>: {grasp: {<xyz>: [0, 0, 0]}}
      tool: {<inertial>: {<mass>: 1 kg, <inertia>: {ixx: 1, iyy: 1, izz: 1}}}
      finger: {}
    <joints>:
      turn:
        <type>: revolute
        <parent>: [[mount]]
        <child>: [[base]]
        <limit>: {<lower>: -1, <upper>: 1, <effort>: 1, <velocity>: 1}
        <dynamics>: {<damping>: 0.1}
      slide:
        type: prismatic
        parent: [[base]]
        child: tool
        xyz: [0, 0, 10 cm]
        limit: {lower: 0, upper: 1 cm, effort: 1, velocity: 1}
      grip:
        type: revolute
        parent: [[tool]]
        child: [[finger]]
        limit: {lower: -1, upper: 1, effort: 1, velocity: 1}
        <mimic>: {<joint>: [[turn]], <multiplier>: 2}
    <sensors>:
      scan: {<type>: lidar_2d, <parent>: [[tool]], <frame>: laser, <xyz>: [0, 0, 1 cm]}
    <servos>:
      motors: {<joints>: [[[turn]]], <rad_per_pulse>: 0.01, <zero_pulse>: 500, <pulse_range>: [0, 1000]}
    <poses>:
      home: {<positions>: {slide: 0}, <pulses>: {turn: 500}}
      away: {<positions>: {[[slide]]: 0}, <pulses>: {[[turn]]: 600}}
    <disabled_contacts>:
      - {<links>: [[[base]], [[finger]]], <reason>: they touch}
    <control>:
      hardware:
        <plugin>: maker/Driver
        <joints>:
          [[slide]]: {<command>: [position], <state>: [position]}
          turn: {command: [position], state: [position]}
    <controllers>:
      trajectory: {<type>: joint_trajectory, <hardware>: [[hardware]], <params>: {joints: [[[slide]], [[turn]]]}}
    <moveit>:
      <groups>:
        manipulator: {<chain>: {<base>: [[mount]], <tip>: [[tool]]}, <states>: {ready: [[home]]}}
        hand: {<joints>: [[[grip]]]}
        others: {<links>: [[[finger]]]}
      <end_effectors>: {gripper: {<group>: [[hand]], <parent>: [[tool]], <parent_group>: [[manipulator]]}}
      <passive_joints>: [[[grip]]]
      <disabled_collisions>: [{<links>: [[[base]], [[finger]]], <reason>: they touch}]
      <spheres>: {[[tool]]: [{<xyz>: [0, 0, 0], <radius>: 1 cm}]}
      <joint_properties>: {[[turn]]: {speed: 1}}
    <actuators>: {motor: {<type>: motor, <joint>: [[slide]]}}
    <constraints>: {held: {<type>: weld, <links>: [[[base]], [[finger]]]}}
    <urdf_elements>: ['<gazebo reference="[[tool]]"/>']
"""
ROBOT = """\
robot: two
include: [arm.yaml]
links: {base_link: {}}
use:
%soutputs:
  urdf: {file: two.urdf, control: jazzy}
  srdf: {file: two.srdf}
  mjcf: {file: two.xml}
  controllers: {file: controllers.yaml}
"""
USES = {
    "once": "  left: {part: arm, parent: base_link}\n",
    "twice": "  left: {part: arm, parent: base_link}\n  right: {part: arm, parent: base_link, xyz: [1, 0, 0]}\n",
    "mirrored": "  left: {part: arm, parent: base_link, xyz: [0, 1, 0]}\n"
    "  right: {part: arm, parent: base_link, xyz: [0, -1, 0], mirror: y}\n",
}
WORD = re.compile(r"<(\w+)>(?=:)|\[\[(\w+)\]\]")


def written(change: int | None = None) -> tuple[str, list[tuple[int, int, str, bool]]]:
    """Return the part without the marks, and its words: line, column, the word, whether it is a key.

    The word of the number ``change`` has two letters swapped.
    """
    words: list[tuple[int, int, str, bool]] = []
    lines = []
    for number, line in enumerate(PART.splitlines(), start=1):
        made, position = "", 0
        for found in WORD.finditer(line):
            made += line[position : found.start()]
            word = found[1] or found[2]
            words.append((number, len(made) + 1, word, found[2] is None))
            made += swapped(word) if len(words) - 1 == change else word
            position = found.end()
        lines.append(made + line[position:])
    return "\n".join(lines) + "\n", words


def swapped(word: str) -> str:
    """Return a word with two letters swapped."""
    places = range(len(word) - 2, -1, -1)
    at = next(at for at in places if word[at] != word[at + 1])
    return word[:at] + word[at + 1] + word[at] + word[at + 2 :]


def errors(folder: Path, uses: str, change: int | None) -> list[Diagnostic]:
    text, _ = written(change)
    (folder / "arm.yaml").write_text(text)
    (folder / "robot.yaml").write_text(ROBOT % uses)
    diagnostics = understand(folder / "robot.yaml").diagnostics
    return [one for one in diagnostics if one.severity == ERROR or one.rule == "unknown-reference"]


def cases() -> Iterator[object]:
    for index, (line, _, word, _) in enumerate(written()[1]):
        for use in USES:
            yield pytest.param(index, use, id=f"{line}-{word}-{index}-{use}")


@pytest.mark.parametrize("use", USES)
def test_the_part_is_sound(tmp_path: Path, use: str) -> None:
    assert errors(tmp_path, USES[use], None) == []


@pytest.mark.parametrize(("index", "use"), list(cases()))
def test_a_misspelt_word_is_told_once(tmp_path: Path, index: int, use: str) -> None:
    line, column, word, is_key = written()[1][index]
    told = errors(tmp_path, USES[use], index)
    assert len(told) == 1, [str(one) for one in told]
    (one,) = told
    assert one.span is not None
    assert (Path(one.span.source.path).name, one.span.line, one.span.column) == ("arm.yaml", line, column), str(one)
    assert f'"{word}"' in one.help, one.help
    assert not is_key or one.rule == "unknown-key"
    if one.message.startswith(("part ", "argument ")):  # found before the part is made
        return
    if not re.search("<spheres>|<joint_properties>", PART.splitlines()[line - 1]):  # one table of the whole robot
        uses = {related for related in one.related if "used here as" in related.message}
        assert len(uses) == len(USES[use].splitlines())
