"""A new robot: it compiles, it is written whole or not at all, and nothing is lost."""

import io
import json
import re
import shutil
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.importing.new_robot import TEMPLATES, check_name, init, texts_of
from rosorin_compile.source.diagnostics import RequestError
from support.kills import at_each_step
from support.paths import COMPILER, PACKAGES, ROOT, SCHEMAS
from support.robots import compiled, texts

pytestmark = pytest.mark.usefixtures("here")

SCHEMA = "descriptions/.schema/rosorin-compile.schema.json"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", str(tmp_path / "cache"))
    return tmp_path


def terminal(answer: str) -> io.StringIO:
    typed = io.StringIO(answer)
    typed.isatty = lambda: True  # type: ignore[method-assign]
    return typed


def files(folder: Path) -> list[str]:
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def test_from_nothing_to_artifacts(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["init", "my_bot"]) == 0
    assert capsys.readouterr().out == (
        "descriptions/my_bot/robot.yaml written: a small mobile base with a lidar, which drives\n"
        f"{SCHEMA} written: completion and help in editors\n"
        "next: rosorin-compile all my_bot, and rosorin-compile view my_bot to see it\n"
    )
    assert files(here) == [SCHEMA, "descriptions/my_bot/robot.yaml"]
    assert main(["all"]) == 0
    shown = capsys.readouterr()
    assert shown.out.startswith("my_bot: 6 artifacts in outputs/my_bot, written: frames.md, frames.svg, my_bot.urdf, ")
    assert shown.err == ""
    assert main(["check"]) == 0


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
    pytest.importorskip("mujoco", minversion="4")
    init("bot", template)
    assert main(["all", "-q"]) == 0
    assert main(["check", "physics"]) == 0
    assert main(["simulate", "--seconds", "0.5", "--no-timing"]) == 0
    told = capsys.readouterr()
    assert "simulated: nothing to say" in told.out
    assert {line.partition("[")[2].partition("]")[0] for line in told.err.splitlines() if "note[" in line} <= {
        "stand-in"
    }


def test_a_length_of_the_arm_stands_once() -> None:
    init("bot", "arm")
    path = Path("descriptions/bot/arm.yaml")
    path.write_text(path.read_text("utf-8").replace("upper_arm: 260 mm", "upper_arm: 300 mm"), "utf-8")
    made = compiled(Path("descriptions/bot/robot.yaml")).robot
    assert made is not None
    assert made.joint["forearm_joint"].origin.xyz == pytest.approx((0, 0, 0.3))


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


@pytest.mark.parametrize(
    ("answer", "written"),
    [
        ("arm\n", "an arm of five joints"),
        ("sens\n", "sensors on a plate"),
        ("\n", "a small mobile base"),
        ("", "a small mobile base"),
    ],
)
def test_a_terminal_is_asked(capsys, monkeypatch, answer: str, written: str) -> None:
    monkeypatch.setattr("sys.stdin", terminal(answer))
    monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
    assert main(["init", "bot"]) == 0
    told = capsys.readouterr().out
    assert all(name in told for name in TEMPLATES)
    assert f"which one? [base] descriptions/bot/robot.yaml written: {written}" in told


def test_whoever_cannot_be_asked_gets_the_default_and_a_taken_name_is_told_before(capsys, monkeypatch) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO("arm\n"))
    monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
    assert main(["init", "bot"]) == 0
    assert "a small mobile base" in capsys.readouterr().out
    monkeypatch.setattr("sys.stdin", terminal("arm\n"))
    assert main(["init", "bot"]) == 2
    told = capsys.readouterr()
    assert "is there already" in told.err
    assert "which one" not in told.out


@pytest.mark.parametrize("base", ["fixed", "free"])
def test_mujoco_runs_the_starter(base: str) -> None:
    mujoco = pytest.importorskip("mujoco")
    init("bot")
    made = compiled(Path("descriptions/bot/robot.yaml"), {"base": base})
    model = mujoco.MjModel.from_xml_string(texts(made)["bot.xml"])
    data = mujoco.MjData(model)
    while data.time < 1:
        mujoco.mj_step(model, data)
    assert abs(data.joint("left_joint").qpos[0]) < 1e-6
    assert abs(data.qpos).max() < 10
    assert not data.warning.number.any()


def test_the_modeline_leads_to_the_schema_without_a_network() -> None:
    init("bot")
    description = Path("descriptions/bot/robot.yaml")
    first = description.read_text("utf-8").splitlines()[0]
    (address,) = re.findall(r"^# yaml-language-server: \$schema=(\S+)$", first)
    schema = description.parent / address
    assert json.loads(schema.read_text("utf-8"))["title"] == "rosorin-compile description"
    assert schema.read_bytes() == (SCHEMAS / "authoring.schema.json").read_bytes()


