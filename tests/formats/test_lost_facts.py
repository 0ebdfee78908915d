"""Facts that only some formats carry: each is written, or a warning or note of the format names it."""

from __future__ import annotations

from pathlib import Path

import pytest

import rosorin_compile

BODY = "{inertial: {mass: 1, inertia: {ixx: 0.1, iyy: 0.1, izz: 0.1}}}"
OUTPUTS = "outputs: {urdf: {file: r.urdf, gazebo: harmonic}, sdf: {file: r.sdf}, mjcf: {file: r.xml}}\n"
CASES = {
    "ball": ("type: ball, dynamics: {damping: 2, stiffness: 5}", "", {"urdf-cannot-say", "sdf-cannot-say"}),
    "floating": ("type: floating, dynamics: {damping: 2}", "", {"mjcf-cannot-say", "sdf-cannot-say"}),
    "planar": ("type: planar, axis: [0, 0, 1]", "", {"sdf-cannot-say", "planar-taken-as-fixed"}),
    "weld": (
        "type: continuous, axis: [0, 0, 1]",
        "constraints: {pin: {type: weld, links: [base_link, arm]}}",
        {"not-in-format", "sdf-cannot-say"},
    ),
    "wrong reference": (
        "type: continuous, axis: [0, 0, 1]",
        "urdf_elements: ['<gazebo reference=\"j\"><mu1>0.4</mu1></gazebo>']",
        {"misplaced-element", "not-in-format"},
    ),
    "plugin of the robot": (
        "type: continuous, axis: [0, 0, 1]",
        'urdf_elements: [\'<plugin name="p" filename="f"/>\']',
        {"misplaced-element"},
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_what_a_format_loses_is_reported(name: str, tmp_path: Path) -> None:
    joint, more, rules = CASES[name]
    text = f"robot: r\nlinks: {{base_link: {BODY}, arm: {BODY}}}\n"
    text += f"joints: {{j: {{parent: base_link, child: arm, {joint}}}}}\n{more}\n{OUTPUTS}"
    (tmp_path / "robot.yaml").write_text(text, encoding="utf-8")
    compiled = rosorin_compile.compile(tmp_path / "robot.yaml")
    assert [one for one in compiled.diagnostics if one.severity == "error"] == []
    assert rules <= {one.rule for one in compiled.diagnostics}


def test_torsional_friction_is_in_a_note(tmp_path: Path) -> None:
    shape = "{sphere: {radius: 0.1}, contact: {friction: [0.3, 0.02]}}"
    link = f"{BODY[:-1]}, collision: [{shape}]}}"
    (tmp_path / "robot.yaml").write_text(f"robot: r\nlinks: {{base_link: {link}}}\n{OUTPUTS}", encoding="utf-8")
    compiled = rosorin_compile.compile(tmp_path / "robot.yaml")
    notes = [one.message for one in compiled.diagnostics if one.rule == "not-in-format"]
    assert [one.split(" cannot")[0] for one in notes if "contact.friction.1" in one] == ["URDF", "SDF"]
