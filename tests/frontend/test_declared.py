"""What is declared in vain: told at its line, and nothing that another robot, another value or another branch needs."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rosorin_compile.formats.compilation import compile_robot
from support.paths import ROOT
from support.robots import compiled_text

START = "robot: it\nlinks: {base_link: {}}\n"


def idle(made) -> list[str]:
    return [d.message for d in made.diagnostics if d.rule == "unused"]


@pytest.mark.parametrize("path", sorted((ROOT / "parts").glob("*.yaml")), ids=lambda path: path.stem)
def test_the_library_uses_what_it_declares(tmp_path, path):
    """Read as a description: its parts are unused there, but each of them uses its own parameters and values."""
    whole = path.read_text("utf-8")
    text = whole[re.search(r"^(let|parts|sensor_types):", whole, re.MULTILINE).start() :]
    told = idle(compiled_text(tmp_path, START + text))
    assert told
    assert not [message for message in told if "never uses" in message]


def test_a_name_inside_does_not_use_the_one_outside(tmp_path):
    text = "let: {r: 1, i: 2}\nparts: {a: {params: {r: 2}, links: {l: {visual: [{sphere: {radius: '${r}'}}]}}}}\n"
    text += "use: {it: {part: a}}\nsensors: {'s${i}': {for: {i: [1]}, type: imu, parent: base_link, frame: 's${i}'}}\n"
    text += "joints: {j: {type: fixed, parent: base_link, child: it_l}}\n"
    told = idle(compiled_text(tmp_path, START + text))
    assert told == ['nothing uses the value "r"', 'nothing uses the value "i"']


def test_it_waits_until_nothing_is_wrong(tmp_path):
    """What is misspelt may be the use of what seems to have none."""
    text = "publishers: {amcl: {}}\nedges: [{parent: odom, child: base_link, publisher: amlc}]\n"
    made = compiled_text(tmp_path, START + text)
    assert [d.rule for d in made.diagnostics] == ["unknown-publisher"]


def test_a_file_that_two_robots_share(tmp_path):
    """What one of them does not use, the other may; once it is alone, it is told."""
    project = tmp_path / "descriptions"
    for name in ("one", "two"):
        (project / name).mkdir(parents=True)
        (project / name / "robot.yaml").write_text(f"robot: {name}\ninclude: [base.yaml]\n" + START[10:], "utf-8")
        (project / name / "base.yaml").write_text("let: {height: 1 m}\nparts: {wheel: {links: {hub: {}}}}\n", "utf-8")
    assert idle(compile_robot(project / "one" / "robot.yaml")) == []
    (project / "two" / "robot.yaml").unlink()
    told = idle(compile_robot(project / "one" / "robot.yaml"))
    assert told == ['nothing uses the value "height"', 'nothing uses the part "wheel"']


def test_arguments_that_an_include_passes_on(tmp_path):
    (tmp_path / "arm.yaml").write_text("args: {reach: 1 m}\nlinks: {arm: {}, far: {if: '${reach > 2}'}}\n", "utf-8")
    text = "let: {long: 3 m}\ninclude: [{file: arm.yaml, args: {reach: '${long}'}}]\n"
    text += "joints: {a: {type: fixed, parent: base_link, child: arm}, b: {type: fixed, parent: arm, child: far}}\n"
    (tmp_path / "robot.yaml").write_text(START + text, "utf-8")
    made = compile_robot(Path(tmp_path / "robot.yaml"))
    assert [d.message for d in made.diagnostics] == []
