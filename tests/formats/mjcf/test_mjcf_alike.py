"""What bodies of a large MJCF have alike is read once, and nothing that is said otherwise is passed over."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile.formats.known import Known
from rosorin_compile.formats.mjcf import facts
from rosorin_compile.meaning.agreement import agreement
from rosorin_compile.pipeline import Compiled, compile_robot
from rosorin_compile.xml.elements import tree_of
from support.paths import ROOT
from support.robots import CHAIN, compiled_text

EYE = "sensors: {eye: {type: camera, parent: s4, frame: eye}}\noutputs: {mjcf: {file: chain.xml}}\n"
ROBOTS = sorted({*ROOT.glob("*/*/robot.yaml"), *ROOT.glob("tests/data/*/robot.yaml")})


@pytest.fixture(autouse=True)
def _any_is_large(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(facts, "_LARGE", 0)


@pytest.fixture
def chain(tmp_path: Path) -> Compiled:
    return compiled_text(tmp_path, CHAIN + EYE)


def test_what_is_alike_stands_once(chain: Compiled) -> None:
    text = facts.folded(chain.artifacts[0].text)
    assert text.count("<inertial") == 1
    assert '<body name="s3" pos="0 0 0.2" alike="1" alike_joint="j3">' in text
    numbers = {body.get("name"): body.get("alike") for body in tree_of(text).iter("body")}
    assert [numbers[f"s{i}"] for i in range(6)] == ["1"] * 6
    assert (numbers["base"], numbers["eye"], numbers["eye_optical"]) == ("0", "0", None)  # the last has a camera


def _mjcfs() -> list[tuple[Compiled, str]]:
    made = [compile_robot(path) for path in ROBOTS]
    return [(one, artifact.text) for one in made for artifact in one.artifacts if artifact.backend == "mjcf"]


def test_all_that_is_said_is_read(chain: Compiled, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is not known of a robot is all that is told: so each one is held against the chain, too."""
    assert chain.robot is not None
    folds = 0
    for made, text in [(chain, chain.artifacts[0].text), *_mjcfs()]:
        folds += facts.folded(text) != text
        assert made.robot is not None
        for robot in (made.robot, chain.robot):
            folded = facts.against(text, Known(robot))
            with monkeypatch.context() as patched:
                patched.setattr(facts, "_LARGE", len(text) + 1)
                whole = facts.against(text, Known(robot))
            assert folded == whole
            assert list(folded.facts) == list(whole.facts)
    assert folds >= 5


@pytest.mark.parametrize(
    ("which", "old", "new", "told"),
    [
        (0, 'mass="2"', 'mass="3"', "s0 mass"),
        (3, 'mass="2"', 'mass="3"', "s3 mass"),
        (2, 'diaginertia="0.1 0.1 0.1', 'diaginertia="0.1 0.1 0.2', "s2 inertia"),
        (3, 'size="0.05 0.05 0.1"', 'size="0.05 0.05 0.2"', "s3 collision"),
        (5, 'size="0.1"', 'size="0.2"', "s5 collision"),
        (2, 'pos="0 0 0.2"', 'pos="0 0 0.3"', "s2 origin z"),
        (2, '<joint name="j', '<joint axis="1 0 0" name="j', "j2"),
        (3, '<body name="s', '<body name="t', "s3"),
    ],
)
def test_one_that_is_not_like_the_others_is_found(chain: Compiled, which: int, old: str, new: str, told: str) -> None:
    assert chain.robot is not None
    text = chain.artifacts[0].text
    place = -1
    for _ in range(which + 1):
        place = text.find(old, place + 1)
        assert place >= 0
    text = text[:place] + new + text[place + len(old) :]
    found = agreement(chain.robot, [chain.artifacts[0]._replace(text=text)])
    assert any(told in one.message for one in found), [one.message for one in found]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("    </body>\n", "    </body>\n    <!-- -->\n"),
        ("    </body>\n", "    </body>\n    <?a b?>\n"),
        ("    </body>\n", '    </body>\n    <geom size="1"/>\n'),
        ("</mujoco>", "<alike/>\n</mujoco>"),
        ("</mujoco>", '<contact><pair geom1="a" geom2="b"/></contact>\n</mujoco>'),
    ],
)
def test_what_might_hide_a_body_is_left_as_it_is(chain: Compiled, old: str, new: str) -> None:
    text = chain.artifacts[0].text.replace(old, new, 1)
    assert text != chain.artifacts[0].text
    assert facts.folded(text) == text


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("<inertial ", "<inertial a "),
        ("<joint name=", "</body><joint name="),
        ("</mujoco>", ""),
        ('rgba="', 'rgba="x '),
        ('mass="2"', 'mass="two"'),
    ],
)
def test_what_is_damaged_is_refused(chain: Compiled, old: str, new: str) -> None:
    assert chain.robot is not None
    text = chain.artifacts[0].text
    assert old in text
    with pytest.raises(ValueError, match=r"."):
        facts.against(text.replace(old, new, 1), Known(chain.robot))
