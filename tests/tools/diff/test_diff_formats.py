"""Diff across formats: our artifacts are the robot that they were made of; what they cannot say is no difference."""

from __future__ import annotations

import re
from pathlib import Path

import jsonschema
import pytest
import yaml

from rosorin_compile.formats.compilation import compile_robot
from support.comparing import DIFF, changed, compared, told
from support.paths import ROOT, ROSORIN, data_text
from support.schemas import schema

OUTPUTS = ROOT / "outputs" / "rosorin"
CASES = yaml.safe_load(data_text("cases/diff_formats.yaml"))


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of the artifacts of the arm, in full digits."""
    folder = tmp_path_factory.mktemp("arm")
    for artifact in compile_robot(DIFF / "arm.yaml").artifacts:
        (folder / artifact.file).write_text(artifact.text, "utf-8")
    return folder


@pytest.mark.landing("fuzz", "rosorin.xml")
@pytest.mark.slow
@pytest.mark.parametrize("file", ["rosorin.urdf", "rosorin_sim.urdf", "rosorin.xml", "robot_model.json"])
def test_the_artifacts_of_the_reference_robot_are_that_robot(file: str) -> None:
    found = compared(ROSORIN, OUTPUTS / file)
    assert found["differences"] == []
    assert found["not_compared"]
    jsonschema.validate(found, schema("robot_diff"))
    assert compared(OUTPUTS / file, ROSORIN)["differences"] == []


@pytest.mark.parametrize("file", CASES["silent"])
def test_the_artifacts_of_the_arm_are_the_arm(arm: Path, file: str) -> None:
    for one, other in ((DIFF / "arm.yaml", arm / file), (arm / file, DIFF / "arm.yaml")):
        expected = [line.format(arm=DIFF / "arm.yaml", file=arm / file) for line in CASES["silent"][file]]
        found = compared(one, other)
        assert found["differences"] == []
        assert found["not_compared"] == expected


@pytest.mark.parametrize(
    ("one", "other", "said"),
    [
        ("arm.urdf", "arm.xml", ["new: link laser (fixed on mast, laser_joint)"]),
        ("arm.xml", "arm.json", []),
        ("arm.urdf", "arm.json", ["new: frame laser (fixed on mast, laser_joint)"]),
    ],
)
def test_the_artifacts_of_the_arm_are_one_robot(arm: Path, one: str, other: str, said: list[str]) -> None:
    """But for the laser, which another node publishes than that of the URDF."""
    assert told(arm / one, arm / other) == said
    assert told(arm / other, arm / one) == [line.replace("new:", "removed:") for line in said]


@pytest.mark.parametrize("case", CASES["carried"], ids=lambda case: case["line"])
def test_a_change_is_told_of_every_artifact_that_carries_it(arm: Path, tmp_path: Path, case: dict[str, str]) -> None:
    path = changed(tmp_path, (case["old"], case["new"]))
    for suffix in ("urdf", "xml", "json"):
        # The artifacts of the arm as it was, against the description as it is.
        found = told(arm / f"arm.{suffix}", path)
        if suffix in case["files"].split():
            assert len(found) == 1, (suffix, found)
            assert found[0].startswith(case["line"]) or (suffix == "urdf" and "mast collision" in found[0]), (
                suffix,
                found,
            )
        else:
            assert found == [], suffix


@pytest.mark.parametrize("suffix", ["urdf", "xml"])
def test_reordered_elements_and_another_file_name_are_no_difference(arm: Path, tmp_path: Path, suffix: str) -> None:
    text = (arm / f"arm.{suffix}").read_text("utf-8")
    other = re.sub(r"[ \t]*\n[ \t]*", " ", text) if suffix == "xml" else _shuffled(text)
    assert other != text
    path = tmp_path / f"renamed.{suffix}"
    path.write_text(other, "utf-8")
    assert told(arm / f"arm.{suffix}", path) == []


def _shuffled(urdf: str) -> str:
    """Return a URDF with its links and joints the other way round."""
    from xml.etree import ElementTree

    root = ElementTree.fromstring(urdf)
    root[:] = list(reversed(root))
    return ElementTree.tostring(root, "unicode")


def test_a_file_of_mujoco_with_its_digits_is_the_same(arm: Path, tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    spec = mujoco.MjSpec.from_file(str(arm / "arm.xml"))
    spec.compile()
    path = tmp_path / "saved.xml"
    path.write_text(spec.to_xml(), "utf-8")
    assert told(arm / "arm.xml", path) == []
    assert told(DIFF / "arm.yaml", path) == []


def test_a_prefix_is_seen_through_found_or_said(arm: Path, tmp_path: Path) -> None:
    text = (arm / "arm.urdf").read_text("utf-8")
    text = re.sub(r'(<(?:link|joint|parent|child|mimic)[^>]*?(?:name|link|joint)=")', r"\1left_", text)
    path = tmp_path / "left.urdf"
    path.write_text(text, "utf-8")
    found = compared(arm / "arm.urdf", path)
    assert found["same"]
    assert found["notes"] == ['the names of B begin with "left_"']
    assert compared(arm / "arm.urdf", path, "--prefix", "left_")["same"]
    refused = compared(arm / "arm.urdf", path, "--prefix", "")
    assert {item["quantity"] for item in refused["differences"]} == {"name"}
