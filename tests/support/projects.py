"""Projects with one robot, ``r``, that reads files of all kinds; each is made in the current folder."""

import shutil
import struct
from pathlib import Path

from support.commands import write_files
from support.paths import DATA, ROOT, ROSORIN


def stl() -> bytes:
    """Return a tetrahedron as binary STL."""
    corners = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    faces = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
    return (
        bytes(80)
        + struct.pack("<I", 4)
        + b"".join(
            struct.pack("<12fH", 0, 0, 0, *(value for corner in face for value in corners[corner]), 0) for face in faces
        )
    )


def rosorin_alone() -> None:
    shutil.copytree(ROSORIN.parent, "descriptions/r")


def ur5e() -> None:
    shutil.copytree(ROOT / "examples" / "ur5e", "descriptions/r")


def packaged() -> None:
    """A xacro in a ROS package, which includes another, and a YAML file that it reads."""
    shutil.copytree(DATA / "include_robot" / "ros", "ros")
    shutil.copytree(DATA / "include_robot" / "descriptions" / "packaged", "descriptions/r")


def foreign() -> None:
    """A URDF and an MJCF that are included, and of the MJCF what it includes."""
    shutil.copytree(DATA / "include_robot" / "descriptions" / "simulated", "descriptions/r")


def meshes() -> None:
    """Meshes of two formats that are copied and converted, a template with a part, a table and a calibration."""
    write_files(
        Path(),
        {
            "descriptions/r/robot.yaml": """\
robot: r
include: [more.yaml, x/v.xacro]
args: {x: {type: length, default: 1}}
let: {table: '${load("data/table.yaml")}'}
links:
  base:
    collision:
      - {mesh: {file: box.stl}}
      - {height_map: {origin: [0, 0], cell: 0.1, step: 0.1, method: by hand, heights: "${table.heights}"}}
joints: {v: {type: fixed, parent: base, child: v_base}, p: {type: fixed, parent: base, child: more}}
outputs:
  urdf: {file: r.urdf}
  mjcf: {file: sim/r.xml}
  note: {template: note.txt.jinja, file: note.txt}
  page: {file: r.html}
""",
            "descriptions/r/more.yaml": "links: {more: {visual: [{mesh: {file: 'package://p/m/ball.obj'}}]}}\n",
            "descriptions/r/data/table.yaml": "heights: [[0.1, 0.2], [0.1, 0.3]]\n",
            "descriptions/r/note.txt.jinja": "{% include 'part.jinja' %} {{ robot.name }}\n",
            "descriptions/r/part.jinja": "a part\n",
            "descriptions/r/x/v.xacro": """\
<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="v"><xacro:include filename="macro.xacro"/>
<xacro:property name="t" value="${xacro.load_yaml('t.yaml')}"/><link name="v_base"/><xacro:m/></robot>
""",
            "descriptions/r/x/macro.xacro": """\
<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro name="m"><link name="v_${t['a']}"/>
<joint name="v_j" type="fixed"><parent link="v_base"/><child link="v_${t['a']}"/></joint></xacro:macro></robot>
""",
            "descriptions/r/x/t.yaml": "a: tip\n",
            "p/package.xml": "<package><name>p</name></package>",
            "p/m/ball.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n",
            "cal.yaml": "x: 2 m\n",
        },
    )
    Path("descriptions/r/box.stl").write_bytes(stl())
