"""What holds for every SDF: no text makes its reader fail, and what it takes is written and read again as the same."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.imported import Imported, ReadOptions
from rosorin_compile.formats.reading import read_robot
from rosorin_compile.formats.templating import Templates
from rosorin_compile.language.lower import lower
from rosorin_compile.model import Output
from rosorin_compile.source.diagnostics import ERROR, Diagnostic, has_errors
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.report import text as report
from rosorin_compile.source.tree import locate
from support.comparing import different
from support.machines import as_in_sdf
from support.paths import DATA

SDF = DATA / "sdf"
FOLDER = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
SEEDS = {path.stem: path.read_text("utf-8") for path in sorted((SDF / "corners").glob("*.sdf"))}


def read(text: str | bytes, folder: Path, lenient: bool = False) -> Imported:
    path = folder / "robot.sdf"
    path.write_bytes(text.encode("utf-8", "surrogatepass") if isinstance(text, str) else text)
    return read_robot(path, ReadOptions(lenient=lenient, environment={}))


def sane(imported: Imported) -> None:
    """Check what holds for everything that is read: a tree or an error, and places that exist."""
    assert (imported.tree is None) == has_errors(imported.diagnostics)
    report(arrange(imported.diagnostics))
    for diagnostic in imported.diagnostics:
        check_place(diagnostic)
    for comment in imported.comments:
        assert imported.tree is not None
        locate(imported.tree, comment.path)
    if imported.tree is not None:
        robot = lower(imported.tree).robot
        assert robot is not None
        FORMATS["sdf"].written(robot, Output("sdf", "sdf", "robot.sdf"), Templates())


def check_place(diagnostic: Diagnostic) -> None:
    assert diagnostic.severity != ERROR or diagnostic.span is not None or diagnostic.rule in ("file-empty", "not-text")
    if diagnostic.span is not None:
        line = diagnostic.span.source.line(diagnostic.span.line)
        assert 1 <= diagnostic.span.column <= len(line) + 1, diagnostic


PIECES = st.sampled_from(
    [
        *("<", ">", "/>", '"', "&", "--", "<!--", "-->", "<![CDATA[", "]]>", "<?x?>", "\0", "\t", "\n", "é", "&#48;"),
        *("nan", "inf", "1e999", "1,5", "-1e16", "0", "-", "a", "b", "world", "__model__", "::", "hand::", "universal"),
        *(
            "<link name='a'/>",
            "<frame name='x'/>",
            "<pose>1</pose>",
            "<joint",
            "</joint>",
            "</model>",
            "<model name='n'>",
        ),
        *(
            "relative_to='b'",
            "attached_to='hand'",
            "<include><uri>x</uri></include>",
            "screw",
            "ball",
            "fixed",
            "<axis/>",
        ),
        *("<parent>b</parent>", "<child>a</child>", "<inertial/>", "<mimic joint='j'/>", "1.4", "1.13", "quat_xyzw"),
    ]
)


@FOLDER
@given(
    st.sampled_from(sorted(SEEDS)),
    st.lists(st.tuples(st.floats(0, 1), st.integers(0, 12), PIECES), min_size=1, max_size=4),
    st.booleans(),
)
def test_any_edit_is_read_or_refused_in_words(tmp_path, seed, edits, lenient):
    text = SEEDS[seed]
    for where, gone, piece in edits:
        at = int(where * len(text))
        text = text[:at] + piece + text[at + gone :]
    sane(read(text, tmp_path, lenient))


@pytest.mark.slow
@pytest.mark.parametrize("case", sorted(SDF.glob("*/*.sdf")), ids=lambda case: f"{case.parent.name}-{case.stem}")
def test_files_broken_further(case, tmp_path):
    chance = random.Random(case.name)  # noqa: S311 - nothing secret
    text = re.sub(r"\A<!--.*?-->\n", "", case.read_text("utf-8"), flags=re.DOTALL)
    words = re.findall(r"[\w.]+|[^\w.]", text)
    for _ in range(12):
        some = list(words)
        at = chance.randrange(len(some))
        some[at : at + chance.randrange(3)] = chance.choices(words, k=chance.randrange(3))
        sane(read("".join(some), tmp_path, lenient=chance.random() < 0.5))


def swapped(text: str, chance: random.Random) -> str:
    """Return an SDF whose names of frames are shuffled: what is relative and attached to what is another."""
    names = sorted(set(re.findall(r'<(?:link|frame) name="(\w+)"', text)))
    words = re.compile(r'((?:relative_to|attached_to|expressed_in)="|<parent>|<child>)(\w+)')
    return words.sub(lambda one: one[1] + (chance.choice(names) if chance.random() < 0.3 else one[2]), text)


@pytest.mark.parametrize("seed", range(60))
def test_any_tree_of_frames_is_read_and_comes_back_or_is_refused(seed, tmp_path):
    chance = random.Random(seed)  # noqa: S311 - nothing secret
    imported = read(swapped(SEEDS[chance.choice(["frames", "anchors", "nested", "followers"])], chance), tmp_path)
    sane(imported)
    if imported.tree is None:
        return
    robot = lower(imported.tree).robot
    assert robot is not None
    text = FORMATS["sdf"].written(robot, Output("sdf", "sdf", "robot.sdf"), Templates())[0]
    again = read(text, tmp_path)
    assert again.tree is not None, [one.message for one in again.diagnostics]
    back = lower(again.tree).robot
    assert back is not None
    assert different(as_in_sdf(robot), as_in_sdf(back), 1e-9, carried_by_urdf=False) == []
