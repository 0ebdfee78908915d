"""Elements beside links and joints become words where those written again mean the same; nothing is lost or said twice.

``data/words/NAME.urdf`` are robots, ``NAME.yaml`` the sections that their words stand in, to the byte, and what was
said: ``python tests/importing/test_import_words.py`` writes those anew. What comes out is held against the source
by ``flat``, which knows nothing of how the tool compares.
"""

import copy
import random
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.formats.imported_robot import ImportedRobot
from rosorin_compile.formats.robot_files import read_robot
from rosorin_compile.importing.elements.convert import report_elements, with_sections
from rosorin_compile.importing.round_trip import check_round_trip
from support.paths import ROOT, data_text
from support.unrounded import compile_unrounded

CASES = ROOT / "tests" / "data" / "words"
ROBOTS = sorted(path.stem for path in CASES.glob("*.urdf"))
SECTIONS = ("modes", "publishers", "edges", "sensors", "drive", "control", "urdf_elements", "outputs")

Leaf = tuple[tuple[str, ...], str]


def imported(file: Path, folder: Path) -> tuple[list[str], str, str]:
    """Return what is said of a file, its description, and the URDF that is compiled of it, with all digits."""
    return described(read_robot(file), folder)


def described(read: ImportedRobot, folder: Path, *change: object) -> tuple[list[str], str, str]:
    made = with_sections(read)
    trip = check_round_trip(made.imported, folder, plain=made.plain)
    related = [one.message for diagnostic in trip.diagnostics for one in diagnostic.related]
    assert trip.diagnostics == [], (*change, trip.diagnostics, related)
    folder.mkdir(exist_ok=True)
    for name, text in trip.files.items():
        (folder / name).write_text(text, "utf-8")
    compiled = compile_unrounded(folder / "robot.yaml")
    urdf = next(one.text for one in compiled.artifacts if one.backend == "urdf")
    return report_elements(made), "".join(trip.files.values()), urdf


def said(file: Path, folder: Path) -> str:
    """Return what the case of a file has: the messages as comments, then the sections of words."""
    lines, text, _ = imported(file, folder)
    blocks = text.split("\n\n")
    kept, wanted = [], False
    for block in blocks:
        first = next((line for line in block.split("\n") if not line.startswith("#")), "")
        if first and not first.startswith(" "):
            wanted = first.partition(":")[0] in SECTIONS
        kept += [block] if wanted else []
    return "".join(f"# {line}\n" for line in lines) + "\n".join(kept).rstrip() + "\n"


@pytest.mark.parametrize("name", ROBOTS)
def test_words_are_those_that_are_committed(name: str, tmp_path: Path) -> None:
    assert said(CASES / f"{name}.urdf", tmp_path / "made") == (CASES / f"{name}.yaml").read_text("utf-8")


SDF = data_text("robots/import_words_sdf.sdf")


def test_sensors_of_an_sdf_come_out_in_both_formats(tmp_path: Path) -> None:
    file = tmp_path / "m.sdf"
    file.write_text(SDF, "utf-8")
    lines, text, urdf = imported(file, tmp_path / "made")
    assert lines[0].endswith("2 sensors (lidar, imu)")
    assert "sdf: {file: m.sdf, gazebo: harmonic}" in text
    made = {one.backend: one.text for one in compile_robot(tmp_path / "made" / "robot.yaml").artifacts}
    assert of_sensors(SDF) == of_sensors(urdf) == of_sensors(made["sdf"])


def of_sensors(artifact: str) -> Counter[Leaf]:
    found: Counter[Leaf] = Counter()
    for one in ElementTree.fromstring(artifact).iter("sensor"):
        for path, value in leaves(one, (), False):
            if value and not (len(path) == 2 and ALONE.get(path[-1]) == value) and ELSEWHERE.get(path[-2:]) != value:
                found[path, value] += 1
    assert found
    return found


# What comes out, held against the source without the tool's own comparison.

ALONE = {"always_on": "false", "visualize": "false", "update_rate": "0.0", "pose": " ".join(["0.0"] * 6)}
ELSEWHERE = {
    ("horizontal", "resolution"): "1.0",
    ("vertical", "resolution"): "1.0",
    ("range", "resolution"): "0.0",
    ("noise", "mean"): "0.0",
    ("camera", "horizontal_fov"): "1.047",
    ("image", "width"): "320.0",
    ("image", "height"): "240.0",
    ("clip", "near"): "0.1",
    ("clip", "far"): "100.0",
    ("imu", "enable_orientation"): "true",
}


def words(text: str) -> str:
    def one(word: str) -> str:
        try:
            return repr(round(float(word), 9) + 0.0)
        except ValueError:
            return word

    return " ".join(map(one, text.split()))


def leaves(element: ElementTree.Element, above: tuple[str, ...], exact: bool) -> Iterator[Leaf]:
    exact = exact or element.tag == "plugin"
    same = (lambda text: text.strip()) if exact else words
    mark = (
        element.get("name", "")
        if element.tag in ("joint", "sensor", "gpio", "transmission", "actuator", "param")
        else ""
    )
    here = (*above, f"{element.tag} {mark}".strip())
    for key, value in element.attrib.items():
        yield (*here, f"@{key}"), same(value)
    text = same(element.text or "")
    if len(element) == 0:
        yield here, {"1": "true", "1.0": "true"}.get(text, text) if element.tag == "always_on" else text
    for child in element:
        yield from leaves(child, here, exact)


