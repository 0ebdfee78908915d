"""Generate docs/from-xacro-reference.md from the cases in tests/xacro.

    python tests/renew.py from-xacro

writes the page. Of each file of a case it shows the lines between "show" and "end", both comments of their own.
"""

from __future__ import annotations

import re
import textwrap
from pathlib import Path
from typing import NamedTuple

from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.diagnostics import text as report
from rosorin_compile.source.load import LoadError, parse_yaml
from support.paths import DOCS, XACRO
from support.xacro_table import Case, cases, names, read, ready

PAGE = DOCS / "from-xacro-reference.md"

# In a why.md: what the feature is for is there, but not in a description.
OTHERWISE = "<!-- in another way -->"

SHOW = re.compile(r"\s*(<!--|#) show( -->)?\s*")
END = re.compile(r"\s*(<!--|#) end( -->)?\s*")


def page() -> str:
    """Return docs/from-xacro-reference.md."""
    found = cases()
    lines = [_HEAD.strip(), "", "| feature of xacro | here |", "|---|---|"]
    lines += [f"| {case.area}: [{case.feature}](#{_anchor(case.feature)}) | {_outcome(case)} |" for case in found]
    area = ""
    for case in found:
        lines += ["", f"## {case.area}"] if case.area != area else []
        area = case.area
        lines += ["", f"### {case.feature[0].upper()}{case.feature[1:]}", "", *_section(case)]
    return "\n".join([*lines, "", "## Names of xacro", "", *_names_section(), ""])


_HEAD = """
# From xacro, feature by feature

<!-- Made by: python tests/renew.py from-xacro. Edit tests/xacro, or the head in tests/support/xacro_page.py. -->

Read this page to find the replacement of one feature of [xacro](https://github.com/ros/xacro); [From
xacro](from-xacro.md) moves a complete package. Each section shows the same robot in both languages. A test expands the
one with xacro 2.1, compiles the other, and compares links, joints, poses, axes, limits, masses and shapes to 1e-12.
Features without a counterpart have a reason and an alternative.
"""

_OUTCOMES = {
    "same": "the same robot",
    "instead": "the same robot, written differently",
    "both": "an error in both, here with its line",
    "only": "an error; xacro accepts it",
    "otherwise": "another way",
    "none": "not supported",
}


def _outcome(case: Case) -> str:
    if case.expected:
        return _OUTCOMES["only" if case.xacro == "accepts" else "both"]
    if case.why:
        return _OUTCOMES["instead" if case.has("robot.yaml") else "otherwise" if OTHERWISE in case.why else "none"]
    return _OUTCOMES["same"]


class Shown(NamedTuple):
    """What the page shows of one file of a case."""

    name: str
    language: str
    text: str


def _shown(case: Case) -> list[Shown]:
    """Return what the page shows of a case: xacro first, the main file of each before what it includes."""
    found = []
    for path in sorted(case.folder.rglob("*"), key=lambda path: (path.stem != "robot", path.as_posix())):
        if path.suffix in (".xacro", ".yaml", ".jinja"):
            language = "xml" if path.suffix == ".xacro" else path.suffix[1:]
            text = _excerpt(path.read_text("utf-8").splitlines(), each=language == "xml")
            language = "text" if language == "yaml" and not _is_yaml(text) else language
            found += [Shown(path.relative_to(case.folder).as_posix(), language, text)] if text else []
    theirs = [piece for piece in found if piece.language == "xml"]
    return theirs + [piece for piece in found if piece not in theirs]


def _is_yaml(text: str) -> bool:
    """Say whether a text is YAML without defects; some cases show one."""
    try:
        parse_yaml(Source("", text))
    except LoadError:
        return False
    return True


def _excerpt(lines: list[str], each: bool) -> str:
    """Return the lines to show, without their indentation: ``each`` run of lines by itself, else all together."""
    runs: list[list[str]] = []
    showing = False
    for line in lines:
        if SHOW.fullmatch(line) or END.fullmatch(line):
            showing = SHOW.fullmatch(line) is not None
            runs += [[]] if showing else []
        elif showing:
            runs[-1].append(line)
    texts = ["\n".join(run) for run in runs]
    return "\n".join(map(textwrap.dedent, texts)) if each else textwrap.dedent("\n".join(texts))


def _section(case: Case) -> list[str]:
    lines = [text for text in (case.why.replace(OTHERWISE, "").strip(), _wrapped(case.remarks)) if text]
    pieces = _shown(case)
    for piece in pieces:
        alone = piece.name.startswith("robot.")
        heading = "" if alone and len(pieces) <= 2 else f"`{piece.name}`:"
        lines += ["", heading] if heading else []
        lines += ["", f"```{piece.language}", piece.text, "```"]
    if case.expected:
        lines += ["", *_message(case)]
    files = [f"`tests/xacro/{case.name}/{name}`" for name in ("robot.xacro", "robot.yaml") if case.has(name)]
    lines += ["", f"Whole files: {', '.join(files)}"] if files else []
    return lines[1:] if lines[0] == "" else lines  # no remarks


def _message(case: Case) -> list[str]:
    with ready(case):
        said = report(compile_robot(Path("robot.yaml"), case.arguments).diagnostics).rstrip()
    kind, _, words = case.xacro.partition(": ")
    theirs = "xacro takes it without a word." if kind == "accepts" else f"xacro: `{words}`."
    return [f"{theirs} Here:", "", "```text", said, "```"]


def _names_section() -> list[str]:
    table = names()
    same = [f"`{name.name}`" for name in table if name.ours and name.ours == name.theirs]
    lines = [_wrapped(f"The same here, without `math.` and `python.`: {', '.join(same)}."), ""]
    lines += ["| name | there | here |", "|---|---|---|"]
    for name in table:
        full = f"`{name.space}.{name.name}`"
        if name.case:
            case = read(XACRO / name.case)
            lines.append(f"| {full} | | see [{case.feature}](#{_anchor(case.feature)}) |")
        elif name.why:
            lines.append(f"| {full} | | not there: {name.why} |")
        elif name.ours != name.theirs:
            lines.append(f"| {full} | `{name.theirs}` | `{name.ours}` |")
    return lines


def _anchor(title: str) -> str:
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")


def _wrapped(text: str) -> str:
    return "\n".join(textwrap.wrap(text, 120, break_long_words=False, break_on_hyphens=False))


if __name__ == "__main__":
    PAGE.write_text(page(), "utf-8")
