"""A new robot: it compiles, it is written whole or not at all, and nothing is lost."""

import json
import re
import shutil
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.importing.new_robot import TEMPLATES, check_free, init, texts_of
from support.kills import at_each_step
from support.paths import ROOT, SCHEMAS
from support.robots import compiled

pytestmark = pytest.mark.usefixtures("here")


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", str(tmp_path / "cache"))
    return tmp_path


def files(folder: Path) -> list[str]:
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


@pytest.mark.parametrize("template", TEMPLATES)
def test_every_template_compiles_with_stand_ins_at_most(template: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["init", "bot", template]) == 0
    folder = Path("descriptions/bot")
    for path in folder.iterdir():
        text = path.read_text("utf-8")
        assert "NAME" not in text
        assert max(map(len, text.splitlines())) <= 120, path.name
    made = compiled(folder / "robot.yaml")
    assert made.robot is not None
    notes = {"not-in-format"} if template == "mobile_manipulator" else set()  # an SDF for all readers has no actuators
    assert {found.rule for found in made.diagnostics} <= {"stand-in", *notes}
    assert len(made.artifacts) > 5
    capsys.readouterr()
    assert main(["all", "-q"]) == main(["check", "-q"]) == 0


@pytest.mark.slow
@pytest.mark.landing("engines", "base")
@pytest.mark.parametrize("template", [name for name in TEMPLATES if name != "mobile_manipulator"])
def test_a_template_could_be_built_and_simulates(template: str, capsys: pytest.CaptureFixture[str]) -> None:
    """The mobile manipulator is the example porter, which other tests drive."""
    pytest.importorskip("mujoco", minversion="3.12")
    init("bot", template)
    assert main(["all", "-q"]) == 0
    assert main(["check", "physics"]) == 0
    assert main(["simulate", "--seconds", "0.5", "--no-timing"]) == 0
    told = capsys.readouterr()
    assert "simulated: nothing to say" in told.out
    assert {line.partition("[")[2].partition("]")[0] for line in told.err.splitlines() if "note[" in line} <= {
        "stand-in"
    }


def test_the_mobile_manipulator_is_the_example() -> None:
    """What is not the same: the first file, and the pairs that follow from the bumper of the example."""
    example = ROOT / "examples" / "porter"
    texts = texts_of("mobile_manipulator", "porter")
    assert set(texts) | {"simulation.yaml"} == {path.name for path in example.iterdir()}
    for name in sorted(set(texts) - {"robot.yaml", "collisions.yaml"}):
        assert (example / name).read_text("utf-8") == texts[name], name
    own, written = (
        text.partition("rosorin_compile: 1")[2]
        for text in (texts["robot.yaml"], (example / "robot.yaml").read_text("utf-8"))
    )
    assert written.replace("simulation.yaml, ", "") == own


def test_the_modeline_leads_to_the_schema_without_a_network() -> None:
    init("bot")
    description = Path("descriptions/bot/robot.yaml")
    first = description.read_text("utf-8").splitlines()[0]
    (address,) = re.findall(r"^# yaml-language-server: \$schema=(\S+)$", first)
    schema = description.parent / address
    assert json.loads(schema.read_text("utf-8"))["title"] == "rosorin-compile description"
    assert schema.read_bytes() == (SCHEMAS / "authoring.schema.json").read_bytes()


@pytest.mark.parametrize("name", ["b", "my_bot", "Bot2", "on", "no", "a-b", "x" * 60])
def test_good_names(here: Path, name: str) -> None:
    check_free(name, Path())
    init(name)
    made = compiled(here / "descriptions" / name / "robot.yaml")
    assert made.robot is not None
    assert made.robot.name == name


def test_exit_codes(here: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    assert main(["init", "2 bots"]) == 2
    assert "use letters, digits and underscores" in capsys.readouterr().err
    (here / "file").write_text("", "utf-8")
    assert main(["init", "bot", "-o", "file"]) == 1
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
    whole, seen = texts_of("base", "bot")["robot.yaml"], set()

    def after() -> None:
        robot = here / "descriptions/bot/robot.yaml"
        assert robot.parent.exists() == robot.exists()
        assert not robot.exists() or robot.read_text("utf-8") == whole
        assert list((here / "descriptions").glob("*/robot.yaml")) in ([], [robot])
        seen.add(robot.exists())
        shutil.rmtree(here / "descriptions", ignore_errors=True)

    assert at_each_step(lambda: init("bot", project=here), after) > 10
    assert seen == {False, True}