def flat(urdf: str) -> Counter[Leaf]:
    """Return all that the elements beside links, joints and materials say, with what SDF takes by default left out."""
    found: Counter[Leaf] = Counter()
    root = ElementTree.fromstring(urdf)
    for block in root:
        if block.tag in ("link", "joint", "material"):
            continue
        if block.tag != "gazebo":
            found.update(leaves(block, (), False))
            continue
        for child in block:
            for path, text in leaves(child, ("gazebo", block.get("reference", "")), False):
                if len(path) == 4 and ALONE.get(path[-1]) == text and path[2].startswith("sensor"):
                    continue
                if (len(path) > 3 and ELSEWHERE.get(path[-2:]) == text) or (text == "" and path[-1][0] != "@"):
                    continue
                # A GPU lidar may be called either way.
                found[tuple("lidar" if step == "ray" and "gpu_lidar" in urdf else step for step in path), text] += 1
    return found


@pytest.mark.parametrize("name", ROBOTS)
def test_nothing_is_lost_said_twice_or_invented(name: str, tmp_path: Path) -> None:
    source = (CASES / f"{name}.urdf").read_text("utf-8")
    _, _, urdf = imported(CASES / f"{name}.urdf", tmp_path / "made")
    mine, theirs = flat(source), flat(urdf)
    if name == "control":  # Jazzy takes a follower for one, where nothing is said
        mine["ros2_control", "joint finger_right", "@mimic"] = 0
        theirs.pop((("ros2_control", "joint finger_right", "@mimic"), "true"), None)
    assert +(mine - theirs) == Counter()
    assert +(theirs - mine) == Counter()


@pytest.mark.parametrize(
    ("before", "after", "told"),
    [
        ("<update_rate>5</update_rate>", "<update_rate>6</update_rate>", "1 new"),
        ("<samples>360</samples>", "<samples>361</samples>", "1 new"),
        ('<param name="baud">115200</param>', '<param name="baud">9600</param>', "1 new"),
        ("publish_odom_tf>true", "publish_odom_tf>false", "1 new"),
        ('<sensor name="lds" type="ray">', '<sensor name="other" type="ray">', "1 new"),
        ("<always_on>true</always_on>", "<!-- always on -->", "1 new"),
        ("<visualize>false</visualize>", "", "the same robot"),
        ("<update_rate>5</update_rate>", "<update_rate>5.00</update_rate>", "the same robot"),
        ('<sensor name="sonar"', '</gazebo><gazebo reference="base_link"><sensor name="sonar"', "the same robot"),
    ],
)
def test_diff_sees_what_changed_in_the_source_since(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], before: str, after: str, told: str
) -> None:
    source = (CASES / "classic.urdf").read_text("utf-8")
    assert before in source
    imported(CASES / "classic.urdf", tmp_path / "made")
    file = tmp_path / "now.urdf"
    file.write_text(source.replace(before, after), "utf-8")
    same = main(["diff", str(tmp_path / "made"), str(file)]) == 0
    assert same == (told == "the same robot")
    assert told in capsys.readouterr().out


CHANGES, AT_A_LANDING = 60, 15  # of one robot


def changed(root: ElementTree.Element, chance: random.Random) -> str:
    """Change one thing in the elements of a robot, as a stranger might have written it; return what."""
    blocks = [block for block in root if block.tag in ("gazebo", "ros2_control") and len(block)]
    inner = [(above, child) for block in blocks for above in block.iter() for child in above if above is not block]
    above, element = chance.choice(inner)
    kind = chance.choice(("text", "attribute", "new element", "new attribute", "remove", "twice"))
    if kind == "text" and not len(element):
        element.text = chance.choice(("7", "0.125", "true", "false", "other", "1 2 3", "1e-3"))
    elif kind == "attribute" and element.attrib:
        element.set(chance.choice(sorted(element.attrib)), chance.choice(("x", "5", "other")))
    elif kind == "new element" and not (element.text or "").strip():
        ElementTree.SubElement(element, chance.choice(("extra", "topic", "noise"))).text = chance.choice(("1", "a"))
    elif kind == "new attribute":
        element.set("extra", "1")
    elif kind == "remove":
        above.remove(element)
    elif kind == "twice":
        above.append(copy.deepcopy(element))
    return f"{kind} of <{element.tag}>"


@pytest.mark.slow
@pytest.mark.landing("fuzz", str(AT_A_LANDING))
@pytest.mark.parametrize("changes", [AT_A_LANDING, CHANGES])
@pytest.mark.parametrize("name", ROBOTS)
def test_whatever_a_stranger_writes_comes_out_again(name: str, changes: int, tmp_path: Path) -> None:
    chance, tried = random.Random(name), 0  # noqa: S311 (the same changes in every run)
    for number in range(changes):
        root = ElementTree.parse(CASES / f"{name}.urdf").getroot()
        what = changed(root, chance)
        source = ElementTree.tostring(root, "unicode")
        file = tmp_path / "changed.urdf"
        file.write_text(source, "utf-8")
        read = read_robot(file)
        if read.tree is None:
            continue
        _, _, urdf = described(read, tmp_path / f"made{number}", number, what)
        mine, theirs = flat(source), flat(urdf)
        for one in (mine, theirs):
            for key in [key for key in one if key[0][-1] == "@mimic" and key[1] == "true"]:
                del one[key]
        assert (+(mine - theirs), +(theirs - mine)) == (Counter(), Counter()), (number, what)
        tried += 1
    assert tried > changes / 2


if __name__ == "__main__":
    import tempfile

    for robot in ROBOTS:
        with tempfile.TemporaryDirectory() as place:
            (CASES / f"{robot}.yaml").write_text(said(CASES / f"{robot}.urdf", Path(place, "made")), "utf-8")
    sys.exit()
