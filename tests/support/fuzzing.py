"""Descriptions that go wrong, made at random from one that uses the whole language, and what must hold for each.

A description is handled here as plain dicts, lists and texts, one tree a file; ``Raw`` is text that is written to YAML
as it stands. Nothing here depends on the hash of a text or on the clock: a seed gives the same description everywhere.
"""

import copy
import json
import os
import random
import re
import resource
import signal
import sys
from collections.abc import Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import yaml

from rosorin_compile.cli.report_formats import FORMATS
from rosorin_compile.formats.compilation import Compiled, compile_robot
from rosorin_compile.source.diagnostics import Diagnostic, Span, has_errors
from support.paths import DATA

Tree = Any
Files = dict[str, Tree]
Steps = tuple[Any, ...]


class Raw(str):
    """Text that is written to YAML as it stands, such as a text in quotes."""

    __slots__ = ()


# One of everything: each piece of the language stands there at least once, so that a mutation can break it.
WHOLE = DATA / "whole"

# What may stand where something else belongs: one of each kind of value, and those that are hard to take.
TEXTS = """
true | 0 | -1 | 2 | 1e-400 | 1e308 | .inf | .nan | 99999999999999999999999 | word | two words | 12 mm | 3 kg |
90 deg | 5 blinks | 2026-11-20 | x | mount | base_link | leg | pad | robot.yaml | sensors/camera |
nowhere/part | os:path/part | json:json/part | ../robot/leg | ${ | $${x} | ${1/0} | ${none} | ${true} |
${legs} | ${unknown} | ${[1, 2, 3]} | ${[[1], [2]]} | ${table} | ${finger} | ${range(4)} | ${3*kg} |
a ${legs} b | ${name} | ${load("robot.yaml")} | ${load("nothing.yaml")}
"""
VALUES: tuple[Tree, ...] = (
    "",
    *(text.strip() for text in TEXTS.split("|")),
    Raw('""'),
    Raw('"12 mm"'),
    Raw('"\\0"'),
    Raw("*nobody"),
    Raw("!!int 3"),
    Raw("|\n        two\n        lines"),
    [],
    ["1"],
    ["", ""],
    ["1", "2", "3"],
    ["x", "y", "z"],
    ["a", ["b", {"c": "d"}]],
    {},
    {"x": "1"},
    {"part": "leg", "parent": "base_link"},
    {"part": "pad"},
    {"for": {"i": "${range(2)}"}, "if": "${i > 0}", "x": "${i}"},
    {"for": "3"},
    {"for": {}},
    {"for": {"i, j": ["1", "2"]}},
    {"for": {"": ["1"]}},
    {"for": {"load()": ["1"]}},
    {"if": "word"},
    {"if": ""},
    {"if": {"if": "${true}"}},
    {"type": "length", "default": "5 kg"},
    {"type": "lenght"},
    {"type": ["x"], "default": {"a": "b"}, "one_of": "word", "help": ["x"]},
    {"file": "wheels.yaml", "args": {"tread": "${1/0}", "nothing": "1"}},
    {"file": "wheels.yaml", "args": "word"},
    {"file": "robot.yaml"},
    {"${legs}": "1", "leg_${name}": "2", "${": "3", "": "4", "a b": "5"},
)

# Keys that mean something somewhere.
WORDS_OF_KEYS = """
for if value part with params let use prefix mirror content parent xyz rpy source help type default
one_of args include file links joints sensors servos poses edges disabled_contacts optical mjcf
publisher sensor_types parts robot child frame positions pulses mimic limit axis name ${name} ${
${legs} <<
"""
KEYS = WORDS_OF_KEYS.split()

# Errors that no file has: what stands on the command line, and a first file that cannot be read.
PLACELESS = {"unknown-argument", "file-unreadable"}


def whole() -> Files:
    """Return the trees of the whole description."""
    found = {path.name: path.read_text("utf-8") for path in sorted(WHOLE.glob("*.yaml"))}
    assert len(found) == 3
    return {name: yaml.load(text, yaml.BaseLoader) for name, text in found.items()}  # noqa: S506 - makes texts only


def steps_of(tree: Tree, at: Steps = ()) -> Iterator[Steps]:
    """Yield the path of every node of a tree, itself first."""
    yield at
    pairs: Any = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, item in pairs:
        yield from steps_of(item, (*at, key))


def node_at(tree: Tree, steps: Steps) -> Tree:
    for step in steps:
        tree = tree[step]
    return tree


def replaced(tree: Tree, steps: Steps, value: Tree) -> Tree:
    """Return a tree with another value at a path."""
    if not steps:
        return copy.deepcopy(value)
    changed = dict(tree) if isinstance(tree, dict) else list(tree)
    changed[steps[0]] = replaced(tree[steps[0]], steps[1:], value)
    return changed


