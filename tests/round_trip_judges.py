"""Engines that are not ours, which say whether two URDFs are the same robot."""

from __future__ import annotations

import io
import logging
import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rosorin_compile.cli import main
from round_trip_meaning import children, differences, lost_comments, parsed

BOTH = ("pinocchio", "yourdfpy")
TOLERANCE = 1e-9


def there_and_back(source: Path, *words: str) -> Path:
    """Import a file and compile what comes out, by the commands; return the URDF."""
    assert main(["import", str(source), "-o", "made", *words]) == 0
    assert main(["all", "made"]) == 0
    (urdf,) = Path("outputs").rglob("*.urdf")
    return urdf


def judge(source: bytes, result: Path, engines: tuple[str, ...] = BOTH, states: int = 50) -> None:
    """Check that the result is the robot of the source, for the comparer and for engines."""
    plain = utf8(source)
    found = differences(plain, result.read_bytes()) + lost_comments(plain, Path("made"))
    for engine in engines:
        pytest.importorskip(engine)
    if "pinocchio" in engines:
        found += pinocchio(plain.decode(), result.read_text("utf-8"), states)[0]
    if "yourdfpy" in engines:
        Path("plain.urdf").write_bytes(plain)
        found += yourdfpy(Path("plain.urdf"), result, states // 5)[0]
    assert not found, "\n".join(found)


def utf8(data: bytes) -> bytes:
    """Return an XML file as UTF-8 without a mark, which is all that some engines read."""
    declared = re.match(rb"(?:\xef\xbb\xbf)?\s*<\?xml[^>]*encoding=[\"']([\w.-]+)[\"']", data)
    encoding = "utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else declared[1].decode() if declared else "utf-8"
    text = data.decode(encoding).removeprefix("\ufeff")
    return re.sub(r"^\s*<\?xml[^>]*\?>", "", text).encode()


def pinocchio(source: str, result: str, states: int = 50) -> tuple[list[str], float]:
    """Return what differs for pinocchio, and how far apart frames are at random states (metres, matrix entries)."""
    import pinocchio as pin

    one, other = pin.buildModelFromXML(source), pin.buildModelFromXML(result)
    found = []
    if list(one.names) != list(other.names):
        return [f"joints {list(one.names)}, {list(other.names)}"], np.inf
    first, second = ({(f.name, str(f.type)): i for i, f in enumerate(m.frames)} for m in (one, other))
    if first.keys() != second.keys():
        return [f"frames {sorted(first.keys() ^ second.keys())}"], np.inf
    for what in ("lowerPositionLimit", "upperPositionLimit", "effortLimit", "velocityLimit", "damping", "friction"):
        if hasattr(one, what) and not np.allclose(getattr(one, what), getattr(other, what), 1e-12, 0, equal_nan=True):
            found.append(f"{what} {getattr(one, what)}, {getattr(other, what)}")
    for name, a, b in zip(one.names, one.inertias, other.inertias, strict=True):
        for mine, theirs in ((a.mass, b.mass), (a.lever, b.lever), (a.inertia, b.inertia)):
            if not np.allclose(mine, theirs, 1e-9, 1e-12 * max(1.0, abs(a.mass)), equal_nan=True):
                found.append(f"inertia at {name}: {mine}, {theirs}")
    pairs = [(i, second[key]) for key, i in first.items()]
    chance, largest = np.random.default_rng(5), 0.0
    data, again = one.createData(), other.createData()
    for number in range(states + 1):
        q = pin.integrate(one, pin.neutral(one), chance.uniform(-3, 3, one.nv) * bool(number))
        pin.framesForwardKinematics(one, data, q)
        pin.framesForwardKinematics(other, again, q)
        for i, j in pairs:
            here, there = data.oMf[i], again.oMf[j]
            far = max(1.0, float(abs(here.translation).max()))
            turned = abs(here.rotation - there.rotation).max()
            largest = max(largest, turned, abs(here.translation - there.translation).max() / far)
    if not largest <= TOLERANCE:
        found.append(f"frames are apart by {largest}")
    return found, float(largest)


def yourdfpy(source: Path, result: Path, states: int = 10) -> tuple[list[str], float]:
    """Return what differs for yourdfpy, and how far apart links are at random states."""
    one, other = (_yourdfpy(path) for path in (source, result))
    if set(one.link_map) != set(other.link_map) or one.actuated_joint_names != other.actuated_joint_names:
        return ["names of links or joints"], np.inf
    chance, largest = np.random.default_rng(6), 0.0
    for number in range(states + 1):
        state = {name: chance.uniform(-3, 3) * bool(number) for name in one.actuated_joint_names}
        one.update_cfg(state)
        other.update_cfg(state)
        for name in one.link_map:
            a, b = (np.array(robot.get_transform(name, robot.base_link)) for robot in (one, other))
            far = max(1.0, float(abs(a[:3, 3]).max()))
            largest = max(largest, abs(a[:3, :3] - b[:3, :3]).max(), abs(a[:3, 3] - b[:3, 3]).max() / far)
    return ([] if largest <= TOLERANCE else [f"links are apart by {largest}"]), float(largest)


def _yourdfpy(path: Path) -> Any:
    """Return a robot without its shapes, of which yourdfpy knows but four; where links are does not depend on them."""
    from yourdfpy import URDF

    document = parsed(path.read_bytes())
    for link in children(document.documentElement, "link"):
        for solid in (*children(link, "visual"), *children(link, "collision")):
            link.removeChild(solid)
    logging.getLogger("yourdfpy").setLevel(logging.CRITICAL)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return URDF.load(io.BytesIO(document.toxml("utf-8")), load_meshes=False, build_scene_graph=True)
