"""The documentation holds: its files compile, its commands print what the page shows, its links lead somewhere.

How a page is read. An HTML comment on the line above a block says what to do with the block:

    <!-- file: PATH -->       it is written to PATH
    <!-- edit: PATH -->       it is a diff: in PATH, its lines with "-" become those with "+"

and ``<!-- continues: PAGE -->`` means that the files and commands of another page come before. In a ``console`` block
each line that begins with "$ " is run in the folder of the page, and what it prints is compared with the lines below
it; a line "..." there stands for any lines. A ``python`` block that begins with ">>> " is a session: it is run at the
top of the project, with what the sessions above it on the page have defined.

    python tests/test_docs.py

writes into the pages what the commands print now. What a page shows with "..." is left to its author, and named.
"""

from __future__ import annotations

import doctest
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import NamedTuple

import pytest

from rosorin_compile.cli import main
from rosorin_compile.diagnostic import Source
from rosorin_compile.expression import CONSTANTS
from rosorin_compile.expression.functions import BUILT_IN
from rosorin_compile.load import parse_yaml
from rosorin_compile.pipeline import compile_robot
from rosorin_compile.quantity import UNITS
from rosorin_compile.reference import language, reference
from rosorin_compile.registry import every_rule
from rosorin_compile.report import text as report
from rosorin_compile.rules_reference import page as page_of_rules

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
HEAD = DOCS / "_language_head.md"
README = ROOT / "README.md"
RULES_HEAD = DOCS / "_rules_head.md"
PAGES = sorted(path for path in DOCS.glob("*.md") if path not in (HEAD, RULES_HEAD))

MARK = re.compile(r"<!-- (file|edit|continues): (\S+) -->")
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#{1,6} (.+)$", re.MULTILINE)
FENCED = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
ELLIPSIS = "..."


class Block(NamedTuple):
    """A fenced block: where its first line stands in the page (from 0), its language, its mark, its lines."""

    start: int
    language: str
    mark: tuple[str, str]
    lines: list[str]


class Ran(NamedTuple):
    """A command, or a line of Python: where its output stands (from 0), what the page shows, and what was printed."""

    command: str
    start: int
    shown: list[str]
    printed: list[str]

    @property
    def holds(self) -> bool:
        """Whether the page shows what was printed, as far as it shows it."""
        pattern = "".join(r"(?:.*\n)*?" if line == ELLIPSIS else re.escape(f"{line.rstrip()}\n") for line in self.shown)
        return re.fullmatch(pattern, "".join(f"{line}\n" for line in self.printed)) is not None


def blocks(text: str) -> Iterator[Block]:
    """Yield the fenced blocks of a page."""
    lines = text.splitlines()
    opened: int | None = None
    for number, line in enumerate(lines):
        if not line.startswith("```"):
            continue
        if opened is None:
            opened = number
            continue
        mark = MARK.fullmatch(lines[opened - 1])
        yield Block(opened + 1, lines[opened][3:], (mark[1], mark[2]) if mark else ("", ""), lines[opened + 1 : number])
        opened = None
    assert opened is None, f"the block that begins in line {opened} has no end"


def play(page: Path, folder: Path) -> list[Ran]:
    """Do in a folder what a page says, and return its commands."""
    text = page.read_text("utf-8")
    for kind, name in MARK.findall(text):
        if kind == "continues":
            play(DOCS / name, folder)
    ran: list[Ran] = []
    names: dict[str, object] = {}
    for block in blocks(text):
        kind, name = block.mark
        if kind == "file":
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text("\n".join(block.lines) + "\n", "utf-8")
        elif kind == "edit":
            edit(folder / name, block.lines)
        elif block.language == "console":
            ran += commands(block, folder)
        elif is_session(block):
            ran += session(block, names)
    return ran


def is_session(block: Block) -> bool:
    """Say whether a block is Python with what it prints."""
    return block.language == "python" and block.lines[0].startswith(">>> ")


