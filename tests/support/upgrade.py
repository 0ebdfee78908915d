"""What a release compiled, kept for ever: descriptions, lists of variants, and every byte that was made of them.

    python tests/renew.py upgrade

makes the folder of this version in tests/upgrade, and refuses one that is there. Nothing in it is edited afterwards:
tests/upgrade/digests.json holds what it was.
"""

from __future__ import annotations

import fnmatch
import hashlib
import io
import json
import os
import re
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import NamedTuple

from rosorin_compile import __version__
from rosorin_compile.cli import main
from support.paths import DOCS, ROOT, TESTS

UPGRADE = TESTS / "upgrade"
DIGESTS = UPGRADE / "digests.json"
# Files on pages that are descriptions and lists: what uses the parts of the library, and a sweep with its lists.
PAGES = ("parts-library.md", "sweep.md")
SHOWN = re.compile(r"<!-- file: (\S+) -->\n```\w*\n(.*?)```", re.DOTALL)
# Lists of variants: the robot and the list.
SWEEPS = {
    "fleet": ("cart", "fleet.csv"),
    "calibrated": ("cart", "calibration"),
    "bases": ("rosorin", "bases.yaml"),
}
BASES = "held: {base: fixed}\nloose: {base: free}\n"
DEPRECATED = re.compile(r"\[deprecated[a-z-]*\]")  # the rules that may refuse what was right once

_TOOL = re.compile(rb'"tool": "[^"]*", ')
SECTION = re.compile(r"^## \[(Unreleased|\d+\.\d+\.\d+)\]", re.MULTILINE)
MOVED = re.compile(r"^- Moved: `([^`]+)` of (\d+\.\d+\.\d+): (\S.{9,})$", re.MULTILINE)


class Move(NamedTuple):
    """A line of CHANGELOG: since ``since``, files of a version (a pattern) have other bytes."""

    since: str
    files: str
    version: str
    reason: str


def moves(changelog: str) -> Iterator[Move]:
    """Yield the moves that a CHANGELOG tells, a line each, or several that are indented."""
    _, *rest = SECTION.split(changelog)
    for since, text in zip(rest[::2], rest[1::2], strict=True):
        for files, version, reason in MOVED.findall(re.sub(r"\n  +", " ", text)):
            yield Move(since, files, version, reason)


def judged(version: str, kept: Mapping[str, bytes], made: Mapping[str, bytes], changelog: str) -> list[str]:
    """Return what is wrong with the artifacts that are made now of what a version kept, by relative name."""
    told = [move for move in moves(changelog) if move.version == version]
    wrong = [f"{move.files}: {move.since} is a patch release, which moves no byte" for move in told if _in_patch(move)]
    moved = sorted(name for name in {*kept, *made} if kept.get(name) != made.get(name))
    for name in moved:
        if not any(fnmatch.fnmatchcase(name, move.files) for move in told):
            wrong.append(f"{name} is not as {version} made it: CHANGELOG says no `- Moved: `{name}` of {version}: WHY`")
    for move in told:
        if not fnmatch.filter(moved, move.files):
            wrong.append(f"{move.files} is as {version} made it: CHANGELOG says that it moved")
    return wrong


def _in_patch(move: Move) -> bool:
    return move.since != "Unreleased" and not move.since.endswith(".0")


def files(folder: Path) -> dict[str, bytes]:
    """Return the bytes of all files below a folder by relative POSIX name."""
    found = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in found}


def digest(folder: Path) -> str:
    """Return what tells a folder from any other one."""
    made = hashlib.sha256()
    for name, data in files(folder).items():
        made.update(f"{name} {hashlib.sha256(data).hexdigest()}\n".encode())
    return made.hexdigest()


def gather(project: Path) -> None:
    """Bring the robots of the repository, the examples, what uses the parts, and lists of variants into a project."""
    for folder in sorted([*(ROOT / "descriptions").iterdir(), *(ROOT / "examples").iterdir()]):
        if (folder / "robot.yaml").is_file():
            shutil.copytree(folder, project / "descriptions" / folder.name, ignore=shutil.ignore_patterns("xacro"))
    for page in PAGES:
        for name, text in SHOWN.findall((DOCS / page).read_text("utf-8")):
            place = project / name
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_text(text, "utf-8", newline="\n")
    (project / "bases.yaml").write_text(BASES, "utf-8", newline="\n")


def compile_all(project: Path) -> tuple[dict[str, bytes], list[str]]:
    """Compile what stands in a project, variants too; return what was made, and what was refused with other words."""
    names = sorted(path.parent.name for path in (project / "descriptions").glob("*/robot.yaml"))
    sweeps = [
        ["sweep", robot, "--over", over, "-o", f"outputs/{name}", "-j", "1", "-q"]
        for name, (robot, over) in SWEEPS.items()
        if (project / over).exists()
    ]
    before, refused = Path.cwd(), []
    os.chdir(project)
    try:
        for words in [*(["all", name, "-q"] for name in names), *sweeps]:
            code, said = _asked(words)
            if code != 0 and not DEPRECATED.search(said):
                refused.append(f"{' '.join(words)}: exit code {code}\n{said[-2000:]}")
    finally:
        os.chdir(before)
    # Of variants the index is enough, which has the digest of each artifact; but for the version that wrote it.
    made = {
        name: data
        for name, data in files(project / "outputs").items()
        if not name.startswith(tuple(f"{one}/" for one in SWEEPS))
    }
    for name in SWEEPS:
        index = project / "outputs" / name / "sweep.json"
        made[f"{name}.json"] = _TOOL.sub(b"", index.read_bytes()) if index.exists() else b""
    return made, refused


def _asked(words: list[str]) -> tuple[int, str]:
    with redirect_stdout(io.StringIO()) as said, redirect_stderr(said):
        return main(words), said.getvalue()


def renew() -> None:
    """Make the folder of the version that this is. Raises SystemExit if there is one."""
    target = UPGRADE / __version__
    if target.exists():
        raise SystemExit(f"{target} is there: what a version compiled is never edited")
    with tempfile.TemporaryDirectory() as folder:
        project = Path(folder, __version__)
        gather(project)
        made, refused = compile_all(project)
        if refused:
            raise SystemExit("\n".join(refused))
        shutil.rmtree(project / "outputs")
        for name, data in made.items():
            (project / "outputs" / name).parent.mkdir(parents=True, exist_ok=True)
            (project / "outputs" / name).write_bytes(data)
        UPGRADE.mkdir(exist_ok=True)
        shutil.copytree(project, target)
    known = json.loads(DIGESTS.read_text("utf-8")) if DIGESTS.exists() else {}
    DIGESTS.write_text(json.dumps(known | {__version__: digest(target)}, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    renew()