def test_into_another_folder(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["init", "bot", "-o", "some/project"]) == 0
    assert files(here / "some") == [f"project/{SCHEMA}", "project/descriptions/bot/robot.yaml"]
    assert "next: cd some/project && rosorin-compile all bot" in capsys.readouterr().out


@pytest.mark.parametrize("kind", ["robot", "empty folder", "file", "dangling link"])
def test_nothing_is_overwritten(capsys: pytest.CaptureFixture[str], kind: str) -> None:
    target = Path("descriptions/bot")
    target.parent.mkdir()
    if kind == "robot":
        init("bot")
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


def test_a_schema_of_another_version_is_named_and_kept(capsys: pytest.CaptureFixture[str]) -> None:
    init("bot")
    Path(SCHEMA).write_text("{}", "utf-8")
    capsys.readouterr()
    assert main(["init", "second"]) == 0
    told = capsys.readouterr().out
    (command,) = re.findall(r"to renew it: rosorin-compile (.*)$", told, re.MULTILINE)
    assert Path(SCHEMA).read_text("utf-8") == "{}"
    assert command == f"schema > {SCHEMA}"
    assert main(["schema"]) == 0
    assert capsys.readouterr().out == (SCHEMAS / "authoring.schema.json").read_text("utf-8")
    init("third")
    assert not init("fourth", project=Path("elsewhere")).schema_outdated


BAD_NAMES = ["", "my bot", "../bot", "a/b", ".", "..", ".bot", "-bot", "2bot", "_", "größe", "bot\n", "a.b", "true"]
BAD_NAMES += ["null"]


@pytest.mark.parametrize("name", [*BAD_NAMES, "x" * 61])
def test_bad_names(name: str) -> None:
    with pytest.raises(RequestError):
        init(name)
    assert files(Path()) == []


@pytest.mark.parametrize("name", ["b", "my_bot", "Bot2", "on", "no", "a-b", "x" * 60])
def test_good_names(here: Path, name: str) -> None:
    check_name(name)
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


def test_everything_that_ships_is_packaged() -> None:
    """Hold the packages and data files in pyproject.toml against what is on disk."""
    text = (ROOT / "pyproject.toml").read_text("utf-8")
    sources = [path for package in PACKAGES for path in package.rglob("__init__.py")]
    on_disk = {".".join(path.parent.relative_to(COMPILER).parts) for path in sources}
    folders = {name: name for name in ("bazel", "cmake", "schemas", "templates")}
    folders |= {"parts_library": "parts", "viewer.built": "viewer/built"}
    data = {f"rosorin_compile.{name}" for name in folders}
    listed = text.partition("packages = [")[2].partition("]")[0]
    assert set(re.findall(r'"(.+?)"', listed)) == on_disk | data
    for name, folder in folders.items():
        patterns = re.findall(r'"(.+?)"', text.partition(f'"rosorin_compile.{name}" = [')[2].partition("]")[0])
        shipped = {path for pattern in patterns for path in (ROOT / folder).glob(pattern)}
        assert {
            path for path in (ROOT / folder).rglob("*") if path.is_file() and path.suffix not in (".py", ".pyc")
        } == shipped


def test_every_file_beside_modules_is_packaged() -> None:
    """Hold what is no module in the folders of packages, as py.typed, against the package data."""
    text = (ROOT / "pyproject.toml").read_text("utf-8").partition("[tool.setuptools.package-data]\n")[2]
    rows = re.findall(r'^"?([\w.]+)"? = \[(.*)\]$', text.partition("\n\n")[0], re.MULTILINE)
    patterns = {package: re.findall(r'"(.+?)"', row) for package, row in rows}
    beside = [path for path in COMPILER.rglob("*") if path.is_file() and "__pycache__" not in path.parts]
    beside = [path for path in beside if path.suffix != ".py" and path.name != "README.md"]
    # Pieces of the schema in folders of sections are part of schemas/description.schema.json, which is packaged.
    beside = [path for path in beside if not ("sections" in path.parts and path.suffix == ".json")]
    assert beside
    left = [
        path.relative_to(COMPILER).as_posix()
        for path in beside
        if path.parent.name != "compiler" and "egg-info" not in path.parent.name
        if not any(
            path.match(pattern) for pattern in patterns.get(".".join(path.parent.relative_to(COMPILER).parts), ())
        )
    ]
    assert left == []
