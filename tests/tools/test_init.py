"""A new robot: it compiles, it is written whole or not at all, and nothing is lost."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from rosorin_compile.cli import main
from rosorin_compile.tools.init import CannotStart, check_name, start
from support.paths import PACKAGE, ROOT, SCHEMAS
from support.robots import compiled, texts

SCHEMA = "descriptions/.schema/rosorin-compile.schema.json"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", str(tmp_path / "cache"))
    return tmp_path


def files(folder: Path) -> list[str]:
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def test_from_nothing_to_artifacts(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["init", "my_bot"]) == 0
    assert capsys.readouterr().out == (
        "descriptions/my_bot/robot.yaml written: a small mobile base with a lidar\n"
        f"{SCHEMA} written: completion and help in editors\n"
        "next: rosorin-compile all my_bot\n"
    )
    assert files(here) == [SCHEMA, "descriptions/my_bot/robot.yaml"]
    assert main(["all"]) == 0
    shown = capsys.readouterr()
    assert shown.out.startswith("my_bot: 5 artifacts in outputs/my_bot, written: frames.md, frames.svg, my_bot.urdf, ")
    assert shown.err == ""
    assert main(["check"]) == 0


@pytest.mark.usefixtures("here")
def test_the_starter_teaches_what_it_says() -> None:
    start("bot", Path())
    path = Path("descriptions/bot/robot.yaml")
    text = path.read_text("utf-8")
    for used in (
        "args:",
        "let:",
        "parts:",
        "use:",
        "for:",
        "sensors:",
        "edges:",
        "when:",
        "source:",
        " deg",
        "${",
        "help:",
    ):
        assert used in text
    assert "NAME" not in text
    assert max(map(len, text.splitlines())) <= 120
    made = compiled(path)
    assert made.robot is not None
    assert {link.name for link in made.robot.links} >= {
        "base_footprint",
        "left_wheel",
        "right_wheel",
        "caster",
        "laser",
    }
    assert [d for d in made.diagnostics if d.severity != "note"] == []
    for command in re.findall(r"rosorin-compile (\w+) bot(?: (\w+))?", text):
        assert command[0] in ("all", "watch", "explain")


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize("base", ["fixed", "free"])
def test_mujoco_runs_the_starter(base: str) -> None:
    mujoco = pytest.importorskip("mujoco")
    start("bot", Path())
    made = compiled(Path("descriptions/bot/robot.yaml"), {"base": base})
    model = mujoco.MjModel.from_xml_string(texts(made)["bot.xml"])
    data = mujoco.MjData(model)
    while data.time < 1:
        mujoco.mj_step(model, data)
    assert abs(data.joint("left_joint").qpos[0]) < 1e-6
    assert abs(data.qpos).max() < 10
    assert not data.warning.number.any()


@pytest.mark.usefixtures("here")
def test_the_modeline_leads_to_the_schema_without_a_network() -> None:
    start("bot", Path())
    description = Path("descriptions/bot/robot.yaml")
    first = description.read_text("utf-8").splitlines()[0]
    (address,) = re.findall(r"^# yaml-language-server: \$schema=(\S+)$", first)
    schema = description.parent / address
    assert json.loads(schema.read_text("utf-8"))["title"] == "rosorin-compile description"
    assert schema.read_bytes() == (SCHEMAS / "authoring.schema.json").read_bytes()


def test_into_another_folder(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["init", "bot", "--folder", "some/project"]) == 0
    assert files(here / "some") == [f"project/{SCHEMA}", "project/descriptions/bot/robot.yaml"]
    assert "next: cd some/project && rosorin-compile all bot" in capsys.readouterr().out


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize("kind", ["robot", "empty folder", "file", "dangling link"])
def test_nothing_is_overwritten(capsys: pytest.CaptureFixture[str], kind: str) -> None:
    target = Path("descriptions/bot")
    target.parent.mkdir()
    if kind == "robot":
        start("bot", Path())
        (target / "robot.yaml").write_text("mine", "utf-8")
    elif kind == "empty folder":
        target.mkdir()
    elif kind == "file":
        target.write_text("mine", "utf-8")
    else:
        target.symlink_to("nowhere")
    before = files(Path())
    assert main(["init", "bot"]) == 2
    assert "is there already; nothing is overwritten" in capsys.readouterr().err
    assert files(Path()) == before
    if kind == "robot":
        assert (target / "robot.yaml").read_text("utf-8") == "mine"


@pytest.mark.usefixtures("here")
def test_a_schema_of_another_version_is_named_and_kept(capsys: pytest.CaptureFixture[str]) -> None:
    start("bot", Path())
    Path(SCHEMA).write_text("{}", "utf-8")
    capsys.readouterr()
    assert main(["init", "second"]) == 0
    told = capsys.readouterr().out
    (command,) = re.findall(r"to renew it: rosorin-compile (.*)$", told, re.MULTILINE)
    assert Path(SCHEMA).read_text("utf-8") == "{}"
    assert command == f"schema > {SCHEMA}"
    assert main(["schema"]) == 0
    assert capsys.readouterr().out == (SCHEMAS / "authoring.schema.json").read_text("utf-8")
    start("third", Path())
    assert not start("fourth", Path("elsewhere")).outdated


@pytest.mark.parametrize(
    "name",
    [
        "",
        "my bot",
        "../bot",
        "a/b",
        ".",
        "..",
        ".bot",
        "-bot",
        "2bot",
        "_",
        "größe",
        "bot\n",
        "a.b",
        "true",
        "null",
        "x" * 61,
    ],
)
@pytest.mark.usefixtures("here")
def test_bad_names(name: str) -> None:
    with pytest.raises(CannotStart):
        start(name, Path())
    assert files(Path()) == []


@pytest.mark.parametrize("name", ["b", "my_bot", "Bot2", "on", "no", "a-b", "x" * 60])
def test_good_names(here: Path, name: str) -> None:
    check_name(name)
    start(name, Path())
    made = compiled(here / "descriptions" / name / "robot.yaml")
    assert made.robot is not None
    assert made.robot.name == name


def test_exit_codes(here: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    assert main(["init", "2 bots"]) == 2
    assert "use letters, digits and underscores" in capsys.readouterr().err
    (here / "file").write_text("", "utf-8")
    assert main(["init", "bot", "--folder", "file"]) == 1
    assert "cannot write in file: Not a directory" in capsys.readouterr().err

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "rename", full)
    assert main(["init", "bot"]) == 1
    assert "No space left on device" in capsys.readouterr().err
    assert files(here) == ["file"]
    assert list((here / "descriptions").iterdir()) in ([], [here / "descriptions" / ".schema"])


@pytest.mark.slow
def test_killed_at_any_moment_it_is_there_or_not(here: Path) -> None:
    """Stop the program before each system call that changes the disk."""
    program = (
        "import os, sys\n"
        "from pathlib import Path\n"
        "left = int(sys.argv[1])\n"
        "def stop(event, arguments):\n"
        "    global left\n"
        "    changes = event in ('os.mkdir', 'os.rename', 'os.remove', 'os.rmdir', 'os.link')\n"
        "    changes |= event == 'open' and isinstance(arguments[1], str) and 'w' in arguments[1]\n"
        "    if changes and str(arguments[0]).startswith('descriptions'):\n"
        "        left -= 1\n"
        "        if left < 0: os._exit(9)\n"
        "from rosorin_compile.tools.init import start\n"
        "from rosorin_compile.frontend import load\n"
        "sys.addaudithook(stop)\n"
        "start('bot', Path())\n"
    )
    whole = (ROOT / "templates" / "starter.yaml").read_text("utf-8").replace("NAME", "bot")
    seen = set()
    for moment in range(40):
        folder = here / str(moment)
        folder.mkdir()
        ran = subprocess.run([sys.executable, "-c", program, str(moment)], cwd=folder, check=False)
        target = folder / "descriptions" / "bot"
        assert not os.path.lexists(target) or (target / "robot.yaml").read_text("utf-8") == whole
        assert list((folder / "descriptions").glob("*/robot.yaml")) in ([], [target / "robot.yaml"])
        seen.add(target.exists())
        if ran.returncode == 0:
            break
    else:
        pytest.fail("the program does not come to its end")
    assert seen == {False, True}


def test_everything_that_ships_is_packaged() -> None:
    """Hold the packages and data files in pyproject.toml against what is on disk."""
    text = (ROOT / "pyproject.toml").read_text("utf-8")
    package = PACKAGE
    on_disk = {".".join(path.parent.relative_to(package.parent).parts) for path in package.rglob("__init__.py")}
    folders = {name: name for name in ("bazel", "cmake", "schemas", "templates")}
    folders |= {"parts_library": "parts", "viewer": "viewer/built"}
    data = {f"rosorin_compile.{name}" for name in folders}
    listed = text.partition("packages = [")[2].partition("]")[0]
    assert set(re.findall(r'"(.+?)"', listed)) == on_disk | data
    for name, folder in folders.items():
        patterns = re.findall(r'"(.+?)"', text.partition(f'"rosorin_compile.{name}" = [')[2].partition("]")[0])
        shipped = {path for pattern in patterns for path in (ROOT / folder).glob(pattern)}
        assert {
            path for path in (ROOT / folder).rglob("*") if path.is_file() and path.suffix not in (".py", ".pyc")
        } == shipped
