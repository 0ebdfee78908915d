"""The schema for editors: it knows all that may be written, flags what may not, and has a word on everything."""

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from jsonschema import Draft7Validator

from rosorin_compile.formats import FORMATS
from rosorin_compile.language.validate import validate
from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.load import parse_yaml, plain_scalar
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.units import UNITS, Quantity
from support import paths
from support.paths import DOCS, ROOT, SCHEMAS, XACRO, data_text

CASES = yaml.safe_load(data_text("cases/authoring.yaml"))

FILE = SCHEMAS / "authoring.schema.json"
SCHEMA = json.loads(FILE.read_text("utf-8"))
VALIDATOR = Draft7Validator(SCHEMA)


def as_an_editor_sees_it(value: Any) -> Any:
    """Return a tree as an editor reads it: a quantity is text there."""
    if isinstance(value, Map):
        return {key: as_an_editor_sees_it(item) for key, item in value.items()}
    if isinstance(value, Seq):
        return [as_an_editor_sees_it(item) for item in value]
    if isinstance(value, Quantity):
        return value.text
    return str(value) if isinstance(value, str) else value


def complaints(text: str) -> list[str]:
    tree = as_an_editor_sees_it(parse_yaml(Source("robot.yaml", text)))
    found = sorted(VALIDATOR.iter_errors(tree), key=lambda error: list(map(str, error.absolute_path)))
    return [f"{'/'.join(map(str, error.absolute_path))}: {error.message}" for error in found]


def files() -> Iterator[Path]:
    yield from sorted((ROOT / "descriptions").glob("*/*.yaml"))
    yield from sorted((ROOT / "templates" / "start").glob("*/*.yaml"))
    yield from sorted((ROOT / "parts").glob("*.yaml"))
    yield from sorted((ROOT / "examples").glob("*/robot.yaml"))
    for path in sorted((XACRO).glob("*/robot.yaml")):
        if "# expect: " not in path.read_text("utf-8"):
            yield path


def pages() -> Iterator[tuple[str, str]]:
    for page in sorted(DOCS.glob("*.md")):
        for name, text in re.findall(
            r"<!-- file: (\S+\.yaml) -->\n```yaml\n(.*?)```", page.read_text("utf-8"), re.DOTALL
        ):
            if re.search(r"^(rosorin_compile|robot|links|joints|sensors|parts|publishers|source):", text, re.MULTILINE):
                yield f"{page.name} {name}", text


def test_it_is_a_schema() -> None:
    Draft7Validator.check_schema(SCHEMA)
    references = re.findall(r'"\$ref": "#/(.+?)"', json.dumps(SCHEMA))
    for reference in references:
        node = SCHEMA
        for step in reference.split("/"):
            node = node[step]


@pytest.mark.parametrize("path", list(files()), ids=lambda path: path.relative_to(ROOT).as_posix())
def test_every_file_fits_alone(path: Path) -> None:
    assert complaints(path.read_text("utf-8")) == []


def test_every_description_on_a_page_fits() -> None:
    found = list(pages())
    assert {name: complaints(text) for name, text in found if complaints(text)} == {}


BAD = ("unknown-key", "wrong-type", "wrong-length", "missing-key", "wrong-value", "wrong-unit", "bad-name")


def cases() -> list[Path]:
    """Return the files of tests/bad in which something has the wrong shape as it is written, without an expression."""
    found = []
    for path in sorted(paths.BAD.glob("*.yaml")):
        text = path.read_text("utf-8")
        rules = re.findall(r"^# expect: .*?error\[(.+?)\]", text, re.MULTILINE)
        if rules and set(rules) <= set(BAD) and "${" not in text and path.stem not in CASES["beyond_an_editor"]:
            found.append(path)
    return found


@pytest.mark.parametrize("path", cases(), ids=lambda path: path.stem)
def test_what_the_compiler_refuses_by_its_shape_is_flagged(path: Path) -> None:
    assert complaints(path.read_text("utf-8")) != []


STARTER = (ROOT / "templates" / "start" / "base" / "robot.yaml").read_text("utf-8")


@pytest.mark.parametrize(("old", "new"), CASES["typos_are_flagged"])
def test_typos_are_flagged(old: str, new: str) -> None:
    assert STARTER.count(old) >= 1
    assert complaints(STARTER.replace(old, new, 1)) != []


@pytest.mark.parametrize("text", CASES["all_that_may_be_written"])
def test_all_that_may_be_written(text: str) -> None:
    assert complaints(text) == []


@given(
    number=st.sampled_from(["1", "-2.5", ".5", "1e-3", "+7.", "1.5E+2"]),
    space=st.sampled_from(["", " ", "  "]),
    units=st.lists(st.sampled_from(sorted(UNITS)), min_size=1, max_size=3),
    operators=st.lists(st.sampled_from("*/"), min_size=2, max_size=2),
    powers=st.lists(st.sampled_from(["", "^2", "^-1"]), min_size=3, max_size=3),
)
def test_a_quantity_that_the_compiler_takes_is_not_flagged(
    number: str, space: str, units: list[str], operators: list[str], powers: list[str]
) -> None:
    factors = [unit + power for unit, power in zip(units, powers, strict=False)]
    unit = factors[0] + "".join(operator + factor for operator, factor in zip(operators, factors[1:], strict=False))
    text = f"robot: r\nlinks: {{a: {{inertial: {{of: collision, mass: {number}{space}{unit}}}}}}}\n"
    assert isinstance(plain_scalar(f"{number}{space}{unit}"), Quantity)
    if not validate(parse_yaml(Source("robot.yaml", text)), FORMATS):
        assert complaints(text) == []


def fragments(node: Any, path: str = "") -> Iterator[tuple[str, Mapping[str, Any]]]:
    if isinstance(node, dict):
        for name, value in node.get("properties", {}).items():
            yield f"{path}/{name}", value
        for key, value in node.items():
            if key != "properties":
                yield from fragments(value, f"{path}/{key}")
            else:
                for name, inner in value.items():
                    yield from fragments(inner, f"{path}/{name}")
    elif isinstance(node, list):
        for item in node:
            yield from fragments(item, path)


def test_hovering_over_a_key_says_what_it_is() -> None:
    found = dict(fragments(SCHEMA))
    for path, value in found.items():
        told = value.get("description")
        while told is None and "$ref" in value:
            node: Any = SCHEMA
            for step in value["$ref"].removeprefix("#/").split("/"):
                node = node[step]
            value, told = node, node.get("description")
        assert told, path


def test_patterns_are_legal_in_an_editor() -> None:
    """Use no escape that JavaScript's regular expressions with the flag u refuse."""
    patterns = re.findall(r'"pattern": "((?:[^"\\]|\\.)*)"', FILE.read_text("utf-8"))
    for pattern in {json.loads(f'"{pattern}"') for pattern in patterns}:
        assert set(re.findall(r"\\(.)", pattern)) <= set("dswSDWbB^$\\.*+?()[]{}|/"), pattern


@pytest.mark.parametrize(
    ("backend", "option", "value"),
    [("sdf", "version", '"1.11"'), ("mjcf", "height_maps", "hfield"), ("mjcf", "visuals", "own")],
)
def test_an_option_of_several_formats_may_have_the_words_of_each(backend, option, value):
    text = "robot: r\nlinks: {{a: {{}}}}\noutputs: {{{}: {{file: a, {}: {}}}}}\n"
    assert complaints(text.format(backend, option, value)) == []
    assert complaints(text.format(backend, option, "nonsense")) != []
