"""Two compiled models are the same robot or not: every planted difference is told, and what differs by right is not.

``compared/everything.xml`` has an object of every kind. A difference is planted in its text, where a person would make
it.
"""

from pathlib import Path
from typing import Any

import pytest
import yaml

mujoco = pytest.importorskip("mujoco", minversion="3.12")

from rosorin_compile.mujoco.mjcf import compare_models  # noqa: E402
from support.paths import DATA, data_text  # noqa: E402

EVERYTHING = DATA / "mjcf" / "compared" / "everything.xml"
TEXT = EVERYTHING.read_text("utf-8")


def compiled(text: str) -> Any:
    spec = mujoco.MjSpec.from_string(text)
    spec.compiler.fusestatic = spec.compiler.discardvisual = False
    return spec.compile()


def told(one: str, other: str, names: Any = None) -> list[str]:
    return [difference.text for difference in compared(compiled(one), compiled(other), names)]


def compared(source: Any, ours: Any, names: Any = None) -> list[compare_models.Difference]:
    return compare_models.Comparison(mujoco, source, ours, names or {}).run()


def edited(old: str, new: str, text: str = TEXT) -> str:
    assert text.count(old) == 1, old
    return text.replace(old, new)


def test_a_model_is_itself() -> None:
    assert told(TEXT, TEXT) == []


PLANTED = yaml.safe_load((DATA / "mjcf/compared/planted.yaml").read_text("utf-8"))


@pytest.mark.parametrize(("old", "new", "message"), PLANTED, ids=lambda value: value[:40])
def test_a_planted_difference_is_told(old: str, new: str, message: str) -> None:
    found = told(TEXT, edited(old, new))
    assert any(text.startswith(message) for text in found), found


def test_what_is_added_is_told() -> None:
    found = told(TEXT, edited('<site name="pull"/>', '<site name="pull"/><geom name="more" size="0.01" mass="0"/>'))
    assert "geom more is only in ours" in found
    heavy = '<site name="pull"/><body name="more"><inertial pos="0 0 0" mass="0.1" diaginertia="1 1 1"/></body>'
    assert told(TEXT, edited('<site name="pull"/>', heavy)) == ["body more is only in ours"]


ARM = data_text("robots/compared_arm.mjcf.xml")
BY_RIGHT = {
    "a site more": [('<site name="tip"', '<site name="arm"/><site name="tip"')],
    "a site that became a body": [
        ('<site name="tip" pos="0.1 0.2 0"/>', '<body name="tip" pos="0.1 0.2 0"><site name="tip"/></body>')
    ],
    "the other sign of a quaternion": [('quat="0.8 0 0.6 0"', 'quat="-0.8 0 -0.6 0"'), ("0.6 1 0 0 0", "0.6 -1 0 0 0")],
    "other principal axes": [('mass="1" dia', 'mass="1" quat="1 1 0 0" dia'), ("0.02 0.02 0.03", "0.02 0.03 0.02")],
    "a visual more, and the groups of both": [
        ('size="0.1 0.1 0.1" rgba="1 0 0 1"/>', 'size="0.1 0.1 0.1" group="3"/><geom type="box" size="0.1 0.1 0.1"'
         ' contype="0" conaffinity="0" group="1" rgba="1 0 0 1" mass="0"/>')
    ],
    "a material that is only a colour": [
        ("<worldbody>", '<asset><material name="red" rgba="1 0 0 1"/></asset><worldbody>'),
        ('rgba="1 0 0 1"/><site', 'material="red"/><site'),
    ],
    "an exclude of neighbours, which is implied": [
        ("<tendon>", '<contact><exclude body1="arm" body2="hand"/></contact><tendon>')
    ],
    "the other sign of the quaternion of a weld": [('0.2 0.8 0 0.6 0"', '0.2 -0.8 0 -0.6 0"')],
    "the look of a tendon of joints, which is not drawn": [
        ("<worldbody>", '<default><tendon rgba="1 0 0 1" width="0.2"/></default><worldbody>')
    ],
    "a body more of what MuJoCo calls no mass": [
        ('<site name="tip"', '<body><inertial pos="0 0 0" mass="1e-12" diaginertia="1 1 1"/></body><site name="tip"')
    ],
    "a body without mass between": [
        ('<body name="hand" pos="0 0 0.2">', '<body name="between" pos="0 0 0.1"><body name="hand" pos="0 0 0.1">'),
        ('name="fist" size="0.1"/></body>', 'name="fist" size="0.1"/></body></body>'),
    ],
}  # fmt: skip


SYMMETRIC = {"the other sign of a quaternion", "other principal axes", "a material that is only a colour"}


@pytest.mark.parametrize("what", BY_RIGHT)
def test_what_differs_by_right_is_not_told(what: str) -> None:
    text = ARM
    for old, new in BY_RIGHT[what]:
        text = edited(old, new, text)
    assert told(ARM, text) == []
    if what in SYMMETRIC:
        assert told(text, ARM) == []


def test_names_that_the_import_gave_are_no_difference() -> None:
    nameless = ARM.replace('name="hand" ', "").replace('name="wrist" ', "")
    renamed = ARM.replace('"hand"', '"arm_body"').replace('"wrist"', '"arm_body_joint"')
    assert told(nameless, renamed) == []
    assert told(ARM, renamed) == [
        "body hand: is called arm_body in ours",
        "joint wrist: is called arm_body_joint in ours",
    ]
    assert told(ARM, renamed, {"body": {3: "arm_body"}, "joint": {1: "arm_body_joint"}}) == []


@pytest.fixture(autouse=True)
def _no_log() -> Any:
    mujoco.set_mju_user_warning(lambda _: None)
    yield
    mujoco.set_mju_user_warning(None)


def _moved(one: str, other: str) -> tuple[float, str]:
    return compare_models.Comparison(mujoco, compiled(one), compiled(other), {}).motion()


def test_a_model_moves_as_itself() -> None:
    assert _moved(TEXT, TEXT)[0] == 0.0


@pytest.mark.parametrize(("old", "new"), [('kp="5"', 'kp="5.5"'), ('mass="1" diaginertia', 'mass="1.1" diaginertia')])
def test_another_motion_is_told(old: str, new: str) -> None:
    largest, where = _moved(ARM, edited(old, new, ARM))
    assert largest > compare_models.TOLERANCE
    assert where in ("joint turn", "joint wrist")


@pytest.mark.filterwarnings("ignore:compiler attribute")
@pytest.mark.parametrize("path", sorted(Path(DATA, "mjcf", "public").glob("*.xml")), ids=lambda path: path.stem)
def test_what_mujoco_saves_is_the_same(path: Path) -> None:
    """The same robot in other words: MuJoCo writes it anew, with its own defaults, frames and order of attributes."""
    pytest.importorskip("mujoco", minversion="3.17")  # MuJoCo 3.12 saves numbers with six digits
    spec = mujoco.MjSpec.from_file(str(path))
    spec.compile()
    spec.compiler.savecompiled = False
    text = spec.to_xml()
    assert text != path.read_text("utf-8")
    assert told(path.read_text("utf-8"), text) == []
    assert _moved(path.read_text("utf-8"), text)[0] <= compare_models.TOLERANCE
