"""Values of parameters: what type one has, and what its validators refuse.

The validators are those of ``PickNikRobotics/generate_parameter_library`` and two of joint_trajectory_controller
(``validate_jtc_parameters.hpp`` of ros2_controllers).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ...diagnostics.wording import counted, listed, quoted

if TYPE_CHECKING:
    from .tables import Key

ARTICLES = {
    "bool": "true or false",
    "int": "a whole number",
    "double": "a number with a point (double)",
    "string": "a text",
    "bool_array": "a list of true and false",
    "int_array": "a list of whole numbers",
    "double_array": "a list of numbers with a point (double)",
    "string_array": "a list of texts",
}


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
    return " or ".join(ARTICLES.get(one, one) for one in kind.split(" or "))


def told(value: Any) -> str:
    """Return a value of a wrong type as a message has it."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f'the text "{value}"'
    if isinstance(value, (list, tuple)):
        kinds = {"int": "whole numbers", "float": "numbers with a point", "str": "texts", "bool": "true and false"}
        found = dict.fromkeys(kinds.get(type(item).__name__, "other things") for item in value)
        return f"a list of {listed(found)}" if found else "an empty list"
    return f"the whole number {value}" if isinstance(value, int) else f"the number {value:g}"


def refused(key: Key, value: Any) -> str:
    """Return why the validators of a parameter refuse a value of its type, in words; empty if they do not."""
    for name, arguments in key.valid.items():
        check = _VALIDATORS.get(name)
        why = check(value, *arguments) if check is not None else ""
        if why:
            return why
    return ""


def _bound(holds: Callable[[float, float], bool], words: str) -> Callable[..., str]:
    def check(value: float, limit: float) -> str:
        return "" if holds(value, limit) else f"it has to be {words} {limit:g}"

    return check


def _or_nan(check: Callable[..., str]) -> Callable[..., str]:
    return lambda value, limit: "" if math.isnan(value) else check(value, limit)


_above = _bound(lambda value, limit: value > limit, "above")
_at_least = _bound(lambda value, limit: value >= limit, "at least")
_at_most = _bound(lambda value, limit: value <= limit, "at most")


def _one_of(value: Any, allowed: Sequence[Any]) -> str:
    return "" if value in allowed else f"it is one of {', '.join(map(str, allowed))}"


def _subset_of(value: Sequence[Any], allowed: Sequence[Any]) -> str:
    others = [str(one) for one in value if one not in allowed]
    return f"{quoted(others)} is none of {', '.join(map(str, allowed))}" if others else ""


def _not_empty(value: Any) -> str:
    return "" if len(value) else "it must not be empty"


def _unique(value: Sequence[Any]) -> str:
    twice = [str(one) for one in dict.fromkeys(value) if value.count(one) > 1]
    return f"{quoted(twice)} stands there twice" if twice else ""


def _size(holds: Callable[[int, int], bool], words: str) -> Callable[..., str]:
    def check(value: Sequence[Any], size: int) -> str:
        return "" if holds(len(value), size) else f"it has {counted(len(value), 'item')}, not {words}{size}"

    return check


def _commands(value: Sequence[str]) -> str:
    if "velocity" in value and len(value) > 1 and "position" not in value:
        return "velocity stands alone, or beside position"
    if "acceleration" in value and "velocity" not in value and "position" not in value:
        return "acceleration needs position and velocity"
    return "effort stands alone" if "effort" in value and len(value) > 1 else ""


def _states(value: Sequence[str]) -> str:
    if "velocity" in value and "position" not in value:
        return "velocity needs position"
    if "acceleration" in value and not {"position", "velocity"} <= set(value):
        return "acceleration needs position and velocity"
    return ""


_VALIDATORS: Mapping[str, Callable[..., str]] = {
    "gt": _above,
    "gt_eq": _at_least,
    "one_of": _one_of,
    "subset_of": _subset_of,
    "not_empty": _not_empty,
    "unique": _unique,
    "fixed_size": _size(lambda size, wanted: size == wanted, ""),
    "size_gt": _size(lambda size, limit: size > limit, "more than "),
    "size_lt": _size(lambda size, limit: size < limit, "fewer than "),
    "control_filters::gt_eq_or_nan": _or_nan(_at_least),
    "control_filters::lt_eq_or_nan": _or_nan(_at_most),
    "joint_trajectory_controller::command_interface_type_combinations": _commands,
    "joint_trajectory_controller::state_interface_type_combinations": _states,
}
