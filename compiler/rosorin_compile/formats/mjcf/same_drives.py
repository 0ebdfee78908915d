"""What is compared of what drives a robot: tendons, actuators, and the keys that have positions and controls.

Zero of a joint may be elsewhere in ours (``ref``): lengths and controls are counted from where the joint stands at
first. It runs in the child process, for ``same``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .matched import BALL, FREE, kind_of_target, rotation
from .same_values import activation, both, close, near, near_pose, slice_of, value

if TYPE_CHECKING:
    from .same import Comparison

FOUND = 1e-6  # between two lengths (m or rad) that simulations have found
SOLIDS_OF_TENDONS = (4, 5)  # mjtWrap: sphere and cylinder


def tendons(comparison: Comparison) -> None:
    """Compare the paths of tendons and their lengths."""
    for one, other in comparison.maps["tendon"].items():
        theirs, own = comparison.source.mj, comparison.ours.mj
        for field in ("wrap_type", "wrap_prm"):
            values = [np.array(value(mj, field, index)) for mj, index in ((theirs, one), (own, other))]
            if field == "wrap_prm":
                types = value(theirs, "wrap_type", one)
                for at in np.flatnonzero(np.isin(types, SOLIDS_OF_TENDONS)) if len(values[0]) == len(values[1]) else ():
                    site = int(values[0][at])
                    values[0][at] = comparison.maps["site"].get(site, -2) if site >= 0 else -1
            comparison.numbers("tendons", "tendon", one, field.partition("_")[2], *values)
        shift = _shift_of_tendon(comparison, one)
        if theirs.tendon_limited[one] and own.tendon_limited[other]:
            comparison.numbers(
                "tendons", "tendon", one, "range", theirs.tendon_range[one] - shift, own.tendon_range[other]
            )
        rests = theirs.tendon_lengthspring[one] - shift, own.tendon_lengthspring[other]
        comparison.numbers("tendons", "tendon", one, "lengthspring", *rests)


def actuators(comparison: Comparison) -> None:
    """Compare the forces that actuators have by themselves, and what they can be asked for."""
    for one, other in comparison.maps["actuator"].items():
        theirs, own = comparison.source.mj, comparison.ours.mj
        control = shift_of_control(comparison, one, other)
        biases = theirs.actuator_biasprm[one].copy(), own.actuator_biasprm[other]
        biases[0][0] = biases[1][0] if control else biases[0][0] + biases[0][1] * _shift_of_length(comparison, one)
        comparison.numbers("actuators", "actuator", one, "biasprm", *biases)
        lengths = [value(mj, "actuator_lengthrange", index) for mj, index in ((theirs, one), (own, other))]
        if not np.allclose(lengths[0], lengths[1], rtol=FOUND, atol=FOUND):
            comparison.tell("actuators", "actuator", one, f"lengthrange {both(*lengths)}")
        limited = "actuator_ctrllimited"
        if comparison.is_set(comparison.source, limited, one) and comparison.is_set(comparison.ours, limited, other):
            ranges = value(theirs, "actuator_ctrlrange", one) - control, value(own, "actuator_ctrlrange", other)
            comparison.numbers("actuators", "actuator", one, "ctrlrange", *ranges)


def keys(comparison: Comparison) -> None:
    """Compare what keys have for joints, actuators and motion capture."""
    for one, other in comparison.maps["key"].items():
        theirs, own = comparison.source.mj, comparison.ours.mj
        for joint, mine in comparison.maps["joint"].items():
            if theirs.jnt_type[joint] == own.jnt_type[mine]:
                _key_of_joint(comparison, one, other, joint, mine)
        for actuator, mine in comparison.maps["actuator"].items():
            at, to = slice_of(theirs, "actuator_ctrlrange", actuator), slice_of(own, "actuator_ctrlrange", mine)
            values = theirs.key_ctrl[one][at] - shift_of_control(comparison, actuator, mine), own.key_ctrl[other][to]
            name = comparison.source.called("actuator", actuator)
            comparison.numbers("keys", "key", one, f"control of {name}", *values)
            acts = [activation(mj, key, index) for mj, key, index in ((theirs, one, actuator), (own, other, mine))]
            comparison.numbers("keys", "key", one, f"activation of {name}", *acts)
        for body, mine in comparison.maps["body"].items():
            places = int(theirs.body_mocapid[body]), int(own.body_mocapid[mine])
            if min(places) >= 0:
                _key_of_mocap(comparison, one, other, comparison.source.called("body", body), places)
        comparison.numbers("keys", "key", one, "plastic", theirs.key_plastic[one], own.key_plastic[other])


def _key_of_mocap(comparison: Comparison, one: int, other: int, name: str, places: tuple[int, int]) -> None:
    """Compare where keys have a body that motion capture moves; ``places`` are its numbers among those."""
    rows = ((comparison.source.mj, one, places[0]), (comparison.ours.mj, other, places[1]))
    positions = [np.reshape(mj.key_mpos[key], (-1, 3))[at] for mj, key, at in rows]
    comparison.numbers("keys", "key", one, f"place of {name}", *positions)
    turns = [np.reshape(mj.key_mquat[key], (-1, 4))[at] for mj, key, at in rows]
    if not near(rotation(turns[0]), rotation(turns[1])):
        comparison.tell("keys", "key", one, f"orientation of {name} {both(*turns)}")


def _key_of_joint(comparison: Comparison, one: int, other: int, joint: int, mine: int) -> None:
    theirs, own = comparison.source.mj, comparison.ours.mj
    name, kind = comparison.source.called("joint", joint), int(theirs.jnt_type[joint])
    size = {FREE: 7, BALL: 4}.get(kind, 1)
    at, to = int(theirs.jnt_qposadr[joint]), int(own.jnt_qposadr[mine])
    values = theirs.key_qpos[one][at : at + size], own.key_qpos[other][to : to + size]
    if size == 1:
        values = values[0] - theirs.qpos0[at], values[1] - own.qpos0[to]
    if not (near(*values) if size == 1 else near_pose(*values)):
        comparison.tell("keys", "key", one, f"position of {name} {both(*values)}")
    count = {FREE: 6, BALL: 3}.get(kind, 1)
    at, to = int(theirs.jnt_dofadr[joint]), int(own.jnt_dofadr[mine])
    speeds = theirs.key_qvel[one][at : at + count], own.key_qvel[other][to : to + count]
    comparison.numbers("keys", "key", one, f"speed of {name}", *speeds)


def shift_of_control(comparison: Comparison, one: int, other: int) -> float:
    """Return how much more a servo of the source is asked for than ours, at the same pose."""
    shift = _shift_of_length(comparison, one)
    bias, gain = comparison.source.mj.actuator_biasprm[one], float(comparison.source.mj.actuator_gainprm[one][0])
    moved = float(bias[0] + bias[1] * shift)
    is_as_it_was = close(moved, comparison.ours.mj.actuator_biasprm[other][0])
    return 0.0 if is_as_it_was or not gain else shift * float(-bias[1] / gain)


def _shift_of_length(comparison: Comparison, one: int) -> float:
    """Return how much longer an actuator of the source is at the same pose."""
    mj, kind = comparison.source.mj, kind_of_target(comparison.source, one)
    target, shift = int(mj.actuator_trnid[one][0]), 0.0
    if kind == "joint":
        shift = _shift_of_joint(comparison, target)
    elif kind == "tendon":
        shift = _shift_of_tendon(comparison, target)
    return shift * float(value(mj, "actuator_gear", one).ravel()[0])


def _shift_of_tendon(comparison: Comparison, one: int) -> float:
    """Return how much longer a tendon of joints is at the same pose, for its joints count from another zero."""
    mj = comparison.source.mj
    total = 0.0
    for kind, joint, factor in zip(*(value(mj, f"wrap_{f}", one) for f in ("type", "objid", "prm")), strict=True):
        total += float(factor) * _shift_of_joint(comparison, int(joint)) if kind == 1 else 0.0
    return total


def _shift_of_joint(comparison: Comparison, joint: int) -> float:
    """Return the position of a joint of the source where ours says zero, for one that turns or slides."""
    other = comparison.maps["joint"].get(joint)
    if other is None or comparison.source.mj.jnt_type[joint] in (FREE, BALL):
        return 0.0
    zero = comparison.source.mj.qpos0[comparison.source.mj.jnt_qposadr[joint]]
    return float(zero - comparison.ours.mj.qpos0[comparison.ours.mj.jnt_qposadr[other]])
