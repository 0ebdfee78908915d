"""The form of a diagnostic in JSON, as a type."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypedDict


class _Place(TypedDict, total=False):
    file: Annotated[str, "The file that it is about; left out where there is no place, as the next three."]
    line: Annotated[int, "The line, from 1."]
    column: Annotated[int, "The column, from 1."]
    length: Annotated[int, "How many characters it is about."]


class Related(_Place):
    """Another place that belongs to a diagnostic, or a remark without one."""

    message: Annotated[str, "What is there."]


class Said(_Place):
    """A diagnostic."""

    rule: Annotated[str, "The id of the rule, which `rosorin-compile rule` explains."]
    severity: Annotated[Literal["error", "warning", "note"], "How bad it is."]
    message: Annotated[str, "What is wrong."]
    help: Annotated[str, "The way out; empty where the message has it."]
    related: list[Related]


ANSWERS: dict[str, Any] = {}
