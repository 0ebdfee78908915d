"""Check the English of the documentation against the list of words in docs/make/prose.yaml.

    python docs/make/prose.py [FILE ...]

FILE is a file of the repository. Without arguments it checks README, all hand-written pages, CHANGELOG, CONTRIBUTING,
SECURITY, RELEASING and the help of every command, and requires that each term that readers search for occurs on some
page. Each expression to avoid is printed as FILE:LINE:COLUMN with its replacement. Exit codes: 0 nothing found, 1
findings.
"""

from __future__ import annotations

import io
import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import redirect_stderr, redirect_stdout, suppress
from pathlib import Path
from typing import NamedTuple

import yaml

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
WORDS = yaml.safe_load(Path(__file__).with_name("prose.yaml").read_text("utf-8"))
IDIOMS = {
    re.compile(pattern.replace(" ", r"\s+"), re.IGNORECASE | re.MULTILINE): replacement
    for pattern, replacement in WORDS["idioms"].items()
}
# Written by generators: their words are those of schemas, rules and parts, or of a head, which is checked itself.
GENERATED = {"language.md", "rules.md", "from-xacro-reference.md"}
OTHERS = ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "RELEASING.md")
# Code, comments and addresses are not prose.
NOT_PROSE = re.compile(r"^```.*?^```$|<!--.*?-->|`[^`]*`|(?<=\]\()[^)\s]+(?=\))|https?://\S+", re.MULTILINE | re.DOTALL)
COMMAND = re.compile(r"^ {2,4}([a-z][a-z-]+)(?: {2,}\S|$)", re.MULTILINE)


class Finding(NamedTuple):
    """An expression to avoid: its place in a text (from 1), and the replacement."""

    name: str
    line: int
    column: int
    expression: str
    replacement: str

    def __str__(self) -> str:
        """Return the finding as one line of the report."""
        return f'{self.name}:{self.line}:{self.column}: "{self.expression}": write {self.replacement}'


def findings(name: str, text: str) -> list[Finding]:
    """Return the expressions to avoid in a Markdown or plain text, in the order of the text."""
    prose = NOT_PROSE.sub(lambda code: re.sub(r"[^\n]", " ", code[0]), text)
    found = []
    for pattern, replacement in IDIOMS.items():
        for match in pattern.finditer(prose):
            group = min(pattern.groups, 1)
            before = prose[: match.start(group)]
            line, column = before.count("\n") + 1, len(before) - before.rfind("\n")
            found.append(Finding(name, line, column, " ".join(match[group].split()), replacement))
    return sorted(found)


def pages() -> list[Path]:
    """Return the hand-written files that are checked without arguments."""
    written = [path for path in sorted(DOCS.glob("*.md")) if path.name not in GENERATED]
    return [*(ROOT / name for name in OTHERS), *written]


def help_texts(command: Sequence[str] = (), above: str = "") -> Iterator[tuple[str, str]]:
    """Yield the help of a command and of its subcommands, each with the command line that prints it."""
    from rosorin_compile.cli.main import commands

    text = _help_text(command)
    if text in ("", above):  # the word is an argument of the command above, not a command
        return
    yield " ".join(["rosorin-compile", *command, "--help"]), text
    if len(command) < 2:
        for word in COMMAND.findall(text) if command else commands():  # also those that the help does not list
            yield from help_texts([*command, word], text)


def _help_text(command: Sequence[str]) -> str:
    from rosorin_compile.cli.main import main

    output = io.StringIO()
    with redirect_stdout(output), redirect_stderr(io.StringIO()), suppress(SystemExit):
        main([*command, "--help"])
    return re.sub(r"-\n +", "-", output.getvalue())  # click wraps lines at hyphens


def missing_terms(texts: Sequence[str]) -> list[str]:
    """Return the terms that readers search for and that occur in none of the texts."""
    whole = "\n".join(texts)
    return [term for term in WORDS["terms"] if not re.search(term.replace(" ", r"\s+"), whole, re.IGNORECASE)]


def main(arguments: Sequence[str]) -> int:
    """Check the files, or everything, and print the findings; return the exit code."""
    paths = [Path(argument).resolve() for argument in arguments] or pages()
    texts = {path.relative_to(ROOT).as_posix(): path.read_text("utf-8") for path in paths}
    missing = []
    if not arguments:
        searched = [text for name, text in texts.items() if name == "README.md" or name.startswith("docs/")]
        missing = missing_terms([*searched, *((DOCS / name).read_text("utf-8") for name in sorted(GENERATED))])
        texts |= dict(help_texts())
    found = [finding for name, text in texts.items() for finding in findings(name, text)]
    for finding in found:
        print(finding)
    for term in missing:
        print(f'README.md, docs: "{term}" does not occur: use it where readers search for it')
    return 1 if found or missing else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