def mutated(files: Files, chance: random.Random) -> Files:
    """Return the files with one thing changed: a value, a key, an entry."""
    name = chance.choice(sorted(files))
    tree = files[name]
    steps = chance.choice(list(steps_of(tree)))
    node = node_at(tree, steps)
    way = chance.randrange(6)
    if way == 0 and isinstance(node, dict) and node:
        key = chance.choice(list(node))
        made: Tree = {chance.choice(KEYS) if k == key else k: v for k, v in node.items()}
    elif way == 1 and isinstance(node, dict):
        made = {**node, chance.choice(KEYS): chance.choice(VALUES)}
    elif way == 2 and isinstance(node, (dict, list)) and node:
        made = copy.copy(node)
        del made[chance.choice(list(node)) if isinstance(node, dict) else chance.randrange(len(node))]
    elif way == 3:
        other = files[chance.choice(sorted(files))]
        made = node_at(other, chance.choice(list(steps_of(other))))
    else:
        made = chance.choice(VALUES)
    return {**files, name: replaced(tree, steps, made)}


def written(tree: Tree, indent: int = 0) -> str:
    """Return a tree as YAML in block style, so that texts need no quotes for what stands in them."""
    margin = "  " * indent
    if isinstance(tree, dict) and tree:
        return "\n" + "\n".join(f"{margin}{scalar(key)}: {written(value, indent + 1)}" for key, value in tree.items())
    if isinstance(tree, list) and tree:
        return "\n" + "\n".join(f"{margin}- {written(value, indent + 1)}" for value in tree)
    return scalar(tree) if isinstance(tree, str) else repr(tree)


def scalar(text: str) -> str:
    """Return a text as a scalar that YAML reads as the same, without quotes where that is possible."""
    if isinstance(text, Raw):
        return text
    plain = re.fullmatch(r"[\w.+/$<-](?:[^\n:#]|:(?=\S)|(?<=\S)#)*", text) and not text.startswith("- ")
    return text if not text or (plain and text == text.strip()) else json.dumps(text)


def write(files: Mapping[str, Tree], folder: Path) -> None:
    """Write files, given as trees, as text or as bytes."""
    for name, tree in files.items():
        data = tree if isinstance(tree, bytes) else tree if isinstance(tree, str) else f"{written(tree)}\n"
        (folder / name).write_bytes(data if isinstance(data, bytes) else data.encode("utf-8"))


def held(path: Path, arguments: Mapping[str, str] | None = None) -> Compiled:
    """Compile a description and hold what came out against what holds for every description."""
    made = compile_robot(path, arguments or {})
    for diagnostic in made.diagnostics:
        hold_diagnostic(diagnostic)
    for form in FORMATS.values():
        form(made.diagnostics).encode("utf-8")
    assert made.robot is not None or has_errors(made.diagnostics), "no robot, and nobody says why"
    assert not made.artifacts or not has_errors(made.diagnostics), "artifacts in spite of errors"
    for artifact in made.artifacts:
        artifact.text.encode("utf-8")
    return made


def hold_diagnostic(diagnostic: Diagnostic) -> None:
    assert re.fullmatch(r"[a-z][a-z0-9]*(-[a-z0-9]+)*", diagnostic.rule), diagnostic
    assert diagnostic.message.strip(), diagnostic
    assert len(diagnostic.message) + len(diagnostic.help) < 20_000, f"{diagnostic.rule}: {diagnostic.message[:200]}..."
    python = ("Traceback", "object has no attribute", "<locals>", "NoneType", "not subscriptable", "expected str")
    assert not any(word in diagnostic.message for word in python), diagnostic.message
    assert diagnostic.span is not None or diagnostic.rule in PLACELESS, diagnostic
    for span in [diagnostic.span, *(related.span for related in diagnostic.related)]:
        if span is not None:
            hold_span(span)


@lru_cache(maxsize=4)
def lines_of(text: str) -> tuple[list[str], ...]:
    """Return the lines of a file; what is no text and what is no YAML is placed by line feeds alone."""
    return text.split("\n"), re.split("\r\n|[\n\r\x85\u2028\u2029]", text)


def hold_span(span: Span) -> None:
    """A place is one that an editor can go to."""
    for lines in lines_of(span.source.text):
        line = [*lines, ""][span.line - 1] if 1 <= span.line <= len(lines) + 1 else None
        if line is not None and 1 <= span.column <= len(line) + 2:
            break
    else:
        raise AssertionError(f"no such place: {span[1:]}")
    assert span.length >= 1, span[1:]


def main() -> None:
    """For each line "FOLDER SECONDS MEGABYTES": hold FOLDER/robot.yaml within these limits, and say how that ended.

    Each is held in a process of its own, of this one, which has everything imported; what is told, and what goes wrong,
    it writes into the folder as ``told.json`` and ``stderr``.
    """
    for line in sys.stdin:
        folder, seconds, megabytes = line.rstrip("\n").rsplit(" ", 2)
        process = os.fork()
        if process == 0:
            os.chdir(folder)
            os.dup2(os.open("stderr", os.O_WRONLY | os.O_CREAT), sys.stderr.fileno())
            _limit(int(seconds), int(megabytes))
            made = held(Path("robot.yaml"))
            Path("told.json").write_text(json.dumps([diagnostic.rule for diagnostic in made.diagnostics]))
            os._exit(0)
        print(os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]), flush=True)


def _limit(seconds: int, megabytes: int) -> None:
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    resource.setrlimit(resource.RLIMIT_AS, (megabytes << 20, megabytes << 20))
    signal.alarm(10 * seconds)


if __name__ == "__main__":
    main()
