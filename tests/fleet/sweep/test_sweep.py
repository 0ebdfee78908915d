"""sweep: what stands in the folder, what is stored once, what is made anew, and what is said."""

import hashlib
import json
import os
import signal
import time
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.variants.folder import VariantsFolder
from support.commands import Shown, edit
from support.paths import data_text

ROBOT = data_text("robots/sweep.yaml")
PROJECT = {
    "descriptions/mast/robot.yaml": ROBOT,
    "descriptions/mast/cal.yaml": "size: 2 cm\n",
    "descriptions/mast/notes.txt.jinja": "the same for all\n",
    "fleet.csv": "name,height\nr1,20 cm\nr2,\nr3,20 cm\n",
}
OUT = Path("build")


@pytest.fixture(autouse=True)
def here(project: Path) -> Path:
    return project


def sweep(*words: str, over: str = "fleet.csv", code: int = 0) -> None:
    time.sleep(0.02)  # a file that is as young as the run is not relied on
    assert main(["sweep", "mast", "--over", over, "-o", str(OUT), "-j", "1", *words]) == code


def index() -> dict[str, Any]:
    text = (OUT / "sweep.json").read_text()
    made: dict[str, Any] = json.loads(text)
    lines = text.splitlines()
    assert [json.loads(line.removesuffix(",")) for line in lines[1:-1]] == made["variants"], "a line a variant"
    return made


def files() -> dict[str, str]:
    """Return the artifacts that stand in the folder, by name, as digests; each is that of the index."""
    found = {
        path.relative_to(OUT).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in OUT.glob("[!.]*/**/*")
        if path.is_file()
    }
    listed = {f"{one['folder']}/{name}": sha for one in index()["variants"] for name, sha in one["artifacts"].items()}
    assert found == listed
    return found


def heights() -> dict[str, str]:
    return {
        path.parent.name: path.read_text().split("<joint")[1].split('xyz="')[1].split('"')[0]
        for path in OUT.glob("*/mast.urdf")
    }


def table(capsys: Shown) -> dict[str, int]:
    shown = capsys.readouterr()
    rows = [line.split() for line in shown.out.splitlines()]
    return {row[0]: int(row[1]) for row in rows if len(row) == 2}


def test_each_variant_has_the_artifacts_of_its_arguments() -> None:
    sweep()
    assert files().keys() == {f"{name}/{file}" for name in ("r1", "r2", "r3") for file in ("mast.urdf", "notes.txt")}
    assert heights() == {"r1": "0.001 0 0.2", "r2": "0.001 0 0.3", "r3": "0.001 0 0.2"}
    made = index()
    assert (made["sweep"], made["description"]) == (1, "../descriptions/mast/robot.yaml")
    assert [one["arguments"] for one in made["variants"]] == [{"height": "20 cm"}, {}, {"height": "20 cm"}]
    assert {one["status"] for one in made["variants"]} == {"made"}
    assert main(["all", "mast", "height:=20 cm", "-o", "alone/mast"]) == 0
    assert (OUT / "r1/mast.urdf").read_bytes() == Path("alone/mast/mast.urdf").read_bytes()


def test_the_index_is_the_same_however_many_make_it(tmp_path: Path) -> None:
    Path("fleet.csv").write_text("name,height\n" + "".join(f"r{n},{n} cm\n" for n in range(1, 6)) + "bad,tall\n")
    sweep(code=1)
    assert main(["sweep", "mast", "--over", "fleet.csv", "-o", "build2", "-j", "2", "-q"]) == 1
    assert (tmp_path / "build2" / "sweep.json").read_bytes() == (OUT / "sweep.json").read_bytes()


