"""Arguments that an including description gives to what it includes."""

from __future__ import annotations

from pathlib import Path

from support.robots import compiled, texts

ROOT = """\
robot: taller
let: {spare: 20 mm}
include:
  - {file: mast.yaml, args: {height: "${6*spare}", side: left}}
links: {base_link: {}}
outputs: {urdf: {file: taller.urdf}}
"""
MAST = """\
args:
  height: {type: length, help: from the deck up}
  side: {one_of: [left, right], default: right}
links: {mast: {}}
joints:
  mast_joint: {type: fixed, parent: base_link, child: mast, xyz: [0, "${0.1 if side == 'left' else -0.1}", "${height}"]}
"""


def test_an_include_gives_arguments_as_expressions_and_the_command_line_has_the_last_word(tmp_path: Path) -> None:
    (tmp_path / "mast.yaml").write_text(MAST, "utf-8")
    (tmp_path / "robot.yaml").write_text(ROOT, "utf-8")
    path = tmp_path / "robot.yaml"
    assert 'xyz="0 0.1 0.12"' in texts(compiled(path))["taller.urdf"]
    assert 'xyz="0 0.1 0.3"' in texts(compiled(path, {"height": "30 cm"}))["taller.urdf"]
    assert 'xyz="0 -0.1 0.12"' in texts(compiled(path, {"side": "right"}))["taller.urdf"]
