"""Sites, cameras, lights and bodies of a simulation: the values that MuJoCo accepts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.rule_registry import SIMULATED, rule
from rosorin_compile.source.tree import Path

from .case import Case, number

_MOVING = ("never", "allowed", "init")
# How many sizes a site of a form has; those behind them mean nothing.
_SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "ellipsoid": 3, "box": 3}


@rule("mark-value", help="Correct it as the message says.", topic=SIMULATED)
def marks(case: Case) -> Iterator[Diagnostic]:
    """A site, a camera or a light of a simulation has a value that MuJoCo refuses, or contradictory values."""
    for link in case.robot.links:
        for mark in link.marked:
            problems = {"camera": _camera, "light": _light}.get(mark.tag, _site)(mark.values)
            for key, message, help in (*problems, *(_aimed(mark.values) if mark.tag != "site" else ())):
                path = case.link(link.name, f"{mark.tag}s", mark.name, key)
                yield case.problem("mark-value", f'{mark.tag} "{mark.name}" {message}', path, help, key=True)


def _site(values: Any) -> Iterator[tuple[str, str, str]]:
    size = values.get("size")
    count = 1 if "fromto" in values else _SIZES.get(str(values.get("type", "sphere")), 0)  # fromto gives the length
    smallest = min(map(float, size[:count]), default=1.0) if isinstance(size, tuple) else 1.0
    if smallest <= 0:
        yield "size", f"has a size of {number(smallest)}", "write sizes above zero"


def _light(values: Any) -> Iterator[tuple[str, str, str]]:
    softness, direction = values.get("softness"), values.get("dir")
    if isinstance(softness, float) and not 0 <= softness <= 1:
        yield "softness", f"has a softness of {number(softness)}", "write a number from 0 to 1"
    if isinstance(direction, tuple) and not any(direction):
        yield "dir", "shines in no direction", "write one, such as [0, 0, -1]"


def _camera(values: Any) -> Iterator[tuple[str, str, str]]:
    of_chip = [word for word in ("focal", "focalpixel", "principal", "principalpixel") if word in values]
    if of_chip and "sensorsize" not in values:
        yield of_chip[0], f"has {of_chip[0]} and no sensorsize", "write sensorsize: [WIDTH, HEIGHT] of the chip, in m"
    if "fovy" in values and "sensorsize" in values:
        yield "fovy", "has fovy and sensorsize, which exclude each other", "leave one of them out"
    if "sensorsize" in values and not {"focal", "focalpixel"} & set(values):
        yield "sensorsize", "has a sensorsize and no focal length", "write focal: [X, Y], in m"
    output, resolution, fovy = values.get("output"), values.get("resolution"), values.get("fovy")
    if isinstance(output, tuple) and len(set(output)) < len(output):
        yield "output", "makes one output twice", "leave one of them out"
    if isinstance(resolution, tuple) and min(map(float, resolution)) <= 0:
        yield "resolution", "has a picture without pixels", "write numbers above zero"
    pairs = [values[word] for word in ("sensorsize", "focal", "focalpixel") if isinstance(values.get(word), tuple)]
    if any(float(size) <= 0 for pair in pairs for size in pair):
        yield "sensorsize", "has sizes that are not above zero", "write those of its data sheet"
    if isinstance(fovy, float) and not 0 < fovy < 180 and values.get("projection") != "orthographic":
        yield "fovy", f"sees {number(fovy)} degrees", "write an angle between 0 and 180 degrees"


def _aimed(values: Any) -> Iterator[tuple[str, str, str]]:
    mode = str(values.get("mode", "fixed"))
    if "target" in values and not mode.startswith("targetbody"):
        yield "target", f"has a target, and its mode is {mode}", "write mode: targetbody"
    elif mode.startswith("targetbody") and "target" not in values:
        yield "mode", "has a mode that needs a target", "write target: LINK"


@rule("body-value", help="Move it to the root link, or leave it out.", topic=SIMULATED)
def bodies(case: Case) -> Iterator[Diagnostic]:
    """A link has an attribute of a body that MuJoCo accepts of the root alone: `mocap`, `sleep`."""
    world, root = case.robot.root_in_world.world, case.robot.root_in_world.values
    others = ", ".join(sorted(set(root) - {"align", "group"}))
    if "align" in root and others:
        message = f"the root has align and {others}, which MuJoCo does not take together"
        yield case.problem("body-value", message, ("root", "mjcf", "align"), "leave it out", key=True)
    bases = {output.options.get("base", "fixed") for output in case.robot.outputs if output.backend == "mjcf"}
    for link in case.robot.links:
        path: Path = case.link(link.name, "mjcf")
        joint = case.robot.joint_to.get(link.name)
        is_root = joint is None or (world and joint.parent == case.robot.root)
        is_held = not is_root or (joint is not None and not joint.is_fixed) or ("free" in bases and not world)
        if link.mjcf.get("mocap") is True and is_held:
            message = f'link "{link.name}" has mocap: a program moves it, and a joint moves or holds it'
            help = "only the root link can, with base: fixed in the output, or a link fixed to a root that is the world"
            yield case.problem("body-value", message, (*path, "mocap"), help, key=True)
        if link.mjcf.get("sleep") in _MOVING and (not is_root or (("fixed" in bases or not bases) and not world)):
            message = f'link "{link.name}" has sleep, which only a free base can have'
            help = "write it in the root link, with base: free in the output, or leave it out"
            yield case.problem("body-value", message, (*path, "sleep"), help, key=True)
