"""SDF is read: files with corners, broken ones with their messages, and what a description becomes and is read from."""

import random
import re
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.imported_robot import ImportedRobot, ReadOptions
from rosorin_compile.formats.robot_files import read_robot
from rosorin_compile.formats.templating import Templates
from rosorin_compile.language.lower import lower
from rosorin_compile.model import Output, Robot
from rosorin_compile.sdf.content import content_of
from rosorin_compile.source.diagnostics import ERROR, has_errors
from support.cases import as_xml_comment, check, read
from support.comparing import as_in_urdf, different
from support.importing import read_any
from support.machines import as_in_sdf, robot_of
from support.paths import DATA, ROOT, ROSORIN
from support.robots import compiled

SDF = DATA / "sdf"
CASES = sorted([*SDF.glob("bad/*.sdf"), *SDF.glob("told/*.sdf")])
FOLLOWERS = '<sdf version="{}"><model name="m">{}</model></sdf>'


def read_text(text: str, folder: Path, **options) -> ImportedRobot:
    path = folder / "robot.sdf"
    path.write_text(text, "utf-8")
    return read_robot(path, ReadOptions(environment={}, **options))


def robot_in(path: Path, **options) -> Robot:
    imported = read_robot(path, ReadOptions(environment={}, **options))
    assert imported.tree is not None, imported.diagnostics
    robot = lower(imported.tree).robot
    assert robot is not None
    return robot


def written(robot: Robot, **options) -> str:
    """Return the SDF of a robot, with all digits: what is lost on the way is no rounding."""
    options = {"number_format": "exact", **options}
    return FORMATS["sdf"].compile(robot, Output("sdf", "sdf", "robot.sdf", options), Templates())[0]


@pytest.mark.parametrize("case", CASES, ids=[f"{case.parent.name}-{case.stem}" for case in CASES])
def test_message(case, monkeypatch):
    monkeypatch.chdir(case.parent)
    imported = read(Path(case.name))
    found = as_xml_comment(imported.diagnostics, case.name)
    assert found
    check(case, found)
    assert (imported.tree is None) == has_errors(imported.diagnostics) == (case.parent.name == "bad")
    assert all(one.span and one.help for one in imported.diagnostics if one.severity == ERROR)


@pytest.mark.parametrize("seed", range(30))
def test_a_robot_comes_back_as_it_was(seed, tmp_path):
    robot = robot_of(random.Random(seed))  # noqa: S311 - a case, no secret
    path = tmp_path / "robot.sdf"
    path.write_text(written(robot), "utf-8")
    weightless = frozenset(content_of(robot).weightless)
    back = as_in_sdf(robot_in(path), weightless)
    assert different(as_in_sdf(robot, weightless), back, 0.0) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    "file", [ROSORIN, *sorted((ROOT / "examples").glob("*/robot.yaml"))], ids=lambda f: f.parent.name
)
def test_the_reference_robot_and_the_examples_come_back_as_they_were(file, tmp_path):
    """All that a URDF says of them comes back, sensors aside, which an SDF has in words of its own."""
    robot = compiled(file).robot
    assert robot is not None
    path = tmp_path / "robot.sdf"
    path.write_text(written(robot, gazebo=False), "utf-8")
    weightless = frozenset(content_of(robot).weightless)
    # Hardware and controllers are said in a URDF and beside it.
    plain = replace(robot, control=(), controllers=())
    sides = [as_in_sdf(one, weightless) for one in (plain, robot_in(path))]
    assert different(*as_in_urdf(*sides), 1e-12) == []


def test_a_difference_is_seen(tmp_path):
    """The comparison can say no."""
    robot = robot_of(random.Random(3))  # noqa: S311 - a case, no secret
    path = tmp_path / "robot.sdf"
    path.write_text(re.sub(r"<mass>(\d)", r"<mass>1\1", written(robot), count=1), "utf-8")
    assert different(as_in_sdf(robot), as_in_sdf(robot_in(path)), 0.0) != []


@pytest.mark.parametrize("path", sorted((SDF / "corners").glob("*.sdf")), ids=lambda path: path.stem)
def test_what_is_written_is_read_as_the_same(path, tmp_path):
    robot = robot_in(path)
    again = tmp_path / path.name
    again.write_text(written(robot), "utf-8")
    assert different(as_in_sdf(robot), as_in_sdf(robot_in(again)), 1e-12) == []


def test_a_model_that_is_included_is_that_model_within(tmp_path):
    """What an <include> brings is what stands there when the model is written into the file."""
    source = SDF / "included" / "include.sdf"
    part = re.search(r"<model name=.*</model>", (source.parent / "part/hand.sdf").read_text("utf-8"), re.DOTALL)
    assert part is not None
    text = source.read_text("utf-8")

    def inline(match: re.Match[str]) -> str:
        name = re.search(r"<name>(.*?)<", match[0])
        pose = re.search(r"<pose.*?</pose>", match[0])
        assert pose is not None
        assert name is not None
        body = part[0].replace('<model name="hand">', f'<model name="{name[1]}">{pose[0]}')
        return body.replace("meshes/palm", "part/meshes/palm")

    whole = tmp_path / "whole.sdf"
    whole.write_text(re.sub(r"<include>.*?</include>", inline, text, flags=re.DOTALL), "utf-8")
    robot = robot_in(source)
    assert different(robot, robot_in(whole), 0.0) == []
    assert [link.name for link in robot.links] == ["a", "left_palm", "left_tip", "right_palm", "right_tip"]
    assert robot.link["left_palm"].visual[0].geometry.file == "part/meshes/palm.stl"


