"""The documentation is written in plain English: docs/make/prose.py finds no expression to avoid."""

import pytest

import prose
from support.paths import DOCS


def test_the_documentation_and_the_help_have_no_expression_to_avoid(capsys: pytest.CaptureFixture[str]) -> None:
    assert prose.main([]) == 0, capsys.readouterr().out


def test_the_terms_that_readers_search_for_occur() -> None:
    assert prose.missing_terms([path.read_text("utf-8") for path in DOCS.glob("*.md")]) == []


def test_the_help_of_every_command_has_no_expression_to_avoid() -> None:
    lines = dict(prose.help_texts())
    assert {f"rosorin-compile {words}--help" for words in ("", "all ", "pulses ", "check physics ")} <= set(lines)
    assert [str(one) for name, text in lines.items() for one in prose.findings(name, text)] == []
