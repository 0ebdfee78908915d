"""Every number of every robot of this repository is written where explain says, and means what explain says."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from rosorin_compile.formats.compilation import understand
from rosorin_compile.language.explain import Explanation, Number, explain
from rosorin_compile.language.expression import evaluate
from rosorin_compile.model import Robot, Transform
from rosorin_compile.source.load import plain_scalar
from support.paths import ROOT, ROSORIN


def all_explanations() -> Iterator[tuple[Path, list[Explanation]]]:
    for path in [ROSORIN, *sorted((ROOT / "examples").glob("*/robot.yaml"))]:
        expanded, lowered, *_ = understand(path)
        assert lowered is not None
        assert lowered.robot is not None
        names = [link.name for link in lowered.robot.links]
        pose = lowered.robot.poses[0].name if lowered.robot.poses else ""
        explanations = explain(expanded, lowered, {}, names, pose)
        assert [e.name for e in explanations] == names
        for explanation in explanations:
            check_transforms(explanation, lowered.robot, pose)
        yield path, explanations


def check_transforms(explanation: Explanation, robot: Robot, pose: str) -> None:
    positions = {p.name: p.positions for p in robot.poses}
    for placed in explanation.placed:
        rigid: Transform = robot.pose_in_root(explanation.name, positions.get(placed.pose, {}))
        assert placed.transform is not None
        assert placed.transform.xyz == pytest.approx(rigid.xyz, abs=1e-12)
        w, x, y, z = rigid.quaternion()
        assert placed.transform.quaternion_xyzw == pytest.approx((x, y, z, w), abs=1e-12)
    assert [placed.pose for placed in explanation.placed] == ([""] if not pose else ["", pose])


def numbers(explanation: Explanation) -> Iterator[Number]:
    for edge in explanation.chain:
        yield from edge.numbers
    yield from explanation.joint
    yield from explanation.inertial
    for shape in explanation.shapes:
        yield from shape.numbers


@pytest.mark.slow
def test_the_meanings_of_names_give_the_number() -> None:
    """Evaluate each expression anew, with nothing but the values that its names are said to have."""
    checked = 0
    for path, explanations in all_explanations():
        for n in (n for explanation in explanations for n in numbers(explanation)):
            found = n.origin and re.fullmatch(r"[\"']?\$\{(.*)\}[\"']?", n.origin.where.text)
            if not found or n.origin is None or n.origin.parts:
                continue
            expression, values = found[1], {}
            for index, meaning in enumerate(n.origin.names):
                expression = re.sub(rf"(?<![\w.]){re.escape(meaning.name)}(?!\w)", f"v_{index}", expression)
                values[f"v_{index}"] = plain_scalar(meaning.value)
            if any(str(value).startswith(("[", "a ")) for value in values.values()):
                continue  # a list or a table is shown in short
            assert abs(evaluate(expression, values.__getitem__)) == pytest.approx(abs(n.value)), (path, n)
            checked += 1
    assert checked > 100


@pytest.mark.slow
def test_every_number_of_every_robot_is_written_where_it_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    literal = expressions = 0
    for path, explanations in all_explanations():
        for explanation in explanations:
            for n in numbers(explanation):
                if n.origin is None:
                    assert n.note, (path, explanation.name, n)
                    continue
                assert n.origin.parts or n.origin.where.text, (path, explanation.name, n)
                if n.origin.parts:
                    continue
                where = n.origin.where
                if (ROOT / where.file).is_file():
                    line = (ROOT / where.file).read_text("utf-8").splitlines()[where.line - 1]
                    assert line[where.column - 1 :].startswith(where.text.removesuffix("...")[:20]), where
                if "${" in where.text:
                    expressions += 1
                    continue
                literal += 1
                said = plain_scalar(where.text)
                assert abs(float(said)) == pytest.approx(abs(n.value), rel=1e-15), (path, explanation.name, n)
    assert literal > 1000
    assert expressions > 100
