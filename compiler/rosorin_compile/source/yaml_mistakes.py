"""YAML mistakes: why a text is not YAML, in the words of whoever wrote it.

The parser (libyaml) says at which character it gave up, and what it had begun before: ``Trouble``. Each function of
``_CAUSES`` knows one family of mistakes and says where the mistake itself stands, which is often a line before.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import yaml

from .diagnostics import Diagnostic, Related, Source, Span, error
from .project import data_folder
from .wording import printable

_CLOSING = {"[": "]", "{": "}"}
_COMMENTS = ("//", "/*", "<!--", "--")
_QUOTE = "put the text in quotes"
_COLON_IN_TEXT = 'a text with a ":" stands here without quotes'
_ITEM = re.compile(r"(- +)*")
_COLON = re.compile(r":(\s|$)")
_CONFLICT = re.compile(r"^(<{7}|\|{7}|>{7})(?= |$)", re.MULTILINE)


class Trouble(NamedTuple):
    """What the parser complains of at ``line``, ``column``, and what was begun at ``begun``; all count from 1."""

    source: Source
    what: str
    line: int
    column: int
    begun: tuple[int, int]

    @property
    def text(self) -> str:
        """The line at which the parser gave up."""
        return self.source.line(self.line)

    @property
    def before(self) -> str:
        """What stands before that place in its line."""
        return self.text[: self.column - 1]

    @property
    def letter(self) -> str:
        """The character at that place."""
        return self.text[self.column - 1 : self.column]

    def describe(
        self, message: str, help: str, line: int, column: int, length: int = 1, and_here: str = ""
    ) -> Diagnostic:
        """Return the diagnostic, with the place where the parser gave up if ``and_here`` says what it is."""
        related = [Related(and_here, Span(self.source, self.line, self.column))] if and_here else []
        return error("yaml-syntax", message, Span(self.source, line, column, max(1, length)), help, related)


def explained(source: Source, problem: yaml.YAMLError) -> Diagnostic:
    """Return what is wrong with a text that the parser of YAML refuses."""
    if isinstance(problem, yaml.reader.ReaderError):
        before = source.text[: problem.position]
        span = Span(source, before.count("\n") + 1, len(before) - before.rfind("\n"))
        return error("yaml-syntax", "control characters are not allowed in YAML", span, "remove it")
    begun = getattr(problem, "context_mark", None)
    mark = getattr(problem, "problem_mark", None) or begun
    line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
    begun_at = (begun.line + 1, begun.column + 1) if begun else (line, column)
    what = f"{getattr(problem, 'context', None) or ''}: {getattr(problem, 'problem', None) or ''}"
    trouble = Trouble(source, what, line, column, begun_at)
    for cause in _CAUSES:
        told = cause(trouble)
        if told is not None:
            return told
    return trouble.describe("YAML cannot be read on from here", f"indent with spaces; {_QUOTE}", line, column)


def _conflict(trouble: Trouble) -> Diagnostic | None:
    mark = _CONFLICT.search(trouble.source.text)
    if mark is None:
        return None
    line = trouble.source.text.count("\n", 0, mark.start()) + 1
    help = "choose a version between <<<<<<< and >>>>>>>, and remove the marks"
    return trouble.describe("a conflict of a merge is not resolved", help, line, 1, 7)


def _tab(trouble: Trouble) -> Diagnostic | None:
    blank = trouble.text[: len(trouble.text) - len(trouble.text.lstrip())]
    if "\t" not in blank:
        return None
    help = "YAML allows no tab for indentation; use spaces"
    return trouble.describe("a tab indents this line", help, trouble.line, blank.index("\t") + 1)


def _expression(trouble: Trouble) -> Diagnostic | None:
    if not trouble.before.endswith("$") or trouble.letter != "{":
        return None
    help = 'inside [ ] and { } an expression needs quotes: "${...}"'
    return trouble.describe("an expression stands here without quotes", help, trouble.line, trouble.column - 1, 2)


def _comment_of_others(trouble: Trouble) -> Diagnostic | None:
    for number in range(trouble.begun[0], trouble.line + 1) if "parsing a flow" in trouble.what else ():
        line = trouble.source.line(number)
        if line.lstrip().startswith(_COMMENTS):
            return _comment(trouble, number, _indent(line) + 1)
    return None


def _quote_open(trouble: Trouble) -> Diagnostic | None:
    """Find a quote that is not closed, or closed only by the next quote in a later line."""
    begun = trouble.begun
    if "quoted scalar" not in trouble.what:
        quoted = _quoted_before(trouble)
        if quoted is None or quoted.start_mark.line == quoted.end_mark.line:
            return None
        begun = quoted.start_mark.line + 1, quoted.start_mark.column + 1
    elif "escape" in trouble.what:
        escape = trouble.text[trouble.column - 1 :][:2]
        help = "use single quotes, or write the backslash twice"
        return trouble.describe(
            f'"{escape}" means nothing between double quotes', help, trouble.line, trouble.column, 2
        )
    return trouble.describe("this quote is not closed", "close it where the text ends", *begun)


def _quoted_before(trouble: Trouble) -> Any:
    """Return the token of the text in quotes that ends just before the place; None if there is none."""
    before = trouble.before.rstrip()
    if not before.endswith(("'", '"')):
        return None
    found = None
    try:
        scanner = getattr(yaml, "CLoader", yaml.Loader)(trouble.source.text)
        while (token := scanner.get_token()) is not None and token.start_mark.line < trouble.line:
            if isinstance(token, yaml.ScalarToken) and token.style in ("'", '"'):
                found = token
    except yaml.YAMLError:
        pass
    return found if found and (found.end_mark.line, found.end_mark.column) == (trouble.line - 1, len(before)) else None


def _after_a_value(trouble: Trouble) -> Diagnostic | None:
    """Find text that goes on where a value has ended: behind a quote or a bracket."""
    before, rest = trouble.before.rstrip(), trouble.text[trouble.column - 1 :].strip()
    if not before.endswith(("'", '"', "]", "}")) or not rest or "did not find expected" not in trouble.what:
        return None
    at = (trouble.line, trouble.column)
    if before[-1] in "'\"":
        help = f"within such quotes write {before[-1] * 2}" if before[-1] == "'" else 'within such quotes write \\"'
        return trouble.describe("the text goes on after its closing quote", f"{help}, or use the other kind", *at)
    if "block" not in trouble.what or rest[0] in ":,":
        return None
    if rest[0] in "]}":
        return trouble.describe(f'this "{rest[0]}" closes nothing', "remove it, or open it before", *at)
    from .units import parse_unit

    word = printable(rest.split()[0])
    help = 'remove it; a comment begins with "#"'
    if parse_unit(word):
        help = f"each number has its own unit: [0, 0, 20 {word}]"
    return trouble.describe(f'"{word}" stands after the closing "{before[-1]}"', help, *at, len(word))


def _bracket(trouble: Trouble) -> Diagnostic | None:
    """Find a bracket that is not closed, or by the wrong one; a comma or quotes missing within."""
    if "found unexpected ':'" in trouble.what:
        help = "write a space behind it, and the value: {NAME: VALUE}"
        return trouble.describe('nothing stands behind this ":"', help, trouble.line, trouble.column)
    if "',' or" not in trouble.what:
        return None
    opened = trouble.source.line(trouble.begun[0])[trouble.begun[1] - 1 :][:1]
    closing = _CLOSING.get(opened, "]")
    if trouble.letter and trouble.letter in "]}":
        message = f'this "{opened}" is not closed before the "{trouble.letter}"'
        return trouble.describe(message, f'add "{closing}"', *trouble.begun, and_here=f'the "{trouble.letter}"')
    if not _is_closed(trouble.source, *trouble.begun):
        goes_on = "here something else begins" if trouble.text.strip() else ""
        return trouble.describe(f'this "{opened}" is not closed', f'add "{closing}"', *trouble.begun, and_here=goes_on)
    return _comma(trouble, closing)


def _comma(trouble: Trouble, closing: str) -> Diagnostic:
    piece = re.split(r"[,\[\]{}]", trouble.before)[-1]
    start = len(trouble.before) - len(piece.lstrip())
    text = piece.strip()
    word = text.split()[-1] if text else ""
    value = text[: -len(word)].rstrip() if word != text or trouble.line == trouble.begun[0] else "above"
    if trouble.letter == ":" and word in _keys() and value and not value.endswith(":"):
        column = start + 1 + len(text) - len(word)
        return trouble.describe(f'a "," is missing before "{word}"', "add it", trouble.line, column, len(word))
    if trouble.letter == ":" and ": " in text:
        value = text.partition(": ")[2].lstrip()
        help = f'{_QUOTE}; if two entries are meant, add a ","'
        return trouble.describe(_COLON_IN_TEXT, help, trouble.line, start + 1 + len(text) - len(value), len(value) + 1)
    message = f'a "," or the closing "{closing}" is missing here'
    return trouble.describe(message, f"add it, or {_QUOTE}", trouble.line, trouble.column)


def _keys() -> set[str]:
    whole = json.loads((data_folder("schemas") / "description.schema.json").read_text("utf-8"))
    return {key for part in (whole, *whole["$defs"].values()) for key in part.get("properties", ())}


def _is_closed(source: Source, line: int, column: int) -> bool:
    """Say whether the bracket at a place is closed anywhere behind it; quotes and comments are passed."""
    open_ones: list[str] = []
    quote = ""
    for number, text in enumerate(source.text.splitlines()[line - 1 :]):
        begin = column - 1 if number == 0 else 0
        for index in range(begin, len(text)):
            letter = text[index]
            if quote:
                quote = "" if letter == quote else quote
            elif letter in "'\"" and not text[index - 1 : index].isalnum():
                quote = letter
            elif letter == "#" and (index == 0 or text[index - 1].isspace()):
                break
            elif letter in _CLOSING:
                open_ones.append(_CLOSING[letter])
            elif letter in "]}":
                if open_ones.pop() != letter:
                    return False
                if not open_ones:
                    return True
    return False


def _second_colon(trouble: Trouble) -> Diagnostic | None:
    if "mapping values are not allowed" not in trouble.what:
        return None
    found = _COLON.search(trouble.before)
    if found is None:
        return None
    value = trouble.before[found.end() :]
    column = found.end() + 1 + len(value) - len(value.lstrip())
    return trouble.describe(_COLON_IN_TEXT, _QUOTE, trouble.line, column, len(value.strip()))


def _no_colon(trouble: Trouble) -> Diagnostic | None:
    if not trouble.what.endswith(("mapping values are not allowed in this context", "could not find expected ':'")):
        return None
    number = trouble.begun[0] if "simple key" in trouble.what else _line_above(trouble.source, trouble.line)
    while number and _is_bare(trouble.source.line(number)):
        above = _line_above(trouble.source, number)
        if (
            not above
            or trouble.source.line(number).lstrip().startswith("- ")
            or not _is_bare(trouble.source.line(above))
        ):
            return _bare(trouble, number)
        number = above
    return None


def _is_bare(line: str) -> bool:
    """Say whether a line, or the item that it is, is a text alone: no entry, and no value in brackets or quotes."""
    text = line[_key_indent(line) :].strip()
    return bool(text) and not _COLON.search(text) and not text.startswith(("[", "{", "---", "'", '"'))


def _bare(trouble: Trouble, number: int) -> Diagnostic:
    line = trouble.source.line(number)
    column = _key_indent(line) + 1
    text = line[column - 1 :].strip()
    at = (number, column, len(text))
    if text.startswith(_COMMENTS):
        return _comment(trouble, number, column)
    if text.startswith("<"):
        help = "write it in YAML, or keep it as text under urdf_elements; a whole URDF is included by its file"
        return trouble.describe("this is XML within YAML", help, *at)
    found = re.match(r"([\w.-]+)\s*(:=|[:=\uff1a])\s*(\S.*)?$", text)
    if found:
        name, sign, value = found.groups()
        is_glued = sign == ":"
        message = 'a space is missing after the ":"' if is_glued else f'"{sign}" does not give a value: ":" does'
        meant = f"{name}: {value or ''}".strip()
        return trouble.describe(message, f"write {printable(meant)}", *at)
    if len(text.split()) > 3 or text[-1] in ".,;!":
        return trouble.describe(
            'this line is no entry: it has no ":"', 'write NAME: VALUE; a comment begins with "#"', *at
        )
    name, _, value = text.partition(" ")
    shown = printable(f"{name}: {value.strip()}" if value else f"{name}:")
    return trouble.describe('a ":" is missing in this line', f"write {shown}", *at)


def _comment(trouble: Trouble, line: int, column: int) -> Diagnostic:
    text = trouble.source.line(line).lstrip()
    sign = next(sign for sign in _COMMENTS if text.startswith(sign))
    return trouble.describe(f'"{sign}" begins no comment', 'a comment begins with "#"', line, column, len(sign))


def _value_and_entries(trouble: Trouble) -> Diagnostic | None:
    number = _line_above(trouble.source, trouble.line)
    if "mapping values are not allowed" not in trouble.what or not number:
        return None
    above = trouble.source.line(number)
    found = _COLON.search(above)
    if found is None:
        return None
    column = _indent(trouble.text) + 1
    name = _name_of(above)
    message = f'this line is indented below "{name}", which has a value already'
    help = f'indent it by {_spaces(_key_indent(above))}, beside "{name}"'
    place = Span(trouble.source, number, _key_indent(above) + 1, len(name))
    return replace(trouble.describe(message, help, trouble.line, column), related=(Related("the value", place),))


def _no_dash(trouble: Trouble) -> Diagnostic | None:
    indent = _indent(trouble.text)
    if "'-' indicator" not in trouble.what or indent != trouble.begun[1] - 1:
        return None
    name = _name_of(trouble.text)
    help = f'write "- {name}: ..." for one more item; indent it by {_spaces(indent + 2)} to belong to the one above'
    return trouble.describe('this line stands among the items of a list, without "- "', help, trouble.line, indent + 1)


def _indentation(trouble: Trouble) -> Diagnostic | None:
    if "expected key" not in trouble.what and "'-' indicator" not in trouble.what:
        return None
    indent = _indent(trouble.text)
    levels = dict(_levels(trouble.source, trouble.line))
    if trouble.before.strip() or not trouble.text.strip():
        return None
    if trouble.letter == "-" and indent in levels:
        lines = (trouble.source.line(number) for number in range(trouble.line - 1, 0, -1))
        items = [line for line in lines if line.lstrip().startswith("- ") and _indent(line) > indent]
        help = f'indent it under the key whose list it is, or write "NAME:" in place of "- " beside "{levels[indent]}"'
        help = f"indent it by {_spaces(_indent(items[0]))}, as the item above" if items else help
        return trouble.describe("an item of a list stands here among keys", help, trouble.line, trouble.column)
    near = sorted(levels, key=lambda level: (abs(level - indent), level))[:2]
    help = ", or ".join(f'by {_spaces(level)}, beside "{levels[level]}"' for level in near)
    message = f"this line is indented by {_spaces(indent)}, as no entry above it is"
    return trouble.describe(message, f"indent it {help}" if help else "", trouble.line, indent + 1)


def _levels(source: Source, line: int) -> Iterator[tuple[int, str]]:
    """Yield the indentations of the entries that are open above a line, innermost first, with their names."""
    lowest = 1_000
    number = _line_above(source, line)
    while number:
        text = source.line(number)
        for indent in (_key_indent(text), _indent(text)):
            if indent < lowest and _COLON.search(text):
                lowest = indent
                yield indent, _name_of(text)
        number = _line_above(source, number)


def _line_above(source: Source, line: int) -> int:
    """Return the number of the nearest line above that is neither empty nor a comment; 0 if there is none."""
    number = line - 1
    while number and (not source.line(number).strip() or source.line(number).lstrip().startswith("#")):
        number -= 1
    return number


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip(" "))


def _key_indent(line: str) -> int:
    """Return the indentation of the key of a line, which may be the first one of an item."""
    found = _ITEM.match(line.lstrip(" "))
    return _indent(line) + (found.end() if found else 0)


def _name_of(line: str) -> str:
    return printable(_COLON.split(line.strip().lstrip("- "))[0].strip()[:40])


def _spaces(count: int) -> str:
    return f"{count} space{'' if count == 1 else 's'}"


def _beginning(trouble: Trouble) -> Diagnostic | None:
    """Find a letter at the beginning of a value that YAML gives a meaning."""
    at, what = (trouble.line, trouble.column), trouble.what
    if "cannot start any token" in what:
        return trouble.describe(f'no text begins with "{printable(trouble.letter)}"', _QUOTE, *at)
    if "block sequence entries are not allowed" in what:
        help = "begin it on the next line, or write it in brackets: [a, b]"
        return trouble.describe("a list cannot begin behind its key", help, *at)
    if "could not find expected ':'" in what:
        return trouble.describe('a ":" is missing here', "write NAME: VALUE", *trouble.begun)
    if "directive" in what:
        return trouble.describe('a line with "%" is for YAML itself', "remove it", trouble.begun[0], 1)
    if "expected node content" in what and not trouble.letter:
        return _open_at_the_end(trouble)
    if "expected node content" in what:
        if trouble.letter == ",":
            return trouble.describe('nothing stands before this ","', "write the value, or remove the comma", *at)
        return trouble.describe(f'this "{trouble.letter}" closes nothing', "remove it, or open it before", *at)
    first = trouble.source.line(trouble.begun[0])[trouble.begun[1] - 1 :][:1]
    meanings = {"*": "an alias", "&": "an anchor", ">": "a text of several lines", "|": "a text of several lines"}
    meanings["!"] = "a tag"
    if first in meanings and what.startswith(("while scanning", "while parsing a node", "while parsing a tag")):
        help = f'{_QUOTE}; an item of a list begins with "- "' if first == "*" else _QUOTE
        return trouble.describe(f'"{first}" begins {meanings[first]} here', help, *trouble.begun)
    if "<document start>" in what:
        if trouble.source.text.startswith("%"):
            return trouble.describe('a line with "%" is for YAML itself', "remove it", 1, 1)
        return trouble.describe("the description has ended before this", "remove it, or the closing bracket above", *at)
    return None


def _open_at_the_end(trouble: Trouble) -> Diagnostic | None:
    text = trouble.source.text
    last = max(text.rfind(bracket) for bracket in _CLOSING)
    if last < 0:
        return None
    line, column = text.count("\n", 0, last) + 1, last - text.rfind("\n", 0, last)
    return trouble.describe(f'this "{text[last]}" is not closed', f'add "{_CLOSING[text[last]]}"', line, column)


_CAUSES: tuple[Callable[[Trouble], Diagnostic | None], ...] = (
    _conflict,
    _tab,
    _expression,
    _comment_of_others,
    _quote_open,
    _after_a_value,
    _bracket,
    _second_colon,
    _no_colon,
    _value_and_entries,
    _no_dash,
    _indentation,
    _beginning,
)
