"""What an import of an MJCF lists may differ, of that feature and in that way; how both moved is said in words."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("mujoco", minversion="4")

from rosorin_compile.compare.proof import Proof
from rosorin_compile.formats.imported import Imported
from rosorin_compile.mujoco.mjcf import proof
from rosorin_compile.mujoco.mjcf.proof import _how_it_moved, is_listed
from rosorin_compile.source.diagnostics import WARNING, Diagnostic

NO_GEOM = 'the mesh "m", that no geom has'


@pytest.mark.parametrize(
    ("feature", "difference", "said", "listed"),
    [
        ("shapes", "mesh m: is not in ours", [NO_GEOM], True),
        ("shapes", "mesh m: is not in ours", [], False),
        ("shapes", "mesh m: is not in ours", ["something else"], False),
        ("sensors", "sensor s: is not in ours", [NO_GEOM], False),
        ("shapes", "geom g: size 1 in the source, 2 in ours", [NO_GEOM], False),
        ("shapes", "mesh m: is not in ours", ["something else", NO_GEOM], True),
    ],
)
def test_what_is_listed(feature: str, difference: str, said: list[str], listed: bool) -> None:
    assert is_listed(feature, difference, said) == listed


MOTION = {"steps": 2, "contacts": 1, "largest": 0.5, "itself": 0.25, "without_contact": 0.0}


@pytest.mark.parametrize(
    ("verdict", "said"),
    [
        ("same", " with moving controls and up to 1 contact: largest difference 0.5"),
        ("differs", " with moving controls: apart by 0.5"),
        (
            "chaotic",
            " with moving controls are chaotic: apart by 0.5, where the source, moved by no more than rounding, is"
            " apart from itself by 0.25; without contact by 0",
        ),
    ],
)
def test_how_both_moved(verdict: str, said: str) -> None:
    assert _how_it_moved({**MOTION, "verdict": verdict}) == f"2 steps{said}"
    assert _how_it_moved({**MOTION, "verdict": verdict, "scene": True}) == f"2 steps without the scene{said}"


def test_a_source_that_falls_apart_is_said_to() -> None:
    said = "the source does not come through a simulation with moving controls"
    assert _how_it_moved({**MOTION, "verdict": "unstable"}) == said


HELD = "MuJoCo's model of the MJCF is that of the source"
APART = {**MOTION, "verdict": "differs", "body": "arm"}


@pytest.mark.parametrize(
    ("answer", "proved"),
    [
        ("MuJoCo did not end", Proof(unknown="MuJoCo did not end")),
        ({"refused": "no"}, Proof({"loading": ["MuJoCo does not load the MJCF that it becomes: no"]})),
        ({"differences": []}, Proof(said=f"{HELD}, in every field that it decides")),
        (
            {"differences": [["shapes", "mesh m: is not in ours"]], "counts": {"geoms": 2}},
            Proof(
                known={"shapes": ["mesh m: is not in ours"]},
                said=f"{HELD}, but for what is listed above (shapes)",
                counts={"geoms": 2},
            ),
        ),
        (
            {"differences": [["shapes", "mesh m: is not in ours"], ["shapes", "geom g: size"], ["order", "joints"]]},
            Proof({"shapes": ["geom g: size"], "order": ["joints"]}, {"shapes": ["mesh m: is not in ours"]}),
        ),
        (
            {"differences": [], "motion": APART},
            Proof({"motion": ["after 2 steps with moving controls the two are apart by 0.5 (arm)"]}),
        ),
    ],
)
def test_what_is_proved(monkeypatch: pytest.MonkeyPatch, answer: str | dict[str, Any], proved: Proof) -> None:
    """What differs and was not listed is a fault; what MuJoCo answers is given here."""
    monkeypatch.setattr(proof, "ask", lambda *_: answer)
    imported = Imported(None, [Diagnostic("import-ignored", WARNING, NO_GEOM)], files=(Path("robot.xml"),))
    assert proof.prove(imported, "", {}) == proved
