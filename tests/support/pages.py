"""Pages of the documentation: what stands on them, and doing what they say."""

from __future__ import annotations

import doctest
import io
import os
import re
import shlex
import subprocess
import sys
import traceback
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import NamedTuple

import pytest

from rosorin_compile.cli.main import main
from support import forks
from support.paths import DOCS, ROOT

README = ROOT / "README.md"
MARK = re.compile(r"<!-- (file|edit|continues): (\S+) -->")
FENCE = re.compile("`{3,}")
FENCED = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
ELLIPSIS = "..."
PACKAGES = ".packages"  # where packages stand that a page installs


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
    """Yield the fenced blocks of a page; a longer fence may enclose lines with a shorter one."""
    lines = text.splitlines()
    opened, fence = -1, ""
    for number, line in enumerate(lines):
        found = FENCE.match(line)
        if fence and line == fence:
            mark = MARK.fullmatch(lines[opened - 1])
            language = lines[opened].removeprefix(fence)
            yield Block(opened + 1, language, (mark[1], mark[2]) if mark else ("", ""), lines[opened + 1 : number])
            fence = ""
        elif not fence and found:
            opened, fence = number, found[0]
    assert not fence, f"the block that begins in line {opened} has no end"


def play(page: Path, folder: Path) -> list[Ran]:
    """Do in a folder what a page says, and return its commands."""
    return play_text(page.read_text("utf-8"), folder)


def play_text(text: str, folder: Path, *, testing: bool = False) -> list[Ran]:
    """Do in a folder what the text of a page says.

    ``testing`` appends ``[exit N]`` to the output of a failure, and runs Python in the folder too, not at the top of
    the project.
    """
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
            ran += commands(block, folder, testing)
        elif is_session(block):
            ran += session(block, names, folder if testing else ROOT)
    return ran


def is_session(block: Block) -> bool:
    """Say whether a block is Python with what it prints."""
    return block.language == "python" and block.lines[0].startswith(">>> ")


def session(block: Block, names: dict[str, object], folder: Path) -> Iterator[Ran]:
    """Run the lines of a session in a folder and yield them; ``names`` are those of its page."""
    for example in doctest.DocTestParser().get_examples("\n".join(block.lines) + "\n"):
        terminal = io.StringIO()
        with pytest.MonkeyPatch.context() as patch, redirect_stdout(terminal), redirect_stderr(terminal):
            patch.chdir(folder)
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


def commands(block: Block, folder: Path, testing: bool) -> Iterator[Ran]:
    """Run the commands of a block and yield them; ``cd`` holds until the end of the block."""
    starts = [number for number, line in enumerate(block.lines) if line.startswith("$ ")]
    assert starts[:1] == [0], f"a console block begins with a command: {block.lines[:1]}"
    code, here = 0, folder
    for first, following in zip(starts, [*starts[1:], len(block.lines)], strict=True):
        command = block.lines[first][2:]
        printed = ""
        if command == "echo $?":
            printed = str(code)
        elif command.startswith("cd "):
            here, code = here / command[3:], 0
        else:
            printed, code = run(command, here)
        lines = [line.rstrip() for line in printed.splitlines()]
        lines += [f"[exit {code}]"] if testing and code else []
        yield Ran(command, block.start + first + 1, block.lines[first + 1 : following], lines)


def run(command: str, folder: Path) -> tuple[str, int]:
    """Return what a command prints, standard output and errors together as on a terminal, and its exit code.

    Where a page has installed a package, for it alone, each command is a process that finds it.
    """
    if command.startswith("pip install "):
        return install(command.removeprefix("pip install "), folder)
    if (folder / PACKAGES).is_dir() and re.match(r"rosorin-compile [^|>;&$*]+$", command):
        code, printed = forks.run(shlex.split(command)[1:], folder, _environment(folder))
        return printed, code
    if (folder / PACKAGES).is_dir() or not command.startswith("rosorin-compile "):
        return run_in_shell(command, folder)
    command, bar, others = command.partition(" | ")
    if bar:
        return run_in_shell(others, folder, run(command, folder)[0])
    command, less, file = command.partition(" < ")
    terminal = io.StringIO()
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(terminal), redirect_stderr(terminal):
        patch.chdir(folder)
        patch.setenv("ROSORIN_COMPILE_CACHE", str(folder / ".cache"))
        if less:
            patch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(Path(file).read_bytes())))
        code = main(shlex.split(command)[1:])
    return terminal.getvalue(), code


def install(package: str, folder: Path) -> tuple[str, int]:
    """Install a package of a page beside its files, offline; return what pip has to complain about."""
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "install", "--quiet", "--no-index", "--no-deps"]
    pip += ["--no-build-isolation", "--target", str(folder / PACKAGES), package]
    ran = subprocess.run(pip, cwd=folder, check=False, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    return ran.stdout, ran.returncode


def run_in_shell(command: str, folder: Path, given: str = "") -> tuple[str, int]:
    environment = _environment(folder)
    if (folder / PACKAGES).is_dir():
        command = f'rosorin-compile() {{ "{sys.executable}" -m rosorin_compile "$@"; }}; {command}'
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    ran = subprocess.run(["bash", "-c", command], cwd=folder, env=environment, check=False, input=given, **options)
    return ran.stdout, ran.returncode


def _environment(folder: Path) -> dict[str, str]:
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "LC_ALL": "C", "PATH": path}
    if (folder / PACKAGES).is_dir():
        environment |= {"PYTHONPATH": str(folder / PACKAGES), "ROSORIN_COMPILE_CACHE": str(folder / ".cache")}
        environment["PYTHONDONTWRITEBYTECODE"] = "1"
    return environment
