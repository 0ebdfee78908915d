"""Nothing of MuJoCo's model is forgotten: each of its fields is compared, or says why it is not."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator

import pytest

mujoco = pytest.importorskip("mujoco", minversion="4")
structs = pytest.importorskip("mujoco.introspect.structs")

from in_mujoco.mjcf.other_fields import CARED_FOR, EXCUSED, follows  # noqa: E402
from rosorin_compile.mujoco.mjcf import compared, compared_drives, compared_fields, compared_values, matched, moves  # noqa: E402


def fields() -> Iterator[str]:
    """Yield each field that the table has, as often as it has it."""
    for kind in compared_fields.KINDS.values():
        for words in kind.fields.values():
            yield from (f"{kind.prefix}_{word}" for word in words.split())
    for words in compared_fields.OF_DOFS.values():
        yield from (f"dof_{word}" for word in words.split())
    yield from compared_fields.REFERENCES
    for words in (*CARED_FOR, *itertools.chain.from_iterable(EXCUSED.values())):
        yield from words.split()
    for words in compared_fields.WHOLE.values():
        yield from words.split()


def test_every_field_of_the_model_is_compared_or_excused_once() -> None:
    listed = Counter(fields())
    published = structs.STRUCTS["mjModel"].fields
    known = [field.name for field in published]
    assert [field.name for field in published if field.name not in listed and not follows(field)] == []
    assert [name for name in listed if name not in known] == []
    assert [name for name, count in listed.items() if count > 1] == []


@pytest.mark.parametrize(("name", "of"), [("mjOption", "opt"), ("mjStatistic", "stat"), ("mjVisual", "vis")])
def test_every_field_of_the_settings_is_compared(name: str, of: str) -> None:
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    struct, known = getattr(model, of), structs.STRUCTS[name].fields
    if of != "vis":
        assert sorted(compared_values.public(struct)) == sorted(field.name for field in known)
        return
    for part in known:
        inner = getattr(struct, {"global": "global_"}.get(part.name, part.name))
        assert sorted(compared_values.public(inner)) == sorted(field.name for field in part.type.fields)
        assert {"global": "global_"}.get(part.name, part.name) in compared.GROUPS


def test_slices_and_gates_speak_of_fields() -> None:
    known = {field.name for field in structs.STRUCTS["mjModel"].fields}
    assert set(compared_fields.SLICES) <= known
    assert {word for address, sizes in compared_fields.SLICES.values() for word in (address, *sizes.split())} <= known
    assert set(compared_fields.GATES) | set(compared_fields.GATES.values()) <= known


def test_numbers_of_mujoco_are_its_own() -> None:
    kinds, joints = mujoco.mjtGeom, mujoco.mjtJoint
    assert (kinds.mjGEOM_HFIELD, kinds.mjGEOM_MESH, kinds.mjGEOM_SDF) == (matched.HFIELD, matched.MESH, matched.SDF)
    assert (joints.mjJNT_FREE, joints.mjJNT_BALL) == (matched.FREE, matched.BALL)
    assert (joints.mjJNT_SLIDE, joints.mjJNT_HINGE) == (matched.SLIDE, matched.HINGE)
    assert mujoco.mjtDisableBit.mjDSBL_FILTERPARENT == compared_values.FILTER_PARENT
    assert mujoco.mjtDisableBit.mjDSBL_CONTACT == moves.NO_CONTACT
    assert mujoco.mjtSleepPolicy.mjSLEEP_AUTO_ALLOWED == compared_values.CHOSEN
    assert mujoco.mjtSleepPolicy.mjSLEEP_NEVER == compared_values.CHOSEN + 1
    wraps = mujoco.mjtWrap
    assert {
        int(wraps.mjWRAP_JOINT): "joint",
        int(wraps.mjWRAP_SITE): "site",
        int(wraps.mjWRAP_SPHERE): "geom",
        int(wraps.mjWRAP_CYLINDER): "geom",
    } == compared.WRAPPED
    assert (wraps.mjWRAP_SPHERE, wraps.mjWRAP_CYLINDER) == compared_drives.SOLIDS_OF_TENDONS
