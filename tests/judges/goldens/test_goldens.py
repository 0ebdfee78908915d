"""The artifacts of forty robots are the same to the byte as they were when their digests were written."""

from __future__ import annotations

import difflib
import hashlib
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from support.paths import ROOT
from support.robots import compiled

HERE = Path(__file__).parent
DIGESTS = HERE / "digests.txt"
DATA = "tests/data"
DESCRIPTIONS = [
    "descriptions/rosorin",
    *(
        f"examples/{name}"
        for name in ("ackermann_car", "omni_base", "porter", "turtlebot3_burger", "unitree_a1", "ur5e")
    ),
    *(
        f"tests/imported/{name}/expected"
        for name in ("alike", "burger", "dog", "hand", "hexapod", "little_arm", "rover", "two_arms")
    ),
    *(f"{DATA}/navigation/{name}" for name in ("fetcher", "husky", "lopsided", "mule")),
    *(
        f"{DATA}/controllers/{name}.yaml"
        for name in ("ackermann", "arm", "differential", "mecanum", "omni", "tricycle", "tricycle_steering")
    ),
    *(f"{DATA}/include_robot/descriptions/{name}" for name in ("cell", "simulated")),
    *(f"{DATA}/{name}" for name in ("whole", "extreme_numbers.yaml")),
    *(
        f"tests/judges/goldens/every_word/{name}.yaml"
        for name in ("robot", "ackermann", "differential", "omni", "tricycle", "world")
    ),
]
IMPORTED = [
    *(f"{DATA}/mjcf/kept/{name}.xml" for name in ("balls", "everything", "hovering", "references")),
    f"{DATA}/mjcf/compared/everything.xml",
    *(
        f"{DATA}/mjcf/corners/{name}.xml"
        for name in ("anchors", "angles", "balls", "bricks", "defaults", "followers", "free", "masses", "several")
    ),
    *(f"{DATA}/sdf/corners/{name}.sdf" for name in ("classic", "kept", "shapes")),
]
CHAINS = {"chain that turns": "revolute", "chain that slides": "prismatic"}
ROBOTS = [*DESCRIPTIONS, *IMPORTED, *CHAINS]


def chain(kind: str, links: int = 200) -> str:
    """Return a description of a chain whose links all differ."""
    lines = ["robot: chain", "outputs: {urdf: {file: c.urdf}, mjcf: {file: c.xml}, sdf: {file: c.sdf}}", "links:"]
    lines += [
        f"  l{n}: {{inertial: {{mass: {1 + n / 100:.2f}, of: collision}},"
        f" collision: [{{cylinder: {{radius: {20 + n} mm, length: {100 + n} mm}}}}]}}"
        for n in range(links)
    ]
    lines.append("joints:")
    lines += [
        f"  j{n}: {{type: {kind}, parent: l{n - 1}, child: l{n}, xyz: [0, 0, {100 + n} mm], axis: [0, 1, 0],"
        f" limit: {{lower: -{n / 100:.2f}, upper: {n / 50:.2f}, effort: {n}, velocity: 1}}}}"
        for n in range(1, links)
    ]
    return "\n".join(lines) + "\n"


def rows(robot: str, folder: Path) -> Iterator[str]:
    """Yield the digest of each artifact of a robot, and of its YAML where that is made here."""
    if robot in DESCRIPTIONS:
        path = ROOT / robot
        path = path if path.suffix else path / "robot.yaml"
    else:
        path = folder / "robot.yaml"
        if robot in CHAINS:
            path.write_text(chain(CHAINS[robot]), "utf-8")
        else:
            source = shutil.copytree((ROOT / robot).parent, folder / "source") / Path(robot).name
            assert main(["import", str(source), "-o", str(folder / "made"), "-q"]) == 0
            path = folder / "made" / "robot.yaml"
            yield from (_row(robot, file.name, file.read_bytes()) for file in sorted(path.parent.glob("*.yaml")))
    for artifact in sorted(compiled(path).artifacts, key=lambda one: one.file):
        yield _row(robot, artifact.file, artifact.text.encode())


def _row(robot: str, file: str, data: bytes) -> str:
    return f"{robot}: {file} {hashlib.sha256(data).hexdigest()[:16]}"


@pytest.mark.parametrize("robot", ROBOTS)
def test_the_artifacts_are_as_they_were(tmp_path: Path, robot: str) -> None:
    committed = [line for line in DIGESTS.read_text("utf-8").splitlines() if line.startswith(f"{robot}: ")]
    moved = [line for line in difflib.ndiff(committed, list(rows(robot, tmp_path))) if line[0] in "-+"]
    assert moved == []


if __name__ == "__main__":
    made: list[str] = []
    for each in ROBOTS:
        with tempfile.TemporaryDirectory() as place:
            made += rows(each, Path(place))
    DIGESTS.write_text("".join(f"{row}\n" for row in made), "utf-8")
    sys.stdout.write(f"{len(made)} digests of {len(ROBOTS)} robots\n")
