"""A command line of words alone: what all options are then, without argparse, which takes 4 ms until it knows them."""

from __future__ import annotations

from types import SimpleNamespace

from ..startup import TYPE_CHECKING

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable, Sequence
    from typing import Any


class _Defaults:
    """Takes the options of a command as a parser does, and keeps what each is where it is not given."""

    def __init__(self) -> None:
        self.values: dict[str, Any] = {}

    def add_argument(self, *names: str, **settings: Any) -> None:
        long = next((name for name in names if name.startswith("--")), names[0])
        key = settings.get("dest", long.lstrip("-").replace("-", "_"))
        otherwise = False if settings.get("action") == "store_true" else None
        self.values.setdefault(key, settings.get("default", otherwise))

    def add_argument_group(self, *_: str) -> _Defaults:
        return self

    def add_mutually_exclusive_group(self) -> _Defaults:
        return self


def options_of(words: Sequence[str], options: Callable[[Any], None]) -> argparse.Namespace:
    """Return the options of a command that takes any ``words``, and was given none but those."""
    defaults = _Defaults()
    options(defaults)
    made: Any = SimpleNamespace(**{**defaults.values, "words": list(words)})
    return made  # type: ignore[no-any-return]
