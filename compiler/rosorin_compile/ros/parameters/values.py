"""Values of parameters: what type one has, and what its validators refuse.

The validators are those of ``PickNikRobotics/generate_parameter_library`` and two of joint_trajectory_controller
(``validate_jtc_parameters.hpp`` of ros2_controllers).
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rosorin_compile.source.diagnostics import Help, Suggestion, listed, quoted

_WORDS = {"bool": "true or false", "int": "a whole number", "double": "a double", "string": "a text"}
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
    made = converted(value, kind)
    if kind == "string" and not isinstance(value, (list, tuple)):
        made = written(value)
    elif kind == "string_array":
        made = [value]
    elif isinstance(value, str) and kind in _WORDS:
        return f"write {type_in_words(kind)} without quotes"
    return f"write {written(made) if fits(made, kind) else type_in_words(kind)}"


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
        why, help = _refused(name.removeprefix("control_filters::"), value, list(arguments))
        if why:
            return why, help
    return None


def _refused(name: str, value: Any, arguments: list[Any]) -> tuple[str, Help]:
    bound = _BOUNDS.get(name.removesuffix("_or_nan"))
    if bound is not None:
        holds, words = bound
        is_free = name.endswith("_or_nan") and math.isnan(value)
        wrong = not is_free and not holds(value, arguments[0])
        return (f"is {written(value)}, and has to be {words} {arguments[0]:g}" if wrong else ""), ""
    if name in _SIZES:
        fits_size, words = _SIZES[name]
        sizes = " or ".join(map(str, arguments))
        fitting = any(fits_size(len(value), size) for size in arguments)
        return ("" if fitting else f"has {len(value)} values, and needs {words}{sizes}"), ""
    allowed = arguments[0] if arguments else ()
    if name == "one_of" and value not in allowed:
        return f"cannot be {written(value)}", Suggestion(str(value), [*map(str, allowed)])
    if name == "subset_of" and (others := [str(one) for one in value if one not in allowed]):
        return f"cannot have {quoted(others)}", Suggestion(others[0], [*map(str, allowed)])
    if name == "not_empty" and not len(value):
        return "is empty", ""
    if name == "unique" and (twice := [str(one) for one in dict.fromkeys(value) if value.count(one) > 1]):
        return f"has {quoted(twice)} twice", ""
    return _combination(name.rpartition("::")[2], set(value) if isinstance(value, (list, tuple)) else set()), ""


def _combination(name: str, words: set[str]) -> str:
    """Return why joint_trajectory_controller refuses a combination of interfaces."""
    lacks_both = "acceleration" in words and not {"position", "velocity"} & words
    if name == "command_interface_type_combinations":
        if "velocity" in words and len(words) > 1 and "position" not in words:
            return "has to have velocity alone, or beside position"
        if lacks_both:
            return "has to have position and velocity beside acceleration"
        return "has to have effort alone" if "effort" in words and len(words) > 1 else ""
    if name == "state_interface_type_combinations":
        if "velocity" in words and "position" not in words:
            return "has to have position beside velocity"
        if "acceleration" in words and not {"position", "velocity"} <= words:
            return "has to have position and velocity beside acceleration"
    return ""


_BOUNDS: Mapping[str, tuple[Callable[[float, float], bool], str]] = {
    "gt": (operator.gt, "above"),
    "gt_eq": (operator.ge, "at least"),
    "lt_eq": (operator.le, "at most"),
}
_SIZES: Mapping[str, tuple[Callable[[int, int], bool], str]] = {
    "fixed_size": (operator.eq, ""),
    "size_gt": (operator.gt, "more than "),
    "size_lt": (operator.lt, "fewer than "),
}
