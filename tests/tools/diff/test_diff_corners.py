"""Corners of diff: what changes together, what hangs otherwise, and what only one of two formats says."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.cli.run import Run
from rosorin_compile.formats.compiled import compile_robot
from support.comparing import compared, diff
from support.paths import BAD


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

CASES: dict[str, tuple[str, str, list[str]]] = {
    "modes": (
        "links: {base: {}}\nmodes: {slam: a map is made}\n",
        "links: {base: {}}\nmodes: {slam: a map is made, replay: no}\n",
        ["robot modes slam -> replay slam"],
    ),
    "elements of a link and of a joint": (
        "links: {base: {urdf_elements: [<a/>]}, arm: {}}\n"
        "joints: {j: {type: fixed, parent: base, child: arm, urdf_elements: [<b/>]}}\n",
        "links: {base: {urdf_elements: [<a/>, <c/>]}, arm: {}}\njoints: {j: {type: fixed, parent: base, child: arm}}\n",
        ["URDF elements of base: 1 new (<c/>)", "URDF elements of j: 1 removed (<b/>)"],
    ),
    "a size and a colour of one shape": (
        BALL.format(0.1, 0),
        BALL.format(0.2, 1),
        ["base visual: sphere radius 0.1 -> 0.2 m (+100.0 mm)", "base visual colour 1 0 0 1 -> 1 1 0 1"],
    ),
    "a place and a turn": (
        TWO + ARM + HAND,
        TWO + ARM.replace("[0, 0, 0.1]", "[0, 0, 0.2], rpy: [0.1, 0, 0]") + HAND,
        ["arm moved 100.0 mm and turned 5.7 deg in base: origin z 0.1 -> 0.2 m, roll 0 -> 0.1 rad"],
    ),
    "a joint that became fixed, elsewhere": (
        TWO + ARM + HAND,
        TWO + ARM + PLATE.replace("plate:", "bend:").replace("0.2, 0", "0.3, 0"),
        ["hand moved 100.0 mm in arm: origin x 0.2 -> 0.3 m", "bend type revolute -> fixed"],
    ),
    "a joint that hangs on another body, elsewhere, about another axis": (
        TWO + ARM + HAND,
        TWO
        + ARM
        + HAND.replace("parent: arm", "parent: base").replace("0.2, 0", "0.3, 0").replace("0, 0, 1", "0, 1, 0"),
        ["hand parent arm -> base", "hand origin x 0.2 -> 0.3 m", "bend axis 0 0 1 -> 0 1 0 (turned 90.0 deg)"],
    ),
    "a fixed joint that moves now, under another name": (
        TWO + ARM + PLATE,
        TWO + ARM + HAND,
        ["plate type fixed -> revolute", "joint plate renamed to bend"],
    ),
    "two joints that changed their names with each other": (
        TWO + ARM + HAND,
        TWO + ARM.replace("turn:", "bend:") + HAND.replace("bend:", "turn:"),
        ["joint turn renamed to bend", "joint bend renamed to turn"],
    ),
    "a joint that has the name of another one, which has a new one": (
        TWO + ARM + HAND,
        TWO + ARM.replace("turn:", "bend:") + HAND.replace("bend:", "fold:"),
        ["joint turn renamed to bend", "joint bend renamed to fold"],
    ),
    "a joint that moves a body without the link that it moved, elsewhere": (
        FOUR + f"  turn: {{type: revolute, parent: low, child: arm, xyz: [0, 0, 0.1], {HINGE}}}\n"
        "  f: {type: fixed, parent: arm, child: p, xyz: [0.1, 0, 0]}\n",
        FOUR.replace("arm: {}, ", "")
        + f"  turn: {{type: revolute, parent: low, child: p, xyz: [0.1, 0, 0.3], {HINGE}}}\n",
        [
            "p moved 200.0 mm in low: origin z 0.1 -> 0.3 m",
            "turn axis moved 100.0 mm in p: p off by up to 221.8 mm at turn = -1, only when turn is away from 0",
            "removed: frame arm (revolute on low, turn)",
        ],
    ),
    "a joint that moves a body without the link that it moved, on another one": (
        FOUR + f"  turn: {{type: revolute, parent: low, child: arm, xyz: [0, 0, 0.1], {HINGE}}}\n"
        "  f: {type: fixed, parent: arm, child: p, xyz: [0.1, 0, 0]}\n",
        FOUR.replace("arm: {}, ", "")
        + f"  turn: {{type: revolute, parent: base, child: p, xyz: [0.1, 0, 0.3], {HINGE}}}\n".replace(
            "0, 0, 1", "0, 1, 0"
        ),
        [
            "arm parent low -> base",
            "arm origin x 0 -> 0.1 m, z 0.1 -> 0.3 m",
            "turn axis 0 0 1 -> 0 1 0 (turned 90.0 deg)",
            "removed: frame arm (revolute on low, turn)",
        ],
    ),
    "a joint on a link that is fixed to another one": (
        PLATED + ON_PLATE + OF_PLATE + HAND,
        PLATED + ON_PLATE + OF_PLATE.replace("0.1]", "0.2]") + HAND,
        ["arm moved 100.0 mm in plate: origin z 0.1 -> 0.2 m"],
    ),
    "a joint on a link that went": (
        PLATED + ON_PLATE + OF_PLATE + HAND,
        PLATED.replace("plate: {}, ", "") + ARM.replace("0, 0, 0.1", "0, 0.1, 0.2") + HAND,
        ["arm moved 100.0 mm in base: origin z 0.1 -> 0.2 m", "removed: frame plate (fixed on base, p)"],
    ),
    "a link that moved below a joint that did not": (
        PLATED + ON_PLATE + OF_PLATE + HAND,
        PLATED + ON_PLATE.replace("0.1", "0.2") + OF_PLATE.replace("0, 0, 0.1", "0, -0.1, 0.1") + HAND,
        ["plate moved 100.0 mm in base: origin y 0.1 -> 0.2 m"],
    ),
    "a joint that moved, and the next one back": (
        TWO + ARM + HAND,
        TWO + ARM.replace("0.1]", "0.2]") + HAND.replace("0.2, 0, 0]", "0.2, 0, -0.1]"),
        ["arm moved 100.0 mm in base: origin z 0.1 -> 0.2 m"],
    ),
    "a joint that slides now, and moves a body without the link that it moved": (
        FOUR + f"  turn: {{type: revolute, parent: low, child: arm, xyz: [0, 0, 0.1], {HINGE}}}\n"
        "  f: {type: fixed, parent: arm, child: p, xyz: [0.1, 0, 0]}\n",
        FOUR.replace("arm: {}, ", "")
        + f"  turn: {{type: prismatic, parent: low, child: p, xyz: [0.1, 0, 0.3], {HINGE}}}\n",
        [
            "p moved 200.0 mm in low: origin z 0.1 -> 0.3 m",
            "turn axis moved 100.0 mm in p",
            "turn type revolute -> prismatic",
            "removed: frame arm (revolute on low, turn)",
        ],
    ),
    "an axis that moved below a link that stays": (
        TWO + ARM + PLATE,
        TWO.replace("arm: {}, ", "") + ARM.replace("child: arm, xyz: [0, ", "child: hand, xyz: [0.2, "),
        [
            "turn axis moved 200.0 mm in hand: hand off by up to 191.8 mm at turn = -1, only when turn is away from 0",
            "removed: frame arm (revolute on base, turn)",
        ],
    ),
    "an axis of a slide that was turned, far from the link that it moves": (
        SLIDE + OFF_SIDE,
        SLIDE.replace("arm: {}, ", "")
        .replace("child: arm", "child: p, xyz: [0.5, 0, 0]")
        .replace("axis: [0, 0, 1]", "axis: [0, 0.28, 0.96]"),
        [
            "lift axis 0 0 1 -> 0 0.28 0.96 (turned 16.3 deg): p off by up to 282.8 mm at lift = -1,"
            " only when lift is away from 0",
            "removed: frame arm (prismatic on base, lift)",
        ],
    ),
    "numbers of a joint that are as good as the same": (
        TWO + ARM + HAND.replace("lower: -1", "lower: 0"),
        TWO + ARM + HAND.replace("lower: -1", f"lower: {TINY}").replace("effort: 1", f"effort: {1 + TINY}"),
        [],
    ),
    "a number near zero that is no length and no angle": (
        TWO + ARM + HAND,
        TWO + ARM + HAND.replace("velocity: 1}", f"velocity: 1}}, dynamics: {{friction: {TINY}, damping: 0}}"),
        ["bend friction 0 -> 1e-10 N*m"],
    ),
}


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
