"""Values of parameters: what type one has, and what its validators refuse.

The validators are those of ``PickNikRobotics/generate_parameter_library`` and two of joint_trajectory_controller
(``validate_jtc_parameters.hpp`` of ros2_controllers).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rosorin_compile.source.diagnostics import Help, Suggestion, listed, quoted

_WORDS = {"bool": "true or false", "int": "a whole number", "double": "a double", "string": "a text"}
_UNQUOTED = {
    "bool": re.compile("yes|no|true|false|on|off", re.IGNORECASE),
    "int": re.compile(r"[-+]?\d+"),
    "double": re.compile(r"[-+]?\d+\.\d*"),
}
_NONE = re.compile(r"(?!)")
_MANY = {"bool": "booleans", "int": "whole numbers", "double": "doubles", "string": "texts"}


def fits(value: Any, kind: str) -> bool:
    """Say whether a value is of a type of the tables, as rcl takes it: 1 is no double.

    >>> fits(1, "double"), fits(1.0, "double"), fits([1, 2.0], "double_array"), fits("a", "string or string_array")
    (False, True, False, True)
    """
    return any(_is(value, one) for one in kind.split(" or "))


def _is(value: Any, kind: str) -> bool:
    if kind == "none":
        return True
    if kind.endswith("_array"):
        return isinstance(value, (list, tuple)) and all(_is(item, kind.removesuffix("_array")) for item in value)
    kinds: Mapping[str, Any] = {"bool": bool, "int": int, "double": float, "string": str}
    return isinstance(value, kinds[kind]) and (kind == "bool" or not isinstance(value, bool))


def converted(value: Any, kind: str) -> Any:
    """Return a value as its type wants it written, where that is the same number; else the value itself."""
    for one in kind.split(" or "):
        if one.endswith("_array") and isinstance(value, (list, tuple)):
            return [converted(item, one.removesuffix("_array")) for item in value]
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if one == "double" and is_number:
            return float(value)
        if one == "int" and isinstance(value, float) and value.is_integer():
            return int(value)
    return value


def type_in_words(kind: str) -> str:
    """Return a type of the tables as a message has it."""

    def one(word: str) -> str:
        base, _, many = word.partition("_")
        return f"a list of {_MANY[base]}" if many else _WORDS[base]

    return " or ".join(map(one, kind.split(" or ")))


def value_text(value: Any) -> str:
    """Return a value of a wrong type as a message has it."""
    if isinstance(value, (list, tuple)):
        kinds = {"int": "int", "float": "double", "str": "string", "bool": "bool"}
        found = dict.fromkeys(_MANY.get(kinds.get(type(item).__name__, ""), "other things") for item in value)
        return f"a list of {listed(found)}" if found else "an empty list"
    return "nothing" if value is None else f"the text {written(value)}" if isinstance(value, str) else written(value)


def as_type(value: Any, kind: str) -> str:
    """Return the fix for a value of the wrong type."""
    meant = converted(value, kind)
    if fits(meant, kind):
        return f"write {written(meant)}"
    if isinstance(value, str) and _UNQUOTED.get(kind, _NONE).fullmatch(value):
        return "write it without quotes"
    if kind == "string_array" and isinstance(value, str):
        return f"write [{value}]"
    if kind == "string" and isinstance(value, (bool, int, float)):
        return f'write "{written(value)}"'
    return f"write {type_in_words(kind)}"


def written(value: Any) -> str:
    """Return a value as YAML has it, in one line."""
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(written, value))}]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return repr(value)
    return f'"{value}"' if isinstance(value, str) else str(value)


def refused(valid: Mapping[str, Sequence[Any]], value: Any) -> tuple[str, Help] | None:
    """Return why validators refuse a value of its type, and a way out, in words; None if they do not."""
    for name, arguments in valid.items():
        check = _VALIDATORS.get(name)
        why = check(value, *arguments) if check is not None else ""
        if why:
            return why if isinstance(why, tuple) else (why, "")
    return None


def _bound(holds: Callable[[float, float], bool], words: str) -> Callable[..., str]:
    def check(value: float, limit: float) -> str:
        return "" if holds(value, limit) else f"is {written(value)}, and has to be {words} {limit:g}"

    return check


def _or_nan(check: Callable[..., str]) -> Callable[..., str]:
    return lambda value, limit: "" if math.isnan(value) else check(value, limit)


_above = _bound(lambda value, limit: value > limit, "above")
_at_least = _bound(lambda value, limit: value >= limit, "at least")
_at_most = _bound(lambda value, limit: value <= limit, "at most")


def _one_of(value: Any, allowed: Sequence[Any]) -> str | tuple[str, Help]:
    return "" if value in allowed else (f"cannot be {written(value)}", Suggestion(str(value), [*map(str, allowed)]))


def _subset_of(value: Sequence[Any], allowed: Sequence[Any]) -> str | tuple[str, Help]:
    others = [str(one) for one in value if one not in allowed]
    return (f"cannot have {quoted(others)}", Suggestion(others[0], [*map(str, allowed)])) if others else ""


def _not_empty(value: Any) -> str:
    return "" if len(value) else "is empty"


def _unique(value: Sequence[Any]) -> str:
    twice = [str(one) for one in dict.fromkeys(value) if value.count(one) > 1]
    return f"has {quoted(twice)} twice" if twice else ""


def _size(holds: Callable[[int, int], bool], words: str = "") -> Callable[..., str]:
    def check(value: Sequence[Any], *sizes: int) -> str:
        wanted = " or ".join(map(str, sizes))
        fits = any(holds(len(value), size) for size in sizes)
        return "" if fits else f"has {len(value)} values, and needs {words}{wanted}"

    return check


def _commands(value: Sequence[str]) -> str:
    if "velocity" in value and len(value) > 1 and "position" not in value:
        return "has to have velocity alone, or beside position"
    if "acceleration" in value and "velocity" not in value and "position" not in value:
        return "has to have position and velocity beside acceleration"
    return "has to have effort alone" if "effort" in value and len(value) > 1 else ""


def _states(value: Sequence[str]) -> str:
    if "velocity" in value and "position" not in value:
        return "has to have position beside velocity"
    if "acceleration" in value and not {"position", "velocity"} <= set(value):
        return "has to have position and velocity beside acceleration"
    return ""


_VALIDATORS: Mapping[str, Callable[..., str | tuple[str, Help]]] = {
    "gt": _above,
    "gt_eq": _at_least,
    "one_of": _one_of,
    "subset_of": _subset_of,
    "not_empty": _not_empty,
    "unique": _unique,
    "fixed_size": _size(lambda size, wanted: size == wanted),
    "size_gt": _size(lambda size, limit: size > limit, "more than "),
    "size_lt": _size(lambda size, limit: size < limit, "fewer than "),
    "control_filters::gt_eq_or_nan": _or_nan(_at_least),
    "control_filters::lt_eq_or_nan": _or_nan(_at_most),
    "joint_trajectory_controller::command_interface_type_combinations": _commands,
    "joint_trajectory_controller::state_interface_type_combinations": _states,
}
