"""Two judges that are not ours look at every URDF and MJCF that is compiled here: simcheck and mjcf-doctor.

Each of their remarks, notes too, is answered in tests/data/judges.yaml, with the reason why it stays. A remark without
an answer fails, and so does an answer without a remark. They say other things in other versions: .ci/run makes an
environment with those below, and names it in JUDGES.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Iterator
from fnmatch import fnmatch
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import pytest
import yaml

from support.paths import DATA, ROOT, ROSORIN
from support.robots import compiled

VERSIONS = {"simcheck": "0.2.0", "mjcf-doctor": "0.2.1"}
ANSWERS = yaml.safe_load((DATA / "judges.yaml").read_text("utf-8"))
ROBOTS = [ROSORIN, *sorted((ROOT / "examples").glob("*/robot.yaml"))]
FOLDER = os.environ.get("JUDGES", "")
ENDINGS = (".urdf", ".xml")

needs_judges = pytest.mark.skipif(
    not FOLDER and not os.environ.get("CI"), reason="JUDGES is not the bin folder of an environment with both judges"
)


class Remark(NamedTuple):
    """What a judge says of a file (its path, then its name); ``of`` are the names that it says it of."""

    judge: str
    file: str
    check: str
    severity: str
    of: frozenset[str]
    text: str


def ask(judge: str, *words: str | Path) -> str:
    ran = subprocess.run(
        [Path(FOLDER, judge), *words], capture_output=True, text=True, check=False, env={**os.environ, "NO_COLOR": "1"}
    )
    assert ran.returncode in (0, 1), ran.stderr
    return ran.stdout


def by_simcheck(*paths: Path) -> Iterator[Remark]:
    """Yield what simcheck says of files, which are called by their paths; it takes seconds to start."""
    words = ["--engines", "mujoco", "--no-config", "--format", "json", "--jobs", "1"]
    reports = json.loads(ask("simcheck", "check", *words, *paths))
    assert [Path(report["asset"]) for report in reports] == list(paths)
    for report in reports:
        assert report["simcheck_version"] == VERSIONS["simcheck"]
        for finding in (finding for result in report["results"] for finding in result["findings"]):
            of = frozenset(finding["target"].split("|"))
            yield Remark("simcheck", report["asset"], finding["check"], finding["severity"], of, finding["message"])


def by_mjcf_doctor(path: Path) -> Iterator[Remark]:
    printed = ask("mjcf-doctor", "check", "--json", path)
    assert VERSIONS["mjcf-doctor"] in printed
    (report,) = json.loads(printed[printed.index("\n[\n") : printed.index("\n]\n") + 2])
    for finding in report["findings"]:
        of = frozenset({finding["subject"]})
        yield Remark("mjcf-doctor", str(path), finding["code"], finding["level"].lower(), of, finding["message"])


def remarks(folder: Path) -> list[Remark]:
    files: dict[Path, str] = {}
    for number, description in enumerate(ROBOTS):
        artifacts = compiled(description).artifacts
        robot = {one.backend: one.file for one in artifacts}
        for artifact in artifacts:
            # A URDF without shapes and masses is for the controller_manager alone.
            shaped = any(word in artifact.text for word in ("<collision", "<geom", "<include"))
            if artifact.file.endswith(ENDINGS) and shaped:
                path = folder / str(number) / artifact.file
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(artifact.text, "utf-8")
                # A scene is the robot that it includes, and a floor: what is said of both is answered once.
                files[path] = robot["mjcf"] if artifact.backend == "scene" else artifact.file
    said = [*by_simcheck(*files), *(one for path in files if path.suffix == ".xml" for one in by_mjcf_doctor(path))]
    return [remark._replace(file=files[Path(remark.file)]) for remark in said]


def is_answered_by(remark: Remark, answer: dict[str, object]) -> bool:
    """Return True if an answer is about a remark: all that it names, or with ``of`` those names alone."""
    same = all(answer[key] == getattr(remark, key) for key in ("judge", "check", "severity"))
    of = answer.get("of")
    return same and fnmatch(remark.file, str(answer["file"])) and (of is None or remark.of <= set(of))  # type: ignore[call-overload]


@needs_judges
@pytest.mark.tier("engines")
def test_each_remark_is_answered_and_each_answer_is_needed(tmp_path: Path) -> None:
    found = remarks(tmp_path)
    assert {remark.judge for remark in found} == set(VERSIONS)
    assert [one for one in found if not any(is_answered_by(one, answer) for answer in ANSWERS)] == []
    for answer in ANSWERS:
        named = [remark.of for remark in found if is_answered_by(remark, answer)]
        assert named, f"nothing is said that this answers: {answer}"
        assert set(answer.get("of") or ()) <= {*chain(*named)}, f"of some of these nothing is said: {answer}"


@needs_judges
@pytest.mark.slow
def test_the_judges_see_what_is_wrong(tmp_path: Path) -> None:
    """A mass in grams, planted by simcheck itself, is a remark that nobody answered."""
    (urdf,) = [one for one in compiled(ROBOTS[-1]).artifacts if one.file.endswith(".urdf")]
    good = tmp_path / urdf.file
    good.write_text(urdf.text, "utf-8")
    ask("simcheck", "mutate", good, "--defect", "mass_grams", "--out", tmp_path / "planted")
    (bad,) = (tmp_path / "planted").iterdir()
    shutil.copy(bad, good)
    found = [remark._replace(file=good.name) for remark in by_simcheck(good)]
    unanswered = [one.check for one in found if not any(is_answered_by(one, answer) for answer in ANSWERS)]
    assert "inertia.density" in unanswered
