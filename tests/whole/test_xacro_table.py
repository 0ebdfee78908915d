"""What xacro says is said here: for each of its features the same robot in both, or the reason why not."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

from rosorin_compile.formats.compilation import CompileResult, compile_robot
from rosorin_compile.language.expression import evaluate
from rosorin_compile.source.diagnostics import NOTE, Source, text
from rosorin_compile.source.load import parse_yaml
from support.cases import as_comment, check
from support.round_trip import differences
from support.unrounded import compile_unrounded
from support.xacro_page import PAGE, page
from support.xacro_table import Case, Name, cases, expand, names, ready

xacro = pytest.importorskip("xacro")

ALL = cases()
SAME = [case for case in ALL if case.has("robot.yaml") and not case.expected]
REFUSED = [case for case in ALL if case.expected]


def compiled_case(case: Case, by: Callable[..., CompileResult] = compile_robot) -> CompileResult:
    with ready(case):
        return by(Path("robot.yaml"), case.arguments)


@pytest.mark.parametrize("case", SAME, ids=lambda case: case.name)
def test_same_robot(case: Case) -> None:
    made = compiled_case(case, compile_unrounded)
    assert made.artifacts, text(made.diagnostics)
    assert [d for d in made.diagnostics if d.severity != NOTE] == [], text(made.diagnostics)
    (artifact,) = [artifact for artifact in made.artifacts if artifact.backend == "urdf"]
    assert differences(expand(case).encode(), artifact.text.encode(), tolerance=1e-12) == []
    assert "<link " in artifact.text


@pytest.mark.parametrize("case", REFUSED, ids=lambda case: case.name)
def test_message(case: Case) -> None:
    found = as_comment(compiled_case(case).diagnostics, "robot.yaml")
    check(case.folder / "robot.yaml", found)
    assert any(" error[" in line for line in found)
    if case.xacro == "accepts":
        expand(case)
        return
    kind, _, words = case.xacro.partition(": ")
    assert kind == "refuses"
    with pytest.raises(xacro.XacroException) as raised:
        expand(case)
    assert words in str(raised.value)


NAMES = names()
SAID = [name for name in NAMES if name.ours]


def number(value: Any) -> Any:
    """Return a value as it is compared: numbers as floats, lists and tuples alike."""
    if isinstance(value, (list, tuple)):
        return [number(item) for item in value]
    return float(value) if isinstance(value, (int, float)) else value


def test_every_name_of_xacro_is_in_the_table() -> None:
    symbols = xacro._global_symbols
    spaces = ("math", "python", "xacro")
    listed = {space: {name.name for name in NAMES if name.space == space} for space in spaces}
    for space in spaces:
        assert set(symbols[space]) - {"cbrt", "exp2", "fma", "sumprod"} <= listed[space]
    assert set(symbols) - set(spaces) - {"__builtins__"} <= set().union(*listed.values())
    assert all(bool(name.ours) + bool(name.case) + bool(name.why) == 1 for name in NAMES)
    assert {name.case for name in NAMES} - {""} <= {case.name for case in ALL}


@pytest.mark.parametrize("name", SAID, ids=lambda name: f"{name.space}.{name.name}")
def test_name_has_the_same_value(name: Name) -> None:
    symbols = {**xacro._global_symbols["math"], **xacro._global_symbols["python"]}
    if name.name not in symbols:
        pytest.skip("newer than this Python")
    assert name.name in name.theirs
    theirs = number(xacro.safe_eval(name.theirs, symbols))
    ours = number(evaluate(name.ours, {}.__getitem__))
    assert ours == pytest.approx(theirs, rel=1e-12, abs=1e-12) if isinstance(theirs, float) else ours == theirs


def test_every_unit_tag_of_xacro_is_read() -> None:
    """A value behind each tag, a calculation too, is in SI what xacro makes of it."""
    loader = yaml.SafeLoader("")
    for unit in xacro.ConstructUnits:
        for value in ("12.5", "-1e-2", "360 / 7", "-pi/2", "sqrt(2) * sin(radians(30))"):
            theirs = unit.constructor(loader, yaml.ScalarNode("", value))
            ours = parse_yaml(Source("table.yaml", f"a: {unit.value.tag} {value}"))["a"]
            assert ours == pytest.approx(theirs, rel=1e-14), unit
            assert type(ours) is float  # !degrees stands before speeds, too


def test_page_is_up_to_date() -> None:
    assert PAGE.read_text("utf-8") == page(), "python tests/renew.py from-xacro"
