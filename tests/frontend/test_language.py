"""Scalars, quantities and expressions: what a value means."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.language.expression import ExpressionError, evaluate, names_in
from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.load import LoadError, parse_yaml, plain_scalar
from rosorin_compile.source.units import LENGTH, UNITS, Quantity, dimension_of, parse_unit
from support.paths import data_text

CASES = yaml.safe_load(data_text("cases/expressions.yaml"))
NAMES = {"radius": 0.05, "side": "left", "length": Quantity(2.0, LENGTH), "offsets": [1, 2, 3]}


@pytest.mark.parametrize(("text", "value"), CASES["scalars"])
def test_scalars_mean_what_yaml_1_2_says(text: str, value: object) -> None:
    found = plain_scalar(text)
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize(("text", "value", "dimension"), CASES["quantities"])
def test_quantities_are_si(text: str, value: float, dimension: list[int]) -> None:
    found = plain_scalar(text)
    assert isinstance(found, Quantity)
    assert list(found.dimension) == dimension
    assert float(found) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["12 mmm", "mm", "12 m m", "12 m*", "12 /m", "12 m^x", "twelve mm"])
def test_what_is_no_quantity_stays_text(text: str) -> None:
    assert Quantity.parse(text) is None
    assert plain_scalar(text) == text


def test_quotes_make_text() -> None:
    assert parse_yaml(Source("f", "['12 mm', \"1\", 'true', 12 mm]")) == ["12 mm", "1", "true", 0.012]


@given(st.floats(-1e6, 1e6, allow_nan=False), st.sampled_from(["mm", "cm", "um", "km", "g", "ms"]))
def test_a_power_of_ten_is_exact(value: float, unit: str) -> None:
    """A number in a decimal unit is the double nearest to the decimal that was meant."""
    from decimal import Decimal

    text = repr(value)
    factor = parse_unit(unit)
    assert factor is not None
    expected = float(Decimal(text) * Decimal(repr(UNITS[unit][0])))
    found = Quantity.parse(f"{text} {unit}")
    assert found is not None
    assert float(found) == expected


@pytest.mark.parametrize(("text", "value"), CASES["expressions"])
def test_expressions(text: str, value: object) -> None:
    assert evaluate(text, NAMES.__getitem__) == value


def test_quantities_keep_their_dimension() -> None:
    area = evaluate("length * 3*mm", NAMES.__getitem__)
    assert area.dimension == (2, 0, 0, 0)
    assert float(area) == 0.006
    assert evaluate("length / (4*m)", NAMES.__getitem__) == 0.5
    assert evaluate("length + 1", NAMES.__getitem__).dimension == LENGTH


@pytest.mark.parametrize(("text", "value", "dimension"), CASES["numbers_with_units"])
def test_a_number_with_a_unit_is_one_value(text: str, value: float, dimension: list[int] | None) -> None:
    found = evaluate(text, {**NAMES, "side_count": 2, "offsets": [1, 2], "mm": 7}.__getitem__)
    assert found == pytest.approx(value, rel=1e-15)
    assert dimension_of(found) == (dimension and tuple(dimension))


def test_text_in_quotes_is_no_quantity() -> None:
    assert evaluate("'leg 3 mm' + side", NAMES.__getitem__) == "leg 3 mmleft"
    assert names_in("2 mm * mast + '3 kg' + 5 N*m") == ["mast"]


@pytest.mark.parametrize(("text", "column"), CASES["unclear"])
def test_quantities_that_are_not_clear(text: str, column: int) -> None:
    with pytest.raises(ExpressionError) as raised:
        evaluate(text, {"m": 3, "x": 1, "y": 2}.__getitem__)
    assert raised.value.column == column
    assert raised.value.help


@pytest.mark.parametrize("text", CASES["without_value"])
def test_expressions_that_have_no_value(text: str) -> None:
    with pytest.raises(ExpressionError):
        evaluate(text, NAMES.__getitem__)


@given(st.text(alphabet="0123456789+-*/%()[]., abmdeginsx'\"_<>=:{}\\\n\t", max_size=60))
def test_no_expression_escapes_or_hangs(text: str) -> None:
    with suppress(ExpressionError):
        evaluate(text, NAMES.__getitem__)


@given(st.text(max_size=200) | st.text(alphabet="{}[]:,-&*!|>'\"% \n\tab#?1", max_size=80))
def test_no_text_breaks_the_loader(text: str) -> None:
    found = None
    try:
        parse_yaml(Source("f", text))
    except LoadError as problem:
        found = problem.diagnostic
    assert found is None or (found.message and found.span is not None)


def test_expressions_together_are_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rosorin_compile.language.expand.scope.MAX_WORK", 20_000)
    loop = 'links: {"l${i}": {for: {i: "${range(ROUNDS)}"}, if: "${sum([k for k in range(100)]) > i}"}}\n'
    for rounds, said in (
        (20, []),
        (99_999, ["the expressions of the description take more than 20,000 steps together"]),
    ):
        path = tmp_path / f"{rounds}.yaml"
        path.write_text("robot: heavy\n" + loop.replace("ROUNDS", str(rounds)), "utf-8")
        found = [one for one in compile_robot(path).diagnostics if one.rule == "too-large"]
        assert [one.message for one in found] == said
        assert [one.span.line for one in found] == [2 for _ in said]  # told once, with its place


def test_a_pipe_in_place_of_a_file_is_told_and_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.yaml")
    for line, rule in (
        ("include: [pipe.yaml]", "file-unreadable"),
        ("let: {x: \"${load('pipe.yaml')}\"}", "expression"),
    ):
        (tmp_path / "robot.yaml").write_text(f"robot: a\n{line}\nlinks: {{b: {{}}}}\n", "utf-8")
        (found,) = compile_robot(tmp_path / "robot.yaml").diagnostics
        assert found.rule == rule
        assert found.message.endswith("not a regular file")
        assert found.span.line == 2


def test_what_an_expression_has_written_changes_no_quantity_that_is_written_elsewhere() -> None:
    plain = Quantity.parse("5 mm")
    assert plain is not None
    evaluate("5mm + 1*mm", {}.__getitem__)
    assert (plain.text, Quantity.parse("5 mm").text) == ("5 mm", "5 mm")  # type: ignore[union-attr]
