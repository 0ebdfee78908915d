"""No command replaces a file of somebody else in silence, and what a kill leaves is gone after the next run."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.importing.extract.results import save
from rosorin_compile.model.mesh_triangles import ExtractProblem
from rosorin_compile.output import OutputError, write_artifacts
from support.kills import at_each_step
from support.paths import DATA

BY_HAND = "# written by hand\n"
ROBOT = """\
robot: mine
links: {base_link: {}}
outputs:
  urdf: {file: mine.urdf}
  table: {file: table.txt, backend: template, template: table.txt.jinja}
"""
URDF = '<robot name="mine"><link name="base_link"/></robot>\n'


def describe(home: Path, text: str = ROBOT, table: str = "one\n") -> Path:
    folder = home / "descriptions" / "mine"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.yaml").write_text(text)
    (folder / "table.txt.jinja").write_text(table)
    outputs = home / "outputs" / "mine"
    outputs.mkdir(parents=True, exist_ok=True)
    return outputs


@pytest.mark.parametrize("text", [BY_HAND, URDF, "\0\xff"])
def test_all_refuses_a_file_that_it_did_not_write(home: Path, capsys: pytest.CaptureFixture[str], text: str) -> None:
    outputs = describe(home)
    (outputs / "mine.urdf").write_text(text)
    assert main(["all"]) == 1
    said = capsys.readouterr().err
    assert "error[output-not-ours]: this tool did not write outputs/mine/mine.urdf: it is not replaced\n" in said
    assert "    move it away, or give the new file another name or folder\n" in said
    assert [path.name for path in outputs.iterdir()] == ["mine.urdf"]
    assert (outputs / "mine.urdf").read_text() == text
    assert main(["all", "--prune"]) == 0, "which removes what is no artifact"


def test_all_keeps_what_may_be_of_somebody_else(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A file without the line that tells, where nothing was written before."""
    outputs = describe(home)
    (outputs / "table.txt").write_text(BY_HAND)
    assert main(["all"]) == 0
    told = "warning[output-kept]: outputs/mine/table.txt may be of somebody else; it is table.txt.kept now\n"
    assert told in capsys.readouterr().err
    assert (outputs / "table.txt").read_text() == "one\n"
    assert (outputs / "table.txt.kept").read_text() == BY_HAND
    for table in ("two\n", "three\n"):
        describe(home, table=table)
        assert main(["all"]) == 0
        assert "output-kept" not in capsys.readouterr().err
        assert (outputs / "table.txt").read_text() == table


@pytest.mark.parametrize("cache", ["cache", "off"])
def test_artifacts_that_came_with_the_project_are_ours(
    home: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], cache: str
) -> None:
    """As after a clone: nothing is remembered, and the artifacts are of an older description."""
    outputs = describe(home)
    assert main(["all"]) == 0
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", cache if cache == "off" else str(home / "another"))
    describe(home, ROBOT.replace("base_link", "base"), "two\n")
    capsys.readouterr()
    assert main(["all"]) == 0
    assert capsys.readouterr().err == ""
    assert (outputs / "table.txt").read_text() == "two\n"
    assert sorted(path.name for path in outputs.iterdir()) == ["mine.urdf", "table.txt"]


