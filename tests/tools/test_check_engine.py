"""check asks MuJoCo whether it loads each MJCF: what it refuses is an error at the place that it comes from."""

import sys
from pathlib import Path
from types import ModuleType

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.mujoco.mjcf import process
from support.commands import Shown, edit, write_files
from support.paths import data_text

pytest.importorskip("mujoco", minversion="3.12")

ROBOT = data_text("robots/check_engine.yaml")
OBJ = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
PROJECT = {"descriptions/cart/robot.yaml": ROBOT, "descriptions/cart/cover.obj": OBJ}


def said(capsys: Shown, code: int) -> list[str]:
    capsys.readouterr()
    assert main(["check"]) == code
    return [line for line in capsys.readouterr().err.splitlines() if "engine-refuses" in line]


def test_a_refusal_that_names_no_mesh_stands_at_the_output(
    project: Path, capsys: Shown, monkeypatch: pytest.MonkeyPatch
) -> None:
    edit(project / "descriptions/cart/robot.yaml", "      - mesh: {file: cover.obj}\n", "")
    assert main(["all"]) == 0
    engine = sys.modules["rosorin_compile.mujoco.mjcf.engine"]
    monkeypatch.setattr(engine, "load", lambda *_: ("Error: no room, is too old for it\nline 3", False))
    assert said(capsys, 1) == [
        "descriptions/cart/robot.yaml:7:11: error[engine-refuses]: MuJoCo cannot load cart.xml:"
        " no room, is too old for it line 3"
    ]


@pytest.mark.usefixtures("project")
@pytest.mark.parametrize("command", ["check", "all"])
def test_without_mujoco_a_note_says_so(command: str, capsys: Shown, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process, "is_installed", lambda _: False)
    if command == "check":
        assert main(["all"]) == 0
        capsys.readouterr()
    note = "MuJoCo not installed: cart.xml was not loaded"
    assert main([command]) == 0
    assert f"note[engine-missing]: {note}\n" in capsys.readouterr().err
    for form, line in (("github", f"::notice title=engine-missing::{note}"), ("sarif", note), ("json", note)):
        assert main(["check", "--format", form]) == 0
        assert line in capsys.readouterr().out


@pytest.mark.usefixtures("project")
def test_without_mujoco_changes_of_mjcf_are_named(capsys: Shown, monkeypatch: pytest.MonkeyPatch) -> None:
    assert main(["all"]) == 0
    monkeypatch.setattr(process, "is_installed", lambda _: False)
    monkeypatch.setitem(sys.modules, "mujoco", None)
    edit(Path("descriptions/cart/robot.yaml"), "mass: 1 kg", "mass: 2 kg")
    capsys.readouterr()
    assert main(["check"]) == 1
    assert capsys.readouterr().out.startswith("body mass 1 -> 2 kg (+1.0 kg): urdf, mjcf\n")


def test_an_engine_that_is_too_old_is_a_warning(home: Path, capsys: Shown, monkeypatch: pytest.MonkeyPatch) -> None:
    class OldMuJoCo(ModuleType):
        """One that refuses an attribute that MuJoCo 4 knows; nothing else of it is asked."""

        class MjSpec:
            @staticmethod
            def from_string(_: str) -> None:
                raise ValueError("XML Error: Schema violation: unrecognized attribute: 'output'\nElement 'camera'")

        __version__ = "3.3.0"

        @staticmethod
        def set_mju_user_warning(handler: object) -> None: ...

    robot = ROBOT.replace("      - mesh: {file: cover.obj}\n", "")
    write_files(home, {"descriptions/cart/robot.yaml": robot})
    assert main(["all"]) == 0
    monkeypatch.setattr("rosorin_compile.mujoco.mjcf.engine.import_module", OldMuJoCo)
    (line,) = said(capsys, 0)
    assert line.startswith("warning[engine-refuses]: MuJoCo cannot load cart.xml: MuJoCo 3.3.0 is")
    assert "MuJoCo 4 may know it: XML Error: Schema violation: unrecognized attribute: 'output' Element" in line
    monkeypatch.setattr(OldMuJoCo, "__version__", "4.0.0")
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", "off")  # an engine is not put in the place of another as one is here
    (line,) = said(capsys, 1)
    assert "error[engine-refuses]" in line


@pytest.mark.slow  # MuJoCo in a process of its own
def test_before_the_first_all_artifacts_are_missing_and_no_engine_is_asked(project: Path, capsys: Shown) -> None:
    assert main(["check"]) == 1
    told = "".join(capsys.readouterr())
    assert "cart.xml: missing; rosorin-compile all writes it" in told
    assert "engine-refuses" not in told
    assert main(["all"]) == 0
    next((project / "outputs/cart").rglob("*.obj")).unlink()
    assert said(capsys, 1) == []
