"""A name of what a condition or a loop has left out: that is told, once, wherever it is missed, and nothing else is."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from rosorin_compile.formats.compilation import understand
from rosorin_compile.source.diagnostics import ERROR, Diagnostic
from support.paths import data_text

ROBOT = data_text("robots/left_out.yaml")
CASES = yaml.safe_load(data_text("cases/left_out.yaml"))
LEFT_OUT, NAMED = CASES["left_out"], CASES["named"]


def told(folder: Path, left_out: str, named: str) -> list[Diagnostic]:
    """Return the errors of the robot with one more use, which is left out, and one more section."""
    outputs = "outputs: {urdf: {file: r.urdf}, srdf: {file: r.srdf}, mjcf: {file: r.xml}}\n"
    (folder / "robot.yaml").write_text(ROBOT + left_out + named + outputs)
    return [one for one in understand(folder / "robot.yaml").diagnostics if one.severity == ERROR]


@pytest.mark.parametrize("how", LEFT_OUT)
def test_nothing_is_missed(tmp_path: Path, how: str) -> None:
    assert told(tmp_path, LEFT_OUT[how]["use"], "") == []


@pytest.mark.parametrize("how", LEFT_OUT)
@pytest.mark.parametrize("where", NAMED)
def test_what_is_left_out_is_told_once(tmp_path: Path, how: str, where: str) -> None:
    found = told(tmp_path, LEFT_OUT[how]["use"], NAMED[where])
    assert len(found) == 1, [str(one) for one in found]
    assert f"; {LEFT_OUT[how]['cause']} because its " in found[0].message.replace(f"{tmp_path}/", "")
    assert found[0].related[0].message == "left out here"


@pytest.mark.parametrize("how", LEFT_OUT)
def test_a_misspelt_name_is_no_name_of_it(tmp_path: Path, how: str) -> None:
    (one,) = told(tmp_path, LEFT_OUT[how]["use"], "poses: {wave: {positions: {left_trun: 0}}}\n")
    assert (one.rule, one.help) == ("unknown-joint", 'did you mean "left_turn"?')
    assert "left out" not in one.message
