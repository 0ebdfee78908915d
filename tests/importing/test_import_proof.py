"""An imported MJCF is held against what its description becomes, in MuJoCo, and the command says how that went."""

from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.mujoco.mjcf import process
from rosorin_compile.mujoco.mjcf.write import write
from support.paths import data_text

pytest.importorskip("mujoco", minversion="3.12")
pytestmark = pytest.mark.slow

ROBOT = data_text("robots/import_proof.mjcf.xml")
TIP = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
HOLDS = "MuJoCo's model of the MJCF is that of the source, in every field but its appearance; frames and"


@pytest.fixture(autouse=True)
def _robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("meshes").mkdir()
    Path("meshes/tip.obj").write_text(TIP, "utf-8")
    Path("arm.xml").write_text(ROBOT, "utf-8")


@pytest.mark.parametrize("words", [(), ("--meshes", "../.."), ("--meshes", "package://arm"), ("--name", "other")])
def test_what_is_the_same_is_said(words: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", "arm.xml", *words]) == 0
    said = capsys.readouterr()
    assert HOLDS in said.out + said.err
    assert "import-untold" not in said.err


def test_what_nobody_said_is_told(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """A fault of ours: the damping of joints is forgotten on the way."""
    _forget(monkeypatch, 'damping="0.5"')
    assert main(["import", "arm.xml"]) == 1
    said = "".join(capsys.readouterr())
    assert (
        "error[import-untold]: 1 thing comes out otherwise than in the source, and nothing above says so: joint"
        " damping\n"
        "    please report it with the file; --lenient writes it all the same\n"
        "      joint turn: damping 0.5 in the source, 0 in ours\n"
    ) in said
    assert "MuJoCo's model of the MJCF" not in said
    assert "arm.xml: 1 error, nothing written" in said
    assert not Path("descriptions").exists()


@pytest.mark.parametrize(("words", "code"), [((), 0), (("--strict",), 1)])
def test_lenient_writes_it_all_the_same(
    words: tuple[str, ...], code: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _forget(monkeypatch, 'damping="0.5"')
    assert main(["import", "arm.xml", "--lenient", *words]) == code
    said = "".join(capsys.readouterr())
    assert ("warning[import-untold]: 1 thing" in said) == (code == 0)
    assert Path("descriptions").exists() == (code == 0)


def test_a_motion_that_differs_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """What no field shows would be a fault of the comparison; here the accelerations differ by themselves."""
    differences = [("motion", "", "frames or accelerations differ by 0.1 (joint arm)")]
    imported = _imported()
    monkeypatch.setattr(process, "_in_child", lambda *_: {"differences": differences})
    assert process.prove(imported, "", {}).wrong == {"motion": ["frames or accelerations differ by 0.1 (joint arm)"]}


def test_a_crash_of_mujoco_is_no_fault_of_the_robot(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    crash = f"import os, sys; sys.argv[2] != 'prove' or os.abort(); {process._START}"
    monkeypatch.setattr(process, "_START", crash)
    assert main(["import", "arm.xml"]) == 0
    said = "".join(capsys.readouterr())
    assert "not compared with the source in its engine: MuJoCo crashed on the file (signal 6)" in said


@pytest.mark.parametrize("child", ["import time; time.sleep(60)", "{}while True: pass"])
def test_a_proof_has_an_end(child: str, monkeypatch: pytest.MonkeyPatch) -> None:
    limited = (
        "import sys; sys.path[:0] = [sys.argv[1]]\nfrom rosorin_compile.mujoco.mjcf import engine\nengine._limit(1)\n"
    )
    imported = _imported()
    monkeypatch.setattr(process, "_START", child.format(limited))
    monkeypatch.setattr(process, "_PATIENCE", 1 if "sleep" in child else 600)
    said = process.prove(imported, "", {}, seconds=1).unknown
    assert said == "MuJoCo did not come to an end with the file in 1 s"


def _forget(monkeypatch: pytest.MonkeyPatch, words: str) -> None:
    def forgetful(*given: Any) -> Any:
        text, told = write(*given)
        assert f" {words}" in text
        return text.replace(f" {words}", ""), told

    monkeypatch.setattr("rosorin_compile.mujoco.mjcf.write.write", forgetful)


def _imported() -> Any:
    from rosorin_compile.formats.imported_robot import ReadOptions
    from rosorin_compile.mujoco.mjcf.robot import read_mjcf

    return read_mjcf(Path("arm.xml"), ReadOptions())
