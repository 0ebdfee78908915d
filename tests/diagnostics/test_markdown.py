"""Markdown: nothing that a robot says is markup, a mention or a link; the whole is bounded and says what is left out.

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
from rosorin_compile.cli.markdown import MAX_BYTES, Diff, Section, Table, code, document, prose
from rosorin_compile.cli.report_formats import from_workspace, github
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, Related, Source, Span, error
from rosorin_compile.source.wording import printable

cmarkgfm = pytest.importorskip("cmarkgfm")

EVIL = [
    *("@admin", "@org/team", "#12", "GH-12", "a/b#3", "!7", "0123abcdef", ":tada:", "$x$", "${a}${b}", "www.evil.com"),
    *("https://evil.com", "mail@evil.com", "<img src=x onerror=alert(1)>", "<!-- x", "</details>", "<script>", "&lt;"),
    *(
        "![x](https://evil.com/a.png)",
        "[x](javascript:y)",
        "a|b",
        "a\\|b",
        "\\",
        "a\\",
        "`",
        "``` x",
        "a`b|c`",
        "**b**",
    ),
    *(
        "__b__",
        "~~b~~",
        "- x",
        "1. x",
        "# x",
        "> x",
        "---",
        "===",
        "| a |",
        "\n\n# x",
        "a\nb",
        "\r",
        "\x1b[2J",
        "\u202e",
    ),
    *(
        "a@b.co|c",
        "[^1]",
        "[x]: y",
        "- [ ] x",
        "\t x",
        "    x",
        " ",
        "",
        "\udc80",
        "Ω",
        "日本 @x",
        "(@x)",
        '"@x"',
        "@x.",
        "'@x',",
    ),
]


def rendered(text: str) -> str:
    made: str = cmarkgfm.github_flavored_markdown_to_html(text, cmarkgfm.Options.CMARK_OPT_UNSAFE)
    return made


def cells(text: str) -> list[str]:
    (body,) = re.findall(r"<tbody>(.*?)</tbody>", rendered(text), re.DOTALL)
    return re.findall(r"<td>(.*?)</td>", body, re.DOTALL)


def shown(piece: str) -> str:
    return html.unescape(re.sub(r"<!-- -->|<[^>]*>", "", piece))


def loose(piece: str) -> str:
    """Return the text outside of code, in which GitHub looks for mentions, issues, links, emoji and mathematics."""
    return shown(re.sub(r"<code>.*?</code>", " ", piece, flags=re.DOTALL))


HARMLESS = re.compile(r"""[\w\s.,;:?!'"()/=+%>-]*""")
ALIVE = re.compile(r"www\.|https?:|\bGH-\d|[!#@$~&]\w|:\w+:|\b(?=\w*\d)[0-9a-f]{7,40}\b", re.IGNORECASE)


def judge(text: str) -> None:
    for cell in (code(text), prose(text)):
        first, last = cells(f"| a | b |\n| --- | --- |\n| {cell} | end |\n")
        tags = set(re.findall(r"<[^>]*>", first))
        assert tags <= {"<code>", "</code>", "<!-- -->"}, first
        assert HARMLESS.fullmatch(loose(first)), loose(first)
        assert not ALIVE.search(loose(first)), loose(first)
        assert shown(first).split() == printable(text).split()
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
    row = (f"{code(text)} in {code(text)}", *[prose(text)] * 4, f"{code(text)}, {code(text)}")
    head = ("what", "quantity", "before", "after", "by", "artifacts")
    blocks = [Table("change", head, (row,)), Diff(text, text, (f"-{text}", f"+{text}", text))]
    note = replace(told, severity=NOTE)
    return Section(text, [text], [text], blocks, [told, note, error("b", text, None, text)])


@pytest.mark.parametrize("text", [text for text in EVIL if text.strip()], ids=ascii)
def test_a_document_has_our_elements_alone(text: str) -> None:
    made = document([section(text), Section(text, [text])])
    assert printable(made, "\n\t") == made
    out = rendered(made)
    plain = rendered(document([section("plain"), Section("plain", ["plain"])]))

    def tags(piece: str) -> list[str]:
        return [
            tag
            for tag in re.findall(r"<[^>]*>", re.sub(r'(<pre lang="diff">)?<code>.*?</code>', "", piece, flags=re.S))
            if tag not in ("<pre>", "</pre>")
        ]

    assert [t for t in tags(out) if t != "<br>"] == [t for t in tags(plain) if t != "<br>"]
    for piece in re.split(r"</?(?:p|td|li|h2|h3|summary)>", re.sub(r"<pre.*?</pre>", "", out, flags=re.S)):
        assert not ALIVE.search(loose(piece)), piece


@pytest.mark.parametrize("robots", [1, 30, 200])
@pytest.mark.parametrize("rows", [0, 10, 3000])
def test_it_is_bounded_and_says_what_is_left_out(robots: int, rows: int) -> None:
    cell = prose("some words " * 20)
    table = Table("change", ("a", "b"), ((cell, cell),) * min(rows, 30_000 // robots))
    diffs = [Diff(f"{n}.urdf", "", ("+" + "x" * 100,) * 40) for n in range(min(rows, 30))]
    sections = [Section(f"robot{n}", wrong=["not up to date"], blocks=[table, *diffs]) for n in range(robots)]
    told = document(sections)
    assert len(told.encode()) <= MAX_BYTES
    named = len(set(re.findall(r"`robot\d+`", told)))
    more = re.search(r"- and ([\d,]+) more robots", told)
    assert named + (int(more[1].replace(",", "")) if more else 0) == robots
    assert told.count("<details>") == told.count("</details>")
    if rows > 20 and robots == 1:
        assert re.search(r"and [\d,]+ more changes", told)
        assert "left out here" in told
    if rows == 3000 and robots > 1:
        assert "Too much to show here" in told or "more changes" in told


def test_paths_are_seen_from_the_top_of_a_checkout(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (home / "robots").mkdir()
    monkeypatch.setenv("GITHUB_WORKSPACE", str(home))
    monkeypatch.chdir(home / "robots")
    assert from_workspace("descriptions/a.yaml") == "robots/descriptions/a.yaml"
    assert from_workspace(str(home / "x.yaml")) == "x.yaml"
    assert from_workspace("../../x.yaml") == "../../x.yaml"
    told = Diagnostic("a", NOTE, "b", Span(Source("descriptions/a.yaml", ""), 1, 1))
    assert github([told]) == "::notice file=robots/descriptions/a.yaml,line=1,col=1,title=a::b\n"
    assert "`robots/descriptions/a.yaml:1:1`" in document([Section("a", wrong=["x"], diagnostics=[told])])


@pytest.mark.parametrize("name", ["::add-mask::x", " ::error::x", "##[error]x"])
def test_no_line_for_github_is_a_command(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    console = Console("github")
    console.say(f"{name}: fine")
    console.warn(f"{name}: 1 error")
    for line in capsys.readouterr().err.splitlines():
        assert "::" not in line
        assert "##[" not in line
        assert line.endswith(("fine", "1 error"))
