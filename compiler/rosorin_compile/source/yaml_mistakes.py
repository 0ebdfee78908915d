"""Explain YAML syntax errors: find the mistake, which is often in a line above the one where the parser stops."""

import json
import re
from collections.abc import Iterator, Sequence
from typing import Any

import yaml

from .diagnostics import Diagnostic, Related, Source, Span, error
from .project import data_folder
from .units import parse_unit
from .wording import count_of, printable

MAX_DEPTH = 60
_QUOTE = "put the text in quotes"
_COMMENT = 'a comment begins with "#"'
_COLON = r":(\s|$)"
_ITEM = r"^ *(- +)*"
_FOREIGN_COMMENT = r" *(//|/\*|<!--|--)"
_CONFLICT = re.compile(r"^(<{7}|\|{7}|>{7})(?= |$)", re.MULTILINE)
_IN_BRACKETS = r"""(?<!\w)"(?:\\.|[^"\\])*"|(?<!\w)'[^']*'|(?<!\S)#.*|[\[\]{}]"""
_BEGINNINGS = {"*": "an alias", "&": "an anchor", "!": "a tag", ">": "a multi-line text", "|": "a multi-line text"}
# (text in libyaml's message, message to report, help, True to report it at the start of the context).
# {letter} is the character at which libyaml stopped.
_REPORTS = (
    ("cannot start any token", 'text without quotes cannot begin with "{letter}"', _QUOTE, False),
    ("block sequence entries are not", "a list cannot begin on the line of its key", "move it to the next line", False),
    ("could not find expected ':'", 'a ":" is missing here', 'write "NAME: VALUE"', True),
    ("directive", 'a line that begins with "%" is a YAML directive', "remove it", True),
)


def explain_mistake(source: Source, problem: yaml.YAMLError) -> Diagnostic:
    """Convert an exception of the YAML parser to a diagnostic that explains the mistake."""
    if isinstance(problem, yaml.reader.ReaderError):
        return error("yaml-syntax", "unexpected control character", source.span(problem.position), "remove it")
    if "maximum nesting depth" in str(getattr(problem, "problem", None)):  # the limit of libyaml is 1,000 levels
        span = source.span(problem.problem_mark.index)  # type: ignore[attr-defined]
        return error("yaml-too-deep", f"nested deeper than {MAX_DEPTH} levels", span, "use fewer nested levels")
    failure = _Failure(source, problem)
    kinds = (failure.mark, failure.quote, failure.after_a_value, failure.bracket, failure.colon, failure.indentation)
    return next((made for kind in kinds if (made := kind())), None) or failure.beginning()


