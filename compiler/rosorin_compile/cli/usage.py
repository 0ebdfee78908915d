"""How a run ends: its exit code, wrong usage, and what is said of the cache and the system."""

from __future__ import annotations

from rosorin_compile.source.cache import cache_refused
from rosorin_compile.source.console import Console
from rosorin_compile.source.diagnostics import RequestError
from rosorin_compile.source.rule_registry import WRITING, Rule
from rosorin_compile.source.system import missed

RULES = (
    Rule(
        "wrong-usage",
        "The command line cannot be followed (in the forms for programs); the exit code is 2.",
        "As the message says; `rosorin-compile COMMAND --help` has what a command takes.",
        WRITING,
    ),
    Rule(
        "run-stopped",
        "The run ended before its result: a file or folder cannot be used, memory ran out, or the input is too large.",
        "As the message says.",
        WRITING,
    ),
    Rule(
        "cache-not-private",
        "A note: somebody else could change what is in the folder of the cache, so there is no cache.",
        "`chmod go-w` of the folder that is named, or another one in `ROSORIN_COMPILE_CACHE`.",
        WRITING,
    ),
    Rule(
        "system-lacks",
        "A note: this system has no locks, or no limits of a process, as Windows has none; the run goes on without.",
        "Let nothing else write into the folder that is named; give it files of people whom you trust.",
        WRITING,
    ),
)

FINE, PROBLEMS, USAGE = 0, 1, 2


WrongUsage = RequestError


def tell_of_system(console: Console) -> None:
    """Say what the run had to do without on this system."""
    for message in missed():
        from rosorin_compile.source.diagnostics import NOTE, Diagnostic

        console.show([Diagnostic("system-lacks", NOTE, message)])


def tell_of_cache(console: Console) -> None:
    """Say that there is no cache, if somebody else could change what would be in it."""
    refused = cache_refused()
    if refused:
        from rosorin_compile.source.diagnostics import NOTE, Diagnostic

        message, help = refused
        console.show([Diagnostic("cache-not-private", NOTE, message, help=help)])
