"""Records of what the command line can do: whoever brings a command says all about it in one of them.

A function is named as text, ``MODULE:NAME``, from the folder in which the module of the records stands: to list what
there is imports none of it.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Command:
    """A command: ``rosorin-compile NAME WORDS``.

    ``help`` says in one line what it does, ``group`` is the heading of the help under which it stands, by its ``order``
    among the others there. ``exits`` says what its exit codes 0 and 1 mean; 2 is wrong usage everywhere.
    ``options(parser)`` adds what it takes, ``run(options)`` does it and returns the exit code; ``also`` are other
    names.
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
