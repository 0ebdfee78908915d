"""Corners of what check says of committed artifacts: names that other things have, too, and what a change explains."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from rosorin_compile.compare.golden_check import compare
from support.paths import data_text
from support.robots import compiled_text, sound

CASES = yaml.safe_load(data_text("cases/committed_corners.yaml"))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["id"])
def test_what_is_said(case: dict[str, Any], tmp_path: Path) -> None:
    before = after = data_text(f"robots/corners_{case['robot']}.yaml")
    for old, new in case["edits"]:
        assert after.count(old) == 1, old
        after = after.replace(old, new)
    _, _, old = sound(compiled_text(tmp_path, before))
    robot, _, new = sound(compiled_text(tmp_path, after))
    committed = {artifact.file: artifact.text.encode() for artifact in old.artifacts}
    assert [change.line() for change in compare(robot, new.artifacts, committed).changes] == case["said"]
