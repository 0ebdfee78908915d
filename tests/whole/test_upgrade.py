"""What a release compiled, every later one compiles to the same bytes, or CHANGELOG says which moved and why.

``python tests/renew.py upgrade`` makes the folder of a release (``support/upgrade.py``), once.
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from rosorin_compile import __version__
from support import upgrade
from support.paths import ROOT
from support.upgrade import DIGESTS, UPGRADE, compile_all, digest, files, judged, moves

CHANGELOG = (ROOT / "CHANGELOG.md").read_text("utf-8")
VERSIONS = sorted(path.name for path in UPGRADE.glob("*.*.*"))


def test_what_a_release_kept_is_not_edited() -> None:
    known = json.loads(DIGESTS.read_text("utf-8")) if DIGESTS.exists() else {}
    assert {version: digest(UPGRADE / version) for version in VERSIONS} == known


@pytest.mark.slow
@pytest.mark.parametrize("version", VERSIONS)
def test_what_a_release_compiled_still_comes_out(version: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", str(tmp_path / "cache"))
    kept = files(UPGRADE / version / "outputs")
    project = tmp_path / version
    shutil.copytree(UPGRADE / version, project, ignore=shutil.ignore_patterns("outputs"))
    made, refused = compile_all(project)
    assert refused == [], "a word of a release is refused without a `deprecated-...` rule that says so"
    assert kept
    assert judged(version, kept, made, CHANGELOG) == []


def test_the_moves_that_changelog_tells_are_of_versions_that_are_kept() -> None:
    assert {move.version for move in moves(CHANGELOG)} <= set(VERSIONS)


KEPT = {"bot/bot.urdf": b"<robot/>", "bot/bot.xml": b"<mujoco/>"}
MOVED = {**KEPT, "bot/bot.xml": b"<mujoco model='bot'/>"}
LINE = "- Moved: `bot/*.xml` of 1.2.0: the name of the model\n  stands in it"
TOLD = "bot/bot.xml is not as 1.2.0 made it: CHANGELOG says no `- Moved: `bot/bot.xml` of 1.2.0: WHY`"


@pytest.mark.parametrize(
    ("made", "changelog", "wrong"),
    [
        (KEPT, "## [Unreleased]\n", []),
        (MOVED, "## [Unreleased]\n", [TOLD]),
        (MOVED, f"## [Unreleased]\n{LINE}\n", []),
        (MOVED, f"## [Unreleased]\n## [1.3.0] - 2027-01-01\n{LINE}\n", []),
        (MOVED, f"## [1.2.1] - 2027-01-01\n{LINE}\n", ["bot/*.xml: 1.2.1 is a patch release, which moves no byte"]),
        (MOVED, f"## [Unreleased]\n{LINE.replace('1.2.0', '1.1.0')}\n", [TOLD]),
        (MOVED, f"## [Unreleased]\n{LINE.partition(': the')[0]}: why\n", [TOLD]),
        (KEPT, f"## [Unreleased]\n{LINE}\n", ["bot/*.xml is as 1.2.0 made it: CHANGELOG says that it moved"]),
        ({"bot/bot.urdf": b"<robot/>"}, "## [Unreleased]\n", [TOLD]),
        ({**KEPT, "bot/bot.xml.1": b""}, "## [Unreleased]\n", [TOLD.replace("bot/bot.xml", "bot/bot.xml.1")]),
    ],
    ids=["same", "moved", "told", "told-later", "patch", "of-another", "no-reason", "stale", "gone", "new"],
)
def test_a_byte_moves_with_a_line_alone(made: dict[str, bytes], changelog: str, wrong: list[str]) -> None:
    assert judged("1.2.0", KEPT, made, changelog) == wrong


@pytest.mark.slow
def test_a_release_is_kept_once_and_what_moves_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def gather(project: Path) -> None:
        (project / "descriptions" / "cart").mkdir(parents=True)
        robot = "robot: cart\nargs: {mast: 0.1}\nlinks: {base_link: {}}\noutputs: {urdf: {file: cart.urdf}}\n"
        (project / "descriptions" / "cart" / "robot.yaml").write_text(robot)
        (project / "fleet.csv").write_text("name\nr1\n")

    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(upgrade, "UPGRADE", tmp_path / "upgrade")
    monkeypatch.setattr(upgrade, "DIGESTS", tmp_path / "upgrade" / "digests.json")
    monkeypatch.setattr(upgrade, "SWEEPS", {"fleet": ("cart", "fleet.csv")})
    monkeypatch.setattr(upgrade, "gather", gather)
    upgrade.renew()
    folder = tmp_path / "upgrade" / __version__
    assert json.loads(upgrade.DIGESTS.read_text()) == {__version__: digest(folder)}
    assert sorted(files(folder / "outputs")) == ["cart/cart.urdf", "fleet.json"]
    with pytest.raises(SystemExit, match="is never edited"):
        upgrade.renew()
    robot = folder / "descriptions" / "cart" / "robot.yaml"
    robot.write_text(robot.read_text().replace("base_link", "base"))
    assert json.loads(upgrade.DIGESTS.read_text()) != {__version__: digest(folder)}
    made, refused = compile_all(folder)
    assert refused == []
    wrong = judged(__version__, {"cart/cart.urdf": b"", "fleet.json": made["fleet.json"]}, made, "")
    assert [line.partition(" ")[0] for line in wrong] == ["cart/cart.urdf"]
    robot.write_text("robot: cart\nlinkz: {}\n")
    assert "unknown-key" in compile_all(folder)[1][0]
