"""Import of a URDF against xacro on the same file and against loading it in yourdfpy: UR5e, and a chain of 100 links.

Import reads the file, writes the description, compiles it, reads the compiled URDF again and compares.
xacro reads the file and writes it. yourdfpy reads it and builds its tree of transforms. Processor time of whole
processes, in pairs.

Run with the environment's Python: ``python benchmarks/import_urdf.py [PAIRS] [LINKS]``.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from pairs import compare, row, used

BIN = Path(sys.executable).parent
OURS = str(BIN / "rosorin-compile")
UR5E = Path(__file__).resolve().parents[1] / "examples" / "ur5e"
GOALS = {"xacro": None, "yourdfpy, load": 3.0}  # xacro has nothing to expand here: it reads the file and writes it
LOAD = "import sys, yourdfpy; yourdfpy.URDF.load(sys.argv[1], load_meshes=False)"


def main(pairs: int, links: int) -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as name:
        os.chdir(name)
        os.environ["ROSORIN_COMPILE_CACHE"] = str(Path(name, "cache"))
        os.environ["PYTHONPYCACHEPREFIX"] = str(Path(name, "bytecode"))  # every program has its bytecode, as installed
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
        made = subprocess.run([OURS, "print", str(UR5E), "urdf"], check=True, capture_output=True, text=True)
        print(f"{'import':<42} {'ours':>11} {'the other':>11}   ratio, median of {pairs} pairs")
        for robot, text in (("UR5e", made.stdout), (f"{links} links", chain(links))):
            Path("robot.urdf").write_text(text, "utf-8")
            others = {
                "xacro": [str(BIN / "xacro"), "robot.urdf", "-o", "xacro.urdf"],
                "yourdfpy, load": [sys.executable, "-c", LOAD, "robot.urdf"],
            }
            for other, command in others.items():
                ratio = compare(_import, lambda: used(command).seconds, pairs)  # noqa: B023
                print(row(f"import of {robot} / {other}", ratio, GOALS[other]))


def _import() -> float:
    shutil.rmtree("made", ignore_errors=True)
    return used([OURS, "import", "robot.urdf", "-o", "made"]).seconds


def chain(links: int) -> str:
    """Return the URDF of a chain: each link with inertia, two shapes and a joint that turns."""
    made = ['<?xml version="1.0"?>', '<robot name="chain">', '  <link name="base"/>']
    for number in range(links - 1):
        parent = f"link_{number - 1}" if number else "base"
        made += [
            f'  <link name="link_{number}">',
            '    <inertial><origin xyz="0 0 0.05"/><mass value="0.8"/>',
            '      <inertia ixx="0.0011" ixy="0" ixz="0" iyy="0.0012" iyz="0" izz="0.0004"/></inertial>',
            '    <visual><origin xyz="0 0 0.05" rpy="0 0 1.5707963267948966"/>',
            f'      <geometry><mesh filename="package://chain_description/meshes/part_{number % 7}.stl"/></geometry>',
            '      <material name="grey"><color rgba="0.5 0.5 0.5 1"/></material></visual>',
            '    <collision><origin xyz="0 0 0.05"/>',
            '      <geometry><cylinder radius="0.03" length="0.1"/></geometry></collision>',
            "  </link>",
            f'  <joint name="joint_{number}" type="revolute">',
            f'    <origin xyz="0 0 {0.1 + number / 1000}" rpy="{number / 500} 0 0.7853981633974483"/>',
            f'    <parent link="{parent}"/><child link="link_{number}"/><axis xyz="0 1 0"/>',
            '    <limit lower="-1.5707963267948966" upper="1.5707963267948966" effort="30" velocity="2.5"/>',
            '    <dynamics damping="0.1" friction="0.02"/>',
            "  </joint>",
        ]
    return "\n".join([*made, "</robot>", ""])


if __name__ == "__main__":
    words = [int(word) for word in sys.argv[1:]]
    main(words[0] if words else 7, words[1] if len(words) > 1 else 100)