def test_only_what_changed_is_made(capsys: Shown) -> None:
    sweep()
    before = (OUT / "sweep.json").stat()
    capsys.readouterr()
    sweep()
    assert table(capsys) == {"made": 0, "unchanged": 3, "errors": 0}
    after = (OUT / "sweep.json").stat()
    assert (after.st_ino, after.st_mtime_ns) == (before.st_ino, before.st_mtime_ns)
    edit(Path("fleet.csv"), "r2,", "r0,1 m\nr2,40 cm")
    sweep()
    assert table(capsys) == {"made": 2, "unchanged": 2, "errors": 0}
    assert index()["variants"][1]["name"] == "r0"
    assert heights()["r2"] == "0.001 0 0.4"
    for file in ("cal.yaml", "notes.txt.jinja", "robot.yaml"):
        path = Path("descriptions/mast", file)
        path.write_text(path.read_text().replace("2 cm", "4 cm").replace("same", "equal").replace("[1 cm", "[2 cm"))
        sweep()
        assert table(capsys) == {"made": 4, "unchanged": 0, "errors": 0}
    files()
    sweep("-a", "cal={x: 2}", code=1)  # a text is no table
    sweep()
    assert table(capsys)["unchanged"] == 4


def test_arguments_of_all_stand_back_behind_those_of_one() -> None:
    sweep("height:=1 m")
    assert heights() == {"r1": "0.001 0 0.2", "r2": "0.001 0 1", "r3": "0.001 0 0.2"}
    assert index()["arguments"] == {"height": "1 m"}


def test_a_variant_with_an_error_stops_no_other(capsys: Shown) -> None:
    sweep()
    edit(Path("fleet.csv"), "r2,", "r2,12 parrots")
    sweep(code=1)
    said = capsys.readouterr().err
    assert "fleet.csv:3:4: error[bad-argument]: r2: " in said
    assert "    3 | r2,12 parrots\n      |    ^^^^^^^^^^ of the mast\n" in said
    assert not (OUT / "r2").exists()
    wrong = index()["variants"][1]
    assert (wrong["status"], wrong["artifacts"]) == ("error", {})
    assert (wrong["diagnostics"][0]["file"], wrong["diagnostics"][0]["line"]) == ("fleet.csv", 3)
    assert files().keys() == {"r1/mast.urdf", "r1/notes.txt", "r3/mast.urdf", "r3/notes.txt"}


def test_an_error_that_a_value_of_a_variant_makes_names_both_places(capsys: Shown) -> None:
    edit(Path("descriptions/mast/robot.yaml"), '"${height}"', '"${1 * m * m / height}"')
    edit(Path("fleet.csv"), "r2,", "r2,0")
    sweep(code=1)
    said = capsys.readouterr().err
    assert "fleet.csv:3:4: error[expression]: r2: division by zero" in said, "it was given there"
    assert "descriptions/mast/robot.yaml:9:95: used here" in said


def test_a_wrong_list_is_refused_before_anything_is_made(capsys: Shown) -> None:
    Path("fleet.csv").write_text("name,hight\nr1,1\n")
    sweep(code=1)
    said = capsys.readouterr().err
    assert 'fleet.csv:1:6: error[unknown-argument]: the description has no argument "hight"; ' not in said
    assert 'fleet.csv:1:6: error[unknown-argument]: the description has no argument "hight"' in said
    assert said.endswith("fleet.csv: 1 error, nothing written\n")
    assert not OUT.exists()


def test_what_many_variants_have_is_said_once(capsys: Shown) -> None:
    edit(Path("descriptions/mast/robot.yaml"), "velocity: 1}", "velocity: 1}, source: {status: stand_in, note: old}")
    edit(Path("fleet.csv"), "r2,", "r2,tall")
    sweep(code=1)
    said = capsys.readouterr().err
    assert said.count("[stand-in]: r1 and 1 more: old") == 1
    edit(Path("fleet.csv"), "tall", "")
    sweep()
    assert "[stand-in]: r1 and 2 more: old" in capsys.readouterr().err
    assert all(one["diagnostics"][0]["rule"] == "stand-in" for one in index()["variants"])
    sweep("-q")
    assert capsys.readouterr().err == "1 stand-in: values that are not measured; without -q they are listed\n"