def test_a_model_that_is_merged_keeps_its_names():
    robot = robot_in(SDF / "included" / "include-merged.sdf")
    assert [link.name for link in robot.links] == ["a", "palm", "tip"]


def test_what_is_included_has_one_budget_of_elements(tmp_path, monkeypatch):
    monkeypatch.setattr("rosorin_compile.sdf.models.MAX_ELEMENTS", 200)
    links = "".join(f'<link name="l{number}"/>' for number in range(48))
    (tmp_path / "part.sdf").write_text(FOLLOWERS.format("1.9", links), "utf-8")
    many = "".join(f"<include><uri>part.sdf</uri><name>p{number}</name></include>" for number in range(9))
    found = read_text(FOLLOWERS.format("1.9", f'<link name="a"/>{many}'), tmp_path)
    assert [one.rule for one in found.diagnostics if one.severity == ERROR] == ["include-too-many"]
    assert len(found.files) == 6


def test_comments_go_with_what_they_speak_of():
    imported = read_robot(SDF / "corners" / "kept.sdf", ReadOptions(environment={}))
    assert [comment.text for comment in imported.comments] == [" it stands "]


def test_an_inertial_may_be_computed(tmp_path):
    shape = '<collision name="c"><geometry><box><size>1 1 1</size></box></geometry></collision>'
    inertial = '<inertial auto="true"><density>300</density></inertial>'
    imported = read_text(FOLLOWERS.format("1.11", f'<link name="a">{inertial}{shape}</link>'), tmp_path)
    assert imported.tree is not None
    robot = lower(imported.tree).robot
    assert robot is not None
    assert robot.link["a"].inertial.mass == pytest.approx(300.0)
    assert robot.link["a"].inertial.ixx == pytest.approx(50.0)


def test_newer_words_are_written_in_their_version(tmp_path):
    for version, wanted in (("1.6", None), ("1.9", None), ("1.11", "1.11"), ("1.12", "1.12")):
        imported = read_text(FOLLOWERS.format(version, '<link name="a"/>'), tmp_path)
        assert imported.tree is not None
        assert imported.tree["outputs"]["sdf"].get("version") == wanted


# What holds for every SDF: no text makes its reader fail, and what it takes is written and read again as the same.


FOLDER = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
SEEDS = {path.stem: path.read_text("utf-8") for path in sorted((SDF / "corners").glob("*.sdf"))}


def sane(text: str, folder: Path, lenient: bool = False) -> ImportedRobot:
    imported = read_any(text, folder / "robot.sdf", lenient)
    if imported.tree is not None:
        robot = lower(imported.tree).robot
        assert robot is not None
        FORMATS["sdf"].compile(robot, Output("sdf", "sdf", "robot.sdf"), Templates())
    return imported


PIECES = st.sampled_from(
    [
        *("<", ">", "/>", '"', "&", "--", "<!--", "-->", "<![CDATA[", "]]>", "<?x?>", "\0", "\t", "\n", "é", "&#48;"),
        *("nan", "inf", "1e999", "1,5", "-1e16", "0", "-", "a", "b", "world", "__model__", "::", "hand::", "universal"),
        *("<link name='a'/>", "<frame name='x'/>", "<pose>1</pose>", "<joint", "</joint>", "</model>", "<axis/>"),
        *("<model name='n'>", "relative_to='b'", "attached_to='hand'", "<include><uri>x</uri></include>", "screw"),
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
    sane(text, tmp_path, lenient)


def swapped(text: str, chance: random.Random) -> str:
    """Return an SDF whose names of frames are shuffled: what is relative and attached to what is another."""
    names = sorted(set(re.findall(r'<(?:link|frame) name="(\w+)"', text)))
    words = re.compile(r'((?:relative_to|attached_to|expressed_in)="|<parent>|<child>)(\w+)')
    return words.sub(lambda one: one[1] + (chance.choice(names) if chance.random() < 0.3 else one[2]), text)


@pytest.mark.parametrize("seed", range(60))
def test_any_tree_of_frames_is_read_and_comes_back_or_is_refused(seed, tmp_path):
    chance = random.Random(seed)  # noqa: S311 - nothing secret
    seed_text = SEEDS[chance.choice(["frames", "anchors", "nested", "followers"])]
    imported = sane(swapped(seed_text, chance), tmp_path)
    if imported.tree is None:
        return
    robot = lower(imported.tree).robot
    assert robot is not None
    text = FORMATS["sdf"].compile(robot, Output("sdf", "sdf", "robot.sdf"), Templates())[0]
    again = sane(text, tmp_path)
    assert again.tree is not None, [one.message for one in again.diagnostics]
    back = lower(again.tree).robot
    assert back is not None
    assert different(as_in_sdf(robot), as_in_sdf(back), 1e-9) == []
