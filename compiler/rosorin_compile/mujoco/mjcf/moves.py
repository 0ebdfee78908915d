"""Moves: half a second of two compiled models under the same moving controls, with contact, from the same state.

Where they part, the source is run once more with every mass, inertia and position moved by one unit in the last place,
or by as much as rounding may. If that alone makes it part from itself, nearly as far, the motion is chaotic, and says
nothing; then both are run without contact. It runs in the child process.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from rosorin_compile.compare.proof import Tolerance

from .compared import Comparison
from .compared_values import slice_of
from .matched import BALL, FREE

SECONDS = 0.5
MOST_STEPS = 2000
TOLERANCE = Tolerance.SIMULATED
LOOKS = 25  # how often the two are compared on the way

# Source and ours differ by rounding: of degrees, of quaternions, of principal axes, at most by 1e-12. By how much of
# itself the source is moved (0: one unit in the last place, 1e-16), how much farther ours may be for that, and which
# signs the numbers are moved by (0: all the same). Of two meshes deep in each other a point of contact comes and goes
# by one bit: few of the signs show it.
NUDGES = (
    *((0.0, 1e4, 0), (1e-13, 1e1, 0), (-1e-13, 1e1, 0), (1e-12, 1e1, 0), (-1e-12, 1e1, 0)),
    *((1e-12 if signs % 2 else 1e-15, 1e1, signs) for signs in range(1, 13)),
)

NO_CONTACT = 1 << 4  # mjDSBL_CONTACT; a test holds it against MuJoCo's
_MOVED = (
    *("body_mass", "body_inertia", "body_pos", "body_quat", "body_ipos", "body_iquat", "geom_pos", "geom_quat"),
    *("jnt_pos", "qpos0"),
)


class Apart(NamedTuple):
    """The largest distance of two runs (m, or an entry of a rotation), the body that it was found at, most contacts.

    ``fell`` says that the first one did not hold: its numbers grew without end, and MuJoCo began anew.
    """

    largest: float
    body: str
    touching: int = 0
    fell: bool = False


class Motion(NamedTuple):
    """How two models moved: apart by how much and where, the source from itself, and both without contact.

    ``verdict`` is same, chaotic, differs or unstable, ``contacts`` the most that there were in the source. ``scene``
    is how many geoms of the source, which ours does not have, touched nothing.
    """

    verdict: str
    steps: int
    largest: float
    body: str
    contacts: int
    itself: float = 0.0
    without_contact: float = 0.0
    scene: int = 0


def run(mujoco: Any, comparison: Comparison) -> Motion:
    """Return how the two models of a comparison move."""
    steps = min(MOST_STEPS, max(1, round(SECONDS / float(comparison.source.mj.opt.timestep))))
    source, ours = comparison.source.mj, comparison.ours.mj
    scene = [geom for geom in range(source.ngeom) if geom not in comparison.maps["geom"]]
    source = _untouched(source, scene)
    found = _apart(mujoco, comparison, source, ours, steps)
    motion = Motion("same", steps, found.largest, found.body, found.touching, scene=len(scene))
    if found.fell:
        return motion._replace(verdict="unstable")
    if found.largest <= TOLERANCE:
        return motion
    itself, is_chaotic = _from_itself(mujoco, comparison, source, steps, found.largest)
    motion = motion._replace(itself=itself)
    if not is_chaotic:
        return motion._replace(verdict="differs")
    bare = [copy.copy(model) for model in (source, ours)]
    for model in bare:
        model.opt.disableflags |= NO_CONTACT
    alone = _apart(mujoco, comparison, bare[0], bare[1], steps)
    motion = motion._replace(verdict="chaotic", without_contact=alone.largest)
    if alone.largest <= TOLERANCE:
        return motion
    _, is_chaotic = _from_itself(mujoco, comparison, bare[0], steps, alone.largest)
    return motion if is_chaotic else motion._replace(verdict="differs", body=alone.body)


def _from_itself(mujoco: Any, comparison: Comparison, source: Any, steps: int, largest: float) -> tuple[float, bool]:
    """Return how far the source parts from itself by rounding, and whether ours parts from it no farther than so."""
    most = 0.0
    for share, factor, signs in NUDGES:
        again = _apart(mujoco, comparison, source, _nudged(source, share, signs), steps, itself=True).largest
        most = max(most, again)
        if largest <= again * factor:
            return most, True
    return most, False


def _untouched(model: Any, geoms: Sequence[int]) -> Any:
    """Return a model of which some geoms touch nothing."""
    made = copy.copy(model) if geoms else model
    for geom in geoms:
        made.geom_contype[geom] = made.geom_conaffinity[geom] = 0
    return made


def _nudged(model: Any, share: float, signs: int) -> Any:
    """Return a model whose numbers are moved by a share of them; by one unit in the last place, if that is 0."""
    made = copy.copy(model)
    chance = np.random.default_rng(signs)
    for field in _MOVED:
        array = getattr(made, field)
        held = array[array != 0]
        moved = share * chance.uniform(-1, 1, held.size) if signs else share
        array[array != 0] = held * (1 + moved) if share else np.nextafter(held, np.inf)
    return made


def _apart(mujoco: Any, comparison: Comparison, source: Any, ours: Any, steps: int, itself: bool = False) -> Apart:
    """Run two models side by side; ``itself`` says that both are the source."""
    first, second = mujoco.MjData(source), mujoco.MjData(ours)
    bodies = np.array(list(comparison.maps["body"].items()), dtype=int)
    mine = bodies[:, 0] if itself else bodies[:, 1]
    _start(mujoco, comparison, first, second, itself)
    controls = list(_controls(comparison, itself))
    worst, where, touching = 0.0, 0, 0
    signs = [getattr(mujoco.mjtWarning, f"mjWARN_{word}") for word in ("BADQPOS", "BADQVEL", "BADQACC")]
    for number in range(steps):
        for index, other, middle, reach in controls:
            aim = middle + reach * math.sin(math.tau * first.time * (1 + 0.3 * (index % 7)) + index)
            first.ctrl[index], second.ctrl[other] = aim, aim
        mujoco.mj_step(source, first)
        if any(first.warning[int(sign)].number for sign in signs):
            return Apart(math.inf, "", touching, fell=True)
        mujoco.mj_step(ours, second)
        touching = max(touching, int(first.ncon))
        if number % max(1, steps // LOOKS) and number != steps - 1:
            continue
        off = np.abs(first.xpos[bodies[:, 0]] - second.xpos[mine]).max(axis=1)
        off = np.maximum(off, np.abs(first.xmat[bodies[:, 0]] - second.xmat[mine]).max(axis=1))
        if not np.isfinite(off).all():
            return Apart(math.inf, "", touching)
        if off.max() > worst:
            worst, where = float(off.max()), int(bodies[off.argmax(), 0])
    return Apart(worst, comparison.source.called("body", where), touching)


def _start(mujoco: Any, comparison: Comparison, first: Any, second: Any, itself: bool) -> None:
    """Put both into the first key of the source, or where they stand at first; ours joint by joint."""
    source, ours = comparison.source.mj, comparison.ours.mj
    if source.nkey:
        mujoco.mj_resetDataKeyframe(source, first, 0)
    if itself:
        second.qpos[:], second.qvel[:], second.act[:] = first.qpos, first.qvel, first.act
        return
    for one, other in comparison.maps["joint"].items():
        at, to = int(source.jnt_qposadr[one]), int(ours.jnt_qposadr[other])
        dof, mine = int(source.jnt_dofadr[one]), int(ours.jnt_dofadr[other])
        size, count = {FREE: (7, 6), BALL: (4, 3)}.get(int(source.jnt_type[one]), (1, 1))
        second.qpos[to : to + size] = first.qpos[at : at + size]
        second.qvel[mine : mine + count] = first.qvel[dof : dof + count]
    for one, other in comparison.maps["actuator"].items():
        at, to = int(source.actuator_actadr[one]), int(ours.actuator_actadr[other])
        count = int(source.actuator_actnum[one]) if at >= 0 else 0
        second.act[to : to + count] = first.act[at : at + count]
    _same_mocap(comparison, first, second)


def _same_mocap(comparison: Comparison, first: Any, second: Any) -> None:
    source, ours = comparison.source.mj, comparison.ours.mj
    for one, other in comparison.maps["body"].items():
        at, to = int(source.body_mocapid[one]), int(ours.body_mocapid[other])
        if at >= 0 and to >= 0:
            second.mocap_pos[to], second.mocap_quat[to] = first.mocap_pos[at], first.mocap_quat[at]


def _controls(comparison: Comparison, itself: bool) -> Iterator[tuple[int, int, float, float]]:
    """Yield each control: its index in both, the middle and the reach of its sine."""
    source, ours = comparison.source.mj, comparison.ours.mj
    for one, other in comparison.maps["actuator"].items():
        here = slice_of(source, "actuator_ctrlrange", one)
        there = here if itself else slice_of(ours, "actuator_ctrlrange", other)
        for at, to in zip(range(here.start, here.stop), range(there.start, there.stop), strict=False):
            low, high = source.actuator_ctrlrange[at] if source.actuator_ctrllimited[at] else (-0.5, 0.5)
            middle = (low + high) / 2
            if not source.actuator_ctrllimited[at] and source.nkey:
                middle = float(source.key_ctrl[0][at])
            yield at, to, float(middle), 0.4 * float(high - low)
