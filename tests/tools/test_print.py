"""``print``: one artifact on standard output, the same bytes as ``all`` writes, and nothing else anywhere."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from support.commands import Shown
from support.paths import OUTPUTS, ROOT, ROSORIN
from support.projects import foreign, meshes, packaged, ur5e

PROGRAM = [sys.executable, "-m", "rosorin_compile"]


def run(*words: str, cwd: Path = ROOT, **environment: str) -> subprocess.CompletedProcess[bytes]:
    variables = {**os.environ, "ROSORIN_COMPILE_CACHE": "off", **environment}
    return subprocess.run([*PROGRAM, *words], capture_output=True, cwd=cwd, env=variables, check=False)


def printed(*words: str, cwd: Path = ROOT, **environment: str) -> bytes:
    done = run("print", *words, cwd=cwd, **environment)
    assert (done.returncode, done.stderr) == (0, b"")
    return done.stdout


def test_neither_locale_nor_folder_nor_buffering_changes_a_byte(tmp_path: Path) -> None:
    (tmp_path / "größe.yaml").write_text('robot: "größe"\nlinks: {"bäse": {}}\n', "utf-8")
    plain = printed(str(tmp_path / "größe.yaml"), "urdf")
    assert plain.decode("utf-8").count("größe") == 2
    assert plain.endswith(b"</robot>\n")
    ascii_only = {
        "LC_ALL": "C",
        "LANG": "C",
        "PYTHONIOENCODING": "ascii",
        "PYTHONUTF8": "0",
        "PYTHONCOERCECLOCALE": "0",
    }
    for environment in (ascii_only, {"PYTHONUNBUFFERED": "1"}, {"FORCE_COLOR": "1"}):
        assert printed("größe.yaml", "urdf", cwd=tmp_path, **environment) == plain


def test_a_read_only_install_space_is_enough(tmp_path: Path) -> None:
    share = tmp_path / "share" / "arm_description" / "descriptions" / "rosorin"
    shutil.copytree(ROSORIN.parent, share)
    folders = [share, *share.parents[:3]]
    for path in [*share.iterdir(), *folders]:
        path.chmod(0o555 if path.is_dir() else 0o444)
    (tmp_path / "elsewhere").mkdir()
    try:
        made = printed(str(share / "robot.yaml"), "urdf", cwd=tmp_path / "elsewhere")
    finally:
        for path in folders:
            path.chmod(0o755)
    assert made == (OUTPUTS / "rosorin.urdf").read_bytes()
    assert sorted(path.name for path in share.iterdir()) == sorted(path.name for path in ROSORIN.parent.iterdir())
    assert list((tmp_path / "elsewhere").iterdir()) == []


def test_what_cannot_be_printed_in_full_is_a_problem(tmp_path: Path) -> None:
    said = b"rosorin-compile: cannot write to standard output: "
    command = f"exec {' '.join(PROGRAM)} print rosorin urdf"
    for script, why in (
        (f"ulimit -f 4; {command} > {tmp_path / 'cut.urdf'}", b"File too large\n"),
        (f"{command} >&-", b"it is closed\n"),
    ):
        done = subprocess.run(["bash", "-c", script], capture_output=True, cwd=ROOT, check=False)
        assert (done.returncode, done.stderr) == (1, said + why)


@pytest.mark.parametrize("make", [ur5e, packaged, foreign, meshes])
def test_each_output_is_what_all_writes(make: Callable[[], None], home: Path, capfdbinary: Shown) -> None:
    """Also where meshes are found, converted, or missing, and before any of them is copied."""
    make()
    more = ["--package", "p=p", "-a", "x=2"] if make is meshes else []
    listed = json.loads(print_bytes(capfdbinary, "--list", "--format", "json", *more))["result"]
    alone = {entry["file"]: print_bytes(capfdbinary, entry["name"], *more) for entry in listed}
    assert main(["all", "r", "-q", *more]) == 0
    capfdbinary.readouterr()
    folder = home / "outputs" / "r"
    assert alone == {file: (folder / file).read_bytes() for file in alone}
    assert alone == {entry["file"]: print_bytes(capfdbinary, entry["name"], *more) for entry in listed}


def print_bytes(capfdbinary: Shown, *words: str) -> bytes:
    assert main(["print", "r", *words]) == 0
    out, err = capfdbinary.readouterr()
    assert err == b""
    return bytes(out)
