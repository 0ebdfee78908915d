"""Names: what a robot has by name, with a helpful word where there is nothing of a name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NoReturn, TypeVar

Named = TypeVar("Named")


class ByName(dict[str, Named]):
    """A mapping by name; ``kind`` is the word for what it holds. What is not there raises a KeyError with a way out."""

    __slots__ = ("kind",)

    def __init__(self, kind: str, items: Mapping[str, Named]) -> None:
        super().__init__(items)
        self.kind = kind

    def __missing__(self, name: object) -> NoReturn:
        raise unknown(self.kind, name, self)

    def __reduce__(self) -> tuple[object, ...]:
        return (ByName, (self.kind, dict(self)))


def unknown(kind: str, name: object, known: Iterable[str], more: str = "") -> KeyError:
    """Return the KeyError about a name that is not there; ``more`` says what it is instead."""
    from ..diagnostic import did_you_mean

    way_out = more or did_you_mean(str(name), known) or "the robot has none"
    return KeyError(f'there is no {kind} "{name}"; {way_out}')
