"""Commands that are ended before a call that changes a file: old or new, as a whole, or ``check deployed`` reports it.

``.ci/full kills`` ends each command before every such call; a few of them are in every run.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from typing import NamedTuple

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.output.package_folder import MANIFEST
from rosorin_compile.ros.package.deploy import unfinished_runs
from rosorin_compile.ros.package.package_files import files_below
from support import kills
from support.commands import write_files
from support.paths import data_text

MAST = data_text("robots/kills_mast.yaml")
PROJECT = {
    "descriptions/a/robot.yaml": MAST.replace("NAME", "a"),
    "descriptions/b/robot.yaml": MAST.replace("NAME", "b"),
    "pkg/package.xml": "<package format='3'><name>pkg</name></package>\n",
    "one.csv": "name,height\nr0,1 m\nr1,2 m\n",
    "old/r.urdf": "<robot name='r'><link name='base'/></robot>\n",
    "new/r.urdf": "<robot name='r'><link name='base'/><link name='a'/>"
    "<joint name='j' type='fixed'><parent link='base'/><child link='a'/></joint></robot>\n",
    "other.csv": "name,height\nr1,3 m\nr2,2 m\n",
}
EDIT = "\n<!-- an hour of work -->\n"
TALL = ["-a", "height=2 m"]
PACKAGE = ["package", "a", "-o", "out/a_description", "--maintainer", "A <a@b.org>", "--license", "MIT"]
SWEEP = ["sweep", "a", "-o", "out", "-j", "1", "--over"]


class Case(NamedTuple):
    """A command that is ended, what was run before it, and what of its files belongs together.

    ``at_once``: what belongs together is old or new even before the next run. ``edited`` is a file that somebody edits
    after the kill, ``other`` a command that comes then, of which that file is none. ``depth``: how many folders deep it
    begins to belong together.
    """

    words: list[str]
    before: tuple[list[str], ...] = ()
    at_once: bool = True
    edited: str = ""
    other: tuple[str, ...] = ()
    depth: int = 2


DEPLOY_B = ("deploy", "b", "-o", "pkg")
CASES = {
    "all": Case(["all", "a", *TALL], (["all", "a"],), edited="outputs/a/notes.txt", other=("all", "b")),
    "all, first": Case(["all", "a"]),
    "deploy": Case(
        ["deploy", "a", "-o", "pkg", *TALL], (["deploy", "a", "-o", "pkg"],), False, "pkg/urdf/a.urdf", DEPLOY_B, 1
    ),
    "deploy, first": Case(["deploy", "a", "-o", "pkg"], (), False, "pkg/config/a_tf.json", DEPLOY_B, 1),
    "package": Case(
        [*PACKAGE, *TALL],
        (PACKAGE,),
        False,
        "out/a_description/urdf/a.urdf",
        ("deploy", "b", "-o", "out/a_description"),
    ),
    "package, first": Case(PACKAGE, (), True, "out/a_description/urdf/a.urdf", ("deploy", "b", "-o", "pkg")),
    "sweep": Case([*SWEEP, "other.csv"], ([*SWEEP, "one.csv"],)),
    "sweep --prune": Case([*SWEEP, "other.csv", "--prune"], ([*SWEEP, "one.csv"],)),
    "print -o": Case(["print", "a", "urdf", "-o", "out/a.urdf", *TALL], (["print", "a", "urdf", "-o", "out/a.urdf"],)),
    "view --html": Case(["view", "a", "--html", "out/a.html", *TALL], (["view", "a", "--html", "out/a.html"],)),
    "check --html": Case(["check", "a", "--html", "out/a.html", *TALL], (["all", "a"],)),
    "picture -o": Case(["picture", "a", "-o", "out/a.png", "--size", "64x64"]),
    "collisions -o": Case(["collisions", "a", "-o", "out/a.yaml"]),
    "import, again": Case(["import", "new/r.urdf", "-o", "out/r"], (["import", "old/r.urdf", "-o", "out/r"],)),
    "all --depfile": Case(["all", "a", *TALL, "--depfile", "out/a.d"], (["all", "a", "--depfile", "out/a.d"],)),
}
_STAGE = re.compile(r"\.rosorin-compile-[0-9a-f]{16}")


@pytest.fixture(autouse=True)
def _possible() -> None:
    if kills.missing():
        pytest.skip(kills.missing())


def seen(home: Path) -> dict[str, bytes]:
    """Return the files of the project, but for notes that name where Python looks for modules: here that is not one."""
    found = {path.relative_to(home).as_posix(): path.read_bytes() for path in home.rglob("*") if path.is_file()}
    return {name: data for name, data in found.items() if "/records/" not in name}


def shown(files: dict[str, bytes], depth: int) -> dict[str, dict[str, bytes]]:
    groups: dict[str, dict[str, bytes]] = {}
    for name, data in files.items():
        if "/." not in f"/{name}":
            parts = name.split("/")
            groups.setdefault("/".join(parts[:-1][:depth]) or name, {})[name] = data
    return groups


class Scene:
    def __init__(self, folder: Path, case: Case) -> None:
        self.home, self.origin, self.case = folder / "home", folder / "origin", case
        self.kills = self.mixed = self.edits = 0

    def begin(self, monkeypatch: pytest.MonkeyPatch) -> list[kills.Call]:
        """Make what is there before, and run the command once; return its calls that change a file."""
        write_files(self.home, PROJECT)
        (self.home / "out").mkdir()
        monkeypatch.chdir(self.home)
        for words in self.case.before:
            main(words)
        if self.case.other[:1] == ("all",):
            Path(self.case.edited).write_text("mine\n")
        subprocess.run(["cp", "-a", self.home, self.origin], check=True)
        self.old = seen(self.home)
        for _ in range(2):  # the first one may have modules to compile, which are calls, too
            found = kills.calls(self.home, self.home, self.case.words)
            self.again()
        self.code = main(self.case.words)
        self.new = seen(self.home)
        assert self.new != self.old
        return found

    def again(self) -> None:
        for path in self.home.iterdir():
            shutil.rmtree(path) if path.is_dir() else path.unlink()
        subprocess.run(["cp", "-a", f"{self.origin}/.", self.home], check=True)

    def kill(self, call: kills.Call) -> None:
        self.again()
        assert kills.killed(self.home, self.case.words, call), call
        self.kills += 1

    def check(self, call: kills.Call) -> None:
        """End the command before a call; then it is run again, in peace."""
        self.kill(call)
        found, old, new = (shown(files, self.case.depth) for files in (seen(self.home), self.old, self.new))
        mixed = [name for name, files in found.items() if files not in (old.get(name, {}), new.get(name, {}))]
        if mixed and not self.case.at_once:
            packages = [path.parent for path in self.home.rglob(MANIFEST)]
            reported = [one for path in packages for one in unfinished_runs(path, files_below(path, skip_built=False))]
            assert reported, (call, mixed, "and check deployed does not report it")
            everything = {**self.old, **self.new}
            for name, data in ((name, data) for files in found.values() for name, data in files.items()):
                assert data in (self.old.get(name), self.new.get(name)), (call, name)
                assert name in everything
            mixed = []
            self.mixed += 1
        assert not mixed, (call, mixed)
        assert main(self.case.words) == self.code
        after = seen(self.home)
        assert sorted(after) == sorted(self.new), call
        assert shown(after, 1) == shown(self.new, 1), call
        assert not [path for path in self.home.rglob(".*") if _STAGE.fullmatch(path.name)], call

    def check_edit(self, call: kills.Call) -> None:
        """End the command before a call; then somebody edits a file, and another command runs, and this one again."""
        self.kill(call)
        file = self.home / self.case.edited
        if not file.is_file():
            return
        file.write_text(file.read_text() + EDIT)
        edited = file.read_bytes()
        self.edits += 1
        for words in (list(self.case.other), self.case.words):
            main(words)
            assert edited in seen(self.home).values(), (call, words)
        assert not [path for path in self.home.rglob(".*") if _STAGE.fullmatch(path.name)], call


def run(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch, only: str = "", step: int = 1) -> Scene:
    """End a command before every ``step``-th of its calls; with ``only`` before those whose name begins so."""
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", "off")
    scene = Scene(folder, CASES[name])
    found = scene.begin(monkeypatch)
    assert len(found) >= 3, found
    for call in [call for call in found if call.name.startswith(only)][::step]:
        scene.check(call)
        if scene.case.edited:
            scene.check_edit(call)
    return scene


# Of commands whose kills are alike one at a landing, the other with all of them.
SOME = [
    ("deploy", "rename"),
    ("import, again", ""),  # one rename exchanges the folders
    pytest.param("sweep --prune", "rename", marks=pytest.mark.tier("builds")),
    ("print -o", ""),
]


@pytest.mark.landing("builds", "print -o-")
@pytest.mark.slow
@pytest.mark.parametrize(("name", "only"), SOME)
def test_some_kills(name: str, only: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert run(name, tmp_path, monkeypatch, only).kills >= 3


@pytest.mark.slow
@pytest.mark.tier("builds")
@pytest.mark.parametrize("name", CASES)
def test_kills_spread_over_a_run(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    scene = run(name, tmp_path, monkeypatch, step=3)
    with capfd.disabled():
        print(f"\n{name}: {scene.kills} kills, {scene.mixed} mixed, {scene.edits} edits")
    if not scene.case.at_once:
        assert scene.mixed
