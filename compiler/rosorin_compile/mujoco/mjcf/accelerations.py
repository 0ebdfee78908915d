"""Compare the frames and accelerations of two compiled models in random states, under random controls.

If they differ, both are compared without constraints: of two meshes deep in each other a contact comes and goes by one
bit, and constraints that exclude each other have no single solution. The fields of contacts, limits and equalities are
compared in any case. This runs in the child process.
"""

from __future__ import annotations

import copy
from typing import Any, NamedTuple

import numpy as np

from .compare_models import Comparison, Difference

STATES = 20
TOLERANCE = 1e-6  # m, an entry of a rotation, and a share of the largest acceleration

# What no motion shows: kinds of objects, and fields.
_STILL_KINDS = {"camera", "light", "texture", "material", "numeric", "text", "tuple", "sensor", "key", "skin", "viewer"}
_STILL_FIELDS = {"name", "group", "rgba", "matid", "user", "castshadow", "nuserdata", "njmax", "nconmax"}


class Motion(NamedTuple):
    """The largest difference of frames (m, or an entry of a rotation) and of accelerations, and its body or joint.

    Accelerations differ by a share of the largest one. ``constraints`` is the number of constraints in all states, or 0
    if the models were compared without; ``scene`` the number of geoms that ours does not have, which touch nothing.
    ``differs``: by more than rounding.
    """

    largest: float
    where: str
    constraints: int
    scene: int
    states: int = STATES
    differs: bool = False


def moves_alike(found: list[Difference]) -> bool:
    """Return True if two models with these differences must move in the same way; a missing scene touches nothing."""
    gone = {"geom", "mesh", "hfield", "site"}
    return all(
        one.kind in _STILL_KINDS
        or one.field in _STILL_FIELDS
        or (one.kind == "site" and one.field in ("type", "size"))
        or (one.kind in gone and one.text.endswith(": is not in ours"))
        for one in found
    )


def compare_motion(mujoco: Any, comparison: Comparison) -> Motion:
    """Return the largest difference of the two models of a comparison."""
    source, ours = copy.copy(comparison.source.mj), copy.copy(comparison.ours.mj)
    scene = [geom for geom in range(source.ngeom) if geom not in comparison.maps["geom"]]
    source.geom_contype[scene] = source.geom_conaffinity[scene] = 0
    motion = _compare(mujoco, comparison, source, ours)
    if motion.largest > TOLERANCE and motion.constraints:
        for model in (source, ours):
            model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
        motion = _compare(mujoco, comparison, source, ours)
    return motion._replace(scene=len(scene), differs=motion.largest > TOLERANCE)


def _compare(mujoco: Any, comparison: Comparison, source: Any, ours: Any) -> Motion:
    first, second, maps = mujoco.MjData(source), mujoco.MjData(ours), comparison.maps
    bodies, chance = np.array(list(maps["body"].items()), dtype=int), np.random.default_rng(1)
    largest, where, constraints = 0.0, "", 0
    for _ in range(STATES):
        _set_state(comparison, first, second, chance)
        mujoco.mj_forward(source, first)
        mujoco.mj_forward(ours, second)
        constraints += int(first.nefc)
        off = np.abs(first.xpos[bodies[:, 0]] - second.xpos[bodies[:, 1]]).max(axis=1)
        off = np.maximum(off, np.abs(first.xmat[bodies[:, 0]] - second.xmat[bodies[:, 1]]).max(axis=1))
        if off.max() > largest:
            largest, where = float(off.max()), comparison.source.called("body", int(bodies[off.argmax(), 0]))
        scale = max(1.0, float(np.abs(first.qacc).max(initial=0)))
        for one, other in maps["joint"].items():
            pair = first.qacc[comparison.source.dofs(one)], second.qacc[comparison.ours.dofs(other)]
            differs = float(np.nan_to_num(np.abs(pair[0] - pair[1]).max(), nan=np.inf)) / scale
            if differs > largest:
                largest, where = differs, comparison.source.called("joint", one)
    return Motion(largest, where, constraints, 0)


def _set_state(comparison: Comparison, first: Any, second: Any, chance: Any) -> None:
    """Put both models into the same random state; joints within their limits, or half a radian or metre around."""
    source, ours, maps = comparison.source, comparison.ours, comparison.maps
    for one, other in maps["joint"].items():
        here, there = source.positions(one), ours.positions(other)
        numbers = source.mj.qpos0[here] + chance.uniform(-0.5, 0.5, here.stop - here.start)
        if len(numbers) == 1 and source.mj.jnt_limited[one]:
            numbers[0] = chance.uniform(*source.mj.jnt_range[one])
        if len(numbers) > 1:
            numbers[-4:] /= np.linalg.norm(numbers[-4:])
        first.qpos[here] = second.qpos[there] = numbers
        speeds = chance.uniform(-1, 1, source.dofs(one).stop - source.dofs(one).start)
        first.qvel[source.dofs(one)] = second.qvel[ours.dofs(other)] = speeds
    for one, other in maps["actuator"].items():
        here, there = source.piece("nu", one), ours.piece("nu", other)
        limits = source.mj.actuator_ctrlrange[here]
        limits = np.where(source.mj.actuator_ctrllimited[here][:, None], limits, (-0.5, 0.5))
        first.ctrl[here] = second.ctrl[there] = chance.uniform(limits[:, 0], limits[:, 1])
        here, there = source.activations(one), ours.activations(other)
        first.act[here] = second.act[there] = chance.uniform(0, 1, here.stop - here.start)