class _Failure:
    def __init__(self, source: Source, problem: yaml.YAMLError) -> None:
        begun = getattr(problem, "context_mark", None)
        mark = getattr(problem, "problem_mark", None) or begun
        self.source = source
        self.at = (mark.line + 1, mark.column + 1) if mark else (1, 1)
        self.begun = (begun.line + 1, begun.column + 1) if begun else self.at
        self.what = f"{getattr(problem, 'context', None) or ''}: {getattr(problem, 'problem', None) or ''}"
        self.line, self.text = self.at[0], source.line(self.at[0])
        self.before, self.rest = self.text[: self.at[1] - 1], self.text[self.at[1] - 1 :]
        self.letter, self.indent = self.rest[:1], len(self.text) - len(self.text.lstrip(" "))
        self.opened = source.line(self.begun[0])[self.begun[1] - 1 :][:1]

    def report(self, message: str, help: str, place: Sequence[int] = (), length: int = 1, here: str = "") -> Diagnostic:
        line, column = place or self.at
        related = [Related(here, Span(self.source, *self.at))] if here else []
        return error("yaml-syntax", message, Span(self.source, line, column, max(1, length)), help, related)

    def mark(self) -> Diagnostic | None:
        """Report characters that do not belong in YAML: git conflict markers, tabs, comments of other languages."""
        if mark := _CONFLICT.search(self.source.text):
            place = self.source.span(mark.start())[1:3]
            return self.report("unresolved merge conflict", "choose a version, and remove the markers", place, 7)
        if "\t" in (blank := self.text[: len(self.text) - len(self.text.lstrip())]):
            return self.report("this line is indented with a tab", "use spaces", (self.line, blank.index("\t") + 1))
        if self.before.endswith("$") and self.letter == "{":
            help = 'inside [ ] and { }, write expressions with quotes: "${...}"'
            return self.report("this expression needs quotes", help, (self.line, self.at[1] - 1), 2)
        lines = range(self.begun[0], self.line + 1) if "parsing a flow" in self.what else ()
        return next((made for number in lines if (made := self.foreign_comment(number))), None)

    def foreign_comment(self, line: int) -> Diagnostic | None:
        found = re.match(_FOREIGN_COMMENT, self.source.line(line))
        message = f'"{found[1]}" does not begin a comment' if found else ""
        return self.report(message, _COMMENT, (line, found.start(1) + 1), len(found[1])) if found else None

    def quote(self) -> Diagnostic | None:
        begun: tuple[int, ...] = self.begun
        if "quoted scalar" not in self.what:  # the parser took a later quote as the end of the string
            end = (self.line - 1, len(self.before.rstrip()))
            *_, last = None, *(token for token in quoted_tokens(self.source.text) if token.start_mark.line < end[0])
            if last is None or (last.end_mark.line, last.end_mark.column) != end:
                return None
            begun = self.source.span(last.start_mark.index)[1:3]
        elif "escape" in self.what:
            help = "use single quotes, or double the backslash"
            return self.report(f'"{self.rest[:2]}" is not a valid escape in double quotes', help, length=2)
        return self.report("this quote is not closed", "close it where the text ends", begun)

    def after_a_value(self) -> Diagnostic | None:
        before, rest = self.before.rstrip(), self.rest.strip()
        if not before.endswith(("'", '"', "]", "}")) or not rest or "did not find expected" not in self.what:
            return None
        if before[-1] in "'\"":
            escape = "''" if before[-1] == "'" else '\\"'
            return self.report("text continues after its closing quote", f"write {escape} for {before[-1]} in the text")
        if "block" not in self.what or rest[0] in ":,":
            return None
        word = printable(rest.split()[0])
        help = "write the unit after each number" if parse_unit(word) else 'remove it, or begin a comment with "#"'
        help = "remove it, or add the opening bracket" if rest[0] in "]}" else help
        return self.report(f'unexpected "{word}" after the closing "{before[-1]}"', help, length=len(word))

    def bracket(self) -> Diagnostic | None:
        if "found unexpected ':'" in self.what:
            return self.report('this ":" has no value', "write a space and the value after it")
        if "',' or" not in self.what:
            return None
        closing, is_other = "}" if self.opened == "{" else "]", self.letter in ("]", "}")
        depth, is_closed = 0, False
        rest = "\n".join(self.source.text.splitlines()[self.begun[0] - 1 :])[self.begun[1] - 1 :]
        for found in re.finditer(_IN_BRACKETS, rest):
            depth += (found[0] in "[{") - (found[0] in "]}")
            is_closed = is_closed or (depth == 0 and found[0] in "]}")
        if is_other or not is_closed:
            here = f'the "{self.letter}"' if is_other else "another entry begins here" if self.text.strip() else ""
            message = f'this "{self.opened}" is not closed{f" before {here}" if is_other else ""}'
            return self.report(message, f'add "{closing}"', self.begun, here=here)
        text = re.split(r"[,\[\]{}]", self.before)[-1].strip()
        end = len(self.before.rstrip()) + 1
        word = text.split()[-1] if text else ""
        value = text[: -len(word)].rstrip() if word != text or self.line == self.begun[0] else "above"
        if self.letter == ":" and value and not value.endswith(":") and word in _keys():
            return self.report(f'a "," is missing before "{word}"', "add it", (self.line, end - len(word)), len(word))
        if self.letter == ":" and ": " in text:
            length = len(text.partition(": ")[2].lstrip())
            return self.report('text with ":" needs quotes', _QUOTE, (self.line, end - length), length + 1)
        return self.report(f'a "," or the closing "{closing}" is missing here', f"add it, or {_QUOTE}")

    def colon(self) -> Diagnostic | None:
        not_allowed = "mapping values are not allowed" in self.what
        if not_allowed and (found := re.search(_COLON, self.before)):
            value = self.before[found.end() :]
            place = (self.line, found.end() + 1 + len(value) - len(value.lstrip()))
            return self.report('text with ":" needs quotes', _QUOTE, place, len(value.strip()))
        above = self.line_above(self.line)
        if not_allowed or self.what.endswith("could not find expected ':'"):
            number = self.begun[0] if "simple key" in self.what else above
            while number and _is_bare(self.source.line(number)):
                higher = self.line_above(number)
                is_item = self.source.line(number).lstrip().startswith("- ")
                if is_item or not higher or not _is_bare(self.source.line(higher)):
                    return self.bare_line(number)
                number = higher
        if not_allowed and re.search(_COLON, text := self.source.line(above)):
            name = printable(re.split(_COLON, text.strip().lstrip("- "))[0].strip()[:40])
            message, spaces = f'this line is indented below "{name}", which already has a value', _key_indent(text)
            help = f'indent it by {count_of(spaces, "space")}, like "{name}"' if spaces else "remove its indentation"
            return self.report(message, help, (self.line, self.indent + 1))
        return None

    def bare_line(self, number: int) -> Diagnostic:
        if comment := self.foreign_comment(number):
            return comment
        line = self.source.line(number)
        text = line[_key_indent(line) :].strip()
        found = re.match(r"([\w.-]+)\s*(:=|[:=\uff1a])\s*(\S.*)?$", text)
        name, sign, value = found.groups() if found else text.partition(" ")
        message, help = 'a ":" is missing in this line', f'write "{printable(f"{name}: {value.strip()}").strip()}"'
        if found:
            message = 'a space is missing after the ":"' if sign == ":" else f'"{sign}" is used instead of ":"'
        elif len(text.split()) > 3 or text[-1] in ".,;!>":
            help = 'write XML as text in "urdf_elements"' if text.startswith("<") else _COMMENT
        return self.report(message, help, (number, _key_indent(line) + 1), len(text))

    def indentation(self) -> Diagnostic | None:
        is_item = "'-' indicator" in self.what
        if not ("expected key" in self.what or is_item) or self.before.strip() or not self.text.strip():
            return None
        message = f"this line is indented by {self.indent} spaces, which matches no line above"
        help = "indent it like the other lines of its entry"
        if is_item and self.indent == self.begun[1] - 1:
            message = 'this line needs a leading "- ", like the other items of the list'
            help = 'add "- ", or indent it like the lines of the item above'
        elif self.letter == "-":
            message, help = "a list item is mixed with keys", "indent it like the other items of its list"
        return self.report(message, help, (self.line, self.indent + 1))

    def beginning(self) -> Diagnostic:
        text = self.source.text
        for words, message, help, at_begun in _REPORTS:
            if words in self.what:
                place = self.begun if at_begun else self.at
                return self.report(message.format(letter=printable(self.letter)), help, place)
        if "expected node content" in self.what:
            if self.letter == ",":
                return self.report('a value is missing before this ","', "write the value, or remove the comma")
            if self.letter:
                return self.report(f'unexpected "{self.letter}"', "remove it, or add the opening bracket")
            last = max(text.rfind("["), text.rfind("{"))
            closing = "]" if text[last] == "[" else "}"
            return self.report(f'this "{text[last]}" is not closed', f'add "{closing}"', self.source.span(last)[1:3])
        is_scanning = self.what.startswith(("while scanning", "while parsing a node", "while parsing a t"))
        if self.opened in _BEGINNINGS and is_scanning:
            return self.report(f'"{self.opened}" begins {_BEGINNINGS[self.opened]} here', _QUOTE, self.begun)
        if "<document start>" in self.what:
            if text.startswith("%"):
                return self.report('a line that begins with "%" is a YAML directive', "remove it", (1, 1))
            return self.report("unexpected text after the description", "remove it, or the closing bracket above")
        return self.report("YAML cannot be parsed from here on", f"indent with spaces; {_QUOTE}")

    def line_above(self, line: int) -> int:
        return next((n for n in range(line - 1, 0, -1) if self.source.line(n).lstrip()[:1] not in ("", "#")), 0)


def _keys() -> set[str]:
    schema = json.loads((data_folder("schemas") / "description.schema.json").read_text("utf-8"))
    return {key for part in (schema, *schema["$defs"].values()) for key in part.get("properties", ())}


def _is_bare(line: str) -> bool:
    text = line[_key_indent(line) :].strip()
    return bool(text) and not re.search(_COLON, text) and not text.startswith(("[", "{", "---", "'", '"'))


def _key_indent(line: str) -> int:
    return len(line) - len(re.sub(_ITEM, "", line))


def quoted_tokens(text: str) -> Iterator[Any]:
    """Yield the PyYAML tokens of quoted scalars, up to the first syntax error."""
    scanner = getattr(yaml, "CLoader", yaml.Loader)(text)
    try:
        while (token := scanner.get_token()) is not None:
            if isinstance(token, yaml.ScalarToken) and token.style in ("'", '"'):
                yield token
    except yaml.YAMLError:  # the caller reports the error
        return