def session(block: Block, names: dict[str, object]) -> Iterator[Ran]:
    """Run the lines of a session at the top of the project and yield them; ``names`` are those of its page."""
    for example in doctest.DocTestParser().get_examples("\n".join(block.lines) + "\n"):
        terminal = io.StringIO()
        with pytest.MonkeyPatch.context() as patch, redirect_stdout(terminal), redirect_stderr(terminal):
            patch.chdir(ROOT)
            patch.setattr(sys, "displayhook", lambda value: None if value is None else print(repr(value)))
            try:
                exec(compile(example.source, "<session>", "single"), names)  # noqa: S102 - a page of ours
            except Exception as problem:
                last = "".join(traceback.format_exception_only(problem))
                print(f"Traceback (most recent call last):\n  ...\n{last}", end="")
        start = block.start + example.lineno + example.source.count("\n")
        printed = [line.rstrip() for line in terminal.getvalue().splitlines()]
        yield Ran(example.source.strip(), start, example.want.splitlines(), printed)


def edit(path: Path, diff: list[str]) -> None:
    """Change a file as a diff without line numbers says."""
    assert diff
    assert all(line[:1] in ("-", "+", " ") for line in diff), diff
    old = "".join(f"{line[1:]}\n" for line in diff if line[0] != "+")
    new = "".join(f"{line[1:]}\n" for line in diff if line[0] != "-")
    text = path.read_text("utf-8")
    assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times in {path.name}"
    path.write_text(text.replace(old, new), "utf-8")


def commands(block: Block, folder: Path) -> Iterator[Ran]:
    """Run the commands of a block and yield them."""
    starts = [number for number, line in enumerate(block.lines) if line.startswith("$ ")]
    assert starts[:1] == [0], f"a console block begins with a command: {block.lines[:1]}"
    code = 0
    for first, following in zip(starts, [*starts[1:], len(block.lines)], strict=True):
        command = block.lines[first][2:]
        printed = str(code)
        if command != "echo $?":
            printed, code = run(command, folder)
        shown = block.lines[first + 1 : following]
        yield Ran(command, block.start + first + 1, shown, [line.rstrip() for line in printed.splitlines()])


def run(command: str, folder: Path) -> tuple[str, int]:
    """Return what a command prints, standard output and errors together as on a terminal, and its exit code."""
    if not command.startswith("rosorin-compile "):
        return run_in_shell(command, folder)
    command, bar, others = command.partition(" | ")
    if bar:
        return run_in_shell(others, folder, run(command, folder)[0])
    terminal = io.StringIO()
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(terminal), redirect_stderr(terminal):
        patch.chdir(folder)
        patch.setenv("ROSORIN_COMPILE_CACHE", str(folder / ".cache"))
        try:
            code = main(shlex.split(command)[1:])
        except SystemExit as stopped:
            code = int(stopped.code or 0)
    return terminal.getvalue(), code


def run_in_shell(command: str, folder: Path, given: str = "") -> tuple[str, int]:
    environment = {**os.environ, "LC_ALL": "C"}
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    ran = subprocess.run(["bash", "-c", command], cwd=folder, env=environment, check=False, input=given, **options)
    return ran.stdout, ran.returncode


def links(text: str) -> list[str]:
    """Return the targets of the links of a page; what looks like one in code is none."""
    return LINK.findall(re.sub(r"`[^`\n]*`", "", FENCED.sub("", text)))


