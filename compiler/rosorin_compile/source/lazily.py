"""Public names of a module that are imported when somebody first asks for them, from where they really are."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def lazily(module: str, homes: Mapping[str, str], names: dict[str, Any]) -> Callable[[str], Any]:
    """Return the ``__getattr__`` of a module: it imports a name from its home, a module of this package or of another.

    ``names`` is the namespace of the module, where what was asked for stays.
    """
    package = __name__.partition(".")[0]

    def asked(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {module!r} has no attribute {name!r}")
        home = homes[name] if homes[name].startswith(package) else f"{package}.{homes[name]}"
        names[name] = getattr(import_module(home), name)
        return names[name]

    return asked
