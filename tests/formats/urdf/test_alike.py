"""What links and joints of a large URDF have alike is read once, and nothing that is said otherwise is passed over."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile.formats.known import Known
from rosorin_compile.formats.urdf import facts
from rosorin_compile.meaning.agreement import agreement
from rosorin_compile.pipeline import Compiled
from rosorin_compile.xml.elements import tree_of
from support.machines import exact_urdf, machine
from support.robots import CHAIN, compiled_text


@pytest.fixture(autouse=True)
def _any_is_large(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(facts, "_LARGE", 0)


@pytest.fixture
def chain(tmp_path: Path) -> Compiled:
    return compiled_text(tmp_path, f"{CHAIN}outputs: {{urdf: {{file: chain.urdf}}}}\n")


def test_what_is_alike_stands_once(chain: Compiled) -> None:
    text = facts.folded(chain.artifacts[0].text)
    assert text.count("<inertial>") == 1
    assert text.count("<axis") == 1
    assert '<link name="s3" alike="0"></link>' in text
    assert '<joint name="j3" type="revolute" alike="1">    <parent link="s2"/><child link="s3"/></joint>' in text
    assert len(tree_of(text)) == 2 + 1 + 6 + 6


def test_all_that_is_said_is_read(chain: Compiled, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is not known of the robot is all that is told: so every robot is held against another one."""
    assert chain.robot is not None
    robots = [(chain.robot, chain.artifacts[0].text), (machine(), exact_urdf(machine()))]
    for known, text in ((Known(robot), text) for robot, _ in robots for _, text in robots):
        folded = facts.against(text, known)
        assert facts.folded(text) != text
        with monkeypatch.context() as patched:
            patched.setattr(facts, "_LARGE", len(text) + 1)
            assert facts.against(text, known) == folded


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
    found = agreement(chain.robot, [chain.artifacts[0]._replace(text=text)])
    assert any(told in one.message for one in found), [one.message for one in found]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("  </link>\n", "  </link>\n  <!-- -->\n"),
        ("  </link>\n", "  </link>\n  <?a b?>\n"),
        ("</robot>", "<alike/>\n</robot>"),
    ],
)
def test_what_might_hide_a_link_is_left_as_it_is(chain: Compiled, old: str, new: str) -> None:
    text = chain.artifacts[0].text.replace(old, new, 1)
    assert facts.folded(text) == text


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
        facts.against(chain.artifacts[0].text.replace(old, new, 1), Known(chain.robot))
