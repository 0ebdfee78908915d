"""Of links and joints that are alike in a URDF, the one that is not is found."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from rosorin_compile.formats.expectation import Expectation

from rosorin_compile.compare.agreement import agreement
from rosorin_compile.formats.urdf import facts
from rosorin_compile.output.pipeline import Compiled
from support.robots import CHAIN, compiled_text


@pytest.fixture
def chain(tmp_path: Path) -> Compiled:
    return compiled_text(tmp_path, f"{CHAIN}outputs: {{urdf: {{file: chain.urdf}}}}\n")


@pytest.mark.parametrize(
    ("which", "old", "new", "told"),
    [
        (0, '<mass value="2"/>', '<mass value="3"/>', "s0 mass"),
        (3, '<mass value="2"/>', '<mass value="3"/>', "s3 mass"),
        (3, '<box size="0.1 0.1 0.2"/>', '<box size="0.1 0.1 0.3"/>', "s3 collision"),
        (4, '<sphere radius="0.1"/>', '<box size="1 1 1"/>', "s4 collision"),
        (3, '<origin xyz="0 0 0.2"', '<origin xyz="0 0 0.3"', "s3 origin z"),
        (5, '<axis xyz="0 1 0"/>', '<axis xyz="0 0 1"/>', "j5 axis"),
        (2, 'upper="1"', 'upper="2"', "j2 limit upper"),
        (2, '<parent link="s1"/>', '<parent link="s0"/>', "s2 parent"),
        (2, '<child link="s2"/>', '<child link="base"/>', "s2"),
    ],
)
def test_one_that_is_not_like_the_others_is_found(chain: Compiled, which: int, old: str, new: str, told: str) -> None:
    assert chain.robot is not None
    pieces = chain.artifacts[0].text.split(old)
    assert len(pieces) in (2, 7)
    place = which + 1 if len(pieces) == 7 else 1
    text = old.join(pieces[:place]) + new + old.join(pieces[place:])
    found = agreement(chain.robot, [replace(chain.artifacts[0], text=text)])
    assert any(told in one.message for one in found), [one.message for one in found]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("    </inertial>\n", "    \n"),
        ("    <inertial>\n", "    <inertial></link>\n"),
        ("    <inertial>\n", "    <inertial a>\n"),
        ("</robot>", ""),
    ],
)
def test_what_is_not_well_formed_is_refused(chain: Compiled, old: str, new: str) -> None:
    assert chain.robot is not None
    with pytest.raises(ValueError, match="line"):
        facts.against(chain.artifacts[0].text.replace(old, new, 1), Expectation(chain.robot))
