"""Questions about robots in other formats (URDF, xacro, SDF, MJCF, JSON), and about planar and floating joints."""

import json
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from support import bags
from support.bags import judged
from support.commands import Shown, ask
from support.paths import ROOT
from support.robots import compiled, texts

pytestmark = pytest.mark.slow


@pytest.fixture
def artifacts(tmp_path: Path) -> Path:
    for name, text in texts(compiled()).items():
        (tmp_path / name).write_text(text, "utf-8")
    return tmp_path


@pytest.mark.parametrize("name", ["rosorin.urdf", "rosorin.xml", "robot_model.json"])
def test_tf_of_every_format(artifacts: Path, capsys: Shown, name: str) -> None:
    """Of each format the same answer as of the description that it was compiled from; MJCF in millionths."""
    words = ["base_link", "end_effector_link", "--joint", "joint2=30deg", "--joint", "joint3=-0.4"]
    words += ["--format", "json"]
    own = json.loads(ask(capsys, "tf", str(ROOT / "descriptions" / "rosorin"), *words))["result"]
    other = json.loads(ask(capsys, "tf", str(artifacts / name), *words))["result"]
    assert other["translation"] == pytest.approx(own["translation"], abs=1e-6)
    assert other["rpy"] == pytest.approx(own["rpy"], abs=1e-5)


def test_verify_against_a_urdf(artifacts: Path, tmp_path: Path, capsys: Shown) -> None:
    """The URDF says nothing of what other nodes publish: their edges are no errors, and all others are compared."""
    bag = bags.bag(tmp_path / "bag")
    assert main(["verify", str(artifacts / "rosorin.urdf"), str(bag)]) == 0
    shown = capsys.readouterr()
    assert "link4 -> link5                        robot_state_publisher  /tf         120" in shown.out
    assert shown.out.rstrip().splitlines()[-1].startswith("rosorin: as described, 1 warning (")
    assert "robot-description" not in shown.err
    other = bags.bag(tmp_path / "other", joint_offset={"joint1": 5.0})
    assert main(["verify", str(artifacts / "rosorin.urdf"), str(other)]) == 0
    assert "joint1 is beyond its limits" in capsys.readouterr().err
    assert not judged(bag).findings
