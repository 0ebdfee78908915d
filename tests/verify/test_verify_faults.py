"""verify finds each fault that is planted in a recording by its name, no other, and none in a clean one."""

import io
import re
import tempfile
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.recordings.results import Verified
from rosorin_compile.source.diagnostics import text as report
from support import bags
from support.bag_faults import FAULTS, gripper_of_its_own
from support.bags import judged, rules
from support.paths import DATA, DOCS, ROOT


def test_joint_states_may_come_from_several_nodes(tmp_path: Path) -> None:
    verdict = judged(bags.bag(tmp_path / "bag", change=gripper_of_its_own))
    assert verdict.findings == ()
    assert verdict.sensors[0].count == 120 + 300


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_a_clean_recording_has_no_finding(tmp_path: Path, storage: str) -> None:
    verdict = judged(bags.bag(tmp_path / "bag", storage))
    assert verdict.findings == ()
    compared = {edge.name: edge for edge in verdict.edges}
    assert compared["link1 -> link2"].by_state == 120
    assert compared["base_link -> laser"].compared == 1
    assert all(not values.wrong for values in compared.values())
    assert len(verdict.edges) == 15


SAID = DATA / "recordings" / "findings.txt"


def said(name: str, verdict: Verified) -> str:
    return f"{name}\n{report(verdict.diagnostics)}"


@pytest.mark.slow
@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_is_found_and_no_other(tmp_path: Path, name: str) -> None:
    scene, expected = FAULTS[name]
    verdict = judged(bags.bag(tmp_path / "bag", "mcap" if len(name) % 2 else "sqlite3", **scene))
    assert rules(verdict) == expected, [finding.message for finding in verdict.findings]
    paragraphs = {text.splitlines()[0]: text for text in SAID.read_text("utf-8").split("\n\n")}
    assert said(name, verdict).rstrip() == paragraphs[name].rstrip()


def test_each_paragraph_is_that_of_a_fault() -> None:
    assert [text.splitlines()[0] for text in SAID.read_text("utf-8").split("\n\n")] == list(FAULTS)


PAGE = DOCS / "recordings.md"
SHOWN = re.compile(r"(<!-- verify: stale -->\n```text\n)(.*?)(```\n)", re.DOTALL)


def printed(folder: Path) -> str:
    """Return what the page shows: a command and what it prints, in the folder of the repository."""
    scene, _ = FAULTS["localisation stops for ten seconds"]
    bags.bag(folder / "first_drive", **scene)
    terminal = io.StringIO()
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(terminal), redirect_stderr(terminal):
        patch.chdir(ROOT)
        assert main(["verify", "rosorin", str(folder / "first_drive")]) == 1
    return f"$ rosorin-compile verify first_drive\n{terminal.getvalue()}"


def test_the_page_shows_what_is_printed(tmp_path: Path) -> None:
    shown = SHOWN.search(PAGE.read_text("utf-8"))
    assert shown is not None
    assert shown[2] == printed(tmp_path)


if __name__ == "__main__":  # writes what the findings say now
    paragraphs = []
    with tempfile.TemporaryDirectory() as folder:
        for number, (fault, (scene, _)) in enumerate(FAULTS.items()):
            paragraphs.append(said(fault, judged(bags.bag(Path(folder, str(number)), **scene))).rstrip())
        text = printed(Path(folder))
    SAID.write_text("\n\n".join(paragraphs) + "\n", "utf-8")
    PAGE.write_text(SHOWN.sub(lambda found: found[1] + text + found[3], PAGE.read_text("utf-8")), "utf-8")
