"""Markdown: no text of a robot is markup, a mention or a link; the document is bounded and names what is left out.

The judge is GitHub's own cmark.
"""

import html
import re
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosorin_compile.cli.console import Console
from rosorin_compile.cli.report_formats import MAX_BYTES, Section, code, from_workspace, github, markdown
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, Related, Source, Span, error
from rosorin_compile.source.wording import printable

cmarkgfm = pytest.importorskip("cmarkgfm")

EVIL = """@admin|@org/team|#12|GH-12|a/b#3|0123abcdef|:tada:|$x$|${a}${b}|www.evil.com|https://evil.com|mail@evil.com
<img src=x onerror=alert(1)>|<!-- x|</details>|<script>|&lt;|![x](https://evil.com/a.png)|[x](javascript:y)|\\|a\\|`
``` x|**b**|__b__|~~b~~|- x|1. x|# x|> x|---|===|\r|\x1b[2J|\u202e|[^1]|[x]: y|- [ ] x|\t x|    x| ||\udc80|日本 @x
(@x)|"@x"|'@x',""".replace("\n", "|").split("|")
EVIL += ["a|b", "a\\|b", "| a |", "a`b|c`", "a@b.co|c", "\n\n# x", "a\nb", "a\n```\n# x"]


def rendered(text: str) -> str:
    made: str = cmarkgfm.github_flavored_markdown_to_html(text, cmarkgfm.Options.CMARK_OPT_UNSAFE)
    return made


def judge(text: str) -> None:
    (body,) = re.findall(r"<tbody>(.*?)</tbody>", rendered(f"| a | b |\n| --- | --- |\n| {code(text)} | end |\n"), re.S)
    first, last = re.findall(r"<td>(.*?)</td>", body, re.DOTALL)
    assert re.fullmatch(r"<code>(?:(?!</?code>).)*</code>", first), first
    shown = html.unescape(re.sub(r"<!-- -->|<[^>]*>", "", first))
    assert shown.split() == printable(text).split()
    assert last == "end"


@pytest.mark.parametrize("text", EVIL, ids=ascii)
def test_no_text_is_alive(text: str) -> None:
    judge(text)
    judge(f"link {text} is not")


@given(st.text(max_size=11))  # more would be cut, each letter made visible
def test_no_text_at_all_is_alive(text: str) -> None:
    judge(text)


def section(text: str) -> Section:
    span = Span(Source(text, text), 1, 2)
    told = Diagnostic("a-rule", WARNING, text, span, (Related(text, span), Related(text, None)), text)
    made = Section(text, lines=[text], wrong=["not up to date"])
    made.differences += [f"-{text}", f"+{text}", text]
    made.diagnostics += [told, replace(told, severity=NOTE), error("b", text, None, text)]
    return made


@pytest.mark.parametrize("text", [text for text in EVIL if text.strip()], ids=ascii)
def test_a_document_has_our_elements_alone(text: str) -> None:
    made = markdown([section(text), Section(text, [text])])
    assert printable(made, "\n\t") == made

    def tags(out: str) -> list[str]:
        return re.findall(r"<[^>]*>", re.sub(r"<code>.*?</code>", "<code>", out.replace("<!-- -->", ""), flags=re.S))

    assert tags(rendered(made)) == tags(rendered(markdown([section("plain"), Section("plain", ["plain"])])))


@pytest.mark.parametrize("robots", [1, 30, 200])
@pytest.mark.parametrize("rows", [0, 10, 3000])
def test_it_is_bounded_and_says_what_is_left_out(robots: int, rows: int) -> None:
    lines = ["+" + "some words " * 40] * min(rows, 30_000 // robots)
    told = Diagnostic("a-rule", NOTE, "some words " * 20)
    sections = [Section(f"robot{n}", [], ["not up to date"], lines, [told]) for n in range(robots)]
    told = markdown(sections)
    assert len(told.encode()) <= MAX_BYTES
    named = len(set(re.findall(r"`robot\d+`", told)))
    more = re.search(r"- and ([\d,]+) more robots", told)
    assert named + (int(more[1].replace(",", "")) if more else 0) == robots
    assert told.count("<details>") == told.count("</details>")
    if rows > 20 and robots == 1:
        assert re.search(r"[\d,]+ more lines", told)
    if rows == 3000 and robots > 1:
        assert "Too much to show here" in told or "more lines" in told


def test_paths_are_seen_from_the_top_of_a_checkout(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (home / "robots").mkdir()
    monkeypatch.setenv("GITHUB_WORKSPACE", str(home))
    monkeypatch.chdir(home / "robots")
    assert from_workspace("descriptions/a.yaml") == "robots/descriptions/a.yaml"
    assert from_workspace(str(home / "x.yaml")) == "x.yaml"
    assert from_workspace("../../x.yaml") == "../../x.yaml"
    told = Diagnostic("a", NOTE, "b", Span(Source("descriptions/a.yaml", ""), 1, 1))
    assert github([told]) == "::notice file=robots/descriptions/a.yaml,line=1,col=1,title=a::b\n"
    assert "\nrobots/descriptions/a.yaml:1:1: note[a]: b" in markdown([Section("a", wrong=["x"], diagnostics=[told])])


@pytest.mark.parametrize("name", ["::add-mask::x", " ::error::x", "##[error]x"])
def test_no_line_for_github_is_a_command(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    console = Console("github")
    console.say(f"{name}: fine")
    console.warn(f"{name}: 1 error")
    for line in capsys.readouterr().err.splitlines():
        assert "::" not in line
        assert "##[" not in line
        assert line.endswith(("fine", "1 error"))
