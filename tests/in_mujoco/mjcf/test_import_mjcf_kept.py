"""What an imported MJCF keeps, in MuJoCo's own terms: the compiled models of source and result are compared."""

import shutil
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from support.paths import DATA

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.slow

KEPT = sorted((DATA / "mjcf" / "kept").glob("*.xml"))
WHOLE = DATA / "mjcf" / "whole"

GRIPPER = (DATA / "robots/gripper.xml").read_text("utf-8")
SHEET = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 1e-4\nf 1 2 3\nf 1 3 4\nf 1 5 2\nf 2 5 3\nf 3 5 4\nf 4 5 1\n"
CORNER = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"

MIXED = """<mujoco model="mixed">
  <worldbody>
    <body name="base"><freejoint name="free"/><geom name="g" type="box" size=".1 .1 .1"/><site name="imu" pos="0 0 .1"/></body>
  </worldbody>
  <sensor>
    <framequat name="orientation" objtype="site" objname="imu"/>
    <gyro name="gyro" site="imu"/>
    <framepos name="place" objtype="site" objname="imu"/>
    <accelerometer name="acceleration" site="imu"/>
  </sensor>
</mujoco>
"""  # noqa: E501


def test_a_gripper_is_the_same_to_mujoco(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Limits of force, settings, order of actuators, names of geoms, a stiff coupling, and a mesh that is a shell."""
    monkeypatch.chdir(tmp_path)
    Path("meshes").mkdir()
    Path("meshes/sheet.obj").write_text(SHEET, "utf-8")
    Path("meshes/corner.obj").write_text(CORNER, "utf-8")
    Path("gripper.xml").write_text(GRIPPER, "utf-8")
    assert main(["import", "gripper.xml", "--meshes", "../.."]) == 0
    assert "MuJoCo's model of the MJCF is that of the source, in every field" in "".join(capsys.readouterr())
    assert main(["all"]) == 0
    assert main(["check"]) == 0
    source, ours = map(mujoco.MjModel.from_xml_path, ("gripper.xml", "outputs/gripper/gripper.xml"))
    assert ours.body("palm").inertia.tolist() == pytest.approx(source.body("palm").inertia.tolist())
    assert [source.actuator(i).name for i in range(source.nu)] == [ours.actuator(i).name for i in range(ours.nu)]


def test_sensors_stay_in_their_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Sensors that become entries and those that stay elements are in the order of the file: sensor data is equal."""
    monkeypatch.chdir(tmp_path)
    Path("mixed.xml").write_text(MIXED, "utf-8")
    assert main(["import", "mixed.xml", "--strict"]) == 0
    assert main(["all"]) == 0
    assert main(["check"]) == 0
    source, ours = map(mujoco.MjModel.from_xml_path, ("mixed.xml", "outputs/mixed/mixed.xml"))
    assert [ours.sensor(i).name for i in range(ours.nsensor)] == [source.sensor(i).name for i in range(source.nsensor)]
    assert ours.sensor_adr.tolist() == source.sensor_adr.tolist()


@pytest.mark.parametrize("path", KEPT, ids=lambda path: path.stem)
def test_all_is_kept_and_moves_the_same(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """MuJoCo's model of what an import becomes is that of the source, field by field, and so is how it moves."""
    monkeypatch.chdir(tmp_path)
    assert main(["import", str(path), "--strict"]) == 0
    said = "".join(capsys.readouterr())
    assert "MuJoCo's model of the MJCF is that of the source" in said
    assert "largest difference" in said.partition("MuJoCo's model")[2]
    assert "import-untold" not in said
    assert main(["all"]) == 0
    assert main(["check"]) == 0


def test_keys_of_the_source_stand_before_the_home_of_ours(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Simulators begin at the first key."""
    monkeypatch.chdir(tmp_path)
    assert main(["import", str(DATA / "mjcf" / "kept" / "hovering.xml")]) == 0
    assert main(["all"]) == 0
    ours = mujoco.MjModel.from_xml_path("outputs/hovering/hovering.xml")
    assert [ours.key(index).name for index in range(ours.nkey)] == ["hover", "crouched", "home"]


@pytest.mark.parametrize("path", sorted(WHOLE.glob("*.xml")), ids=lambda path: path.stem)
def test_a_whole_model_in_the_manner_of_public_ones(path: Path, home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(WHOLE / "assets", home / "assets")
    shutil.copy(path, "whole.xml")
    assert main(["import", "whole.xml", "--strict", "--meshes", "../.."]) == 0
    said = "".join(capsys.readouterr())
    assert "MuJoCo's model of the MJCF is that of the source" in said
    assert "not carried over" not in said
    assert main(["all"]) == 0
    assert main(["check"]) == 0
