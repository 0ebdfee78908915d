"""What is compared of what drives a robot: tendons, actuators, keys with positions and controls, and their order.

It runs in the child process, for ``compared``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rosorin_compile.compare.proof import Tolerance

from .compared_values import activation, both, near, near_pose, slice_of, value
from .matched import BALL, FREE, rotation

if TYPE_CHECKING:
    from .compared import Comparison

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
        if theirs.tendon_limited[one] and own.tendon_limited[other]:
            comparison.numbers("tendons", "tendon", one, "range", theirs.tendon_range[one], own.tendon_range[other])
        rests = theirs.tendon_lengthspring[one], own.tendon_lengthspring[other]
        comparison.numbers("tendons", "tendon", one, "lengthspring", *rests)


def actuators(comparison: Comparison) -> None:
    """Compare the forces that actuators have by themselves, and what they can be asked for."""
    for one, other in comparison.maps["actuator"].items():
        theirs, own = comparison.source.mj, comparison.ours.mj
        biases = theirs.actuator_biasprm[one], own.actuator_biasprm[other]
        comparison.numbers("actuators", "actuator", one, "biasprm", *biases)
        lengths = [value(mj, "actuator_lengthrange", index) for mj, index in ((theirs, one), (own, other))]
        if not np.allclose(lengths[0], lengths[1], rtol=Tolerance.SIMULATED, atol=Tolerance.SIMULATED):
            comparison.tell("actuators", "actuator", one, f"lengthrange {both(*lengths)}")
        limited = "actuator_ctrllimited"
        if comparison.is_set(comparison.source, limited, one) and comparison.is_set(comparison.ours, limited, other):
            ranges = value(theirs, "actuator_ctrlrange", one), value(own, "actuator_ctrlrange", other)
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
            values = theirs.key_ctrl[one][at], own.key_ctrl[other][to]
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
    if not (near(*values) if size == 1 else near_pose(*values)):
        comparison.tell("keys", "key", one, f"position of {name} {both(*values)}")
    count = {FREE: 6, BALL: 3}.get(kind, 1)
    at, to = int(theirs.jnt_dofadr[joint]), int(own.jnt_dofadr[mine])
    speeds = theirs.key_qvel[one][at : at + count], own.key_qvel[other][to : to + count]
    comparison.numbers("keys", "key", one, f"speed of {name}", *speeds)


def order(comparison: Comparison) -> None:
    """Compare the order of joints, controls and measurements, and which keys come first: programs count them."""
    if [other for _, other in sorted(comparison.maps["key"].items())] != list(range(len(comparison.maps["key"]))):
        comparison.differ("order", "the keys of the source are not the first ones, in their order")
    for kind, field in (("joint", "jnt_qposadr"), ("actuator", "actuator_ctrladr"), ("sensor", "sensor_adr")):
        places = [int(getattr(comparison.ours.mj, field)[other]) for _, other in sorted(comparison.maps[kind].items())]
        if places != sorted(places):
            comparison.differ("order", f"the {kind}s stand in another order in ours")
