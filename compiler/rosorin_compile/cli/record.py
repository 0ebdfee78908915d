"""Records of what the command line can do: whoever brings a command says all about it in one of them.

A function is named as text, ``MODULE:NAME``, from the folder in which the module of the records stands: to list what
there is imports none of it.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, fields

_NAME = re.compile(r"[a-z][a-z0-9-]*")
_FUNCTION = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_]\w*")


def _check_fields(record: Command | Check) -> None:
    """Raise TypeError or ValueError for a record whose fields cannot be."""
    for field in fields(record):
        value, kind = getattr(record, field.name), {"str": str, "int": int, "bool": bool}.get(str(field.type), tuple)
        if not isinstance(value, kind) or (isinstance(value, tuple) and not all(isinstance(one, str) for one in value)):
            raise TypeError(f"{field.name} of {record.name} is a {field.type}, not {str(value)[:60]!r}")
    if not _NAME.fullmatch(record.name):
        raise ValueError(f'"{record.name}" cannot be a name of the command line')
    for function in (record.options, record.run):
        if not _FUNCTION.fullmatch(function):
            raise ValueError(f'"{function}" of {record.name} names no function: write MODULE:NAME')


@dataclass(frozen=True)
class Command:
    """A command: ``rosorin-compile NAME WORDS``.

    ``help`` says in one line what it does, ``group`` is the heading of the help under which it stands, by its ``order``
    among the others there. ``exits`` says what its exit codes 0 and 1 mean; 2 is wrong usage everywhere.
    ``options(parser)`` adds what it takes, ``run(options)`` does it and returns the exit code; ``also`` are other
    names. One that is ``hidden`` is not in the first help.
    """

    name: str
    group: str
    words: str
    help: str
    exits: str
    options: str
    run: str
    also: tuple[str, ...] = ()
    order: int = 100
    hidden: bool = False

    def __post_init__(self) -> None:
        """Check the fields. Raises TypeError or ValueError for one that no record may have."""
        _check_fields(self)


@dataclass(frozen=True)
class Check:
    """A check: ``rosorin-compile check NAME WORDS``. The other fields are as in ``Command``."""

    name: str
    words: str
    help: str
    options: str
    run: str
    exits: str = "0 nothing is wrong, 1 errors"

    def __post_init__(self) -> None:
        """Check the fields. Raises TypeError or ValueError for one that no record may have."""
        _check_fields(self)