def test_import_keeps_a_description_that_somebody_changed(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (home / "mine.urdf").write_text(URDF)
    assert main(["import", "mine.urdf", "-o", "to"]) == 0
    path = home / "to" / "robot.yaml"
    path.write_text(path.read_text() + BY_HAND)
    changed = path.read_text()
    assert main(["import", "mine.urdf", "-o", "to"]) == 0  # put together: the source says what it said
    assert path.read_text() == changed
    assert main(["import", "mine.urdf", "-o", "to", "--force"]) == 0
    assert "to/robot.yaml may be of somebody else; it is robot.yaml.kept now" in capsys.readouterr().err
    assert path.with_name("robot.yaml.kept").read_text() == changed
    assert main(["import", "mine.urdf", "-o", "to", "--force"]) == 0
    assert "output-kept" not in capsys.readouterr().err


@pytest.mark.parametrize("name", ["joints.yaml", "boxes.yaml"])
def test_extract_factory(home: Path, capsys: pytest.CaptureFixture[str], name: str) -> None:
    pytest.importorskip("trimesh")
    (home / "pkg").mkdir()
    (home / "pkg" / "mine.urdf").write_text(URDF)
    (home / "to").mkdir()
    (home / "to" / name).write_text(BY_HAND)
    assert main(["extract", "factory", "pkg", "-o", "to"]) == 1
    assert f"error[output-not-ours]: this tool did not write to/{name}: it is not replaced" in capsys.readouterr().err
    assert [path.name for path in (home / "to").iterdir()] == [name]
    (home / "to" / name).unlink()
    assert main(["extract", "factory", "pkg", "-o", "to"]) == 0
    assert main(["extract", "factory", "pkg", "-o", "to"]) == 0


def test_extract_and_init(home: Path) -> None:
    (home / "a.yaml").write_text(BY_HAND)
    with pytest.raises(ExtractProblem, match="extract did not make it"):
        save(home / "a.yaml", "new")
    (home / "descriptions" / "mine").mkdir(parents=True)
    assert main(["init", "mine"]) == 2
    schema = home / "descriptions/.schema/rosorin-compile.schema.json"
    schema.parent.mkdir()
    schema.write_text(BY_HAND)
    assert main(["init", "other"]) == 0
    assert schema.read_text() == BY_HAND


PAGES = [(["view", "--html", "mine"], 1), (["check", "--html", "mine"], 2)]
PAGES += [(["diff", "mine", "mine", "--html", "mine.html"], 2), (["print", "urdf", "-o", "mine"], 1)]
PAGES += [(["print", "table", "-o", "mine"], 1), (["print", "json", "-o", "mine"], 1)]
PAGES += [(["all", "--depfile", "mine"], 1), (["check", "--depfile", "mine", "--depfile-target", "x"], 1)]
PAGES += [(["collisions", "-o", "mine"], 1)]


@pytest.mark.parametrize(
    ("words", "code", "cache"), [*((*row, "cache") for row in PAGES), *((*row, "off") for row in PAGES[3:6])]
)
def test_one_file(
    home: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: list[str],
    code: int,
    cache: str,
) -> None:
    """A file that this tool did not write is refused; one that it did is replaced, also with another content."""
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", cache if cache == "off" else str(home / cache))
    describe(home, ROBOT + "  json: {file: tf.json, backend: static_tf_json}\n")
    assert main(["all"]) == 0
    file = home / words[-1] if words[0] == "diff" else home / "mine"
    for text in (BY_HAND, ROBOT, "all:\n\techo mine\n", "{}\n"):
        file.write_text(text)
        capsys.readouterr()
        assert main(words) == code
        said = capsys.readouterr().err
        assert file.name in said
        assert "this tool did not write" in said or "was not written by" in said or "is there, and" in said
        assert file.read_text() == text
    file.unlink()
    assert main(words) == 0
    assert file.read_text() not in ("", text)
    describe(home, (home / "descriptions/mine/robot.yaml").read_text().replace("base_link", "base"), "two\n")
    assert main(["all"]) == 0
    nobody_knows = "table" in words and cache == "off"
    assert main(words) == int(nobody_knows)
    file.write_text("\n")
    assert main(words) == 0
    assert file.read_text().strip()


def test_a_summary_is_appended(home: Path) -> None:
    describe(home)
    assert main(["all"]) == 0
    (home / "job.md").write_text(BY_HAND)
    assert main(["check", "--summary", "job.md"]) == 0
    assert (home / "job.md").read_text().startswith(f"{BY_HAND}## Robots: no problems\n")


def test_what_is_no_file_is_not_read(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    describe(home)
    os.mkfifo(home / "pipe")
    for name in ("pipe", "/dev/full", "outputs"):
        assert main(["collisions", "-o", name]) == 2
        assert f"{name} cannot be written: it is not a regular file" in capsys.readouterr().err


def test_verify(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    describe(home)
    (home / "notes.md").write_text(BY_HAND)
    recording = str(DATA / "recordings" / "session.txt")
    assert main(["verify", recording, "--junit", "notes.md"]) == 2
    assert "this tool did not write notes.md: it is not replaced; name another file" in capsys.readouterr().err
    assert (home / "notes.md").read_text() == BY_HAND
    for _ in range(2):
        assert main(["verify", recording, "--junit", "new.xml"]) == 1
    assert "<testsuites" in (home / "new.xml").read_text()


def hidden(folder: Path) -> list[str]:
    return [path.name for path in folder.rglob(".rosorin*")]


def test_what_a_living_run_prepares_is_not_removed(home: Path) -> None:
    from rosorin_compile.output import locked, staging_folder

    with locked(home), staging_folder(home) as folder:
        program = (
            "from pathlib import Path; from rosorin_compile.output import write_file; write_file(Path('a.txt'), b'')"
        )
        other = subprocess.Popen([sys.executable, "-c", program], cwd=home)
        with pytest.raises(subprocess.TimeoutExpired):
            other.wait(1)
        assert folder.is_dir()
        assert not (home / "a.txt").exists()
    assert other.wait() == 0
    assert (home / "a.txt").exists()
    assert not hidden(home)


@pytest.mark.slow
def test_a_killed_all_loses_nothing(home: Path) -> None:
    folder, files = home / "out", {"a.txt": "new", "b.txt": "new b"}

    def fresh() -> None:
        folder.mkdir(exist_ok=True)
        for path in folder.iterdir():
            path.unlink()
        (folder / "a.txt").write_text(BY_HAND)
        for path in (home / "cache" / "outputs").glob("*"):
            path.unlink()

    def after() -> None:
        found = {path.name: path.read_text() for path in folder.iterdir()}
        assert found in ({"a.txt": BY_HAND}, {**files, "a.txt.kept": BY_HAND})
        write_artifacts(folder, files)
        assert (folder / "a.txt.kept").read_text() == BY_HAND
        assert not hidden(home)
        fresh()

    fresh()
    assert at_each_step(lambda: write_artifacts(folder, files), after) > 20


def test_a_refused_set_writes_nothing(home: Path) -> None:
    (home / "out").mkdir()
    (home / "out" / "b.urdf").write_text(BY_HAND)
    marked = "<!-- Generated by rosorin-compile -->"
    with pytest.raises(OutputError, match="this tool did not write"):
        write_artifacts(home / "out", {"a.txt": "a", "b.urdf": marked})
    assert [path.name for path in (home / "out").iterdir()] == ["b.urdf"]
