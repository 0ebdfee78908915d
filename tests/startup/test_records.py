"""Values of ours behave as those of the standard library, which a type checker takes them for."""

from __future__ import annotations

import copy
import dataclasses
import inspect
import pickle
import typing
from collections.abc import Mapping
from functools import cached_property
from typing import Any

import pytest

from rosorin_compile.startup import records


class Theirs:
    """The same classes, made by the library."""

    class Point(typing.NamedTuple):
        x: float
        y: float = 2.0

        @property
        def sum(self) -> float:
            return self.x + self.y

    @dataclasses.dataclass(frozen=True)
    class Link:
        name: str
        mass: float = 1.0
        tags: Mapping[str, str] = dataclasses.field(default_factory=dict, hash=False)
        note: str = dataclasses.field(default="", compare=False, repr=False)


class Point(records.NamedTuple):
    x: float
    y: float = 2.0

    @property
    def sum(self) -> float:
        return self.x + self.y


class Named(Point):
    """One that adds a method."""

    def doubled(self) -> float:
        return 2 * self.sum


@records.dataclass(frozen=True)
class Link:
    name: str
    mass: float = 1.0
    tags: Mapping[str, str] = records.field(default_factory=dict, hash=False)
    note: str = records.field(default="", compare=False, repr=False)


@records.dataclass
class Open:
    size: int = 0

    def __post_init__(self) -> None:
        self.size += 1


@records.dataclass(frozen=True, kw_only=True, eq=False)
class Words:
    one: str
    two: str = "b"


GIVEN: list[tuple[tuple[Any, ...], dict[str, Any]]] = [
    (("a",), {}),
    (("a", 2.0), {}),
    (("a",), {"mass": 3.0, "tags": {"k": "v"}, "note": "n"}),
]


@pytest.mark.parametrize(("given", "named"), GIVEN)
def test_a_dataclass(given: tuple[Any, ...], named: dict[str, Any]) -> None:
    ours, theirs = Link(*given, **named), Theirs.Link(*given, **named)
    assert vars(ours) == vars(theirs)
    assert repr(ours) == repr(theirs).replace("Theirs.", "")
    assert dataclasses.asdict(ours) == dataclasses.asdict(theirs)
    assert ours == Link(*given, **{**named, "note": "another"})
    assert hash(ours) == hash(Link(*given, **{**named, "tags": {}}))
    assert ours != records.replace(ours, mass=9.0)
    assert vars(records.replace(ours, mass=9.0)) == vars(dataclasses.replace(theirs, mass=9.0))
    assert dataclasses.replace(ours, mass=9.0) == records.replace(ours, mass=9.0)
    assert pickle.loads(pickle.dumps(ours)) == copy.deepcopy(ours) == ours  # noqa: S301
    assert dataclasses.is_dataclass(ours)
    assert [one.name for one in dataclasses.fields(ours)] == [one.name for one in dataclasses.fields(theirs)]
    assert Link.__match_args__ == Theirs.Link.__match_args__
    with pytest.raises(dataclasses.FrozenInstanceError):
        ours.mass = 2.0  # type: ignore[misc]
    with pytest.raises(dataclasses.FrozenInstanceError):
        del ours.mass


def test_each_value_has_its_own_default() -> None:
    assert Link("a").tags is not Link("a").tags
    assert Open().size == 1
    with pytest.raises(TypeError, match="unhashable"):
        hash(Open())
    assert Open(1) == Open(1) != Open(2)
    assert Words(one="a") != Words(one="a")
    for wrong in ({}, {"one": 1, "three": 3}):
        with pytest.raises(TypeError):
            Words(**wrong)
    with pytest.raises(TypeError):
        Words("a")  # type: ignore[misc]
    with pytest.raises(TypeError):
        records.replace(Link("a"), colour="red")


def test_a_tuple_with_names() -> None:
    ours, theirs = Point(1.0), Theirs.Point(1.0)
    assert ours == theirs == (1.0, 2.0)
    assert (ours.x, ours.y, ours.sum, hash(ours)) == (theirs.x, theirs.y, theirs.sum, hash(theirs))
    assert repr(ours) == repr(theirs)
    assert ours._replace(y=5.0) == theirs._replace(y=5.0)
    assert ours._asdict() == theirs._asdict()
    assert Point._make([3, 4]) == Theirs.Point._make([3, 4])
    assert (Point._fields, Point._field_defaults) == (Theirs.Point._fields, Theirs.Point._field_defaults)
    assert type(pickle.loads(pickle.dumps(ours))) is type(copy.copy(ours)) is Point  # noqa: S301
    for wrong in ({"z": 1.0}, {"x": 1.0, "z": 2.0}):
        with pytest.raises(ValueError, match="z"):
            ours._replace(**wrong)
        with pytest.raises(TypeError):
            Point(**wrong)
    match ours:
        case Point(x, y):
            assert (x, y) == (1.0, 2.0)
    assert not hasattr(ours, "__dict__")


def test_one_that_adds_a_method() -> None:
    assert Named(1.0).doubled() == 6.0
    assert type(Named(1.0, 4.0)) is Named
    assert Named(2.0)._replace(x=1.0).doubled() == 6.0


@pytest.mark.parametrize("kind", [Point, Named, Link, Open], ids=lambda kind: kind.__name__)
def test_the_first_values_are_as_the_later_ones(kind: Any) -> None:
    """A class gets a function of its own when many values were made of it."""
    right: list[tuple[tuple[Any, ...], dict[str, Any]]] = [((1,), {}), ((), {"size" if kind is Open else "x": 1})]
    for given, named in right if kind is not Link else GIVEN:
        values = [kind(*given, **named) for _ in range(60)]
        assert all(value == values[0] for value in values)
    function = kind.__new__ if issubclass(kind, tuple) else kind.__init__
    assert "given" not in str(inspect.signature(function))


class Asked(records.NamedTuple):
    """Its fields are called as what Python itself hands over."""

    asked: str
    self: str = ""
    given: str = ""
    named: str = ""


@records.dataclass(frozen=True)
class Own:
    own: str
    given: str = ""


def test_fields_may_have_any_name() -> None:
    for _ in range(60):
        assert Asked(asked="a", self="b") == ("a", "b", "", "")
        assert vars(Own(own="a", given="b")) == {"own": "a", "given": "b"}


@pytest.mark.parametrize(
    ("given", "named"), [((1, 2, 3), {}), ((1,), {"x": 1}), ((), {"y": 1}), ((1,), {"z": 1})], ids=str
)
def test_a_wrong_call_is_told_as_python_tells_it(given: tuple[int, ...], named: dict[str, int]) -> None:
    class Few(records.NamedTuple):
        x: float
        y: float = 2.0

    for _ in range(2):
        with pytest.raises(TypeError, match=r"__new__\(\)"):
            Few(*given, **named)


def test_what_was_worked_out_of_a_value_is_not_that_of_one_made_from_it() -> None:
    first = _Worked(1, 2)
    assert first.total == 3
    second = records.replace(first, y=5)
    assert (second, second.total, first.total) == (_Worked(1, 5), 6, 3)
    assert records.replace(second, x=0) == _Worked(0, 5)


@records.dataclass(frozen=True)
class _Worked:
    x: int
    y: int

    @cached_property
    def total(self) -> int:
        return self.x + self.y
