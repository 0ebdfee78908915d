"""Small xacros, translated."""

from __future__ import annotations

from pathlib import Path

from rosorin_compile.formats.imported import Outputs, ReadOptions
from rosorin_compile.formats.reading import read_robot
from rosorin_compile.importing.xacro.translate import Translation, translate
from rosorin_compile.importing.xacro.write_yaml import Target

_HEAD = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'


def translation_of(here: Path, body: str) -> Translation:
    """Return the translation of a xacro that holds a text."""
    path = here / "robot.xacro"
    path.write_text(f"{_HEAD}{body}</robot>", "utf-8")
    how = ReadOptions(trust=True)
    imported = read_robot(path, how)
    assert imported.tree is not None, imported.diagnostics
    return translate(path, how, imported, Outputs({"urdf": {"file": "robot.urdf"}}, {}, {}), Target(Path("d")))
