"""rosorin-compile: one description of a robot in YAML, and every artifact that other programs read.

The public Python API (docs/python.md): ``compile``, ``read``, ``diff`` and the values that they return. Each name is
imported when it is first asked for, so that importing the package costs nothing.
"""

__version__ = "0.1.0"

TYPE_CHECKING = False  # as typing has it, which costs milliseconds
if TYPE_CHECKING:
    from .diagnostic import Diagnostic as Diagnostic
    from .difference import Difference as Difference
    from .difference.reading import diff as diff
    from .emit.record import Format as Format
    from .expression.functions import function as function
    from .model import Robot as Robot
    from .pipeline import Compiled as Compiled
    from .pipeline import Reading as Reading
    from .pipeline import compile as compile  # noqa: A004 - re.compile is called so, too
    from .pipeline import read as read
    from .registry import rule as rule

# Each public name and the module that has it.
_HOMES = {
    "Compiled": "pipeline",
    "Diagnostic": "diagnostic",
    "Difference": "difference",
    "Format": "emit.record",
    "Reading": "pipeline",
    "Robot": "model",
    "compile": "pipeline",
    "diff": "difference.reading",
    "function": "expression.functions",
    "read": "pipeline",
    "rule": "registry",
}

__all__ = [
    "Compiled",
    "Diagnostic",
    "Difference",
    "Format",
    "Reading",
    "Robot",
    "__version__",
    "compile",
    "diff",
    "function",
    "read",
    "rule",
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
