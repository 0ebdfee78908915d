"""rosorin-compile: compile one YAML description of a robot to the files that other programs read.

The names in ``__all__`` are the Python API (docs/python.md): the functions of ``api`` and the dataclasses of
``results``. ``rosorin_compile.model`` and ``rosorin_compile.extend``, which has the records of plug-ins
(docs/extend.md), are public beside them. Names are imported on first use, so that importing the package is fast.
"""

from rosorin_compile.source.version import __version__

TYPE_CHECKING = False  # typing takes milliseconds to import, in which a Ctrl-C would end in a traceback

# fmt: off
# isort: off
if TYPE_CHECKING:
    from rosorin_compile.api import (
        arguments, check, check_deployed, check_parameters, check_physics, collisions, compile, deploy,  # noqa: A004
        diff, explain, explain_rules, extract_boxes, extract_factory, extract_height_map, frames, graph,
        import_robot, init, outputs, package, picture, pulses, read, schema, simulate, sweep, transform,
        verify, view, write, write_sweep,
    )
    from rosorin_compile.results import (
        Argument, Arguments, Artifact, Checked, CheckedPhysics, CollisionMatrix, Compiled, Diagnostic,
        Difference, Explained, Frames, FrameTransform, NewRobot, Outputs, Page, Picture, Pulses, Reading,
        RequestError, Robot, Rules, Simulated, Transforms, UnknownName, Variant, Verified, Written,
        WrittenVariants,
    )

__all__ = [
    "Argument", "Arguments", "Artifact", "Checked", "CheckedPhysics", "CollisionMatrix", "Compiled", "Diagnostic",
    "Difference", "Explained", "FrameTransform", "Frames", "NewRobot", "Outputs", "Page", "Picture", "Pulses",
    "Reading", "RequestError", "Robot", "Rules", "Simulated", "Transforms", "UnknownName", "Variant", "Verified",
    "Written", "WrittenVariants", "__version__", "arguments", "check", "check_deployed", "check_parameters",
    "check_physics", "collisions", "compile", "deploy", "diff", "explain", "explain_rules", "extract_boxes",
    "extract_factory", "extract_height_map", "frames", "graph", "import_robot", "init", "outputs", "package", "picture",
    "pulses", "read", "schema", "simulate", "sweep", "transform", "verify", "view", "write", "write_sweep",
]
# isort: on
# fmt: on


def __getattr__(name: str) -> object:
    """Return a public name, imported at this moment."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}; plug-ins import {__name__}.extend")
    from rosorin_compile import api, results

    globals()[name] = value = getattr(api if name.islower() else results, name)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
