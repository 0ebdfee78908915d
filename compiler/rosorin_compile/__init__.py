"""Compile a YAML description of a robot to URDF, MJCF, SDF, ROS parameters and other files.

The names in ``__all__`` are the Python API (docs/python.md). ``rosorin_compile.model`` and ``rosorin_compile.extend``
(for plug-ins, docs/extend.md) are also public. Names are imported on first use, so that importing the package is fast.
"""

from rosorin_compile.source.version import __version__

TYPE_CHECKING = False  # importing typing takes milliseconds, during which Ctrl-C prints a traceback

# fmt: off
# isort: off
if TYPE_CHECKING:
    from rosorin_compile.api import (
        Arguments, CheckResult, ExplainResult, Outputs, Rules, WriteResult, arguments, check, collisions, compile,  # noqa: A004
        diff, explain, explain_rules, outputs, read, schema, write,
    )
    from rosorin_compile.compare.difference import Difference
    from rosorin_compile.formats.compilation import CompileResult, ReadResult, Variant
    from rosorin_compile.formats.format import Artifact
    from rosorin_compile.importing.extract.extract import extract_boxes, extract_height_map
    from rosorin_compile.importing.extract.factory import extract_factory
    from rosorin_compile.importing.import_robot import import_robot
    from rosorin_compile.importing.new_robot import NewRobot, init
    from rosorin_compile.joint_values import Pulses, pulses
    from rosorin_compile.language.arguments import Argument
    from rosorin_compile.model import Robot
    from rosorin_compile.mujoco.collisions import CollisionMatrix
    from rosorin_compile.mujoco.physics import CheckedPhysics, check_physics
    from rosorin_compile.mujoco.simulation import Simulation, simulate
    from rosorin_compile.recordings import verify
    from rosorin_compile.recordings.results import Verification
    from rosorin_compile.ros.check_parameters.check import check_parameters
    from rosorin_compile.ros.graph import graph
    from rosorin_compile.ros.package.deploy import check_deployed, deploy
    from rosorin_compile.ros.package.package import package
    from rosorin_compile.source.diagnostics import Diagnostic, RequestError, UnknownName
    from rosorin_compile.transforms import FrameTransform, Transforms, transform
    from rosorin_compile.variants.sweep import WrittenVariants, sweep, write_sweep
    from rosorin_compile.viewer.frames import Frames, frames
    from rosorin_compile.viewer.picture.draw import Picture, picture
    from rosorin_compile.viewer.robot_view import Page, view

_MODULES = {
    "api": "Arguments CheckResult ExplainResult Outputs Rules WriteResult arguments check collisions compile diff "
           "explain explain_rules outputs read schema write",
    "compare.difference": "Difference",
    "formats.compilation": "CompileResult ReadResult Variant",
    "formats.format": "Artifact",
    "importing.extract.extract": "extract_boxes extract_height_map",
    "importing.extract.factory": "extract_factory",
    "importing.import_robot": "import_robot",
    "importing.new_robot": "NewRobot init",
    "joint_values": "Pulses pulses",
    "language.arguments": "Argument",
    "model": "Robot",
    "mujoco.collisions": "CollisionMatrix",
    "mujoco.physics": "CheckedPhysics check_physics",
    "mujoco.simulation": "Simulation simulate",
    "recordings": "verify",
    "recordings.results": "Verification",
    "ros.check_parameters.check": "check_parameters",
    "ros.graph": "graph",
    "ros.package.deploy": "check_deployed deploy",
    "ros.package.package": "package",
    "source.diagnostics": "Diagnostic RequestError UnknownName",
    "transforms": "FrameTransform Transforms transform",
    "variants.sweep": "WrittenVariants sweep write_sweep",
    "viewer.frames": "Frames frames",
    "viewer.picture.draw": "Picture picture",
    "viewer.robot_view": "Page view",
}
_HOME = {name: module for module, names in _MODULES.items() for name in names.split()}
__all__ = [
    "Argument", "Arguments", "Artifact", "CheckResult", "CheckedPhysics", "CollisionMatrix", "CompileResult",
    "Diagnostic", "Difference", "ExplainResult", "FrameTransform", "Frames", "NewRobot", "Outputs", "Page", "Picture",
    "Pulses", "ReadResult", "RequestError", "Robot", "Rules", "Simulation", "Transforms", "UnknownName", "Variant",
    "Verification", "WriteResult", "WrittenVariants", "__version__", "arguments", "check", "check_deployed",
    "check_parameters", "check_physics", "collisions", "compile", "deploy", "diff", "explain", "explain_rules",
    "extract_boxes", "extract_factory", "extract_height_map", "frames", "graph", "import_robot", "init", "outputs",
    "package", "picture", "pulses", "read", "schema", "simulate", "sweep", "transform", "verify", "view", "write",
    "write_sweep",
]
# isort: on
# fmt: on


def __getattr__(name: str) -> object:
    """Import and return a public name on first access."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}; plug-ins import {__name__}.extend")
    from importlib import import_module

    globals()[name] = value = getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
