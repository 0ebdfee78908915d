"""rosorin-compile: one description of a robot in YAML, and every artifact that other programs read.

The public Python API: the verbs ``compile``, ``read``, ``check``, ``diff``, ``explain``, ``write`` and ``schema`` with
what they return (docs/python.md), and what a plug-in is made of (docs/extend.md); more of that is in ``model``,
``diagnostics`` and ``extending``. Each name is imported when it is first asked for, so that importing the package costs
nothing.
"""

TYPE_CHECKING = False  # typing takes milliseconds to import, in which a Ctrl-C would end in a traceback

__version__ = "0.3.0"

if TYPE_CHECKING:
    from .commands.record import Check, Command
    from .commands.sides import diff
    from .commands.verbs import Checked, Explained, Written, check, explain, schema, write
    from .diagnostics import Diagnostic
    from .diagnostics.registry import Rule, rule
    from .formats.facts import frame_facts
    from .formats.format import Artifact, Fact, Facts, Format, Opened, Value
    from .formats.templating import Templates
    from .frontend.expression.functions import function
    from .meaning.difference import Difference
    from .model import Robot
    from .model.sections import Section
    from .pipeline import (
        Compiled,
        Reading,
        Variant,
        compile,  # noqa: A004 - re.compile is called so, too
        read,
    )
    from .rules.case import Case

# Each public name and the module that has it.
_HOMES = {
    "Artifact": "formats.format",
    "Case": "rules.case",
    "Check": "commands.record",
    "Checked": "commands.verbs",
    "Command": "commands.record",
    "Compiled": "pipeline",
    "Diagnostic": "diagnostics",
    "Difference": "meaning.difference",
    "Explained": "commands.verbs",
    "Fact": "formats.format",
    "Facts": "formats.format",
    "Format": "formats.format",
    "Opened": "formats.format",
    "Reading": "pipeline",
    "Robot": "model",
    "Rule": "diagnostics.registry",
    "Section": "model.sections",
    "Templates": "formats.templating",
    "Value": "formats.format",
    "Variant": "pipeline",
    "Written": "commands.verbs",
    "check": "commands.verbs",
    "compile": "pipeline",
    "diff": "commands.sides",
    "explain": "commands.verbs",
    "frame_facts": "formats.facts",
    "function": "frontend.expression.functions",
    "read": "pipeline",
    "rule": "diagnostics.registry",
    "schema": "commands.verbs",
    "sweep": "commands.verbs",
    "write": "commands.verbs",
}

__all__ = [
    "Artifact",
    "Case",
    "Check",
    "Checked",
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
    "Robot",
    "Rule",
    "Section",
    "Templates",
    "Value",
    "Variant",
    "Written",
    "__version__",
    "check",
    "compile",
    "diff",
    "explain",
    "frame_facts",
    "function",
    "read",
    "rule",
    "schema",
    "sweep",
    "write",
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
