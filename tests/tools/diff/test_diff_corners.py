"""Corners of diff: what changes together, what hangs otherwise, and what only one of two formats says."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import pytest
import yaml

from rosorin_compile.cli.main import main
from rosorin_compile.cli.run import Run
from rosorin_compile.formats.compiled import compile_robot
from support.comparing import compared, diff
from support.paths import BAD, data_text


def robot(folder: Path, name: str, text: str) -> Path:
    path = folder / f"{name}.yaml"
    path.write_text(f"robot: r\n{text}", "utf-8")
    return path


LIMIT = "limit: {lower: -1, upper: 1, effort: 1, velocity: 1}"
HINGE = f"axis: [0, 0, 1], {LIMIT}"
TWO = "links: {base: {}, arm: {}, hand: {}}\njoints:\n"
ARM = f"  turn: {{type: revolute, parent: base, child: arm, xyz: [0, 0, 0.1], {HINGE}}}\n"
HAND = f"  bend: {{type: revolute, parent: arm, child: hand, xyz: [0.2, 0, 0], {HINGE}}}\n"
FOUR = (
    "links: {base: {}, low: {}, arm: {}, p: {}, q: {}}\njoints:\n"
    f"  lift: {{type: prismatic, parent: base, child: low, {HINGE}}}\n"
    "  g: {type: fixed, parent: p, child: q, xyz: [0, 0.1, 0]}\n"
)
PLATE = "  plate: {type: fixed, parent: arm, child: hand, xyz: [0.2, 0, 0]}\n"
SLIDE = FOUR.replace("base: {}, low: {}", "base: {}").replace("child: low", "child: arm")
OFF_SIDE = "  f: {type: fixed, parent: arm, child: p, xyz: [0.5, 0, 0]}\n"
PLATED = "links: {base: {}, plate: {}, arm: {}, hand: {}}\njoints:\n"
ON_PLATE = "  p: {type: fixed, parent: base, child: plate, xyz: [0, 0.1, 0]}\n"
OF_PLATE = ARM.replace("parent: base", "parent: plate")
TINY = 1e-10  # below the tolerance of diff
BALL = "links: {{base: {{visual: [{{sphere: {{radius: {}}}, rgba: [1, {}, 0, 1]}}]}}}}\n"

CASES = yaml.safe_load(data_text("cases/diff_corners.yaml"))["cases"]


@pytest.mark.parametrize("case", CASES)
def test_what_is_said(tmp_path: Path, case: str) -> None:
    one, other, said = CASES[case]
    found = compared(robot(tmp_path, "a", one), robot(tmp_path, "b", other))
    assert [item["text"] for item in found["differences"]] == said


def test_what_breaks_the_specification_is_compared(tmp_path: Path) -> None:
    path = tmp_path / "r.urdf"
    path.write_text('<robot name="r"><!-- a -- b --><link name="base"/></robot>', "utf-8")
    assert compared(path, path)["same"]


def test_a_description_that_includes_a_xacro_is_trusted_or_not() -> None:
    pytest.importorskip("xacro")
    path = BAD / "xacro-runs-code-include" / "robot.yaml"
    code, _, err = diff(path, path)
    assert (code, "warning[xacro-runs-code]" in err) == (0, True)
    assert diff(path, path, "--trust")[2] == ""


def test_whom_a_follower_follows_stands_in_the_json(tmp_path: Path) -> None:
    """What a follower followed and follows stands in the JSON before and after."""
    one = TWO + ARM + HAND.replace("velocity: 1}}", "velocity: 1}, mimic: {joint: turn}}")
    found = compared(robot(tmp_path, "a", one), robot(tmp_path, "b", TWO + ARM + HAND))
    (item,) = found["differences"]
    assert (item["quantity"], item["a"], item["b"]) == ("mimic", "turn * 1 + 0", "nothing")


def test_a_urdf_has_the_mass_of_what_another_node_moves(tmp_path: Path) -> None:
    """It stands still there, with what carries it, and so it is compared."""
    solid = "{inertial: {mass: %s, of: collision}, collision: [{sphere: {radius: 0.1}}]}"
    path = robot(
        tmp_path,
        "a",
        f"links: {{root: {{}}, base: {solid % 1}, arm: {solid % 0.5}, hand: {solid % 0.2}}}\njoints:\n"
        "  f: {type: fixed, parent: root, child: base}\n"
        "  turn: {type: continuous, parent: base, child: arm, axis: [0, 1, 0], xyz: [0, 0, 0.2], publisher: driver}\n"
        "  bend: {type: continuous, parent: base, child: hand, axis: [0, 1, 0], xyz: [0, 0.3, 0.2]}\n"
        "publishers: {driver: {}}\noutputs: {urdf: {file: r.urdf}}\n",
    )
    urdf = tmp_path / "r.urdf"
    urdf.write_text(compile_robot(path).artifacts[0].text, "utf-8")
    assert compared(path, urdf)["differences"] == compared(urdf, path)["differences"] == []
    urdf.write_text(urdf.read_text("utf-8").replace('mass value="0.2"', 'mass value="0.3"'), "utf-8")
    assert [item["text"] for item in compared(path, urdf)["differences"]] == ["hand mass 0.2 -> 0.3 kg (+100.0 g)"]


def test_what_differs_is_printed_before_the_page_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where standard output is a pipe, which nobody else flushes; the page may take a while."""
    one, other = robot(tmp_path, "a", TWO + ARM + HAND), robot(tmp_path, "b", TWO + ARM + PLATE)
    pipe = io.BytesIO()
    seen: list[bytes] = []
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(pipe, "utf-8"))
    monkeypatch.setattr(Run, "write_page", lambda *_: seen.append(pipe.getvalue()))
    assert main(["diff", str(one), str(other), "--html", str(tmp_path / "page.html")]) == 1
    assert b"bend" in seen[0]
