"""No command replaces a file of somebody else in silence, and what a kill leaves is gone after the next run."""

import subprocess
import sys
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.importing.extract.extract import save
from rosorin_compile.model.mesh_triangles import ExtractProblem
from rosorin_compile.output import OutputError, write_artifacts
from support.kills import at_each_step

BY_HAND = "# written by hand\n"
ROBOT = """\
robot: mine
links: {base_link: {}}
outputs:
  urdf: {file: mine.urdf}
  table: {file: table.txt, backend: template, template: table.txt.jinja}
"""


def describe(home: Path, text: str = ROBOT, table: str = "one\n") -> Path:
    folder = home / "descriptions" / "mine"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.yaml").write_text(text)
    (folder / "table.txt.jinja").write_text(table)
    outputs = home / "outputs" / "mine"
    outputs.mkdir(parents=True, exist_ok=True)
    return outputs


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


def test_extract(home: Path) -> None:
    (home / "a.yaml").write_text(BY_HAND)
    with pytest.raises(ExtractProblem, match="extract did not make it"):
        save(home / "a.yaml", "new")


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


def test_a_summary_goes_to_the_file_of_the_job(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Other steps may have begun that one, and GitHub says which it is."""
    describe(home)
    assert main(["all"]) == 0
    (home / "job.md").write_text(BY_HAND)
    assert main(["check", "--summary", "job.md"]) == 2
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(home / "job.md"))
    assert main(["check", "--summary", "job.md"]) == 0
    assert (home / "job.md").read_text().startswith(f"{BY_HAND}## Robots: no problems\n")


def hidden(folder: Path) -> list[str]:
    return [path.name for path in folder.rglob(".rosorin*")]


def test_what_a_living_run_prepares_is_not_removed(home: Path) -> None:
    from rosorin_compile.output import lock, staging_folder

    with lock(home), staging_folder(home) as folder:
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
