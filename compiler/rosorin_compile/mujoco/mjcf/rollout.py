"""Simulate half a second of two compiled models with the same moving controls, with contact, from the same state.

If they diverge, the source is simulated again with every mass, inertia and position changed by rounding. If it diverges
from itself nearly as far, the motion is chaotic and proves nothing; then both are simulated without contact. This runs
in the child process.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from .compare_models import SIMULATED, Comparison, Difference

SECONDS, MOST_STEPS = 0.5, 2000
TOLERANCE = SIMULATED
_SAMPLES = 25  # how often the two are compared on the way

# Source and ours differ by rounding, at most by 1e-12. Each change is a share of the numbers (0: one unit in the last
# place, 1e-16), how much farther ours may be for that, and the seed of the signs (0: all the same). Of two meshes deep
# in each other a contact comes and goes by one bit: few of the signs show it.
_CHANGES = (
    *((0.0, 1e4, 0), (1e-13, 1e1, 0), (-1e-13, 1e1, 0), (1e-12, 1e1, 0), (-1e-12, 1e1, 0)),
    *((1e-12 if seed % 2 else 1e-15, 1e1, seed) for seed in range(1, 13)),
)
_CHANGED = (
    *("body_mass", "body_inertia", "body_pos", "body_quat", "body_ipos", "body_iquat", "geom_pos", "geom_quat"),
    *("jnt_pos", "qpos0"),
)

# What no motion shows: kinds of objects, and fields.
_STILL_KINDS = {"camera", "light", "texture", "material", "numeric", "text", "tuple", "sensor", "key", "skin", "viewer"}
_STILL_FIELDS = {"name", "group", "rgba", "matid", "user", "castshadow", "nuserdata", "njmax", "nconmax"}


class Divergence(NamedTuple):
    """The largest distance of two runs (m, or an entry of a rotation), its body, and the most contacts.

    ``is_unstable``: the numbers of the first one grew without end, and MuJoCo reset it.
    """

    largest: float
    body: str
    contacts: int = 0
    is_unstable: bool = False


class Motion(NamedTuple):
    """How two models moved: ``verdict`` is same, chaotic, differs or unstable.

    ``largest`` is how far they diverged, at ``body``, ``itself`` how far the source did from itself, and
    ``without_contact`` how far both did without. ``scene`` is how many geoms of the source that ours does not have were
    left out.
    """

    verdict: str
    steps: int
    largest: float
    body: str
    contacts: int
    itself: float = 0.0
    without_contact: float = 0.0
    scene: int = 0


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


def simulate(mujoco: Any, comparison: Comparison) -> Motion:
    """Return how the two models of a comparison move."""
    source, ours = copy.copy(comparison.source.mj), comparison.ours.mj
    steps = min(MOST_STEPS, max(1, round(SECONDS / float(source.opt.timestep))))
    scene = [geom for geom in range(source.ngeom) if geom not in comparison.maps["geom"]]
    source.geom_contype[scene] = source.geom_conaffinity[scene] = 0
    run = _Run(mujoco, comparison, steps)
    found = run.diverge(source, ours)
    motion = Motion("same", steps, found.largest, found.body, found.contacts, scene=len(scene))
    if found.is_unstable:
        return motion._replace(verdict="unstable")
    if found.largest <= TOLERANCE:
        return motion
    itself, is_chaotic = run.from_itself(source, found.largest)
    if not is_chaotic:
        return motion._replace(verdict="differs", itself=itself)
    bare = [copy.copy(model) for model in (source, ours)]
    for model in bare:
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    alone = run.diverge(*bare)
    motion = motion._replace(verdict="chaotic", itself=itself, without_contact=alone.largest)
    if alone.largest <= TOLERANCE or run.from_itself(bare[0], alone.largest)[1]:
        return motion
    return motion._replace(verdict="differs", body=alone.body)


class _Run:
    """Simulates pairs of models with the objects of a comparison."""

    def __init__(self, mujoco: Any, comparison: Comparison, steps: int) -> None:
        self.mujoco, self.comparison, self.steps = mujoco, comparison, steps
        names = ("BADQPOS", "BADQVEL", "BADQACC")
        self.warnings = [int(getattr(mujoco.mjtWarning, f"mjWARN_{name}")) for name in names]

    def from_itself(self, source: Any, largest: float) -> tuple[float, bool]:
        """Return how far the source diverges from itself by rounding, and whether ours diverges no farther."""
        most = 0.0
        for share, factor, seed in _CHANGES:
            changed, chance = copy.copy(source), np.random.default_rng(seed)
            for field in _CHANGED:
                array = getattr(changed, field)
                numbers = array[array != 0]
                shares = share * chance.uniform(-1, 1, numbers.size) if seed else share
                array[array != 0] = numbers * (1 + shares) if share else np.nextafter(numbers, np.inf)
            distance = self.diverge(source, changed, itself=True).largest
            most = max(most, distance)
            if largest <= distance * factor:
                return most, True
        return most, False

    def diverge(self, source: Any, ours: Any, itself: bool = False) -> Divergence:
        """Simulate two models side by side; ``itself``: both are the source."""
        first, second = self.mujoco.MjData(source), self.mujoco.MjData(ours)
        bodies = np.array(list(self.comparison.maps["body"].items()), dtype=int)
        theirs, own = bodies[:, 0], bodies[:, 0] if itself else bodies[:, 1]
        self._start(first, second, itself)
        controls = list(self._controls(itself))
        worst, where, contacts = 0.0, 0, 0
        for number in range(self.steps):
            for index, other, middle, reach in controls:
                aim = middle + reach * math.sin(math.tau * first.time * (1 + 0.3 * (index % 7)) + index)
                first.ctrl[index] = second.ctrl[other] = aim
            self.mujoco.mj_step(source, first)
            if any(first.warning[index].number for index in self.warnings):
                return Divergence(math.inf, "", contacts, is_unstable=True)
            self.mujoco.mj_step(ours, second)
            contacts = max(contacts, int(first.ncon))
            if number % max(1, self.steps // _SAMPLES) and number != self.steps - 1:
                continue
            off = np.abs(first.xpos[theirs] - second.xpos[own]).max(axis=1)
            off = np.maximum(off, np.abs(first.xmat[theirs] - second.xmat[own]).max(axis=1))
            if not np.isfinite(off).all():
                return Divergence(math.inf, "", contacts)
            if off.max() > worst:
                worst, where = float(off.max()), int(theirs[off.argmax()])
        return Divergence(worst, self.comparison.source.called("body", where), contacts)

    def _start(self, first: Any, second: Any, itself: bool) -> None:
        """Put both into the first key of the source, or its first pose; ours joint by joint."""
        source, ours, maps = self.comparison.source, self.comparison.ours, self.comparison.maps
        if source.mj.nkey:
            self.mujoco.mj_resetDataKeyframe(source.mj, first, 0)
        if itself:
            second.qpos[:], second.qvel[:], second.act[:] = first.qpos, first.qvel, first.act
            return
        for one, other in maps["joint"].items():
            second.qpos[ours.positions(other)] = first.qpos[source.positions(one)]
            second.qvel[ours.dofs(other)] = first.qvel[source.dofs(one)]
        for one, other in maps["actuator"].items():
            second.act[ours.activations(other)] = first.act[source.activations(one)]
        for one, other in maps["body"].items():
            at, to = int(source.mj.body_mocapid[one]), int(ours.mj.body_mocapid[other])
            if at >= 0 and to >= 0:
                second.mocap_pos[to], second.mocap_quat[to] = first.mocap_pos[at], first.mocap_quat[at]

    def _controls(self, itself: bool) -> Iterator[tuple[int, int, float, float]]:
        """Yield each control: its number in both, the middle and the reach of its sine."""
        source, ours = self.comparison.source, self.comparison.ours
        for one, other in self.comparison.maps["actuator"].items():
            here = source.piece("nu", one)
            there = here if itself else ours.piece("nu", other)
            for at, to in zip(range(here.start, here.stop), range(there.start, there.stop), strict=False):
                is_limited = source.mj.actuator_ctrllimited[at]
                low, high = source.mj.actuator_ctrlrange[at] if is_limited else (-0.5, 0.5)
                middle = (low + high) / 2 if is_limited or not source.mj.nkey else source.mj.key_ctrl[0][at]
                yield at, to, float(middle), 0.4 * float(high - low)
