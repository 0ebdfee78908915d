"""The door: nothing outside of the modules listed here asks the system itself."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from support.imports import Module, modules
from support.paths import PACKAGE, PACKAGES

# Whose work it is to speak with the system, and why.
LISTED = {
    "cli": "sets the variable by which all processes of a run know how long a xacro may calculate",
    "diagnostics.installing": "what pip wrote about this installation, by importlib.metadata",
    "formats.xacro.child": "makes its environment that which it is given; what xacro itself looks for is noted here",
    "world.disk": "the system behind the door",
    "startup.cache": "the user's private files, which are believed only if nobody else could change them",
    "output": "writes the folder of the artifacts: whole, or not at all",
    "output.one_file": "writes a file, and what it would write over is looked at with it",
    "output.ours": "writes the record of what was written, against which it holds what is there",
    "output.placing": "writes into folders of others, and takes back what it began",
    "output.staging": "writes beside what is there, and moves it into place",
    "rosorin_compile_mujoco.collisions.search": "reads what its own processes hand back, by a pipe",
    "rosorin_compile_import.translating.proving": "sets variables of the environment for what it compares",
    "rosorin_compile_fleet.sweep.compiling": "compares input files and the installation with those of the last run",
    "rosorin_compile_fleet.sweep.folder": "writes the folder of a sweep",
    "rosorin_compile_verify.bags": "rosbags opens recordings, which are read in pieces: such a run is spoiled",
    "rosorin_compile_verify.sources": "reads what is pasted by a pipe, once: such a run is spoiled",
}

BANNED = frozenset(
    (
        *(
            "open",
            "read_text",
            "read_bytes",
            "exists",
            "is_file",
            "is_dir",
            "iterdir",
            "glob",
            "rglob",
            "stat",
            "lstat",
        ),
        *("resolve", "readlink", "samefile", "listdir", "scandir", "walk", "environ", "getenv", "getcwd", "cwd"),
        *("isfile", "isdir", "islink", "lexists", "realpath", "getsize", "getmtime", "is_symlink", "is_fifo", "access"),
        *("find_spec", "fdopen"),
    )
)


MENTIONED = re.compile(rf"\b({'|'.join(sorted(BANNED))})\b")


def asks(text: str) -> Iterator[str]:
    """Yield what a module calls that asks the system, with its line.

    ``os.environ`` needs no call. What only writes (``open("w")``) asks nothing; ``walk`` is that of ``os``, ``resolve``
    with something to resolve is none of a path, and a plain name other than ``open`` is a function of ours: those of
    ``os`` are seen where they are imported.
    """
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and node.module in ("os", "os.path", "glob", "io", "importlib.util"):
            yield from (f"{one.name}, line {node.lineno}" for one in node.names if one.name in BANNED)
        if isinstance(node, ast.Attribute) and node.attr == "environ":
            yield f"environ, line {node.lineno}"
        if isinstance(node, ast.Call) and (name := _name(node.func)) in BANNED and not _harmless(name, node):
            yield f"{name}, line {node.lineno}"


def _name(called: ast.expr) -> str:
    return called.attr if isinstance(called, ast.Attribute) else called.id if isinstance(called, ast.Name) else ""


def _harmless(name: str, call: ast.Call) -> bool:
    if name == "walk":
        return not (isinstance(call.func, ast.Attribute) and ast.unparse(call.func.value) == "os")
    if name == "resolve":
        return bool(call.args)
    if name != "open":
        return isinstance(call.func, ast.Name)
    if ast.unparse(call.func) == "webbrowser.open":
        return True
    given = [*call.args, *(one.value for one in call.keywords if one.arg == "mode")]
    modes = [one.value for one in given if isinstance(one, ast.Constant) and isinstance(one.value, str)]
    return any(set(mode) <= set("wxabt") and set(mode) & set("wxa") for mode in modes)


@cache
def asking() -> dict[str, list[str]]:
    """Return what each module asks; one that has none of the words is not parsed."""
    every = {name: module for package in PACKAGES for name, module in named(package)}
    known = {name: module for name, module in every.items() if MENTIONED.search(module.text)}
    return {name: found for name, module in known.items() if (found := list(asks(module.text)))}


def named(package: Path) -> Iterator[tuple[str, Module]]:
    """Yield the modules of a package, those of the core by their names within it."""
    before = "" if package == PACKAGE else f"{package.name}."
    yield from ((f"{before}{name}", module) for name, module in modules(package).items())


def test_nothing_asks_the_system_but_what_is_listed() -> None:
    found = {name: calls for name, calls in asking().items() if name not in LISTED}
    assert not found, "\n".join(f"{name}: {', '.join(calls)}" for name, calls in found.items())


def test_the_list_holds_no_module_that_asks_nothing() -> None:
    assert not LISTED.keys() - asking().keys()


@pytest.mark.parametrize(
    "line",
    [
        "Path(name).read_text()",
        "path.open()",
        "open(path, 'rb')",
        "path.open('r+')",
        "os.environ.get('HOME')",
        "environment = os.environ",
        "from os import environ",
        "os.path.isfile(path)",
        "path.resolve()",
        "path.resolve(strict=True)",
        "os.walk(folder)",
        "importlib.util.find_spec('mujoco')",
    ],
)
def test_what_asks_is_seen(line: str) -> None:
    assert list(asks(line))


@pytest.mark.parametrize(
    "line",
    [
        *("robot.walk()", "scope.resolve(value)", "path.open('w')", "open(path, mode='xb')", "read(path)"),
        *("exists(tree, path)", "webbrowser.open(address)"),
    ],
)
def test_what_asks_nothing_is_none(line: str) -> None:
    assert not list(asks(line))
