"""sweep: its artifacts are those of ``all``, its index is that of any number of jobs, and a failed run damages nothing.

What it prints and keeps in its folder: commands/sweep.md.
"""

import json
import os
import signal
import time
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.variants.folder import VariantsFolder
from support.commands import Shown
from support.paths import data_text

PROJECT = {
    "descriptions/mast/robot.yaml": data_text("robots/sweep.yaml"),
    "descriptions/mast/cal.yaml": "size: 2 cm\n",
    "descriptions/mast/notes.txt.jinja": "the same for all\n",
    "fleet.csv": "name,height\nr1,20 cm\nr2,\nr3,20 cm\n",
}
OUT = Path("build")
pytestmark = pytest.mark.usefixtures("project")


def sweep(*words: str, code: int = 0) -> Any:
    """Run sweep; return its index, which has one line for each variant."""
    assert main(["sweep", "mast", "--over", "fleet.csv", "-o", str(OUT), *words]) == code
    if not (OUT / "sweep.json").exists():
        return None
    text = (OUT / "sweep.json").read_text()
    made = json.loads(text)
    assert [json.loads(line.removesuffix(",")) for line in text.splitlines()[1:-1]] == made["variants"]
    return made


def test_each_variant_has_the_artifacts_of_its_arguments() -> None:
    made = sweep("-j", "1")
    assert (made["sweep"], made["description"]) == (1, "../descriptions/mast/robot.yaml")
    assert [one["arguments"] for one in made["variants"]] == [{"height": "20 cm"}, {}, {"height": "20 cm"}]
    for name, arguments in (("r1", ["height:=20 cm"]), ("r2", [])):
        assert main(["all", "mast", *arguments, "-o", f"alone/{name}"]) == 0
        alone = {path.name: path.read_bytes() for path in Path("alone", name).iterdir()}
        assert {path.name: path.read_bytes() for path in (OUT / name).iterdir()} == alone


def test_the_index_is_the_same_however_many_make_it() -> None:
    Path("fleet.csv").write_text("name,height\n" + "".join(f"r{n},{n} cm\n" for n in range(1, 6)) + "bad,tall\n")
    sweep("-j", "1", code=1)
    before = (OUT / "sweep.json").read_bytes()
    OUT.rename("before")
    sweep("-j", "2", "-q", code=1)
    assert (OUT / "sweep.json").read_bytes() == before


def test_a_second_run_into_the_folder_is_refused(capsys: Shown) -> None:
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        with VariantsFolder(OUT).hold():
            os.write(writing, b"1")
            time.sleep(60)
    try:
        os.read(reading, 1)
        sweep("-j", "1", code=1)
        assert "error[output-busy]: another run writes into build" in capsys.readouterr().err
    finally:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
    sweep("-j", "1")


def test_where_nothing_can_be_written_the_run_ends(capsys: Shown, monkeypatch: pytest.MonkeyPatch) -> None:
    count = iter(range(1000))
    replace = Path.replace

    def full(path: Path, target: Path) -> Path:
        if next(count) > 1 and str(path).startswith("build"):
            raise OSError(28, os.strerror(28), str(path))
        return replace(path, target)

    monkeypatch.setattr(Path, "replace", full)
    assert sweep("-j", "1", code=1) is None
    assert "error[output-full]: cannot write build" in capsys.readouterr().err
    monkeypatch.setattr(Path, "replace", replace)
    assert len(sweep("-j", "1")["variants"]) == 3
    assert len([path for path in OUT.glob("r?/*") if path.is_file()]) == 6
    assert not list(OUT.glob(".rosorin-compile-????????????????")), "what the run left behind is gone"
