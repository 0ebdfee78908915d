"""Convert three robots from URDF to MJCF with seven converters, and compare each result with its URDF.

Each converter gets a virtual environment with the version below. Every result is loaded in the newest MuJoCo and
compared with numbers that pinocchio computes from the URDF. A converter that fails has its error in the table.

Run with Python of the test extra: ``python benchmarks/converters.py --environments FOLDER``. The environments take
2.2 GB and are used again by the next run. ``--write docs/converters.md`` writes the tables into the page;
``--check docs/converters.md`` compares them with it, and exits with 1 if they differ.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import venv
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from urdf_reference import reference

ROOT = Path(__file__).parents[1]
SECONDS = 300  # for one conversion, or one measurement
ENVIRON = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
ROBOT_DATA = "example-robot-data==6.0.0"
MARKERS = "<!-- tables of benchmarks/converters.py -->\n", "<!-- end of tables -->\n"

BY_MUJOCO = """
import sys, mujoco
spec = mujoco.MjSpec.from_file(sys.argv[1])
spec.compiler.fusestatic = False
spec.compile()
open(sys.argv[2], "w").write(spec.to_xml())
"""
BY_CYBERWAVE = """
import sys
from cyberwave_robot_format.mjcf import MJCFExporter
from cyberwave_robot_format.urdf import URDFParser
MJCFExporter().export(URDFParser().parse(sys.argv[1]), sys.argv[2])
"""


@dataclass(frozen=True)
class Converter:
    """A converter: its PyPI requirement, or None for this repository, and its command lines.

    ``{bin}`` is the folder of programs of its environment. The commands run in a copy of the folder of ``robot.urdf``
    and write one MJCF below it; ``usd``, if the converter has it, writes ``made.usda`` instead. ``options`` explains
    the options to the reader of the page.
    """

    name: str
    requirement: str | None
    commands: tuple[tuple[str, ...], ...]
    options: str
    usd: tuple[str, ...] = ()


MUJOCO = Converter(
    "MuJoCo",
    "mujoco==4.0.0",
    (("{bin}/python", "-c", BY_MUJOCO, "robot.urdf", "made.xml"),),
    "`fusestatic` off, which keeps the links on fixed joints; it reads no DAE, and drops visual shapes by default",
)
CONVERTERS = (
    MUJOCO,
    Converter(
        "truerig",
        "truerig[usd]==0.1.1",
        (("{bin}/truerig", "convert", "robot.urdf", "made.xml"),),
        "defaults",
        ("{bin}/truerig", "convert", "robot.urdf", "made.usda"),
    ),
    Converter(
        "urdf2any",
        "urdf2any[mjcf-validate,skin]==0.3.0",
        (("{bin}/urdf2any", "robot.urdf", "-o", "made.xml"),),
        "defaults",
        ("{bin}/urdf2any", "robot.urdf", "-o", "made.usda"),
    ),
    Converter(
        "urdf-mujoco-converter",
        "urdf-mujoco-converter==0.1.0",
        (("{bin}/urdf-mujoco-converter", "robot.urdf", "made", "--allow-convex-hull"),),
        "`--allow-convex-hull`, without which it refuses most meshes",
    ),
    Converter(
        "scikit-robot",
        "scikit-robot[usd]==0.4.7",
        (("{bin}/convert-urdf-to-mjcf", "robot.urdf", "-o", "made.xml"),),
        "defaults; `--self-collision` turns contacts between links on, `--joint-damping` sets one damping for all",
        ("{bin}/convert-urdf-to-usd", "robot.urdf", "-o", "made.usda"),
    ),
    Converter(
        "cyberwave",
        "cyberwave-robot-format[usd]==0.1.8",
        (("{bin}/python", "-c", BY_CYBERWAVE, "robot.urdf", "made.xml"),),
        "`URDFParser` and `MJCFExporter`, without options",
        ("{bin}/python", "-c", BY_CYBERWAVE.replace("mjcf", "usd").replace("MJCF", "USD"), "robot.urdf", "made.usda"),
    ),
    Converter(
        "rosorin-compile",
        None,
        (
            ("{bin}/python", "-m", "rosorin_compile", "import", "robot.urdf", "-o", "descriptions/robot"),
            ("{bin}/python", "-m", "rosorin_compile", "all", "descriptions/robot", "-o", "made"),
        ),
        "defaults of `import` and `all`",
    ),
)
ROWS = {
    "frames": "links found as a body or a site",
    "position": "largest error of the position of a link (mm)",
    "angle": "largest error of the orientation of a link (deg)",
    "mass": "error of the mass (kg)",
    "inertia": "error of the joint-space inertia matrix (%)",
    "visuals": "links with a visual shape",
    "mimic": "mimic joints with an equality constraint",
    "damping": "joints with the same damping",
    "friction": "joints with the same friction",
    "limits": "joints with the same position limits",
    "effort": "joints with the same effort limit",
    "armature": "joints with armature",
    "pairs": "pairs of links that can touch",
    "contacts": "pairs of links in contact at rest",
    "actuators": "actuators",
}


def main() -> int:
    """Run all converters on all robots, print the tables, and write or check the page."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--environments", type=Path, required=True, help="folder of the virtual environments")
    parser.add_argument(
        "--robots", type=Path, help="folder that example-robot-data is installed in; default: install it"
    )
    parser.add_argument("--write", type=Path, help="page to write the tables into")
    parser.add_argument("--check", type=Path, help="page to compare the tables with")
    options = parser.parse_args()
    environments = options.environments.resolve()
    failures = {one.name: install(one.requirement, environments / one.name) for one in CONVERTERS if one.requirement}
    if failures[MUJOCO.name]:
        sys.exit(f"MuJoCo, which measures the results, is not installed: {failures[MUJOCO.name]}")
    share = robot_data(options.robots, environments / "example-robot-data")
    with tempfile.TemporaryDirectory() as work:
        tables = [_versions(failures)]
        for name, title in robots(share, Path(work)):
            tables.append(table(title, Path(work, name), environments, failures))
        tables.append(other_abilities(Path(work, "panda"), environments, failures))
    text = "\n".join(tables)
    print(text)
    page = options.write or options.check
    if page is None:
        return 0
    old = page.read_text("utf-8")
    new = "".join(
        (old.partition(MARKERS[0])[0], MARKERS[0], "\n", text, "\n", MARKERS[1], old.partition(MARKERS[1])[2])
    )
    if options.write:
        page.write_text(new, "utf-8")
    elif old != new:
        print(f"{page} differs from these tables: run {Path(__file__).name} with --write", file=sys.stderr)
    return int(bool(options.check) and old != new)


