"""Any finite number anywhere: a robot compiles into artifacts that agree with it, or says what is wrong.

One robot has every kind of number that a description has, and most formats; each of its numbers is replaced by those at
which arithmetic ends: the largest and the smallest, those that no square has, those that are no whole number any more.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from rosorin_compile.compare.agreement import agreement
from rosorin_compile.formats.compiled import compile_robot
from rosorin_compile.source.diagnostics import Diagnostic, has_errors

pytestmark = pytest.mark.slow

ROBOT = (Path(__file__).parent.parent / "data" / "extreme_numbers.yaml").read_text("utf-8")
_NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?![\w.%])")
NUMBERS = [found.span() for found in _NUMBER.finditer(ROBOT)]
EXTREME = [
    "1.7976931348623157e308",
    "1e308",
    "1e300",
    "1e200",
    "1e155",
    "1e149",
    "1e110",
    "1e100",
    "1e30",
    "9e29",
    "1e18",
    "1e16",
    "1e10",
]
EXTREME += ["9007199254740993", "5e-324", "1e-308", "1e-300", "1e-160", "1e-30", "1e-12", "0", "255"]
EXTREME += [f"-{text}" for text in EXTREME]
_NO_NUMBER = re.compile(r"(?<![\w\"'])[-+]?(?:nan|inf)(?![\w\"'])", re.IGNORECASE)


def told(folder: Path, changes: dict[int, str]) -> list[Diagnostic]:
    """Compile the robot with other numbers; what comes of it has to hold against the model."""
    text = ROBOT
    for number, value in sorted(changes.items(), reverse=True):
        start, end = NUMBERS[number]
        text = text[:start] + value + text[end:]
    path = folder / "robot.yaml"
    path.write_text(text, "utf-8")
    made = compile_robot(path)
    if has_errors(made.diagnostics):
        assert not made.artifacts
        assert all(one.span is not None for one in made.diagnostics if one.severity == "error"), made.diagnostics
        return made.diagnostics
    assert made.robot is not None
    assert made.artifacts
    assert agreement(made.robot, made.artifacts) == []
    for artifact in made.artifacts:
        if artifact.backend != "page":  # whose program has those words
            assert _NO_NUMBER.search(artifact.text) is None, artifact.file
    return made.diagnostics


def test_the_robot_itself_is_sound(tmp_path: Path) -> None:
    assert not has_errors(told(tmp_path, {}))


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    changes=st.dictionaries(
        st.integers(0, len(NUMBERS) - 1),
        st.one_of(st.sampled_from(EXTREME), st.floats(allow_nan=False, allow_infinity=False).map(repr)),
        min_size=1,
        max_size=3,
    )
)
@example(changes={NUMBERS.index(found.span()): "9e15" for found in _NUMBER.finditer(ROBOT) if found[0] == "0.35"})
@example(changes={55: "0"})  # the axis of a joint that is damped
def test_any_numbers(tmp_path: Path, changes: dict[int, str]) -> None:
    told(tmp_path, changes)


@pytest.mark.tier("fuzz")
@pytest.mark.parametrize("number", range(len(NUMBERS)))
def test_each_number_at_each_extreme(tmp_path: Path, number: int) -> None:
    for value in EXTREME:
        told(tmp_path, {number: value})


PLACES = {
    "links": "links: {{b: {{collision: [{{sphere: {{radius: {}}}}}]}}}}",
    "inertia": "links: {{b: {{inertial: {{mass: 1, inertia: {{ixx: {}, iyy: 1, izz: 1}}}}}}}}",
    "pose": "links: {{b: {{}}, a: {{}}}}\njoints: {{j: {{type: fixed, parent: b, child: a, xyz: [0, {}, 0]}}}}",
    "quantity": "links: {{b: {{}}, a: {{}}}}\njoints: {{j: {{type: fixed, parent: b, child: a, xyz: [0, {} m, 0]}}}}",
}


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("value", ["1e151", "-1e151", "1e308"])
def test_what_nothing_can_be_calculated_with_is_told_at_its_place(tmp_path: Path, place: str, value: str) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(f"robot: r\n{PLACES[place].format(value)}\noutputs: {{urdf: {{file: r.urdf}}}}\n", "utf-8")
    found = [one for one in compile_robot(path).diagnostics if one.rule == "not-finite"]
    assert len(found) == 1
    assert f"is {float(value):g}, and nothing can be calculated with more than 1e+150" in found[0].message
    span = found[0].span
    assert span is not None
    assert path.read_text("utf-8").splitlines()[span.line - 1][span.column - 1 :].startswith(value)


@pytest.mark.parametrize(
    "place",
    [
        "links: {{b: {{inertial: {{mass: {}, inertia: {{ixx: 1, iyy: 1, izz: 1}}}}}}}}",
        "links: {{b: {{}}}}\npublishers: {{n: {{package: p}}}}\nposes: {{home: {{mjcf: {{time: {}}}}}}}",
    ],
)
def test_what_is_not_calculated_with_or_has_a_rule_of_its_own_is_not_told_so(tmp_path: Path, place: str) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(f"robot: r\n{place.format('1e151')}\noutputs: {{urdf: {{file: r.urdf}}}}\n", "utf-8")
    assert [one for one in compile_robot(path).diagnostics if one.rule == "not-finite"] == []


def test_a_limit_may_be_the_largest_number(tmp_path: Path) -> None:
    """As many files of others say that there is none."""
    most = "1.7976931348623157e308"
    limit = f"{{lower: -{most} rad, upper: {most} rad, effort: {most}, velocity: {most}}}"
    joints = f"{{j: {{type: revolute, parent: b, child: a, axis: [0, 0, 1], limit: {limit}}}}}"
    path = tmp_path / "robot.yaml"
    path.write_text(f"robot: r\nlinks: {{b: {{}}, a: {{}}}}\njoints: {joints}\noutputs: {{urdf: {{file: r.urdf}}}}\n")
    made = compile_robot(path)
    assert not has_errors(made.diagnostics)
    assert made.artifacts
