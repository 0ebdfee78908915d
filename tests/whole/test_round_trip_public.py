"""Round trip of descriptions that other people wrote: those of the package pybullet.

All of them are taken, but of its 1,000 random objects one in 25. pybullet itself is not imported.
"""

from importlib.util import find_spec
from pathlib import Path

import pytest

from support.round_trip import BOTH, judge, there_and_back

pytestmark = pytest.mark.slow

OBJECTS = "random_urdfs"
EVERY = 25

# What breaks the specification, and why it is refused.
REFUSED = {
    "bicycle/bike.urdf": '<joint name="handlebar_to_frontwheel">: "0.07," is not a number',
    "biped/biped2d_pybullet.urdf": '<joint name="torso_to_rightleg">: "-1.57." is not a number',
    "cube_no_rotation.urdf": 'error[limit-swapped]: the lower limit 1 m of joint "x_to_world" is above its upper limit',
    "humanoid/humanoid.urdf": "error[xml-syntax]: the character U+0000",
    "quadruped/microtaur/microtaur.urdf": "error[wrong-count]: rpy of <origin> of "
    '<joint name="dynamixel7_chassis_left"> has 4 numbers',
    "racecar/racecar_differential.urdf": 'error[wrong-count]: scale of <mesh> of <link name="chassis"> has 4 numbers',
    "spherical_joint_limit.urdf": '<joint name="neck"> is of type "spherical", which URDF does not have',
    "torus_deform.urdf": 'error[no-links]: the robot "torus" has no links',
}
LENIENT = ("cube_no_rotation.urdf", "racecar/racecar_differential.urdf")
MESH_REFUSED = ("table_square/table_square.urdf",)  # MuJoCo 4.0 refuses its mesh, but `all` writes the artifacts
XACRO = ("husky/husky.urdf",)  # a xacro in spite of its name: engines do not read it


def data() -> Path | None:
    found = find_spec("pybullet_data")
    return None if found is None or found.origin is None else Path(found.origin).parent


def files() -> list[str]:
    folder = data()
    if folder is None:
        return []
    names = sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*.urdf"))
    objects = [name for name in names if name.startswith(OBJECTS)]
    return [name for name in names if name not in objects] + objects[::EVERY]


NAMES = files()
ACCEPTED = [name for name in NAMES if name not in REFUSED]


@pytest.fixture(autouse=True)
def here(tmp_path: Path, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", str(tmp_path_factory.mktemp("cache")))
    folder = data()
    if folder is None:
        pytest.skip("pybullet is not installed: pip install 'rosorin-compile[test]' on Linux with Python 3.11")
    return folder


@pytest.mark.landing("robots", *ACCEPTED[::4])
@pytest.mark.parametrize("name", ACCEPTED)
def test_robot_of_other_people(here: Path, name: str) -> None:
    if name in XACRO:
        pytest.importorskip("xacro")
        there_and_back(here / name, "--verbatim")
        return
    source = (here / name).read_bytes()
    codes = (0, 1) if name in MESH_REFUSED else (0,)
    judge(source, there_and_back(here / name, "--verbatim", codes=codes), BOTH, states=10)


@pytest.mark.parametrize("name", sorted(REFUSED))
def test_broken_file_is_refused(here: Path, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    from rosorin_compile.cli.main import main

    assert main(["import", str(here / name), "-o", "made"]) == 1
    said = capsys.readouterr().err
    assert REFUSED[name] in said
    assert said.endswith("nothing written\n")
    assert not Path("made").exists()
    assert (main(["import", str(here / name), "-o", "made", "--lenient"]) == 0) == (name in LENIENT)