def anchors(text: str) -> set[str]:
    """Return the anchors of a page: those that GitHub gives to its headings, and those that it has itself."""
    headings = HEADING.findall(FENCED.sub("", text))
    own = set(re.findall(r'<a id="([^"]+)"></a>', text))
    return own | {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_page_holds(page: Path, tmp_path: Path) -> None:
    for ran in play(page, tmp_path):
        shown = "\n".join(ran.shown)
        printed = "\n".join(ran.printed)
        assert ran.holds, f"{page.name}:{ran.start}: $ {ran.command}\nshown:\n{shown}\nprinted:\n{printed}"
    for path in sorted(tmp_path.glob("descriptions/*/robot.yaml")):
        made = compile_robot(path)
        assert made.robot is not None, report(made.diagnostics)


def checkout(folder: Path) -> Path:
    """Return a folder with what the commands of the README read."""
    for name in ("descriptions", "outputs", "tests/imported", "tests/data/recordings"):
        shutil.copytree(ROOT / name, folder / name)
    return folder


def test_readme_holds(tmp_path: Path) -> None:
    pytest.importorskip("numpy")  # the extra [verify]
    ran = play(README, checkout(tmp_path))
    assert len(ran) >= 3
    for one in ran:
        assert one.holds, f"$ {one.command}\nprinted:\n" + "\n".join(one.printed)


def test_there_are_pages_with_files_and_commands() -> None:
    found = [block for page in PAGES for block in blocks(page.read_text("utf-8"))]
    assert sum(block.mark[0] == "file" and block.language == "yaml" for block in found) >= 5
    assert sum(block.language == "console" for block in found) >= 5
    assert sum(map(is_session, found)) >= 5


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_yaml_block_is_yaml(page: Path) -> None:
    for block in blocks(page.read_text("utf-8")):
        if block.language == "yaml":
            parse_yaml(Source(page.name, "\n".join(block.lines)))


@pytest.mark.parametrize("page", [*PAGES, README], ids=lambda page: page.stem)
def test_links_lead_somewhere(page: Path) -> None:
    for target in links(page.read_text("utf-8")):
        if target.startswith("https://"):
            continue
        name, _, anchor = target.partition("#")
        path = (page.parent / name).resolve() if name else page
        assert path.exists(), f"{page.name}: {target}"
        assert not anchor or anchor in anchors(path.read_text("utf-8")), f"{page.name}: {target}"


def test_every_page_is_in_the_index() -> None:
    assert {page.name for page in PAGES} <= {"README.md", *links((DOCS / "README.md").read_text("utf-8"))}


def test_reference_is_what_the_generator_gives() -> None:
    made = reference(language(), HEAD.read_text("utf-8"))
    assert (DOCS / "language.md").read_text("utf-8") == made, "python -m rosorin_compile.reference > docs/language.md"


def test_python_on_a_page_runs(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    page = DOCS / "artifacts.md"
    play(page, tmp_path)
    (block,) = [block for block in blocks(page.read_text("utf-8")) if block.language == "python"]
    subprocess.run([sys.executable, "-c", "\n".join(block.lines)], cwd=tmp_path, check=True, capture_output=True)


def test_reference_has_every_unit_and_function() -> None:
    made = reference({"$defs": {}, "properties": {}, "description": ""}, HEAD.read_text("utf-8"))
    assert all(f"`{name}`" in made for name in [*UNITS, *(one.name for one in BUILT_IN), *CONSTANTS])


def test_reference_has_every_key_of_the_schema() -> None:
    made = reference(language())
    fragments = [language()]
    while fragments:
        fragment = fragments.pop()
        assert all(f"| `{key}` |" in made for key in fragment.get("properties", {})), fragment
        inner = [fragment.get("items"), fragment.get("additionalProperties")]
        inner += [*fragment.get("properties", {}).values(), *fragment.get("$defs", {}).values()]
        fragments += [value for value in inner if isinstance(value, dict)]


def test_page_of_rules_is_what_the_modules_declare() -> None:
    made = page_of_rules(RULES_HEAD.read_text("utf-8"), every_rule().values())
    assert (DOCS / "rules.md").read_text("utf-8") == made, "python -m rosorin_compile.rules_reference > docs/rules.md"
    listed = re.findall(r'^\| <a id="([a-z0-9-]+)"></a>`\1` \|', made, re.MULTILINE)
    assert sorted(listed) == sorted(every_rule())
    bad = "".join(path.read_text("utf-8") for path in (ROOT / "tests" / "bad").rglob("*.yaml"))
    assert set(re.findall(r"\b(?:error|warning|note)\[([a-z0-9-]+)\]", bad)) <= set(listed)


def rewrite(page: Path) -> None:
    """Write into a page what its commands print."""
    lines = page.read_text("utf-8").splitlines()
    with tempfile.TemporaryDirectory() as folder:
        ran = play(page, checkout(Path(folder)) if page == README else Path(folder))
    for command in reversed(ran):
        if ELLIPSIS not in command.shown:
            lines[command.start : command.start + len(command.shown)] = command.printed
        elif not command.holds:
            sys.stderr.write(f"{page.name}:{command.start}: $ {command.command}\n" + "\n".join(command.printed) + "\n")
    page.write_text("\n".join(lines) + "\n", "utf-8")


if __name__ == "__main__":
    for each in [HEAD, RULES_HEAD, README, *PAGES]:
        rewrite(each)
    (DOCS / "language.md").write_text(reference(language(), HEAD.read_text("utf-8")), "utf-8")
    (DOCS / "rules.md").write_text(page_of_rules(RULES_HEAD.read_text("utf-8"), every_rule().values()), "utf-8")
