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


@pytest.mark.parametrize(
    "text",
    [
        "A stand-in. A stand-alone program is no longer needed. The rollers lie along the rim.",
        'It is defined twice. `--publisher` takes a node or "nobody".',
        "What is this? It shows what each package contains.",
    ],
)
def test_ordinary_english_is_not_reported(text: str) -> None:
    assert prose.findings("page.md", text) == []


def test_a_finding_has_its_place_and_a_replacement() -> None:
    text = "# Title\n\n`What it says` is code. The file\nsays so.\n```yaml\nhelp: it is told\n```\nWhat is this?\n"
    assert [str(finding) for finding in prose.findings("page.md", text)] == [
        'page.md:4:1: "says": write defines, sets, declares, states, prints'
    ]
