"""The example package examples/rosorin-battery, installed with pip: a section of the language from a plug-in."""

import os
import shutil
from pathlib import Path

import pytest

from support import forks
from support.pages import PACKAGES, install
from support.paths import ROOT

EXAMPLE = ROOT / "examples" / "rosorin-battery"
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("battery")
    shutil.copytree(EXAMPLE, folder / "rosorin-battery")
    assert install("./rosorin-battery", folder) == ("", 0)
    shutil.copy(EXAMPLE / "cart.yaml", folder / "cart.yaml")
    return folder


def run(project: Path, *words: str) -> tuple[int, str]:
    variables = {"PYTHONPATH": str(project / PACKAGES), "ROSORIN_COMPILE_CACHE": str(project / ".cache")}
    return forks.run(words, project, {**os.environ, **variables})


def changed(project: Path, old: str, new: str) -> str:
    text = (project / "cart.yaml").read_text("utf-8")
    assert text.count(old) == 1
    (project / "changed.yaml").write_text(text.replace(old, new), "utf-8")
    return "changed.yaml"


def test_the_mass_of_the_battery_is_in_the_artifacts(project: Path) -> None:
    code, printed = run(project, "print", "cart.yaml", "urdf")
    assert code == 0
    assert '<mass value="6"/>' in printed
    assert "battery main mass  2 kg" in run(project, "explain", "cart.yaml", "base", "mass")[1]


def test_a_change_is_a_difference_of_the_section(project: Path) -> None:
    code, printed = run(project, "diff", "cart.yaml", changed(project, "mass: 2 kg", "mass: 2500 g"))
    assert code == 1
    assert "battery main mass 2 -> 2.5" in printed
