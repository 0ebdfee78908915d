"""Proof: the SDF that an imported one becomes is held against it in Drake, where the Python that runs this has it."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rosorin_compile.compare.proof import Found, Proof, Tolerance
from rosorin_compile.formats.imported import Imported
from rosorin_compile.model import Robot
from rosorin_compile.source.diagnostics import counted
from rosorin_compile.source.installing import is_installed

STATES = 20
SECONDS = 300
_SEED = 14
_ENGINE = Path(__file__).with_name("engine.py")


def prove(imported: Imported, text: str, files: Mapping[str, str], python: str = "") -> Proof:  # noqa: ARG001
    """Return how Drake tells an SDF of ours from its source; nothing where there is no Drake.

    ``python`` has Drake; default: this one, if it has. Meshes are not opened.
    """
    if not python and not is_installed("pydrake"):
        return Proof()
    return Proof.of(imported, (text, python), _by_drake)


def _by_drake(imported: Imported, made: tuple[str, str]) -> Found | str:
    """Return what Drake tells apart; ``made`` is the SDF, and the Python that has Drake."""
    text, python = made
    robot = imported.robot
    if robot is None:
        return Found()
    led = [joint for joint in robot.joints if joint.moves and joint.mimic is None]
    states = Proof.states([(joint, -1.0, 1.0) for joint in led], STATES, _SEED)
    for state in states:
        state |= {one.name: robot.position(one, state) for one in robot.joints if one.mimic is not None}
    with tempfile.TemporaryDirectory(prefix="rosorin-compile-") as folder:
        file = Path(folder, "made.sdf")
        file.write_text(text, "utf-8")
        answer = ask([imported.files[0].absolute(), file], "world", states, python)
    if isinstance(answer, str):
        return answer
    source, ours = answer
    for who, one in (("the source", source), ("what it becomes", ours)):
        if "refused" in one:
            lines = [line for line in one["refused"].splitlines() if line.strip()] or ["no reason said"]
            return f"Drake does not load {who}: {lines[-1].strip()[:200]}"
    return _compared(robot, source, ours, bool(imported.left_out))


def ask(files: Sequence[Path], root: str, states: Sequence[Mapping[str, Any]], python: str = "") -> list[Any] | str:
    """Return what the engine says of files; why it says nothing in its place."""
    words = json.dumps({"files": [str(file) for file in files], "root": root, "states": list(states)})
    call = [python or sys.executable, "-P", str(_ENGINE)]
    try:
        ran = subprocess.run(call, input=words, capture_output=True, text=True, timeout=SECONDS, check=False)  # noqa: S603
    except (OSError, subprocess.TimeoutExpired) as problem:
        return f"Drake did not come to an end: {type(problem).__name__}"
    if ran.returncode:
        return f"Drake gave up: {(ran.stderr.strip().splitlines() or ['no reason said'])[-1][:200]}"
    found: list[Any] = json.loads(ran.stdout)
    return found


def _compared(robot: Robot, source: Mapping[str, Any], ours: Mapping[str, Any], listed: bool) -> Found:
    """Return what differs; where the import has listed something as left out, that is known."""
    found: list[tuple[str, str]] = []
    worst, count = 0.0, 0
    for name in robot.link:
        if name not in ours["frames"][0] or name not in source["frames"][0]:
            continue
        count += 1
        pairs = zip(source["frames"], ours["frames"], strict=True)
        apart = max(Tolerance.apart(before[name], after[name]) for before, after in pairs)
        worst = max(worst, apart)
        if apart > Tolerance.POSE:
            found.append(("frames", f"frame {name} is {apart:.2g} elsewhere"))
    for name, mass in source["masses"].items():
        other = ours["masses"].get(name)
        if other is None or not Tolerance.same(mass, other):
            found.append(("masses", f"link {name} weighs {mass} -> {other} kg"))
        elif Tolerance.apart(source["inertias"][name], ours["inertias"][name]) > Tolerance.NUMBER:
            found.append(("inertias", f"the inertia of link {name} is another"))
    for name, said in source["joints"].items():
        kept = ours["joints"].get(name)
        if kept is not None and kept != said:
            found.append(("joints", f"joint {name}: {said} -> {kept}"))
    same = (
        f"Drake sees the same robot: {counted(count, 'frame')} at {STATES} random joint states, largest difference"
        f" {worst:.2g}, and {counted(len(source['masses']), 'mass')} with their inertias"
    )
    return Found(found, lambda *_: listed, lambda _: "" if listed else same)
