"""What a description accepts is a note, and the artifacts say what was written and load.

Each file of ``accepted/`` accepts one rule. Its comment has the note (see support/cases.py) that a refusal becomes, and
``urdf: TEXT`` of the URDF; a warning that is accepted leaves no message.
"""

from pathlib import Path

import pytest

from rosorin_compile.compare.artifacts import agreement
from rosorin_compile.formats.compilation import CompileResult, compile_robot
from rosorin_compile.formats.mesh_files import Places, search
from rosorin_compile.source.diagnostics import has_errors
from rosorin_compile.source.load import load_mapping
from support.cases import as_comment, check
from support.paths import TESTS
from support.robots import compiled_text, texts

mujoco = pytest.importorskip("mujoco", minversion="3.12")

CASES = sorted((TESTS / "accepted").glob("*.yaml"))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.stem)
def test_message(case: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (rule,) = [entry["rule"] for entry in load_mapping(case, case.name)["accept"]]
    monkeypatch.chdir(case.parent)
    made = compile_robot(Path(case.name))
    found = as_comment([one for one in made.diagnostics if one.rule == rule], case.name)
    assert all(" note[" in line and "accepted: " in line for line in found)
    check(case, found)
    assert made.robot is not None
    assert not has_errors(made.diagnostics), made.diagnostics
    assert agreement(made.robot, made.artifacts) == []
    artifacts = {artifact.backend: artifact.text for artifact in made.artifacts}
    for line in case.read_text("utf-8").splitlines():
        assert not line.startswith("# urdf: ") or line.removeprefix("# urdf: ") in artifacts["urdf"]
    assert "nan" not in artifacts["urdf"]
    if "mjcf" in artifacts:
        mujoco.MjModel.from_xml_string(artifacts["mjcf"])


def accepted(rule: str) -> CompileResult:
    return compile_robot(TESTS / "accepted" / f"{rule}.yaml")


@pytest.mark.parametrize("rule", ["axis-not-unit", "limit-equal", "limit-zero", "mass-not-positive"])
def test_pinocchio_reads_the_urdf(rule: str) -> None:
    pinocchio = pytest.importorskip("pinocchio")
    assert pinocchio.buildModelFromXML(texts(accepted(rule))["a.urdf"]).existFrame("hand")


def test_a_follower_of_a_fixed_joint_is_held_in_mujoco() -> None:
    model = mujoco.MjModel.from_xml_string(texts(accepted("mimic-fixed"))["a.xml"])
    assert (model.neq, model.eq_obj2id[0]) == (1, -1)
    assert model.eq_data[0][:5] == pytest.approx([0.5, 0, 0, 0, 0])


ROBOT = """
robot: a
links:
  base: &body {inertial: {mass: 1, inertia: {ixx: 1, iyy: 1, izz: 1}}}
  arm: *body
  hand: {%s}
joints:
  shoulder:
    {type: revolute, axis: [0, 0, 1], limit: {lower: -1, upper: 1, effort: 1, velocity: 1}, parent: base, child: arm}
  wrist: {type: %s, parent: arm, child: hand}
%s
outputs: {urdf: {file: a.urdf}, mjcf: {file: a.xml}}
"""


@pytest.mark.parametrize("mass", [0.0, 1.0, -1.0])
@pytest.mark.parametrize(
    "moments", [(0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (1.0, 1.0, 1.0), (1.0, 1.0, 3.0), (1.0, 1.0, -0.5)]
)
@pytest.mark.parametrize("product", [0.0, 1.0])
@pytest.mark.parametrize("kind", ["fixed", "continuous"])
def test_the_backend_refuses_what_mujoco_refuses(tmp_path, mass, moments, product, kind):
    """The MJCF is emitted and loads, or there is an error that MuJoCo gives too."""
    xx, yy, zz = moments
    hand = f"inertial: {{mass: {mass}, inertia: {{ixx: {xx}, iyy: {yy}, izz: {zz}, ixy: {product}}}}}"
    rules = ("mass-not-positive", "inertia-triangle", "inertia-not-positive-definite")
    accept = "accept: [" + ", ".join(f"{{rule: {rule}, of: [hand], reason: it is so}}" for rule in rules) + "]"
    made = compiled_text(tmp_path, ROBOT % (hand, kind, accept))
    errors = [d.rule for d in made.diagnostics if d.severity == "error"]
    assert set(errors) <= {"mjcf-needs-mass", "mjcf-refused-inertia"}
    if not errors:
        text = next(artifact.text for artifact in made.artifacts if artifact.backend == "mjcf")
        model = mujoco.MjModel.from_xml_string(text)
        assert model.body("hand").mass == pytest.approx(max(mass, 0.0))
        return
    full = " ".join(str(v) for v in (xx, yy, zz, product, 0, 0))
    inertia = f'fullinertia="{full}"' if product else f'diaginertia="{xx} {yy} {zz}"'
    body = '<body><joint/><geom size="1" density="0"/>INERTIAL</body>'.replace(
        "<joint/>", "<joint/>" if kind != "fixed" else ""
    )
    empty = mass == 0 and not any(moments) and not product
    mjcf = f"<mujoco><worldbody>{body}</worldbody></mujoco>".replace(
        "INERTIAL", "" if empty else f'<inertial pos="0 0 0" mass="{mass}" {inertia}/>'
    )
    with pytest.raises(ValueError, match=r"inertia|mass"):
        mujoco.MjModel.from_xml_string(mjcf)


MESHED = """
robot: a
links: {base: {visual: [{mesh: {file: a.stl}}]}}
accept:
- {rule: parts-overlap, reason: one housing}
- {rule: mesh-unreadable, reason: it is on another machine}
- {rule: mesh-not-found, reason: it is on another machine}
- {rule: mesh-not-read, of: [base], reason: it is huge}
outputs: {urdf: {file: a.urdf}}
"""


@pytest.mark.parametrize("there", [False, True])
def test_what_nobody_asked_for_is_not_accepted_in_vain(there: bool, tmp_path: Path) -> None:
    (tmp_path / "robot.yaml").write_text(MESHED)
    if there:
        (tmp_path / "a.stl").write_bytes(b"solid")
    assert compile_robot(tmp_path / "robot.yaml").diagnostics == []
    searched = compile_robot(
        tmp_path / "robot.yaml",
        search=lambda tree, outputs: search(tree, outputs, Places(tmp_path / "robot.yaml", tmp_path / "out", {}, {})),
    )
    unused = [(one.rule, one.message.split()[4]) for one in searched.diagnostics]
    assert unused == [("accept-unused", rule) for rule in (["mesh-not-found"] if there else []) + ["mesh-not-read"]]
