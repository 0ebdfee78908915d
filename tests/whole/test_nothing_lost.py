"""No command replaces a file of somebody else in silence, and what a kill leaves is gone after the next run."""

import subprocess
import sys
from pathlib import Path

import pytest

from rosorin_compile.output.artifact_set import write_artifacts
from support.kills import at_each_step

BY_HAND = "# written by hand\n"


def hidden(folder: Path) -> list[str]:
    return [path.name for path in folder.rglob(".rosorin*")]


def test_what_a_living_run_prepares_is_not_removed(home: Path) -> None:
    from rosorin_compile.output.atomic_files import lock, staging_folder

    with lock(home), staging_folder(home) as folder:
        program = "from rosorin_compile.output.atomic_files import *; write_file(Path('a.txt'), b'')"
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
