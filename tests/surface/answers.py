"""The keys of every JSON answer as lines, with the types that they have on robots of this project."""

from __future__ import annotations

import contextlib
import io
import json
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rosorin_compile.cli import main
from support.paths import DATA, ROOT

# What is asked, in a folder of its own; {root} is this project, {data} the data of the tests, {here} that folder.
ASKED = {
    "args": "args {root}/examples/unitree_a1 --format json",
    "check, messages": "check {here}/broken.yaml --format json",
    "check, sarif": "check {here}/broken.yaml --format sarif",
    "diff": "diff {here}/arm.yaml {here}/other.yaml --format json",
    "explain": "explain {root}/descriptions/rosorin laser joint1 base_link r_link --format json",
    "extract boxes": "extract boxes {data}/factory_package/meshes/base_link.stl --format json",
    "frames": "frames {root}/descriptions/rosorin --format json",
    "print --list": "print --list {root}/descriptions/rosorin --format json",
    "pulses": "pulses {root}/descriptions/rosorin --format json",
    "rule": "rule axis-zero --format json",
    "simulate": "simulate {root}/examples/ur5e --format json --no-timing",
    "tf": "tf {root}/descriptions/rosorin base_link link5 --format json",
    "tf, swept": "tf {root}/descriptions/rosorin base_link link5 --sweep joint1=0:1:3 --format json",
    "verify": "verify {root}/descriptions/rosorin {data}/recordings/session.txt --format json",
}
ARM = """\
robot: arm
links: {base_link: {}, tool: {}}
joints: {lift: {type: fixed, parent: base_link, child: tool, xyz: [0, 0, LENGTH]}}
outputs: {urdf: {file: arm.urdf}}
"""


def lines() -> Iterator[str]:
    """Yield each key of each answer once, with all types that stand there."""
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        (here / "arm.yaml").write_text(ARM.replace("LENGTH", "1 m"), "utf-8")
        (here / "other.yaml").write_text(ARM.replace("LENGTH", "2 m"), "utf-8")
        (here / "broken.yaml").write_text(ARM.replace("child: tool", "child: tol").replace("LENGTH", "1 m"), "utf-8")
        for name, words in ASKED.items():
            yield from _keys(name, _answer([word.format(root=ROOT, data=DATA, here=here) for word in words.split()]))
        (here / "list.csv").write_text("name\none\n", "utf-8")
        main(["sweep", f"{here}/arm.yaml", "--over", f"{here}/list.csv", "-o", f"{here}/fleet", "-q"])
        yield from _keys("sweep.json", json.loads((here / "fleet" / "sweep.json").read_text("utf-8")))


def _keys(name: str, answer: Any) -> Iterator[str]:
    found: dict[str, set[str]] = {}
    _walk("", answer, found)
    for key, types in sorted(found.items()):
        yield f"{name}: {key or '.'} {' | '.join(sorted(types))}"


def _answer(words: list[str]) -> Any:
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(io.StringIO()):
        code = main(words)
    if code not in (0, 1) or not said.getvalue().startswith(("{", "[")):
        raise AssertionError(f"{' '.join(words)}: exit code {code}, no JSON")
    return json.loads(said.getvalue())


def _walk(key: str, value: Any, found: dict[str, set[str]]) -> None:
    kind = type(value).__name__
    found.setdefault(key, set()).add({"NoneType": "null", "int": "number", "float": "number"}.get(kind, kind))
    if isinstance(value, dict):
        for name, inner in value.items():
            _walk(f"{key}.{name}", inner, found)
    elif isinstance(value, list):
        for inner in value:
            _walk(f"{key}[]", inner, found)
