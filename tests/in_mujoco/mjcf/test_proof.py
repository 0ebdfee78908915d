"""What an import of an MJCF lists may differ, of that feature and in that way; how both moved is said in words."""

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("mujoco", minversion="4")

from rosorin_compile.formats.imported import Imported, Proof
from rosorin_compile.mujoco.mjcf import proof
from rosorin_compile.mujoco.mjcf.proof import is_listed
from rosorin_compile.source.diagnostics import WARNING, Diagnostic

NO_GEOM = 'the mesh "m", that no geom has'


@pytest.mark.parametrize(
    ("feature", "difference", "said", "listed"),
    [
        ("mesh", "mesh m: is not in ours", [NO_GEOM], True),
        ("mesh", "mesh m: is not in ours", [], False),
        ("mesh", "mesh m: is not in ours", ["something else"], False),
        ("sensor", "sensor s: is not in ours", [NO_GEOM], False),
        ("geom size", "geom g: size 1 in the source, 2 in ours", [NO_GEOM], False),
        ("mesh", "mesh m: is not in ours", ["something else", NO_GEOM], True),
    ],
)
def test_what_is_listed(feature: str, difference: str, said: list[str], listed: bool) -> None:
    assert is_listed(feature, difference, said) == listed


HELD = "MuJoCo's model of the MJCF is that of the source"


@pytest.mark.parametrize(
    ("answer", "proved"),
    [
        ("MuJoCo did not end", Proof(unknown="MuJoCo did not end")),
        ({"refused": "no"}, Proof({"loading": ["MuJoCo does not load the MJCF that it becomes: no"]})),
        ({"differences": []}, Proof(said=f"{HELD}, in every field that it decides")),
        (
            {"differences": [["mesh", "", "mesh m: is not in ours"]], "counts": {"geoms": 2}},
            Proof(
                known={"mesh": ["mesh m: is not in ours"]},
                said=f"{HELD}, except for what is listed above (mesh)",
                counts={"geoms": 2},
            ),
        ),
        (
            {
                "differences": [
                    ["mesh", "", "mesh m: is not in ours"],
                    ["geom", "size", "geom g: size"],
                    ["order", "joint", "x"],
                ]
            },
            Proof({"geom size": ["geom g: size"], "order joint": ["x"]}, {"mesh": ["mesh m: is not in ours"]}),
        ),
    ],
)
def test_what_is_proved(monkeypatch: pytest.MonkeyPatch, answer: str | dict[str, Any], proved: Proof) -> None:
    """What differs and was not listed is a fault; what MuJoCo answers is given here."""
    monkeypatch.setattr(proof, "prove_in_child", lambda *_: answer)
    imported = Imported(None, [Diagnostic("import-ignored", WARNING, NO_GEOM)], files=(Path("robot.xml"),))
    assert proof.prove(imported, "", {}) == proved
