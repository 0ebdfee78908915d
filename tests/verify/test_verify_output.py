"""What verify prints and writes: JSON, JUnit, the picture, the bar; what it needs for that; words in a wrong order."""

import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path
from xml.etree import ElementTree

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.cli.console import plain
from rosorin_compile.cli.main import main
from rosorin_compile.model import Transform
from rosorin_compile.recordings.results import as_junit, table
from rosorin_compile.recordings.verification import as_svg
from rosorin_compile.source.diagnostics import text as report
from support import bags
from support.bags import START, TYPES, Message, judged
from support.paths import DATA, ROOT
from support.schemas import schema

pytestmark = pytest.mark.slow

ROBOT = str(ROOT / "descriptions" / "rosorin")


def test_json_junit_and_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag = bags.bag(tmp_path / "bag", seconds=20.0, slam=lambda seconds: not 5.0 < seconds < 15.3)
    junit, picture = tmp_path / "junit.xml", tmp_path / "picture.svg"
    command = ["verify", ROBOT, str(bag), "--junit", str(junit), "--picture", str(picture)]
    assert main([*command, "--format", "json"]) == 1
    document = json.loads(capsys.readouterr().out)["result"]
    described = schema("recording")
    jsonschema.Draft7Validator.check_schema(described)
    jsonschema.Draft7Validator(described).validate(document)
    assert document["as_described"] is False
    assert [finding["rule"] for finding in document["findings"]] == ["edge-stale"]
    assert document["findings"][0]["file"].endswith("publishers.yaml")
    suite = ElementTree.parse(junit).getroot()[0]
    failed = [case.get("name") for case in suite if case.find("failure") is not None]
    assert failed == ["map -> odom"]
    assert suite.get("failures") == "1"
    assert int(suite.get("tests", "0")) == len(suite)
    drawn = picture.read_bytes()
    root = ElementTree.fromstring(drawn)
    texts = [element.text for element in root.iter() if element.tag.endswith("text")]
    assert "map -> odom" in texts
    gaps = [element for element in root.iter() if element.get("class") == "gap"]
    assert len(gaps) == 1
    assert float(gaps[0].get("width", "0")) / 720 == pytest.approx(10.3 / 20.0, abs=0.02)
    assert main(command) == 1
    assert picture.read_bytes() == drawn
    capsys.readouterr()
    assert main(["verify", ROBOT, str(DATA / "recordings/frames.gv"), "--picture", str(picture)]) == 2
    assert main(["verify", ROBOT, str(bag), "--junit", str(tmp_path / "new" / "junit.xml")]) == 1
    assert (tmp_path / "new" / "junit.xml").read_bytes() == junit.read_bytes(), (
        "folders are made, as for each other file"
    )
    assert main(["verify", ROBOT, str(bag), "--junit", str(junit / "junit.xml")]) == 2


FRAMES = st.sampled_from(
    ["base_link", "laser", "link1", "link2", "odom", "map", "", "/", "x" * 300, "imu_link", "a->b"]
)
EXTREMES = st.sampled_from([0.0, -0.0, 1.0, -0.5, 1e-320, 1e160, -1e308, math.inf, -math.inf, math.nan])
TIMES = st.sampled_from([0, -1, 1, START, START + 10**9, 2**31 * bags.SECOND - 1, -(2**31) * bags.SECOND])
RECEIVED = st.one_of(st.integers(0, 2**62 - 1), st.integers(START, START + 10**10))


@settings(max_examples=40, deadline=None)
@given(st.data())
def test_any_content_is_judged_and_shown_without_a_traceback(data: st.DataObject) -> None:
    said = []
    for _ in range(data.draw(st.integers(1, 12))):
        received, stamp = data.draw(RECEIVED), data.draw(TIMES)
        kind = data.draw(st.sampled_from(["tf", "tf", "tf_static", "joint_states", "scan", "robot_description"]))
        numbers = data.draw(st.tuples(*[EXTREMES] * 7))
        if kind in ("tf", "tf_static"):
            transform = bags.transform_message(stamp, data.draw(FRAMES), data.draw(FRAMES), Transform(xyz=numbers[:3]))
            if data.draw(st.booleans()):
                transform.transform.rotation = TYPES["geometry_msgs/msg/Quaternion"](*numbers[3:])
            said.append(bags.tf(received, [transform], kind == "tf_static"))
        elif kind == "joint_states":
            names = data.draw(st.sampled_from([bags.ARM, ("joint1", "joint1"), (), ("r_joint", "x")]))
            state = bags.joint_state(stamp, names, list(numbers[: data.draw(st.integers(0, 7))]))
            said.append(Message(received, "/joint_states", "sensor_msgs/msg/JointState", state))
        elif kind == "scan":
            head = bags.header(stamp, data.draw(FRAMES))
            said.append(Message(received, "/scan", "sensor_msgs/msg/LaserScan", bags.scan(head)))
        else:
            text = TYPES["std_msgs/msg/String"](data.draw(st.sampled_from(["", "<robot/>", "\ud7ff", bags.urdf()])))
            said.append(Message(received, "/robot_description", "std_msgs/msg/String", text))
    with tempfile.TemporaryDirectory() as folder:
        bag = bags.write(Path(folder, "bag"), sorted(said, key=lambda message: message.received), "mcap")
        verdict = judged(bag)
    json.dumps(plain(verdict), allow_nan=False)
    ElementTree.fromstring(as_junit(verdict))
    if verdict.data.start is not None and verdict.data.series:
        ElementTree.fromstring(as_svg(verdict.data))
    assert "\n".join(table(verdict)).isprintable() or table(verdict)
    assert report(verdict.diagnostics) or not verdict.findings


@pytest.mark.landing("outside", "rosbags-bag-1-reading a recording needs the package rosbags, which is not installed")
@pytest.mark.slow
@pytest.mark.parametrize(
    ("absent", "source", "code", "message"),
    [
        ("numpy", "text", 2, "rosorin-compile verify needs numpy, and rosbags for recordings: pip install"),
        ("rosbags", "text", 0, ""),
        ("rosbags", "bag", 1, "reading a recording needs the package rosbags, which is not installed"),
    ],
)
def test_what_is_not_installed_is_said(
    clean: dict[str, Path], absent: str, source: str, code: int, message: str
) -> None:
    path = clean["mcap"] if source == "bag" else DATA / "recordings" / "frames.gv"
    hide = f"import sys; sys.modules[{absent!r}] = None; from rosorin_compile.cli.main import main"
    command = f"{hide}; sys.exit(main(['verify', {ROBOT!r}, {str(path)!r}]))"
    ran = subprocess.run([sys.executable, "-c", command], capture_output=True, text=True, check=False)
    assert ran.returncode == code, ran.stderr
    assert message in ran.stderr
    assert "Traceback" not in ran.stderr
