"""The record of a format: functions that are named as text are there, and what 0.2 said flat is still understood."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, replace

import pytest

from rosorin_compile import Format
from rosorin_compile.extending import FORMATS, InRos, by_name
from rosorin_compile.formats.format import GROUPS, Named


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


def test_the_flat_fields_of_0_2_are_read_and_said_with_a_warning() -> None:
    with pytest.warns(DeprecationWarning, match=r"says ros\.folder, writing\.lacks in groups, since 0\.3\.0"):
        flat = Format(name="toy", word="toy", folder="toys", lacks=frozenset({"mass"}))  # type: ignore[call-arg]
    assert (flat.ros.folder, flat.writing.lacks) == ("toys", {"mass"})
    with pytest.warns(DeprecationWarning, match=r"ros\.folder"):
        assert flat.folder == "toys"  # type: ignore[attr-defined]
    with pytest.warns(DeprecationWarning, match=r"proving\.complete"):
        more = replace(flat, complete=True)  # type: ignore[call-arg]
    assert more.proving.complete
    assert more.ros.folder == "toys"


def test_both_ways_go_together_and_a_name_that_there_is_not_is_refused() -> None:
    with pytest.warns(DeprecationWarning, match="ros.deploys"):
        both = Format(name="toy", word="toy", ros=InRos(folder="a"), deploys=True)  # type: ignore[call-arg]
    assert (both.ros.folder, both.ros.deploys) == ("a", True)
    with pytest.raises(TypeError, match="foldr"):
        Format(name="toy", word="toy", foldr="a")  # type: ignore[call-arg]
    with pytest.raises(AttributeError, match="a Format has no foldr"):
        _ = both.foldr  # type: ignore[attr-defined]
