"""The record of a format: functions that are named as text are there."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields

import pytest

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import GROUPS, Named, by_name


def named() -> Iterator[tuple[str, Named]]:
    """Yield the functions of all records that are named as text, each with the format and the field."""
    for format in FORMATS.values():
        for part in (format, *(getattr(format, group) for group in GROUPS)):
            for field in fields(part):
                if isinstance(value := getattr(part, field.name), Named):
                    yield f"{format.name} {field.name}", value


def test_functions_that_are_named_as_text_are_there() -> None:
    found = dict(named())
    assert {"urdf facts", "mjcf against", "srdf join", "controllers write"} <= found.keys()
    assert [name for name, one in found.items() if not callable(one.function())] == []


def test_a_name_that_is_wrong_is_found() -> None:
    with pytest.raises(AttributeError, match="no attribute 'wirte'"):
        by_name("rosorin_compile.formats.urdf")("write:wirte").function()
