"""Round trip: a file, imported and compiled by the commands, is the same robot for engines that are not ours.

Every file of ``round_trip/`` covers a corner of the specification. Two engines say where each link is at random joint
states; a comparer of its own reads both texts and holds masses, limits, shapes, materials and kept elements together.
"""

import os
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings

from rosorin_compile.cli.main import main
from support.importing import robot
from support.paths import ROUND_TRIP
from support.round_trip import BOTH, comments, differences, judge, pinocchio, there_and_back

pytestmark = pytest.mark.slow

FOLDER = ROUND_TRIP
CASES = sorted(FOLDER.glob("*.urdf"))
# What an engine does not read, or reads wrongly; the other one and the comparer judge.
REFUSED = {
    "quaternions": "yourdfpy",  # knows no quat_xyzw
    "text_between": "pinocchio",  # no instruction <?...?> inside the root
    "white_space": "pinocchio",  # no tabs and line ends between numbers
}
BALL = '<geometry><sphere radius="1"/></geometry>'
RICH = ("comments", "all_joints", "materials", "extensions", "white_space")


@pytest.fixture(autouse=True)
def here(tmp_path: Path, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", str(tmp_path_factory.mktemp("cache")))
    return tmp_path


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.stem)
def test_corner_of_the_specification(case: Path) -> None:
    engines = tuple(engine for engine in BOTH if REFUSED.get(case.stem) != engine)
    judge(case.read_bytes(), there_and_back(case), engines)


def encoded(text: str) -> Iterator[tuple[str, bytes]]:
    body = re.sub(r"\A<\?xml[^>]*\?>\s*", "", text)
    yield "mark", b"\xef\xbb\xbf" + body.encode()
    yield "dos", body.replace("\n", "\r\n").encode()
    yield "mac", body.replace("\n", "\r").encode()
    yield "utf16", f'<?xml version="1.0" encoding="UTF-16"?>\n{body}'.encode("utf-16")
    yield "latin1", f'<?xml version="1.0" encoding="ISO-8859-1"?>\n<!-- Größe -->\n{body}'.encode("latin-1", "ignore")


@pytest.mark.parametrize("form", ["mark", "dos", "mac", "utf16", "latin1"])
@pytest.mark.parametrize("name", RICH)
def test_encodings_and_line_ends(name: str, form: str) -> None:
    data = dict(encoded((FOLDER / f"{name}.urdf").read_text("utf-8")))[form]
    Path("robot.urdf").write_bytes(data)
    judge(data, there_and_back(Path("robot.urdf")), engines=())


def chain(count: int) -> str:
    links = "".join(f'<link name="l{i}"/>' for i in range(count))
    joints = "".join(
        f'<joint name="j{i}" type="{("continuous", "fixed")[i % 2]}"><parent link="l{i}"/><child link="l{i + 1}"/>'
        f'<origin xyz="0.01 {i / 1000} 0" rpy="0.0{i} 0 .1"/><axis xyz="0 {i % 2} 1"/></joint>'
        for i in range(count - 1)
    )
    return f'<robot name="chain">{joints}{links}</robot>'


def star(count: int) -> str:
    links = "".join(f'<link name="l{i}"/>' for i in range(count))
    joints = "".join(
        f'<joint name="j{i}" type="prismatic"><parent link="hub"/><child link="l{i}"/><origin rpy="0 0 {i / 7}"/>'
        '<limit lower="0" upper="1" effort="1" velocity="1"/></joint>'
        for i in range(count)
    )
    return f'<robot name="star"><link name="hub"/>{links}{joints}</robot>'


@pytest.mark.landing("fuzz", "100 children")
@pytest.mark.parametrize("text", [chain(300), star(100)], ids=["chain of 300", "100 children"])
def test_large_robots(text: str) -> None:
    Path("robot.urdf").write_text(text, "utf-8")
    # yourdfpy multiplies a chain in the best of all orders, and looks for that order for minutes
    judge(text.encode(), there_and_back(Path("robot.urdf")), engines=("pinocchio",))


def test_xacro_with_arguments() -> None:
    xacro = pytest.importorskip("xacro")
    case = FOLDER / "args.xacro"
    given = {"reach": "0.25", "prefix": "left_"}
    result = there_and_back(case, *(f"{name}:={value}" for name, value in given.items()))
    expanded = xacro.process_file(str(case), mappings=given)
    assert '<link name="left_upper">' in expanded.toxml()
    for node in list(expanded.childNodes):  # the banner that says that the file was made by xacro
        if node.nodeType == node.COMMENT_NODE:
            expanded.removeChild(node)
    judge(expanded.toxml("utf-8"), result)


@settings(deadline=None, max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(robot())
def test_any_robot(text: str) -> None:
    for folder in ("made", "outputs"):
        shutil.rmtree(folder, ignore_errors=True)
    Path("robot.urdf").write_text(text, "utf-8")
    judge(text.encode(), there_and_back(Path("robot.urdf")), engines=())


@pytest.mark.parametrize("name", [b"bad\xff.urdf", b"new\nline.urdf", b"a--b.urdf", b"<&\">'${x}.urdf"])
def test_file_of_any_name(name: bytes) -> None:
    source = Path(os.fsdecode(name))
    shutil.copy(FOLDER / "single_link.urdf", source)
    judge(source.read_bytes(), there_and_back(source))


def test_comments_take_no_time() -> None:
    """Check a file whose comments once took a time that doubled with each of them."""
    comments = "".join(f"<!-- {number} -->\n" for number in range(3000))
    data = f'{comments}<robot name="r"><link name="a"/>{comments}</robot>'.encode()
    Path("robot.urdf").write_bytes(data)
    judge(data, there_and_back(Path("robot.urdf")))


def test_long_numbers_take_no_time(capsys: pytest.CaptureFixture[str]) -> None:
    """Check words whose digits once were shared out among the parts of a number in all ways."""
    text = f'<robot name="r"><link name="a"><visual><origin xyz="{"1" * 200_000}x 0 0"/>{BALL}</visual></link></robot>'
    Path("robot.urdf").write_text(text, "utf-8")
    assert main(["import", "robot.urdf", "-o", "made"]) == 1
    assert "is not a number" in capsys.readouterr().err


def test_the_comparer_sees_differences() -> None:
    """Check the judges: each change of one word of a source is seen."""
    text = (FOLDER / "all_joints.urdf").read_text("utf-8") + "\n<!-- end -->"
    seen = 0
    for found in re.finditer(r'(?<=[" ])-?\d*\.?\d+(?=[" ])', text):
        changed = f"{text[: found.start()]}{float(found[0]) + 0.5}{text[found.end() :]}"
        line = text[: found.start()].rsplit("\n", 1)[-1]
        said = differences(text.encode(), changed.encode())
        assert said or "version=" in line, changed
        seen += bool(said)
    assert seen >= 40
    assert comments(text.encode()) == ["end"]
    assert pinocchio(text, text.replace('xyz="0 0 .1"', 'xyz="0 0 .1000001"', 1))[0]


def test_what_xacro_has_made_is_no_xacro(capsys: pytest.CaptureFixture[str]) -> None:
    there_and_back(FOLDER / "made_by_xacro.urdf")
    said = capsys.readouterr().err
    assert "xacro-runs-code" not in said
    assert "banner" not in said
    text = Path("made", "robot.yaml").read_text("utf-8")
    assert text.startswith("# Copyright: somebody\nrosorin_compile: 1\n")
    assert "\n      # the hull\n      - {box: {size: [1, 1, 1]}, xyz: [0, 0, 0.1]}\n" in text
