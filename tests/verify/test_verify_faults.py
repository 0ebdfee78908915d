"""verify reports each fault of a recording by its name and no other, and nothing about the habits of real robots."""

import io
import re
import tempfile
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.recordings.results import Verification, table
from rosorin_compile.source.diagnostics import text as report
from support import bags
from support.bag_faults import CHANCE, SCENES, by, node, simulated
from support.bags import judged, rules
from support.paths import DATA, DOCS, ROOT

SAID = DATA / "recordings" / "findings.txt"
PAGE = DOCS / "recordings.md"
SHOWN = re.compile(r"(<!-- verify: stale -->\n```text\n)(.*?)(```\n)", re.DOTALL)


def verified(folder: Path, name: str) -> Verification:
    CHANCE.seed(name)
    return judged(bags.bag(folder, "mcap" if len(name) % 2 else "sqlite3", **SCENES[name]))


def said(name: str, verdict: Verification) -> str:
    return f"{name}\n{report(verdict.diagnostics) or 'no finding'}".rstrip()


def paragraphs() -> dict[str, str]:
    return {text.splitlines()[0]: text.rstrip() for text in SAID.read_text("utf-8").split("\n\n")}


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_the_findings_of_each_scene(tmp_path: Path, name: str) -> None:
    assert said(name, verified(tmp_path / "bag", name)) == paragraphs()[name]


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_a_clean_recording_has_no_finding(tmp_path: Path, storage: str) -> None:
    verdict = judged(bags.bag(tmp_path / "bag", storage))
    assert verdict.findings == ()
    compared = {edge.name: edge for edge in verdict.edges}
    assert compared["link1 -> link2"].by_state == 120
    assert compared["base_link -> laser"].compared == 1
    assert all(not values.wrong for values in compared.values())
    assert len(verdict.edges) == 15


@pytest.mark.slow
def test_messages_of_all_nodes_are_counted(tmp_path: Path) -> None:
    assert verified(tmp_path / "bag", "a gripper that reports by itself").sensors[0].count == 120 + 300


@pytest.mark.slow
def test_a_slow_simulation_is_as_old_as_its_own_clock_says(tmp_path: Path) -> None:
    """Ages and times are those of the simulation: the same as of a robot that is not simulated."""
    real = judged(bags.bag(tmp_path / "real"))
    slow = judged(bags.bag(tmp_path / "slow", change=simulated(0.25)))
    for key, series in real.data.series.items():
        if not series.static:
            pace = slow.data.series[key].pace
            assert pace.mean_age == pytest.approx(series.pace.mean_age, abs=0.006)
            assert pace.gap.seconds == pytest.approx(series.pace.gap.seconds, abs=0.012)
            assert pace.rate == pytest.approx(series.pace.rate, rel=0.01)


@pytest.mark.slow
def test_the_table_shows_how_far_ahead_an_edge_is_dated(tmp_path: Path) -> None:
    def change(messages: list[bags.Message]) -> list[bags.Message]:
        for names, stamp in (({"link1"}, lambda _: 0), ({"base_link"}, by(3600.0)), ({"odom"}, by(1.0))):
            messages = node(names, stamp)(messages)
        return messages

    rows = table(judged(bags.bag(tmp_path / "bag", change=change)))
    at = rows[0].index("age, oldest"), rows[0].index("value")
    ages = {row.split("  ")[0]: row[at[0] : at[1]].strip() for row in rows[1:16]}
    assert ages["map -> odom"] == "998 ms ahead, 0.0 ms"
    assert ages["odom -> base_link"] == "3600.0 s ahead: another clock"
    assert ages["base_link -> link1"] == "no stamp"


def test_warnings_fail_with_strict(tmp_path: Path) -> None:
    bag = str(bags.bag(tmp_path / "bag", seconds=2.0, joint_offset={"joint1": 2.0}))
    command = ["verify", str(ROOT / "descriptions" / "rosorin"), bag]
    assert (main(command), main([*command, "--strict"])) == (0, 1)
    assert rules(judged(bag)) == ["joint-beyond-limit"]


def printed(folder: Path) -> str:
    """Return what the page shows: a command and what it prints, in the folder of the repository."""
    bags.bag(folder / "first_drive", **SCENES["localisation stops for ten seconds"])
    terminal = io.StringIO()
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(terminal), redirect_stderr(terminal):
        patch.chdir(ROOT)
        assert main(["verify", "rosorin", str(folder / "first_drive")]) == 1
    return f"$ rosorin-compile verify first_drive\n{terminal.getvalue()}"


def test_the_page_shows_what_is_printed(tmp_path: Path) -> None:
    shown = SHOWN.search(PAGE.read_text("utf-8"))
    assert shown is not None
    assert shown[2] == printed(tmp_path)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        texts = [said(name, verified(Path(folder, str(number)), name)) for number, name in enumerate(SCENES)]
        text = printed(Path(folder))
    SAID.write_text("\n\n".join(texts) + "\n", "utf-8")
    PAGE.write_text(SHOWN.sub(lambda found: found[1] + text + found[3], PAGE.read_text("utf-8")), "utf-8")
