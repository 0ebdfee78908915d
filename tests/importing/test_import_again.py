"""A source is imported again into a description that was edited: edits stay, and conflicts are marked."""

from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rosorin_compile import compile as compile_description
from rosorin_compile.cli.main import main
from rosorin_compile.importing.reimport import import_again, read_record, record_of
from rosorin_compile.source.diagnostics import has_errors
from support.paths import IMPORTED, data_text

BODY = data_text("robots/import_again_body.xml")
WHEEL = data_text("robots/import_again_wheel.xml")
LEFT, RIGHT, REAR = (
    WHEEL.replace("NAME", name).replace("PLACE", place)
    for name, place in (("left", "0.2 0.25"), ("right", "0.2 -0.25"), ("rear", "-0.2 0"))
)
ROOT = Path("descriptions/cart/robot.yaml")
SENSOR = "sensors:\n  # bought by hand\n  imu: {type: imu, frame: base_link}\n\noutputs:"


def source(*pieces: str, name: str = "cart.urdf") -> None:
    """Write the source; its pieces are links and joints."""
    Path(name).write_text(f'<robot name="cart">\n{"".join(pieces)}</robot>\n')


def run(*words: str) -> int:
    """Import cart.urdf again; return the exit code."""
    return main(["import", "cart.urdf", *words])


def mine(old: str, new: str, file: Path = ROOT) -> str:
    """Change what stands in a file, as a person does; return its text."""
    text = file.read_text()
    assert text.count(old) == 1, (old, text)
    file.write_text(text.replace(old, new))
    return file.read_text()


def there() -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in Path().rglob("*") if path.is_file() and "cache" not in path.parts}


def refused(capsys: pytest.CaptureFixture[str], *words: str, code: int = 1) -> str:
    """Import what is refused; return what is said. Nothing may change."""
    before = there()
    capsys.readouterr()
    assert run(*words) == code
    assert there() == before
    return capsys.readouterr().err


