"""Sites, cameras, lights and bodies of a simulation: what MuJoCo takes of them, and where."""

from __future__ import annotations

from collections.abc import Iterator

from rosorin_compile.model.simulation import Marked
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.rule_registry import SIMULATED, rule

from .case import Case, number

# What a camera with a chip is described by; what it has without one.
_OF_CHIP = ("focal", "focalpixel", "principal", "principalpixel")
_MOVING = ("never", "allowed", "init")


@rule(
    "mark-value",
    "A site, a camera or a light of a simulation has a value that MuJoCo does not take, or two that go against each "
    "other.",
    "As the message says.",
    SIMULATED,
)
def marks(case: Case) -> Iterator[Diagnostic]:
    """Find marks of links that MuJoCo would refuse."""
    for link in case.robot.links:
        for mark in link.marked:
            wrong = _camera(mark) if mark.tag == "camera" else _light(mark) if mark.tag == "light" else _site(mark)
            for key, message, help in wrong:
                path = case.link(link.name, f"{mark.tag}s", mark.name, key)
                yield case.problem("mark-value", f'{mark.tag} "{mark.name}" {message}', path, help, key=True)


# How many sizes a site of a form has; what stands behind them means nothing.
_SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "ellipsoid": 3, "box": 3}


def _site(mark: Marked) -> Iterator[tuple[str, str, str]]:
    size = mark.values.get("size")
    count = _SIZES.get(str(mark.values.get("type", "sphere")), 0)
    if "fromto" in mark.values:  # which says the length
        count = 1
    own = [float(value) for value in size[:count]] if isinstance(size, tuple) else []
    if not all(value > 0 for value in own):
        yield "size", f"has a size of {number(min(own))}", "write sizes above zero"


def _light(mark: Marked) -> Iterator[tuple[str, str, str]]:
    softness = mark.values.get("softness")
    if isinstance(softness, float) and not 0 <= softness <= 1:
        yield "softness", f"has a softness of {number(softness)}", "write a number from 0 to 1"
    direction = mark.values.get("dir")
    if isinstance(direction, tuple) and not any(direction):
        yield "dir", "shines in no direction", "write one, such as [0, 0, -1]"
    yield from _aimed(mark)


def _camera(mark: Marked) -> Iterator[tuple[str, str, str]]:
    values = mark.values
    of_chip = next((word for word in _OF_CHIP if word in values), "")
    if of_chip and "sensorsize" not in values:
        yield of_chip, f"has {of_chip} and no sensorsize", "write sensorsize: [WIDTH, HEIGHT] of the chip, in m"
    if "fovy" in values and "sensorsize" in values:
        yield "fovy", "has fovy and sensorsize, two words for what it sees", "leave one of them out"
    if "sensorsize" in values and not {"focal", "focalpixel"} & set(values):
        yield "sensorsize", "has a sensorsize and no focal length", "write focal: [X, Y], in m"
    output = values.get("output")
    if isinstance(output, tuple) and len(set(output)) < len(output):
        yield "output", "makes one output twice", "leave one of them out"
    resolution = values.get("resolution")
    if isinstance(resolution, tuple) and not all(float(value) > 0 for value in resolution):
        yield "resolution", "has a picture without pixels", "write numbers above zero"
    sized = [values[word] for word in ("sensorsize", "focal", "focalpixel") if isinstance(values.get(word), tuple)]
    if any(float(one) <= 0 for pair in sized if isinstance(pair, tuple) for one in pair):
        yield "sensorsize", "has sizes that are not above zero", "write what its data sheet says"
    fovy = values.get("fovy")
    if isinstance(fovy, float) and not 0 < fovy < 180 and values.get("projection") != "orthographic":
        yield "fovy", f"sees {number(fovy)} degrees", "write an angle between 0 and 180 degrees"
    yield from _aimed(mark)


def _aimed(mark: Marked) -> Iterator[tuple[str, str, str]]:
    mode = str(mark.values.get("mode", "fixed"))
    if mode.startswith("targetbody") != ("target" in mark.values):
        if "target" in mark.values:
            yield "target", f"has a target, and its mode is {mode}", "write mode: targetbody"
        else:
            yield "mode", "looks at a target that it does not name", "write target: LINK"


@rule(
    "body-value",
    "A link has an attribute of a body that MuJoCo takes of the root alone: `mocap` of one that is fixed in the world, "
    "`sleep` of one that is free.",
    "Move it to the root link, or leave it out.",
    SIMULATED,
)
def bodies(case: Case) -> Iterator[Diagnostic]:
    """Attributes of bodies that stand elsewhere than MuJoCo takes them."""
    root = case.robot.root_in_world.values
    if "align" in root and not set(root) <= {"align", "group"}:
        others = ", ".join(sorted(set(root) - {"align", "group"}))
        message = f"the root has align and {others}, which MuJoCo does not take together"
        yield case.problem("body-value", message, ("root", "mjcf", "align"), "leave it out", key=True)
    bases = {output.options.get("base", "fixed") for output in case.robot.outputs if output.backend == "mjcf"}
    for link in case.robot.links:
        if not link.mjcf:
            continue
        path = case.link(link.name, "mjcf")
        joint = case.robot.joint_to.get(link.name)
        world = case.robot.root_in_world.world
        is_root = joint is None or (world and joint.parent == case.robot.root)
        if link.mjcf.get("mocap") is True and (
            not is_root or (joint is not None and not joint.is_fixed) or ("free" in bases and not world)
        ):
            message = f'link "{link.name}" is to go where a program puts it (mocap), and a joint moves or holds it'
            help = (
                "only the root link can, with base: fixed in the output, or what is fixed to a root that is the world"
            )
            yield case.problem("body-value", message, (*path, "mocap"), help, key=True)
        if link.mjcf.get("sleep") in _MOVING and (not is_root or (("fixed" in bases or not bases) and not world)):
            message = f'link "{link.name}" says how it sleeps, which only a free base does'
            help = "say it of the root link, with base: free in the output, or leave it out"
            yield case.problem("body-value", message, (*path, "sleep"), help, key=True)
