"""A package that people have, and what is deployed into it."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.model import STATIC_TRANSFORM_PUBLISHER, Joint, Pose, Publisher, Robot
from rosorin_compile.ros.package.options import Options
from rosorin_compile.ros.package.package import make
from support.paths import ROOT, ROSORIN
from support.robots import compiled

TEXTS = {artifact.file: artifact.text for artifact in compiled().artifacts}
PACKAGE_XML = """\
<package format="3">
  <name>rosorin_base</name><version>0.1.0</version><description>d</description>
  <maintainer email="a@b.org">m</maintainer><license>MIT</license>
  <exec_depend>robot_state_publisher</exec_depend>
  <exec_depend>tf2_ros</exec_depend>
</package>
"""
SETUP = """\
import os
from glob import glob
from setuptools import setup
package_name = 'rosorin_base'
setup(name=package_name, version='0.1.0', packages=[package_name], data_files=[
    ('share/' + package_name, ['package.xml']),
    (os.path.join('share', package_name, 'launch'), glob(os.path.join('launch', '*.launch.py'))),
    ('share/rosorin_base/config', ['config/robot_model.json', 'config/ekf.yaml']),
])
"""
LAUNCH = """\
import os
from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch_ros.actions import Node


def mounted(node, place, angles, on, child):
    turned = ['--roll', angles[0], '--pitch', angles[1], '--yaw', angles[2]]
    return Node(package='tf2_ros', executable='static_transform_publisher', name=node, arguments=[
        '--x', place[0], '--y', place[1], '--z', place[2]] + turned + ['--frame-id', on, '--child-frame-id', child])


def generate_launch_description():
    share = get_package_share_directory('rosorin_base')
    urdf = open(os.path.join(share, 'urdf', 'rosorin.urdf')).read()
    return LaunchDescription([
        Node(package='robot_state_publisher', executable='robot_state_publisher', name='robot_state_publisher',
             parameters=[{'robot_description': urdf}]),
        mounted('tf_base_laser', ['0.048156', '0.0000756', '0.106748'], ['0', '0', '3.14159265'],
                'base_link', 'laser'),
        mounted('tf_base_imu', ['-0.027258', '-0.0000564', '0.048046'], ['0', '-0.0087266', '1.5707'],
                'base_link', 'imu_link'),
    ])
"""


def package_of_people(folder: Path) -> Path:
    """Write a package like that of a robot which has run for a while: old URDF, current model, launch by hand."""
    folder = folder / "ws" / "src" / "rosorin_base"
    files = {
        "package.xml": PACKAGE_XML,
        "setup.py": SETUP,
        "launch/base.launch.py": LAUNCH,
        "config/ekf.yaml": "ekf: {}\n",
        "config/robot_model.json": TEXTS["robot_model.json"],
        "urdf/rosorin.urdf": TEXTS["rosorin.urdf"].replace("7.5437e-05 0.16044", "7.5437e-05 0.17044"),
        "rosorin_base/__init__.py": "",
    }
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, "utf-8")
    return folder


def deploy(folder: Path, *words: str) -> int:
    return main(["deploy", str(ROSORIN), "-o", str(folder), *words])


def check(folder: Path, *words: str) -> int:
    return main(["check", "deployed", str(ROSORIN), str(folder), *words])


def contents(folder: Path) -> dict[str, str]:
    return {p.relative_to(folder).as_posix(): p.read_text("utf-8") for p in folder.rglob("*") if p.is_file()}


# Packages that tests write.


EXAMPLES = sorted(path.parent for path in (ROOT / "examples").rglob("robot.yaml"))
FORMS = ("py", "xml", "yaml")


def written(folder: Path, *words: str) -> Path:
    """Write the package of rosorin into a folder with a space in its name, and return it."""
    target = folder / "a folder" / "package"
    assert main(["package", str(ROSORIN), "-o", str(target), *words]) == 0
    return target


def names_in(folder: Path) -> list[str]:
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def made(folder: Path, robot: Robot) -> Path:
    """Write the package of a robot that no description says, and return it."""
    from rosorin_compile.formats import Artifact

    artifact = Artifact("robot.urdf", '<robot name="r"><link name="base_link"/></robot>', "urdf", "urdf")
    for name, data in make(robot, [artifact], Options("made"), (), folder)[0].items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    return folder


def static(name: str, parent: str, child: str, pose: Pose, node: str) -> Joint:
    return Joint(name, "fixed", parent, child, pose, publisher=Publisher(STATIC_TRANSFORM_PUBLISHER, node))


def describe(folder: Path, text: str) -> Path:
    path = folder / "descriptions" / "meshed" / "robot.yaml"
    path.parent.mkdir(parents=True)
    path.write_text(text, "utf-8")
    return path


def clean(*files: Path) -> None:
    """Check that files are what ament_flake8 and ament_pep257 ask of a ROS 2 package."""
    ruff = shutil.which("ruff") or shutil.which("ruff", path=str(Path(sys.executable).parent))
    if ruff is None:
        pytest.skip("ruff is not installed")
    house = ["--line-length=99", "--config=lint.flake8-quotes.inline-quotes='single'"]
    house += ["--config=lint.isort.force-sort-within-sections=true", "--config=lint.isort.known-third-party=['launch']"]
    rules = ["--select=E,F,W,I,D,B,UP,N,Q,PTH", "--ignore=D203,D213"]
    command = [ruff, "check", "--isolated", *house, *rules, *map(str, files)]
    checked = subprocess.run(command, capture_output=True, text=True, check=False)
    assert files
    assert checked.returncode == 0, checked.stdout