def install(requirement: str, folder: Path) -> str:
    """Create the environment of a converter unless it exists, and return the error of pip in one line, or ""."""
    note = folder / "requirement"
    if note.is_file() and note.read_text("utf-8") == requirement:
        return ""
    venv.create(folder, with_pip=True, clear=True)
    error = run((f"{folder}/bin/python", "-m", "pip", "install", "--quiet", requirement), Path())[1]
    if not error:
        note.write_text(requirement, "utf-8")
    return error


def robot_data(installed: Path | None, folder: Path) -> Path:
    """Return the folder of the package of robots: the installed one if it has the version, or else a new one."""
    note = "{}-{}.dist-info".format(*ROBOT_DATA.replace("-", "_").split("=="))
    for place in (installed, folder):
        if place and (place / note).is_dir():
            return place.resolve()
    pip = (sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target", str(folder), ROBOT_DATA)
    if error := run(pip, Path())[1]:
        sys.exit(error)
    return folder


def run(command: tuple[str, ...], folder: Path) -> tuple[str, str]:
    """Run a program and return its output, and the last line of its error if it failed, or ""."""
    try:
        done = subprocess.run(
            command, cwd=folder, env=ENVIRON, capture_output=True, text=True, timeout=SECONDS, check=False
        )
    except subprocess.TimeoutExpired:
        return "", f"no result after {SECONDS} s"
    if done.returncode == 0:
        return done.stdout, ""
    lines = [line.strip() for line in (done.stderr.strip() or done.stdout.strip()).splitlines() if line.strip()]
    return "", re.sub(r"(/[\w.@-]+)+/", "", (lines or [f"exit code {done.returncode}"])[-1]).partition(". ")[0][:200]


def robots(share: Path, work: Path) -> list[tuple[str, str]]:
    """Write each robot into a folder, as ``robot.urdf`` with its meshes adjacent, and return names and titles."""
    import xacro

    found = share / "cmeel.prefix" / "share"
    models = found / "example-robot-data" / "robots"
    burger = xacro.process_file(str(ROOT / "examples/turtlebot3_burger/xacro/robot.xacro")).toxml()
    arm = (models / "panda_description/urdf/panda.urdf").read_text("utf-8")
    mobile = (models / "tiago_pro_description/robots/tiago_pro.urdf").read_text("utf-8")
    for name, text in (("turtlebot3_burger", burger), ("panda", arm), ("tiago_pro", mobile)):
        folder, copies = work / name, dict[str, str]()
        folder.mkdir()
        root = ET.fromstring(text)  # noqa: S314
        for mesh in root.iter("mesh"):
            source = found / mesh.attrib["filename"].removeprefix("package://")
            copy = copies.setdefault(str(source), f"{source.stem}_{len(copies)}{source.suffix.lower()}")
            mesh.set("filename", copy)
            shutil.copy(source, folder / copy)
        ET.ElementTree(root).write(folder / "robot.urdf")
    return [
        ("turtlebot3_burger", "TurtleBot3 Burger: wheels, no meshes"),
        ("panda", "Franka Panda: an arm with a gripper; DAE and STL meshes, one mimic joint"),
        ("tiago_pro", "TIAGo Pro: a mobile robot with two arms; STL meshes, ten mimic joints"),
    ]


def convert(converter: Converter, folder: Path, environments: Path) -> tuple[Path | None, str]:
    """Convert ``robot.urdf`` in a folder and return the MJCF or None, and the error in one line, or ""."""
    start, error = time.perf_counter(), ""
    for command in converter.commands:
        error = error or run(_words(converter, command, environments), folder)[1]
    print(f"{folder.name}, {converter.name}: {time.perf_counter() - start:.1f} s {error}", file=sys.stderr)
    made = sorted(folder.rglob("*.xml"))
    return (made[0] if made and not error else None), error or ("" if made else "no file was written")


def _words(converter: Converter, command: tuple[str, ...], environments: Path) -> tuple[str, ...]:
    programs = environments / converter.name / "bin" if converter.requirement else Path(sys.executable).parent
    return tuple(word.replace("{bin}", str(programs)) for word in command)


def measured(converter: Converter, source: Path, environments: Path, numbers: Path) -> tuple[dict[str, Any], str]:
    """Return the numbers of the result of a converter, or its error or that of MuJoCo in one line."""
    with tempfile.TemporaryDirectory() as work:
        folder = Path(shutil.copytree(source, Path(work, source.name)))
        made, error = convert(converter, folder, environments)
        if made is None:
            return {}, f"no result: {error}"
        program = f"{environments}/{MUJOCO.name}/bin/python", str(ROOT / "benchmarks" / "measure_mjcf.py")
        output, error = run((*program, str(numbers), str(made)), folder)
    if error:
        raise RuntimeError(f"measure_mjcf.py: {error}")
    result = json.loads(output)
    return result, f"MuJoCo does not load the result: {result.pop('error')}" if "error" in result else ""


def _versions(failures: dict[str, str]) -> str:
    lines = ["| converter | version | options |", "|---|---|---|"]
    for one in CONVERTERS:
        version = f"`{one.requirement}`" if one.requirement else "this repository"
        lines.append(f"| {one.name} | {version} | {failures.get(one.name) or one.options} |")
    return "\n".join([*lines, ""])


def table(title: str, folder: Path, environments: Path, failures: dict[str, str]) -> str:
    """Return the table of one robot, a column per converter, with the errors of converters below it."""
    numbers = folder.with_suffix(".json")
    expected = reference(folder / "robot.urdf")
    numbers.write_text(json.dumps(expected), "utf-8")
    joints = expected["joints"].values()
    full = {"frames": len(expected["links"]), "visuals": len(expected["visuals"]), "pairs": len(expected["pairs"])}
    full |= dict.fromkeys(("damping", "friction", "limits", "effort"), len(joints))
    full["mimic"] = sum(joint["mimic"] is not None for joint in joints)
    errors, columns = [], []
    for converter in CONVERTERS:
        column, error = {}, failures.get(converter.name, "")
        if not error:
            column, error = measured(converter, folder, environments, numbers)
        columns.append(column)
        errors += [f"- {converter.name}: {error}"] if error else []
    lines = [f"### {title}", "", *_head("")]
    for key, label in ROWS.items():
        if full.get(key) != 0:
            cells = (_cell(key, column[key], full.get(key)) if column else "error" for column in columns)
            lines.append(f"| {label} | {' | '.join(cells)} |")
    return "\n".join([*lines, "", *errors, *([""] if errors else [])])


def _head(first: str) -> list[str]:
    return [f"| {first} | {' | '.join(one.name for one in CONVERTERS)} |", "|---" * (len(CONVERTERS) + 1) + "|"]


def _cell(key: str, value: float, full: int | None) -> str:
    if full is not None:
        return f"{value} of {full}"
    scales = {"position": (1000, 2), "angle": (180 / np.pi, 2), "mass": (1, 3), "inertia": (100, 2)}
    if key not in scales:
        return str(value)
    factor, digits = scales[key]
    text = f"{abs(value) * factor:.{digits}f}"
    return "0" if not float(text) else ("-" if value < 0 else "") + text


def other_abilities(source: Path, environments: Path, failures: dict[str, str]) -> str:
    """Return the table of which converters convert a robot whose mesh files do not exist, and write USD."""
    errors, without, usd = [], [], []
    for converter in CONVERTERS:
        error = failures.get(converter.name, "")
        with tempfile.TemporaryDirectory() as work:
            folder = Path(work, "without_meshes")
            folder.mkdir()
            shutil.copy(source / "robot.urdf", folder)
            error = error or convert(converter, folder, environments)[1]
        without.append("no" if error else "yes")
        errors += [f"- {converter.name}, without meshes: {error}"] if error else []
        with tempfile.TemporaryDirectory() as work:
            folder = Path(shutil.copytree(source, Path(work, "robot")))
            error = run(_words(converter, converter.usd, environments), folder)[1] if converter.usd else ""
            usd.append("yes" if (folder / "made.usda").is_file() and not error else "no")
        errors += [f"- {converter.name}, USD: {error}"] if error else []
    rows = (("converts the Panda without its mesh files", without), ("writes the Panda as USD", usd))
    lines = ["### Missing meshes, and USD", "", *_head("")]
    return "\n".join([*lines, *(f"| {label} | {' | '.join(cells)} |" for label, cells in rows), "", *errors, ""])


if __name__ == "__main__":
    sys.exit(main())
