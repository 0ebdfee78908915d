"""Broken URDF and xacro files get their message: each case in tests/broken_sources lists them in its comment.

The comment (see support/cases.py) may begin with "options: lenient NAME:=VALUE". Two dashes, which no comment may hold,
are written as ==.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile.source.diagnostics import ERROR, has_errors
from support.cases import as_xml_comment, check, read
from support.paths import BROKEN_SOURCES, DOCS

CASES = sorted([*BROKEN_SOURCES.glob("*.urdf"), *BROKEN_SOURCES.glob("*.xacro")])
DOCUMENTED = (DOCS / "rules.md").read_text("utf-8")


@pytest.mark.parametrize("case", CASES, ids=[case.name for case in CASES])
def test_message(case, monkeypatch):
    monkeypatch.chdir(BROKEN_SOURCES)
    imported = read(Path(case.name))
    assert imported.diagnostics
    check(case, as_xml_comment(imported.diagnostics, case.name))
    assert (imported.tree is None) == has_errors(imported.diagnostics)
    for one in imported.diagnostics:
        assert f"`{one.rule}` |" in DOCUMENTED, f"docs/rules.md has no row for {one.rule}"
        if one.severity == ERROR:
            assert one.span
            assert one.help or one.rule == "xacro-error"  # the message of xacro says what to do
