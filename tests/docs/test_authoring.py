"""The schema for editors: it knows all that may be written, flags what may not, and has a word on everything."""

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
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
from support.paths import DOCS, ROOT, SCHEMAS, XACRO

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
    """Yield every file that is a description, or a part of one, in this repository."""
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
# What an editor cannot see in one file, or not without evaluating it.
BEYOND = {
    "missing-key-parent": "whether a part has a mount",
    "missing-key-robot": "an included file has none",
    "unknown-key-let-used-twice": "a named value may be anything",
    "wrong-unit-control": "the unit depends on the interface",
    "wrong-unit-effort": "the unit depends on the type of the joint",
    "wrong-unit-limit-and-pose": "the unit depends on the type of the joint",
    "wrong-unit-hinge": "the unit depends on the type of the joint",
    "wrong-unit-pose": "the unit depends on the type of the joint",
    "wrong-unit-slide": "the unit depends on the type of the joint",
}


def cases() -> list[Path]:
    """Return the files of tests/bad in which something has the wrong shape as it is written, without an expression."""
    found = []
    for path in sorted(paths.BAD.glob("*.yaml")):
        text = path.read_text("utf-8")
        rules = re.findall(r"^# expect: .*?error\[(.+?)\]", text, re.MULTILINE)
        if rules and set(rules) <= set(BAD) and "${" not in text and path.stem not in BEYOND:
            found.append(path)
    return found


@pytest.mark.parametrize("path", cases(), ids=lambda path: path.stem)
def test_what_the_compiler_refuses_by_its_shape_is_flagged(path: Path) -> None:
    assert complaints(path.read_text("utf-8")) != []


def test_what_is_beyond_an_editor_is_so() -> None:
    for name in BEYOND:
        assert complaints((paths.BAD / f"{name}.yaml").read_text("utf-8")) == []


STARTER = (ROOT / "templates" / "start" / "base" / "robot.yaml").read_text("utf-8")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("xyz: [-130 mm", "xzy: [-130 mm"),
        ("joints:\n  base", "jonts:\n  base"),
        ("mass: 1.8 kg", "mass: 1.8 gk"),
        ("mass: 1.8 kg", "mass: 1.8 mm"),
        ("mass: 1.8 kg", "mass: heavy"),
        ("mass: 1.8 kg", "mass: '${mass} kg'"),
        ("type: continuous", "type: continous"),
        ("part: wheel", "prt: wheel"),
        ("with: {radius", "wiht: {radius"),
        ("child: base_link", "child: base<link"),
        ("xyz: [40 mm, 0,", "xyz: [40 mm,"),
        ("rpy: [0, 0, 180 deg]", "rpy: [0, 0, 180 mm]"),
        ("mirror: y}", "mirror: forward}"),
        ("type: length, default: 90 mm", "type: lenght, default: 90 mm"),
        ("{type: length}", "{typ: length}"),
        ("help: a driven wheel", "hlp: a driven wheel"),
        ("status: chosen", "status: choosen"),
        ("when: mapping}", "whn: mapping}"),
        ("publisher: {static_transform_publisher: tf", "publisher: {static_transform: tf"),
        ("rosorin_compile: 1 ", "rosorin_compile: 2 "),
        ("wheel_radius: 40", "wheel-radius: 40"),
        ("of: collision}    #", "of: colision}    #"),
    ],
)
def test_typos_are_flagged(old: str, new: str) -> None:
    assert STARTER.count(old) >= 1
    assert complaints(STARTER.replace(old, new, 1)) != []


@pytest.mark.parametrize(
    "text",
    [
        "links: {'leg_${i}': {for: {i: '${range(4)}'}, if: '${i > 1}'}}",
        "links: {a: '${leg}', b: null}",
        "links: '${all_links}'",
        "joints: {j: {type: '${kind}', parent: '${a}_link', child: b, xyz: '${pose}', axis: [0, '${sign}', 0]}}",
        "joints: {j: {type: fixed, parent: a, child: b, '${key}': 3, xyz: [1 mm, 2mm, '${3*mm}']}}",
        "joints: {j: {type: revolute, parent: a, child: b, limit: {lower: -90 deg, upper: 2, effort: 3 N*m^1}}}",
        "edges: [{for: {f: [a, b]}, parent: '${f}', child: c, moving: '${not still}'}]",
        "links: {a: {collision: [{for: {x: [1, 2]}, box: {size: ['${x}', 1, 1]}}, '${shape}']}}",
        "links: {a: {inertial: {mass: 3 lb, inertia: {ixx: 1 kg*m^2, iyy: 2 g*cm^2, izz: '${i}'}}}}",
        "links: {größe: {}}\nlet: {größe: 3 mm, _a: 1}",
        "include: [a.yaml, {file: b.yaml, args: {lidar: LD19, mast: 3 mm}}]",
        "parts: {p: {params: {a: 3 mm, b: [1, 2], c: null, d: {type: mass}}, use: {q: {part: r}}}}",
        "use: {left: {part: wheels/fixed, with: {r: 3}, prefix: '', parent: b, mirror: y, content: {links: {a: {}}}}}",
        "sensor_types: {radar: {help: a radar, params: {range: 3 m}, optical: {frame: '${frame}_o'}}}",
        "sensors: {s: {type: radar, parent: a, frame: b, with: {range: 4 m}}}",
        "servos: {arm: {joints: [a], rad_per_pulse: '${240*deg/1000}', zero_pulse: '${zero}', pulse_range: [0, 1000]}}",
        "outputs: {mjcf: {file: '${name}.xml', base: '${base}', options: {a: 1}}}",
    ],
)
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
