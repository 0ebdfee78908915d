"""Where sections and keys are written is said by the schema: of any section."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.formats.imported import Imported, Outputs
from rosorin_compile.importing import description
from rosorin_compile.importing.description import write
from rosorin_compile.language import annotations, schema
from rosorin_compile.language.expand.description import expand
from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.load import parse_yaml
from rosorin_compile.source.tree import Map

# A section that no module knows: several by name, each on a link, with a key that is as usual and words of others.
BATTERIES = {
    "type": "object",
    "description": "The batteries: what each weighs and where it sits.",
    "propertyNames": {"$ref": "#/$defs/name", "x-gives": "battery"},
    "additionalProperties": {
        "type": "object",
        "properties": {
            "link": {"$ref": "#/$defs/name", "x-names": "link"},
            "mass": {"type": "number", "x-unit": "kg"},
            "cells": {"type": "integer", "default": 1},
            "xyz": {"$ref": "#/$defs/xyz", "default": [0, 0, 0]},
            "maker": {"type": "object", "properties": {"name": {}, "code": {}}, "x-first": ["code"]},
        },
        "x-mirror": ["pose"],
    },
    "x-in-parts": True,
    "x-merge": "entries",
    "x-called": "battery",
    "x-file": "energy",
}


@pytest.fixture(autouse=True)
def another_section(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    whole = schema.schema()
    *others, last = whole["properties"].items()
    with monkeypatch.context() as changed:
        changed.setitem(whole, "properties", dict([*others, ("batteries", BATTERIES), last]))
        _forget()
        yield
    _forget()


def _forget() -> None:
    for module in (schema, annotations, description):
        for name, one in vars(module).items():
            if hasattr(one, "cache_clear") and name != "schema":
                one.cache_clear()


def tree(text: str) -> Map:
    made = parse_yaml(Source("", text))
    assert isinstance(made, Map)
    return made


def plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: plain(one) for key, one in value.items()}
    return [plain(one) for one in value] if isinstance(value, list) else value


def test_a_section_that_nobody_lists_is_written_and_read_again(tmp_path: Path) -> None:
    robot = tree(
        """\
batteries:
  left: {maker: {name: some, code: X1}, xyz: [0, 0, 0], mass: 0.5, link: box}
  right: {colour: red, cells: 1, link: box, xyz: [0, 0.1, 0]}
robot: cart
links: {box: {}}
"""
    )
    wanted = Outputs({"urdf": {"file": "cart.urdf"}}, {}, {})
    files = write(Imported(robot, []), wanted, split=True)
    assert list(files) == ["robot.yaml", "links.yaml", "energy.yaml"]
    assert files["energy.yaml"].splitlines() == [
        "# The batteries: what each weighs and where it sits.",
        "batteries:",
        "  left:",
        "    link: box",
        "    mass: 0.5",
        "    maker: {code: X1, name: some}",
        "",
        "  right: {link: box, xyz: [0, 0.1, 0], colour: red}",
    ]
    for name, text in files.items():
        (tmp_path / name).write_text(text, "utf-8")
    made = expand(tmp_path / "robot.yaml", {}, None)
    assert not made.diagnostics
    assert made.tree is not None
    assert plain(made.tree["batteries"]) == {
        "left": {"link": "box", "mass": 0.5, "maker": {"code": "X1", "name": "some"}},
        "right": {"link": "box", "xyz": [0, 0.1, 0], "colour": "red"},
    }
    whole = write(Imported(robot, []), wanted, split=False)["robot.yaml"]
    assert [line for line in whole.splitlines() if line[:1].isalpha()] == [
        "rosorin_compile: 1",
        "robot: cart",
        "links:",
        "batteries:",
        "outputs:",
    ]
