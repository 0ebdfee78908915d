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
