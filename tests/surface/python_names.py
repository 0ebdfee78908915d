"""The public names of Python as lines: functions with their signatures, classes with what they have."""

from __future__ import annotations

import inspect
import re
import types
from collections.abc import Iterator
from importlib import import_module
from typing import Any

import rosorin_compile
from support.door import DOOR

_OURS = rosorin_compile.__name__
# A default that is a function shows where it is today.
_AT = re.compile(r"<function (\w+) at \w+>")


def lines() -> Iterator[str]:
    """Yield each name of the door, and each public attribute of the classes among them."""
    for module in (import_module(f"{_OURS}.{name}".rstrip(".")) for name in DOOR):
        for name in sorted(module.__all__):
            yield from _of(f"{module.__name__}.{name}", getattr(module, name))


def _of(name: str, value: Any) -> Iterator[str]:
    if isinstance(value, types.GenericAlias):
        yield f"{name} = {value}"
    elif inspect.isclass(value):
        yield f"{name} class"
        for attribute in sorted(_attributes(value)):
            yield f"{name}.{_member(value, attribute)}"
    elif callable(value):
        yield f"{name}{_signature(value)}"
    else:
        yield f"{name}: {type(value).__name__}"


def _attributes(kind: type) -> set[str]:
    """Return the public attributes that a class or one that it is made of says itself."""
    ours = [base for base in kind.__mro__ if base.__module__.startswith(_OURS)]
    names = {name for base in ours for name in (*vars(base), *vars(base).get("__annotations__", ()))}
    return {name for name in names if not name.startswith("_")}


def _member(kind: type, name: str) -> str:
    for base in kind.__mro__:
        annotation = vars(base).get("__annotations__", {}).get(name)
        if annotation is not None:
            # NamedTuple wraps what stands in the source.
            return f"{name}: {getattr(annotation, '__forward_arg__', annotation)}"
    value = inspect.getattr_static(kind, name)
    if isinstance(value, property):
        return f"{name}: {_returned(value.fget)}"
    if hasattr(value, "func"):  # a cached property
        return f"{name}: {_returned(value.func)}"
    if isinstance(value, (classmethod, staticmethod)):
        return f"{name}{_signature(value.__func__)} {type(value).__name__}"
    return f"{name}{_signature(value)}" if callable(value) else f"{name}: {type(value).__name__}"


def _returned(function: Any) -> str:
    return str(getattr(function, "__annotations__", {}).get("return", "Any"))


def _signature(function: Any) -> str:
    return _AT.sub(r"\1", str(inspect.signature(function)).replace("'", ""))