def test_a_program_gets_one_document(capsys: Shown) -> None:
    edit(Path("fleet.csv"), "r2,", "r2,tall")
    sweep("--format", "json", code=1)
    (told,) = json.loads(capsys.readouterr().out)["diagnostics"]
    assert (told["rule"], told["file"], told["line"], told["message"][:4]) == ("bad-argument", "fleet.csv", 3, "r2: ")


def test_a_folder_of_calibrations(capsys: Shown) -> None:
    for name, size in (("a", 3), ("b", 4)):
        path = Path("descriptions/mast/arms", f"{name}.yaml")
        path.parent.mkdir(exist_ok=True)
        path.write_text(f"cal: {{x: {size} mm}}\n")
    sweep(over="descriptions/mast/arms")
    assert heights() == {"a": "0.003 0 0.3", "b": "0.004 0 0.3"}
    Path("descriptions/mast/arms/b.yaml").write_text("kal: {x: 1}\n")
    sweep(over="descriptions/mast/arms", code=1)
    assert (
        'arms/b.yaml:1:1: error[unknown-argument]: b: the description has no argument "kal"' in capsys.readouterr().err
    )
    for name in "ab":
        Path("descriptions/mast/arms", f"{name}.yaml").write_text(f"x: {ord(name)} mm\nsize: {ord(name)} cm\n")
    sweep("--as", "cal", over="descriptions/mast/arms")
    assert heights() == {"a": "0.097 0 0.3", "b": "0.098 0 0.3"}
    sweep("--as", "table", over="descriptions/mast/arms")
    assert 'size="0.01 0.01 0.98"' in (OUT / "b/mast.urdf").read_text()
    assert main(["sweep", "mast", "--over", "descriptions/mast/arms", "-o", "x", "--as", "tabel"]) == 2
    assert 'mast has no argument "tabel"; did you mean "table"?' in capsys.readouterr().err
    assert main(["sweep", "mast", "--over", "fleet.csv", "-o", "x", "--as", "table"]) == 2


def test_a_file_that_one_variant_loads_concerns_it_alone(capsys: Shown) -> None:
    for name in ("one", "two"):
        Path(f"descriptions/mast/{name}.yaml").write_text("size: 1 cm\n")
    Path("fleet.csv").write_text("name,table\nr1,one.yaml\nr2,two.yaml\nr3,none.yaml\n")
    sweep(code=1)
    assert "error[expression]: r3: cannot read descriptions/mast/none.yaml" in capsys.readouterr().err
    Path("descriptions/mast/two.yaml").write_text("size: 7 cm\n")
    sweep(code=1)
    assert table(capsys) == {"made": 1, "unchanged": 1, "errors": 1}
    assert 'size="0.01 0.01 0.07"' in (OUT / "r2/mast.urdf").read_text()


def test_what_is_edited_is_made_anew(capsys: Shown) -> None:
    sweep()
    made = files()
    with (OUT / "r1/notes.txt").open("a") as file:
        file.write("edited in place\n")
    (OUT / "r2/mast.urdf").unlink()
    capsys.readouterr()
    sweep()
    shown = capsys.readouterr()
    assert "warning[variant-outdated]: 2 variants " in shown.err
    assert [line.split() for line in shown.out.splitlines()] == [["made", "2"], ["unchanged", "1"], ["errors", "0"]]
    assert files() == made


def test_a_damaged_record_is_made_again(capsys: Shown) -> None:
    sweep()
    made = files()
    records = sorted((OUT / ".rosorin-compile-sweep/records").iterdir())
    for record, text in zip(records, ("", "[1]", '{"key": 1}'), strict=True):
        record.write_text(text)
    capsys.readouterr()
    sweep()
    assert table(capsys) == {"made": 3, "unchanged": 0, "errors": 0}
    assert files() == made


