"""The documentation is written in plain English: docs/make/prose.py finds no expression to avoid."""

from __future__ import annotations

import pytest

import prose
from support.paths import DOCS

# The pages that are rewritten. Call prose.main([]) instead as soon as all of them are.
REWRITTEN = (
    "agents.md",
    "architecture.md",
    "artifacts.md",
    "builds.md",
    "controllers.md",
    "extend.md",
    "moveit.md",
    "nav2.md",
    "parts-library.md",
    "ros-package.md",
    "shell.md",
)


def test_the_pages_have_no_expression_to_avoid(capsys: pytest.CaptureFixture[str]) -> None:
    assert prose.main([str(DOCS / name) for name in REWRITTEN]) == 0, capsys.readouterr().out


def test_a_finding_has_its_place_and_a_replacement() -> None:
    text = "# Title\n\n`What it says` is code. The file\nsays so.\n```yaml\nhelp: it is told\n```\nWhat is this?\n"
    assert [str(finding) for finding in prose.findings("page.md", text)] == [
        'page.md:4:1: "says": write defines, sets, declares, states, prints'
    ]


def test_a_sentence_begins_with_its_subject() -> None:
    found = prose.findings("page.md", "| What a part is | text |\n\nOf a mesh the hull counts. What counts is new.\n")
    assert [(one.line, one.column, one.expression) for one in found] == [
        (1, 3, "What"),
        (3, 1, "Of a"),
        (3, 28, "What"),
    ]


def test_a_term_that_readers_search_for_has_to_occur() -> None:
    texts = ["An override of a default; a duplicate is an error. Reference.", "compare, deprecated"]
    assert prose.missing_terms(texts) == ["environment variable"]
    assert prose.missing_terms([*texts, "Environment\nvariables"]) == []


def test_the_help_of_every_command_is_checked() -> None:
    lines = dict(prose.help_texts())
    assert {"rosorin-compile --help", "rosorin-compile all --help", "rosorin-compile check physics --help"} <= set(
        lines
    )
