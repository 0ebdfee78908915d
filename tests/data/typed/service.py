"""What a service of somebody may be that embeds the compiler: each verb, and the records that they return.

mypy in its strict mode and pyright have nothing to say of it (tests/whole/test_typed.py).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import rosorin_compile
from rosorin_compile import Artifact, Checked, Compiled, Diagnostic, Difference, Explained, Reading, Written
from rosorin_compile.extend import ERROR, Case, Format, Span, Templates, did_you_mean, rule
from rosorin_compile.model import Box, Joint, Link, Mesh, Output, Pose, Robot, Transform, Vector
from rosorin_compile.output import OutputError, write_file
from rosorin_compile.source.diagnostics import count_of, has_errors, phrase
from rosorin_compile.source.load import LoadError
from rosorin_compile.source.tree import Map
from rosorin_compile.source.units import Quantity


@dataclass(frozen=True)
class Answer:
    """What the service answers with."""

    text: str
    errors: tuple[str, ...]
    mass: float = 0.0


def compiled(name: str, arguments: dict[str, object]) -> Answer:
    made: Compiled = rosorin_compile.compile(name, arguments, packages={"arm": Path("arm")})
    if made.robot is None:
        return Answer("", tuple(place(one) for one in made.diagnostics if one.severity == ERROR))
    artifacts: tuple[Artifact, ...] = made.artifacts
    texts = {artifact.file: artifact.text for artifact in artifacts}
    return Answer(texts["robot.urdf"], (), mass(made.robot))


def place(one: Diagnostic) -> str:
    span: Span | None = one.span
    return f"{span.source.path}:{span.line}: {one.message}" if span is not None else one.message


def mass(robot: Robot) -> float:
    return sum(link.inertial.mass for link in robot.links if link.inertial is not None)


def movers(robot: Robot) -> Iterator[tuple[str, Vector]]:
    joint: Joint
    for joint in robot.joints:
        upper = joint.limit.upper if joint.limit is not None else None
        if upper is not None and upper > 0:
            yield joint.name, joint.origin.xyz


def sizes(link: Link) -> Iterable[str]:
    for shape in link.collision:
        if isinstance(shape.geometry, Box):
            yield f"a box of {shape.geometry}"
        elif isinstance(shape.geometry, Mesh):
            yield shape.geometry.file


def reads(path: Path) -> list[str]:
    reading: Reading = rosorin_compile.read(path, lenient=True)
    wrong: bool = has_errors(reading.diagnostics)
    if reading.robot is None or wrong:
        return [count_of(len(reading.diagnostics), "problem")]
    seen: Transform = reading.robot.transform("base_link", "laser", {"joint1": 0.5})
    return [did_you_mean("lasr", [link.name for link in reading.robot.links]), phrase(map(str, seen.xyz))]


def same(name: str, file: Path) -> bool:
    difference: Difference = rosorin_compile.diff(name, file, tolerance=1e-6)
    checked: Checked = rosorin_compile.check(name, outputs="outputs")
    return difference.same and checked.same and not checked.differing


def written(name: str, folder: Path) -> tuple[str, ...]:
    done: Written = rosorin_compile.write(name, outputs=folder, prune=True)
    explained: Explained = rosorin_compile.explain(name, ["laser"], pose="tuck")
    try:
        write_file(folder / "laser.txt", str(explained).encode())
    except (OutputError, LoadError) as problem:
        return (problem.diagnostic.message,)
    title: str = rosorin_compile.schema("description")["title"]
    return (*done.written, title)


def metres(text: str, tree: Map) -> float:
    quantity: Quantity | None = Quantity.parse(text)
    return quantity if quantity is not None else float(tree["length"])


@rule("too-long", "A name is too long for the service.", accept="link")
def too_long(case: Case) -> Iterator[Diagnostic]:
    for link in case.robot.links:
        if len(link.name) > 40:
            yield case.problem("too-long", f"{link.name} is too long", case.link(link.name))


def write(robot: Robot, _output: Output, _templates: Templates) -> tuple[str, list[Diagnostic]]:
    pose: Pose = robot.joints[0].origin
    return f"{robot.name} {pose.xyz}", []


def view(robot: Robot, _output: Output) -> Robot:
    return Robot(robot.name, robot.links, ())


def read(text: str) -> Robot:
    return Robot(text.split()[0], (), ())


FORMAT = Format(
    name="service", word="service", article="a", about="the robot", file="{}.s", write=write, view=view, read=read
)