@pytest.fixture
def cart(home: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    source(BODY, LEFT, RIGHT)
    assert run() == 0
    capsys.readouterr()
    return home


@pytest.mark.usefixtures("cart")
def test_a_second_time_nothing_changes(capsys: pytest.CaptureFixture[str]) -> None:
    before = there()
    assert run() == 0
    assert there() == before
    assert "descriptions/cart: unchanged\n" in capsys.readouterr().out
    mine("mass: 8", "mass: 9")
    before = there()
    assert run() == 0
    assert there() == before
    assert "edited here, and kept: robot.yaml\n" in capsys.readouterr().out


@pytest.mark.usefixtures("cart")
def test_changes_of_both_sides_are_merged(capsys: pytest.CaptureFixture[str]) -> None:
    mine("mass: 8, inertia: {ixx: 0.1, iyy: 0.2, izz: 0.3}", "mass: 9, inertia: { ixx: .1, iyy: .2, izz: .3 }")
    mine("outputs:", SENSOR)
    text = mine("  laser: {}\n", "  laser: {}   # above the lid\n")
    source(BODY.replace("0.1 0 0.2", "0.15 0 0.2"), LEFT, RIGHT, REAR)
    assert run() == 0
    said = capsys.readouterr().out
    assert "descriptions/cart: written: robot.yaml\n" in said
    assert "changes of the newer cart.urdf: robot.yaml\n" in said
    assert "edited here, and kept: robot.yaml\n" in said
    now = ROOT.read_text()
    wanted = text.replace("[0.1, 0, 0.2]", "[0.15, 0, 0.2]")
    added = [line for line in now.splitlines() if line not in wanted.splitlines()]
    assert added == ["  rear: {part: wheel, parent: base_link, xyz: [-0.2, 0, 0.08]}"]
    assert [line for line in wanted.splitlines() if line not in now.splitlines()] == []
    made = compile_description(ROOT)
    assert made.robot is not None
    assert made.robot.link["base_link"].inertial.mass == 9
    assert [made.robot.joint[f"{name}_joint"].origin.xyz[0] for name in ("laser", "rear_wheel")] == [0.15, -0.2]


def conflict() -> None:
    mine("mass: 8", "mass: 9")
    source(BODY.replace('value="8"', 'value="8.5"'), LEFT, RIGHT, REAR)


@pytest.mark.usefixtures("cart")
def test_a_conflict_is_marked_and_has_to_be_resolved(capsys: pytest.CaptureFixture[str]) -> None:
    conflict()
    own = ROOT.read_text().splitlines()
    assert run() == 1
    text = ROOT.read_text()
    (start,) = [number for number, line in enumerate(text.splitlines(), 1) if line.startswith("<<<<<<<")]
    said = capsys.readouterr()
    assert f"descriptions/cart/robot.yaml:{start}:1: error[import-conflict]: the newer cart.urdf changes " in said.err
    assert "choose a version at each <<<<<<<, and remove the marks" in said.err
    assert "descriptions/cart: written: robot.yaml\n" in said.out
    assert "next:" not in said.out
    assert [line for line in own if line not in text.splitlines()] == []
    assert all(f"mass: {mass}," in text for mass in ("9", "8", "8.5"))
    assert "rear: {" in text
    assert str(Path.cwd()) not in text
    for words in (["check", "cart"], ["import", "cart.urdf"]):
        before = there()
        assert main(words) == 1
        assert there() == before
        told = capsys.readouterr().err
        assert f"descriptions/cart/robot.yaml:{start}:1: error[yaml-syntax]: unresolved merge conflict" in told
        assert told.count("error[") == 1
    marked = text.splitlines(keepends=True)
    first, middle, last = (
        next(number for number, line in enumerate(marked) if line.startswith(mark)) for mark in ("<<<", "|||", ">>>")
    )
    ROOT.write_text("".join([*marked[:first], *marked[first + 1 : middle], *marked[last + 1 :]]))
    resolved = ROOT.read_text()
    assert run() == 0  # the record is that of the newer source
    assert ROOT.read_text() == resolved
    assert main(["all", "cart"]) == 0


@pytest.mark.usefixtures("cart")
def test_conflicts_are_resolved_in_favour_of_the_edits() -> None:
    conflict()
    assert run("--ours") == 0
    assert "mass: 9" in ROOT.read_text()
    assert "rear: {" in ROOT.read_text()
    before = there()
    assert run() == 0
    assert there() == before


@pytest.mark.usefixtures("cart")
@pytest.mark.parametrize("git", ["", "#!/bin/sh\necho broken >&2\nexit 255\n"])
def test_without_git_nothing_is_written(
    git: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    conflict()
    Path("bin").mkdir()
    if git:
        Path("bin/git").write_text(git)
        Path("bin/git").chmod(0o755)
    with monkeypatch.context() as without:
        without.setenv("PATH", str(Path("bin").absolute()))
        said = refused(capsys)
    assert "error[import-no-git]: descriptions/cart was edited, and the changes of the newer cart.urdf" in said
    assert ("git merge-file fails: broken" if git else "git is not installed") in said
    assert run("--ours") == 0
    assert "rear: {" in ROOT.read_text()


@pytest.mark.usefixtures("cart")
def test_line_ends_stay_as_they_are() -> None:
    mine("mass: 8", "mass: 9")
    ROOT.write_bytes(ROOT.read_bytes().replace(b"\n", b"\r\n"))
    source(BODY, LEFT, RIGHT, REAR)
    assert run() == 0
    text = ROOT.read_bytes()
    assert b"rear: {" in text
    assert b"mass: 9" in text
    assert text.count(b"\r\n") == text.count(b"\n")


@pytest.mark.usefixtures("cart")
def test_a_file_that_is_no_text_stays(capsys: pytest.CaptureFixture[str]) -> None:
    ROOT.write_bytes(b"robot: \xff\n")
    source(BODY, LEFT, RIGHT, REAR)
    assert "descriptions/cart/robot.yaml is not UTF-8 text" in refused(capsys, code=2)


@pytest.mark.usefixtures("cart")
def test_the_import_of_another_robot_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    source(BODY, name="two.urdf")
    assert main(["import", "two.urdf"]) == 2
    said = capsys.readouterr().err
    assert "descriptions/cart is of another import: rosorin-compile import cart.urdf; this one is: two.urdf" in said
    assert run("--name", "other") == 0


@pytest.mark.usefixtures("home")
def test_an_option_is_added_and_not_forgotten(capsys: pytest.CaptureFixture[str]) -> None:
    source(BODY.replace('<box size="0.4 0.3 0.1"/>', '<mesh filename="base.stl"/>'), LEFT, RIGHT)
    assert run() == 0
    mine("mass: 8", "mass: 9")
    assert run("--meshes", "package://cart") == 0
    assert "package://cart/base.stl" in ROOT.read_text()
    assert "mass: 9" in ROOT.read_text()
    said = refused(capsys, code=2)
    assert "was imported with --meshes: rosorin-compile import cart.urdf --meshes package://cart; give the " in said


@pytest.mark.usefixtures("cart")
def test_without_a_record_nothing_is_written(capsys: pytest.CaptureFixture[str]) -> None:
    for text in (None, "robot: x\n", "# rosorin-compile import\n", '# rosorin-compile import "\n'):
        record = ROOT.with_name("robot.yaml.imported")
        record.unlink() if text is None else record.write_text(text)
        said = refused(capsys, code=2)
        assert "descriptions/cart is not empty; name a new folder with -o, or write into this one with --force" in said
        assert "(no robot.yaml.imported there says what was imported, so changes cannot be merged)" in said
    text = mine("mass: 8", "mass: 9")
    assert run("--force") == 0  # and from then on there is one
    assert ROOT.with_name("robot.yaml.kept").read_text() == text
    assert run() == 0


@pytest.fixture
def rover(home: Path) -> Path:
    Path("cart.urdf").write_text((IMPORTED / "rover" / "rover.urdf").read_text())
    assert run("--no-parts") == 0
    return home / "descriptions" / "rover"


@pytest.mark.slow
def test_a_description_of_several_files(rover: Path) -> None:
    (rover / "mine.yaml").write_text("sensors:\n  mine: {type: imu, frame: base_link}\n")
    mine("include: [links.yaml", "include: [mine.yaml, links.yaml", rover / "robot.yaml")
    links = rover / "links.yaml"
    links.write_text(f"# as ordered\n{links.read_text()}")
    before = there()
    assert run("--no-parts") == 0
    assert there() == before
    Path("cart.urdf").write_text(Path("cart.urdf").read_text().replace('<mass value="', '<mass value="1', 1))
    assert run("--no-parts") == 0
    now = there()
    assert [name for name in before if before[name] != now[name]] == [
        "cart.urdf",
        "descriptions/rover/links.yaml",
        "descriptions/rover/links.yaml.imported",
    ]
    assert links.read_text().startswith("# as ordered\n")
    assert "mass: 114.2" in links.read_text()
    assert "mine.yaml, links.yaml" in (rover / "robot.yaml").read_text()


@pytest.mark.slow
def test_a_file_that_was_deleted_stays_deleted(rover: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (rover / "links.yaml").unlink()
    before = there()
    assert run("--no-parts") == 0
    assert there() == before
    assert "links.yaml was deleted, and robot.yaml includes it" in capsys.readouterr().err
    Path("cart.urdf").write_text(Path("cart.urdf").read_text().replace('<mass value="', '<mass value="1', 1))
    assert run("--no-parts") == 0
    said = capsys.readouterr().err
    assert "warning[import-file-left]: descriptions/rover/links.yaml was deleted, and the newer cart.urdf" in said
    assert not (rover / "links.yaml").exists()
    before = there()
    assert run("--no-parts") == 0
    assert there() == before


@pytest.mark.slow
@pytest.mark.parametrize("edited", [False, True])
def test_a_file_that_the_source_has_no_more_goes_unless_it_was_edited(
    rover: Path, capsys: pytest.CaptureFixture[str], edited: bool
) -> None:
    """The record stands in for an older source, which had one more file."""
    for name in ("more.yaml", "more.yaml.imported"):
        (rover / name).write_text("links: {more: {}}\n")
    if edited:
        (rover / "more.yaml").write_text("links: {most: {}}\n")
    assert run("--no-parts") == 0
    assert not (rover / "more.yaml.imported").exists()
    assert (rover / "more.yaml").exists() == edited
    assert ("warning[import-file-left]" in capsys.readouterr().err) == edited
    before = there()
    assert run("--no-parts") == 0
    assert there() == before
    assert "import-file-left" not in capsys.readouterr().err


@pytest.mark.slow
def test_a_new_file_does_not_replace_one_of_the_same_name(rover: Path) -> None:
    """The record stands in for an older source, which did not have the file yet."""
    (rover / "joints.yaml.imported").unlink()
    (rover / "joints.yaml").write_text("# mine\n")
    assert run("--no-parts") == 1
    text = (rover / "joints.yaml").read_text()
    assert text.startswith("<<<<<<< edited here\n# mine\n||||||| imported before\n=======\n")


@pytest.mark.slow
@pytest.mark.usefixtures("cart")
def test_a_robot_that_grows_beyond_a_file_stays_in_it() -> None:
    mine("mass: 8", "mass: 9")
    many = [BODY.replace("base_link", "base_link").replace("laser", f"laser_{number}") for number in range(60)]
    links = [piece[piece.index("  <!--") :] for piece in many]
    source(BODY, LEFT, RIGHT, *links)
    assert run() == 0
    assert [path.name for path in sorted(ROOT.parent.iterdir())] == ["robot.yaml", "robot.yaml.imported"]
    assert "mass: 9" in ROOT.read_text()
    assert "laser_59_joint" in ROOT.read_text()


# Whatever was edited in a description and whatever changed in its source: each new line of both is in the result.


WORDS = ["robot.urdf"]
BASE = "".join(f"  link_{number}: {{mass: {number}}}\n" for number in range(12))


@st.composite
def edited(draw: st.DrawFn) -> str:
    """Return the text with lines that are changed, added or removed."""
    lines = BASE.splitlines(keepends=True)
    for _ in range(draw(st.integers(0, 4))):
        place = draw(st.integers(0, len(lines) - 1))
        new = f"  # {draw(st.text('abc', min_size=1, max_size=6))}\n"
        lines[place : place + draw(st.integers(0, 2))] = [new] * draw(st.integers(0, 2))
        lines = lines or [new]
    return "".join(lines)


def saved(folder: Path, files: dict[str, str]) -> Path:
    folder.mkdir(exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text)
    return folder


@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
@given(edited(), edited())
def test_each_new_line_of_both_sides_is_there(mine: str, newer: str) -> None:
    with TemporaryDirectory() as name:
        head = "links:\n"
        base, ours, theirs = ({"robot.yaml": head + text} for text in (BASE, mine, newer))
        folder = saved(Path(name, "d"), {**record_of(base, WORDS), **ours})
        record = read_record(folder, WORDS)
        assert record is not None
        assert record == base
        merged = import_again(folder, record, theirs, WORDS)
        saved(folder, merged.files)
        lines, old = (one.splitlines() for one in ((folder / "robot.yaml").read_text(), base["robot.yaml"]))
        for side in (ours, theirs):
            assert [line for line in side["robot.yaml"].splitlines() if line not in old and line not in lines] == []
        conflicts = [line for line in lines if line.startswith(("<<<<<<<", "|||||||", ">>>>>>>"))]
        assert bool(conflicts) == has_errors(merged.diagnostics)
        if ours == base:
            assert "\n".join(lines) == theirs["robot.yaml"].rstrip("\n")
        again = read_record(folder, WORDS)
        assert again is not None
        assert again == theirs
        second = import_again(folder, again, theirs, WORDS)
        assert second.refused == bool(conflicts)
        assert second.files == ({} if conflicts else record_of(theirs, WORDS))
