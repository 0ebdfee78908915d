"""Cases that are files: the comment at the top of each lists the diagnostics that it gets.

    # expect: LINE:COLUMN: SEVERITY[RULE]: MESSAGE           (FILE: before the line if it is another file)
    #   help: HELP
    #   related: LINE:COLUMN: MESSAGE

In XML the lines are without "# ", between "<!--" and "-->". File, line, column, severity and rule are written by hand.
The message, and the help and related lines, are written by

    python tests/renew.py messages [PATH...]

which runs the tests named ``test_message``. A text that ends with "..." in place of a list that grows is left as it is.
"""

import os
import re
import sys
from pathlib import Path

import pytest

from rosorin_compile.formats.imported_robot import ImportedRobot, ReadOptions
from rosorin_compile.formats.robot_files import read_robot
from rosorin_compile.source.diagnostics import Diagnostic, Span
from rosorin_compile.source.messages import arrange
from support.paths import TESTS

RENEW = "RENEW_MESSAGES"  # set in the environment by renew.py

_EXPECTED = re.compile(r"(# )?(expect: |  (help|related): )")
_BY_HAND = re.compile(r"(# )?expect: .*?(error|warning|note)\[[^]]+\]")
_MAIN_FILE = re.compile(r"((?:# )?(?:expect|  related): )(\d+)(?=:\d+: )")
_HEADER = re.compile(r"<!--\n(.*?)-->\n", re.DOTALL)


def check(case: Path, found: list[str]) -> None:
    """Compare diagnostics, as lines, with those that the comment of a case expects; or renew the texts there.

    Raises AssertionError if a position or rule differs, in both cases.
    """
    lines = case.read_bytes().decode().split("\n")
    comment = _comment(lines)
    places = [index for index in comment if _EXPECTED.match(lines[index])]
    expected = [lines[index].removesuffix("\r") for index in places]
    assert _by_hand(found) == _by_hand(expected), "\n".join([f"{case}: rules or positions differ; it gets", *found])
    texts = [next((line for line in expected if _fits(line, actual)), actual) for actual in found]
    if texts == expected:
        return
    assert RENEW in os.environ, "\n".join([f"{case}: run python tests/renew.py messages; it gets", *found])
    added = len(texts) - len(expected)
    texts = [_MAIN_FILE.sub(lambda place: f"{place[1]}{int(place[2]) + added}", line) for line in texts]
    kept = [line for index, line in enumerate(lines) if index not in places]
    case.write_bytes("\n".join([*kept[: places[0]], *texts, *kept[places[0] :]]).encode())


def _comment(lines: list[str]) -> range:
    if lines[0].startswith("<!--"):
        return range(1, next(index for index, line in enumerate(lines) if line.startswith("-->")))
    return range(next((index for index, line in enumerate(lines) if not line.startswith("#")), len(lines)))


def _by_hand(lines: list[str]) -> list[str]:
    return [found[0] for line in lines if (found := _BY_HAND.match(line))]


def _fits(expected: str, line: str) -> bool:
    return line == expected or (expected.endswith(" ...") and line.startswith(expected.removesuffix("...")))


def header(path: Path) -> list[str]:
    """Return the lines of the comment at the top of a foreign file."""
    found = _HEADER.match(path.read_text("utf-8"))
    assert found, f"{path.name} does not begin with a comment"
    return found[1].splitlines()


def read(path: Path) -> ImportedRobot:
    """Return what reading a foreign file gives, with the options that it asks for."""
    words = [word for line in header(path) if line.startswith("options: ") for word in line.split()[1:]]
    arguments = dict(word.split(":=", 1) for word in words if ":=" in word)
    return read_robot(path, ReadOptions(arguments=arguments, lenient="lenient" in words, environment={}))


def as_comment(diagnostics: list[Diagnostic], main: str) -> list[str]:
    """Return diagnostics as comment lines of the description ``main``, with unprintable characters escaped."""
    return [f"# {_visible(line)}" for line in _lines(diagnostics, main)]


def as_xml_comment(diagnostics: list[Diagnostic], main: str) -> list[str]:
    """Return diagnostics, in order, as the lines of an XML comment, which must not contain "--": it becomes "==" """
    return [line.replace("--", "==").replace("\0", "\\0") for line in _lines(arrange(diagnostics), main)]


def _lines(diagnostics: list[Diagnostic], main: str) -> list[str]:
    lines = []
    for diagnostic in diagnostics:
        where = _place(diagnostic.span, main)
        lines.append(f"expect: {where}{diagnostic.severity}[{diagnostic.rule}]: {diagnostic.message}")
        lines += [f"  help: {diagnostic.help}"] if diagnostic.help else []
        lines += [f"  related: {_place(other.span, main)}{other.message}" for other in diagnostic.related]
    return lines


def _place(span: Span | None, main: str) -> str:
    if span is None:
        return ""
    file = "" if span.source.path == main else f"{span.source.path.removeprefix(main).strip()}:"
    return f"{file}{span.line}:{span.column}: "


def _visible(text: str) -> str:
    return "".join(letter if letter.isprintable() else f"\\x{ord(letter):02x}" for letter in text)


if __name__ == "__main__":
    os.environ[RENEW] = "yes"
    os.chdir(TESTS.parent)
    tests = [str(path) for path in TESTS.rglob("test_*.py") if "def test_message(" in path.read_text("utf-8")]
    raise SystemExit(pytest.main(["-k", "test_message", *(sys.argv[1:] or sorted(tests))]))