def test_what_is_not_ours_stays(capsys: Shown) -> None:
    OUT.mkdir()
    (OUT / "notes.md").write_text("mine")
    (OUT / "r1").mkdir()
    (OUT / "r1/log.txt").write_text("mine")
    (OUT / "r2").mkdir()
    (OUT / "r2/mast.urdf").write_text("<robot name='mine'/>")
    (OUT / "r3").write_text("a file")
    sweep(code=1)
    said = capsys.readouterr().err
    assert "error[output-not-ours]: r2: this tool did not write build/r2/mast.urdf: it is not replaced" in said
    assert "error[output-in-the-way]: r3: build/r3 is not a folder" in said
    assert (OUT / "r2/mast.urdf").read_text() == "<robot name='mine'/>"
    assert [path.name for path in sorted((OUT / "r1").iterdir())] == ["log.txt", "mast.urdf", "notes.txt"]
    edit(Path("fleet.csv"), "r1,20 cm", "r1,tall")
    sweep(code=1)
    assert [path.name for path in (OUT / "r1").iterdir()] == ["log.txt"]
    Path("fleet.csv").write_text("name\nx\n")
    sweep("--prune")
    assert (OUT / "notes.md").read_text() == (OUT / "r1/log.txt").read_text() == "mine"


def test_a_variant_that_is_not_in_the_list_any_more(capsys: Shown) -> None:
    sweep()
    Path("fleet.csv").write_text("name\nr2\n")
    capsys.readouterr()
    sweep()
    said = capsys.readouterr().err
    assert "note[variant-forgotten]: 2 variants of build " in said
    assert "r1, r3" in said
    assert (OUT / "r1/mast.urdf").exists()
    sweep("--prune")
    assert "2 variants removed" in capsys.readouterr().out
    assert sorted(path.name for path in OUT.iterdir()) == [".rosorin-compile-sweep", "r2", "sweep.json"]


def test_a_second_run_into_the_folder_is_refused(capsys: Shown) -> None:
    folder = VariantsFolder(OUT)
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        with folder.hold():
            os.write(writing, b"1")
            time.sleep(60)
    try:
        os.read(reading, 1)
        sweep(code=1)
        assert "error[output-busy]: another run writes into build" in capsys.readouterr().err
    finally:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
    sweep()


def test_where_nothing_can_be_written_the_run_ends(capsys: Shown, monkeypatch: pytest.MonkeyPatch) -> None:
    count = iter(range(1000))
    replace = Path.replace

    def full(path: Path, target: Path) -> Path:
        if next(count) > 1 and str(path).startswith("build"):
            raise OSError(28, os.strerror(28), str(path))
        return replace(path, target)

    monkeypatch.setattr(Path, "replace", full)
    sweep(code=1)
    said = capsys.readouterr().err
    assert "error[output-full]: cannot write build" in said
    assert not (OUT / "sweep.json").exists()
    monkeypatch.setattr(Path, "replace", replace)
    sweep()
    assert len(files()) == 6
    assert not list(OUT.glob(".rosorin-compile-????????????????")), "what the run left behind is gone"


def test_usage(capsys: Shown) -> None:
    assert main(["sweep", "mast", "other", "--over", "fleet.csv", "-o", "x"]) == 2
    assert "sweep takes one robot, not 2" in capsys.readouterr().err
    for jobs in ("0", "-1"):
        assert main(["sweep", "mast", "--over", "fleet.csv", "-o", "x", "-j", jobs]) == 2
    assert main(["sweep", "mast", "--over", "fleet.csv", "-o", "x", "-j", "two"]) == 2
    assert main(["sweep", "mast", "--over", "none.csv", "-o", "x"]) == 1
    assert 'there is no file or folder "none.csv" of variants' in capsys.readouterr().err
    Path("file").write_text("")
    assert main(["sweep", "mast", "--over", "fleet.csv", "-o", "file"]) == 1
    assert "error[output-folder]: cannot write file" in capsys.readouterr().err


def test_a_description_with_errors_is_an_error_of_each(capsys: Shown) -> None:
    edit(Path("descriptions/mast/robot.yaml"), "parent: base_link", "parent: bas_link")
    Path("fleet.csv").write_text("name\n" + "".join(f"r{n}\n" for n in range(30)))
    sweep(code=1)
    said = capsys.readouterr().err
    assert said.count('did you mean "base_link"?') == 20
    assert "10 more variants with errors" in said
