"""Springs of joints and poses of bases that a simulation cannot do anything with."""

from __future__ import annotations

from collections.abc import Iterator

from rosorin_compile.source.diagnostics import NOTE, Diagnostic
from rosorin_compile.source.rule_registry import Check
from rosorin_compile.source.tree import Path

from .case import Case, number


@Check
def springs(case: Case) -> Iterator[Diagnostic]:
    """Springs that MuJoCo makes of a time and a ratio (dynamics-negative)."""
    for joint in case.robot.joints:
        yields = joint.mjcf.get("springyield")
        if isinstance(yields, float) and yields < 0:
            message = f'the springyield of joint "{joint.name}" is {number(yields)}, below zero'
            path = case.joint(joint, "mjcf", "springyield")
            yield case.problem("dynamics-negative", message, path, "write it without the sign")
        pair = joint.mjcf.get("springdamper")
        if isinstance(pair, tuple) and any(float(one) <= 0 for one in pair) and any(pair):
            message = f'the springdamper of joint "{joint.name}" is not above zero'
            path = case.joint(joint, "mjcf", "springdamper")
            yield case.problem("dynamics-negative", message, path, "write a time in s and a ratio above zero")


@Check
def bases(case: Case) -> Iterator[Diagnostic]:
    """Poses of the base of a robot whose base stands still in every MJCF (ignored-key)."""
    bases = [
        output.options.get("base", "fixed")
        for output in case.robot.outputs
        if output.backend in case.formats and "base" in case.formats[output.backend].options
    ]
    if not bases or "free" in bases or case.robot.moveit is not None:  # whose virtual joint it places
        return
    for pose in case.robot.poses:
        if pose.base is not None:
            message = f'pose "{pose.name}" places the base, which is fixed in every output: no effect'
            path: Path = ("poses", pose.name, "base")
            yield case.problem("ignored-key", message, path, "say base: free in the output", severity=NOTE, key=True)
