"""Two compiled models are the same robot or not: every planted difference is told, and what differs by right is not.

``compared/everything.xml`` has an object of every kind. A difference is planted in its text, where a person would make
it, and in every compared array of its model.
"""

import copy
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

mujoco = pytest.importorskip("mujoco", minversion="4")

from mujoco.introspect import structs  # noqa: E402

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
    assert "geom more is in ours alone" in found
    heavy = '<site name="pull"/><body name="more"><inertial pos="0 0 0" mass="0.1" diaginertia="1 1 1"/></body>'
    assert told(TEXT, edited('<site name="pull"/>', heavy)) == ["body more is in ours alone"]


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


@pytest.fixture(name="everything", scope="module")
def _everything() -> Any:
    return compiled(TEXT)


# Arrays of mjModel that are not compared, besides those that follow from others and addresses.
IN_NO_OBJECT = re.compile(
    "(bvh|oct|M|B|C|D|mapM2|mapD2|efm0|efmC|ten_J|flexedge_J|flexedge_rigid|tree|names?|paths|plugin|exclude)_?.*"
    "|mesh_(graph|poly.*|vert|normal)|qpos0|qpos_spring|history"
)
# Arrays that cannot be changed alone: a planted text above changes them.
NOT_ALONE = (
    *("text_data", "wrap_type", "wrap_prm", "eq_type", "eq_objtype", "geom_dataid", "pair_geom2"),
    *(
        "body_parentid",
        "jnt_bodyid",
        "jnt_type",
        "body_mocapid",
        "actuator_plugin",
        "site_quat",
        "mesh_pos",
        "mesh_quat",
    ),
    *("actuator_dyntype", "actuator_actnum"),
)
# Rows that count for nothing: of a geom that touches nothing, of a tendon of joints, of what does not limit.
SOME_ROWS = re.compile(
    ".*(solref|solimp|margin|range|user|lengthspring|data|rgba|width|id|trnid|prm)|(body|geom|site|key)_.*|jnt_(pos|axis)|cam_quat|light_dir"
)


def _arrays() -> Iterator[str]:
    for field in structs.STRUCTS["mjModel"].fields:
        is_compared = field.name in dict(compare_models.arrays()) and not IN_NO_OBJECT.fullmatch(field.name)
        if is_compared and field.name not in NOT_ALONE:
            yield field.name


@pytest.mark.slow
@pytest.mark.parametrize("field", list(_arrays()))
def test_a_difference_in_any_array_is_told(everything: Any, field: str) -> None:
    """A new array of MuJoCo fails until it is compared, or known to follow from others."""
    data = getattr(everything, field)
    rows = range(len(data)) if SOME_ROWS.fullmatch(field) else {0, len(data) - 1} if data.size else ()
    seen = (any(compared(everything, planted) for planted in _planted(everything, field, row)) for row in rows)
    assert not data.size or (any(seen) if SOME_ROWS.fullmatch(field) else all(seen))


def _planted(model: Any, field: str, row: int) -> Iterator[Any]:
    """Yield copies of a model with one number of an array changed: the first and the last of a row."""
    shape = getattr(model, field).shape if not isinstance(getattr(model, field), bytes) else ()
    for column in {0, shape[1] - 1} if len(shape) > 1 and shape[1] else {None}:
        made = copy.copy(model)
        array = getattr(made, field)
        if isinstance(array, bytes):
            return
        at = row if column is None else (row, column)
        kind = array.dtype.kind
        if kind == "b":
            array[at] = not array[at]
        elif field.endswith("id") and kind == "i" and array[at] > 0:
            array[at] -= 1
        elif kind in "iu":
            array[at] += 1
        else:
            array[at] = array[at] * 1.5 + 0.125
        yield made


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
    spec = mujoco.MjSpec.from_file(str(path))
    spec.compile()
    spec.compiler.savecompiled = False
    text = spec.to_xml()
    assert text != path.read_text("utf-8")
    assert told(path.read_text("utf-8"), text) == []
    assert _moved(path.read_text("utf-8"), text)[0] <= compare_models.TOLERANCE
