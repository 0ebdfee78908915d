"""What import writes is YAML that reads back as the same values, and looks as a person would have written it."""

import math
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.importing.description import Verbatim, escape, in_degrees, layout, number
from rosorin_compile.language.expand.scope import Expansion, Scope
from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.load import parse_yaml, plain_scalar
from rosorin_compile.source.tree import Place
from rosorin_compile.source.yaml_text import Scalar

ODD = [
    *("on", "no", "y", "1", "1.5", "0x1F", "1e3", "1_000", "12:30", "2020-01-01", "null", "~", "true", ".inf", ".nan"),
    *("12 mm", "180 deg", "5 parsec", "<<", "=", "...", "---", "- a", "? a", ": a", "a: b", "a:", "a #b", "#a", "&a"),
    *("*a", "!a", "|", ">", "%a", "@a", "`a", "'a'", '"a"', "a'b\"c", "C:\\meshes", "[a]", "{a}", "a, b", "a]"),
    *(" a", "a "),
    *("${HOME}/a", "$${HOME}", "$$${x", "${", "$", "a${b}c", "äöü", "机器人", "🤖", "\u200b", "\ufeff", "\x85", "\x07"),
    *("a\nb", "a\nb\n", "\na", "a\n\n", "  a\nb", "a\n  b\n c", "\ta\nb", "a\n\tb", "a\n ", "a\r\nb", "x" * 900),
    *("word " * 60 + "end", "<a>\n\t<b c='${d}'/>\n</a>", "<gazebo reference='a'/>", "", "for", "if"),
]
TEXTS = st.text(st.characters(codec="utf-8"), max_size=12) | st.sampled_from(ODD)
TEXTS |= st.text("ab :#-{}[],'\"\\$\n\t", max_size=12)
NUMBERS = st.floats(allow_nan=False, allow_infinity=False).map(number)
VALUES = st.recursive(
    TEXTS | NUMBERS | st.none() | st.booleans(),
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(TEXTS, inner, max_size=5),
    max_leaves=25,
)


def plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list):
        return [plain(item) for item in value]
    return float(value) if isinstance(value, Verbatim) else value


def expanded(text: str) -> Any:
    """Return what the language makes of a file: read, and its expressions evaluated."""
    source = Source("robot.yaml", text)
    scope = Scope(Expansion())
    made = scope.resolve(parse_yaml(source), Place(source.span(), None))
    assert scope.expansion.diagnostics == []
    return made


def order(value: Any) -> Any:
    if isinstance(value, dict):
        return [(key, order(item)) for key, item in value.items()]
    return [order(item) for item in value] if isinstance(value, list) else None


@settings(max_examples=400, deadline=None)
@given(st.dictionaries(TEXTS, VALUES, min_size=1, max_size=5))
def test_what_is_written_reads_back(document: dict[str, Any]) -> None:
    text = layout(document)
    read = expanded(text)
    assert read == plain(document)
    assert order(read) == order(document)


@settings(max_examples=100, deadline=None)
@given(st.dictionaries(TEXTS, VALUES, min_size=1, max_size=4), st.data())
def test_comments_change_nothing(document: dict[str, Any], data: st.DataObject) -> None:
    paths = [(), *((key,) for key in document)]
    for key, value in document.items():
        if isinstance(value, dict):
            paths += [(key, inner) for inner in value]
        elif isinstance(value, list) and any(isinstance(item, (dict, list)) for item in value):
            paths += [(key, index) for index in range(len(value))]
    lines = st.lists(st.sampled_from(["a: b", "- c", "word " * 40, "", "#", "'"]), min_size=1, max_size=2)
    remarks = data.draw(st.dictionaries(st.sampled_from(paths), lines, max_size=5))
    assert expanded(layout(document, remarks)) == plain(document)


@pytest.mark.parametrize("text", ODD)
@pytest.mark.parametrize("flow", [True, False])
def test_other_readers_see_the_same_text(text: str, flow: bool) -> None:
    """PyYAML knows YAML 1.1, where more words mean something else."""
    written = Scalar(escape(text)).as_text(flow)
    read = yaml.safe_load(f"[{written}]" if flow else f"- {written}")
    assert read == [escape(text)]


FORMS = [
    (math.pi, "deg", "180 deg"),
    (-math.pi / 2, "deg", "-90 deg"),
    (math.pi / 8, "deg", "22.5 deg"),
    (math.pi / 8, "", "0.39269908169872414"),
    (math.pi, "deg/s", "180 deg/s"),
    (3.14159265, "deg", "3.14159265"),
    (1.5708, "deg", "1.5708"),
    (-0.0, "deg", "0"),
    (1e-3, "", "0.001"),
]


@pytest.mark.parametrize(("value", "angle", "written"), FORMS)
def test_forms_of_numbers(value: float, angle: str, written: str) -> None:
    assert number(value, angle) == written
    assert float(plain_scalar(written)) == value


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_degrees_are_exact_or_not_said(value: float) -> None:
    text = in_degrees(value, "deg")
    assert not text or plain_scalar(text) == value


@given(st.integers(-360 * 4, 360 * 4))
def test_quarters_of_a_degree_are_said(quarters: int) -> None:
    value = quarters / 4 * (math.pi / 180)
    assert float(plain_scalar(number(value, "deg"))) == value
    assert quarters == 0 or number(value, "deg").endswith(" deg")
