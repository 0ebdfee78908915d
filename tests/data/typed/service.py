"""A service that embeds the compiler: the verbs, and the records that they return. See tests/whole/test_typed.py."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import rosorin_compile
from rosorin_compile import (
    Artifact,
    CheckResult,
    CompileResult,
    Diagnostic,
    Difference,
    ExplainResult,
    ReadResult,
    WriteResult,
)
from rosorin_compile.extend import ERROR, Case, Format, Span, Templates, did_you_mean, rule
from rosorin_compile.model import Box, Joint, Mesh, Output, Robot, Transform, Vector


def compiled(name: str, arguments: dict[str, object]) -> tuple[str, tuple[str, ...]]:
    made: CompileResult = rosorin_compile.compile(name, arguments, packages={"arm": Path("arm")})
    if made.robot is None:
        return "", tuple(place(one) for one in made.diagnostics if one.severity == ERROR)
    artifacts: tuple[Artifact, ...] = made.artifacts
    print(artifacts[0].files)  # type: ignore[attr-defined]
    return {artifact.file: artifact.text for artifact in artifacts}["robot.urdf"], ()


def place(one: Diagnostic) -> str:
    span: Span | None = one.span
    return f"{span.source.path}:{span.line}: {one.message}" if span is not None else one.message


def movers(robot: Robot) -> Iterator[tuple[str, Vector, float]]:
    joint: Joint
    for joint in robot.joints:
        upper = joint.limit.upper if joint.limit is not None else None
        inertial = robot.link[joint.child].inertial
        if upper is not None and upper > 0 and inertial is not None:
            yield joint.name, joint.origin.xyz, inertial.mass


def reads(path: Path) -> list[str]:
    reading: ReadResult = rosorin_compile.read(path, lenient=True)
    if reading.robot is None:
        return []
    seen: Transform = reading.robot.transform("base_link", "laser", {"joint1": 0.5})
    shapes = [shape.geometry for link in reading.robot.links for shape in link.collision]
    files = [shape.file for shape in shapes if isinstance(shape, Mesh)]
    sizes = [str(shape.size) for shape in shapes if isinstance(shape, Box)]
    return [did_you_mean("lasr", [link.name for link in reading.robot.links]), str(seen.xyz), *files, *sizes]


def same(name: str, file: Path) -> bool:
    difference: Difference = rosorin_compile.diff(name, file, tolerance=1e-6)
    checked: CheckResult = rosorin_compile.check(name, outputs="outputs")
    return difference.same and checked.same and not checked.differing


def written(name: str, folder: Path) -> tuple[str, ...]:
    done: WriteResult = rosorin_compile.write(name, outputs=folder, prune=True)
    explained: ExplainResult = rosorin_compile.explain(name, ["laser"], pose="tuck")
    title: str = rosorin_compile.schema("description")["title"]
    return (*done.written, title, str(explained))


@rule("too-long", "A name is too long for the service.", accept="link")
def too_long(case: Case) -> Iterator[Diagnostic]:
    for link in case.robot.links:
        if len(link.name) > 40:
            yield case.problem("too-long", f"{link.name} is too long", case.link(link.name))


def write(robot: Robot, _output: Output, _templates: Templates) -> tuple[str, list[Diagnostic]]:
    return f"{robot.name} {robot.joints[0].origin.xyz}", []


FORMAT = Format(
    name="service",
    word="service",
    article="a",
    about="the robot",
    file="{}.s",
    write=write,
    view=lambda robot, _: robot,
    read=lambda text: Robot(text.split()[0], (), ()),
)
