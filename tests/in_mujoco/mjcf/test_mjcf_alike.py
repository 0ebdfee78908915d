"""Of bodies that are alike in an MJCF, the one that is not is found."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from rosorin_compile.formats.expectation import Expectation

from rosorin_compile.compare.agreement import agreement
from rosorin_compile.mujoco.mjcf import facts
from rosorin_compile.output.pipeline import Compiled
from support.robots import CHAIN, compiled_text

EYE = "sensors: {eye: {type: camera, parent: s4, frame: eye}}\noutputs: {mjcf: {file: chain.xml}}\n"


@pytest.fixture
def chain(tmp_path: Path) -> Compiled:
    return compiled_text(tmp_path, CHAIN + EYE)


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
    found = agreement(chain.robot, [replace(chain.artifacts[0], text=text)])
    assert any(told in one.message for one in found), [one.message for one in found]


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
        facts.against(text.replace(old, new, 1), Expectation(chain.robot))
