"""rosorin-compile: one description of a robot in YAML, and every artifact that other programs read.

The public Python API: the verbs ``compile``, ``read``, ``check``, ``diff``, ``explain``, ``write`` and ``schema`` with
what they return (docs/python.md), and what a plug-in is made of (docs/extend.md); more of that is in ``model``,
``diagnostics`` and ``extending``. Each name is imported when it is first asked for, so that importing the package costs
nothing.
"""

from rosorin_compile.source.version import __version__

TYPE_CHECKING = False  # typing takes milliseconds to import, in which a Ctrl-C would end in a traceback

if TYPE_CHECKING:
    from rosorin_compile.api import (
        Checked,
        Explained,
        Written,
        check,
        check_physics,
        collisions,
        explain,
        schema,
        simulate,
        sweep,
        verify,
        write,
        write_sweep,
    )
    from rosorin_compile.cli.record import Check, Command
    from rosorin_compile.compare.difference import Difference
    from rosorin_compile.formats.facts import frame_facts
    from rosorin_compile.formats.format import Artifact, Fact, Facts, Format, Opened, Value
    from rosorin_compile.formats.templating import Templates
    from rosorin_compile.language.expression.functions import function
    from rosorin_compile.model import Robot
    from rosorin_compile.model.sections import Section
    from rosorin_compile.mujoco.collisions.matrix import CollisionMatrix
    from rosorin_compile.mujoco.physics.answers import CheckedPhysics
    from rosorin_compile.mujoco.simulate.simulation import Simulated
    from rosorin_compile.output.diff_inputs import diff
    from rosorin_compile.output.pipeline import Compiled, Reading, Variant, compile, read  # noqa: A004 - re.compile is called so, too
    from rosorin_compile.recordings.answers import Verified
    from rosorin_compile.rules.case import Case
    from rosorin_compile.source.diagnostics import Diagnostic, RequestError
    from rosorin_compile.source.rule_registry import Rule, rule
    from rosorin_compile.variants.writing import WrittenVariants

# Each public name and the module that has it.
_HOMES = {
    "Artifact": "formats.format",
    "Case": "rules.case",
    "Check": "cli.record",
    "Checked": "api",
    "CheckedPhysics": "mujoco.physics.answers",
    "CollisionMatrix": "mujoco.collisions.matrix",
    "Command": "cli.record",
    "Compiled": "output.pipeline",
    "Diagnostic": "source.diagnostics",
    "Difference": "compare.difference",
    "Explained": "api",
    "Fact": "formats.format",
    "Facts": "formats.format",
    "Format": "formats.format",
    "Opened": "formats.format",
    "Reading": "output.pipeline",
    "RequestError": "source.diagnostics",
    "Robot": "model",
    "Rule": "source.rule_registry",
    "Section": "model.sections",
    "Simulated": "mujoco.simulate.simulation",
    "Templates": "formats.templating",
    "Value": "formats.format",
    "Variant": "output.pipeline",
    "Verified": "recordings.answers",
    "Written": "api",
    "WrittenVariants": "variants.writing",
    "check": "api",
    "check_physics": "api",
    "collisions": "api",
    "compile": "output.pipeline",
    "diff": "output.diff_inputs",
    "explain": "api",
    "frame_facts": "formats.facts",
    "function": "language.expression.functions",
    "read": "output.pipeline",
    "rule": "source.rule_registry",
    "schema": "api",
    "simulate": "api",
    "sweep": "api",
    "verify": "api",
    "write": "api",
    "write_sweep": "api",
}

__all__ = [
    "Artifact",
    "Case",
    "Check",
    "Checked",
    "CheckedPhysics",
    "CollisionMatrix",
    "Command",
    "Compiled",
    "Diagnostic",
    "Difference",
    "Explained",
    "Fact",
    "Facts",
    "Format",
    "Opened",
    "Reading",
    "RequestError",
    "Robot",
    "Rule",
    "Section",
    "Simulated",
    "Templates",
    "Value",
    "Variant",
    "Verified",
    "Written",
    "WrittenVariants",
    "__version__",
    "check",
    "check_physics",
    "collisions",
    "compile",
    "diff",
    "explain",
    "frame_facts",
    "function",
    "read",
    "rule",
    "schema",
    "simulate",
    "sweep",
    "verify",
    "write",
    "write_sweep",
]


def __getattr__(name: str) -> object:
    """Return a public name, imported at this moment."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    value = getattr(import_module(f".{_HOMES[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
