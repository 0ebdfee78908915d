"""Report: what a merge took of the newer source, what stayed, and what is in its way, line by line."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from rosorin_compile.diagnostics import (
    ERROR,
    WARNING,
    Diagnostic,
    Heading,
    Related,
    Rule,
    Source,
    Span,
    and_more,
    counted,
    error,
)
from rosorin_compile.extending import Map, Quantity, Scalar
from rosorin_compile.extending import Path as Keys

from .three_way import MISSING, Change, Conflict, merged
from .together import Cannot, Judged, Together

RULES = (
    Rule(
        "import-conflict",
        "A newer state of a source is imported again, and a value is another one in it that somebody has changed in "
        "the description since; nothing is written.",
        "Write the value of the newer source, or `--ours` to keep those of the description.",
        Heading.READING,
    ),
    Rule(
        "import-apart",
        "A newer state of a source is imported again, and what somebody changed in the description reaches something "
        "else in it, such as a new use of a part that was changed; nothing is written, or, with `--ours`, this is a "
        "warning.",
        "Change it for that use, or `--ours` if it is meant.",
        Heading.READING,
    ),
    Rule(
        "import-cannot-merge",
        "A newer state of a source is imported again, and a file cannot be edited without losing something that stands "
        "in it, such as a comment; nothing is written.",
        "Make the changes that are told by hand, and import again.",
        Heading.READING,
    ),
    Rule(
        "import-unproven",
        "A newer state of a source is imported again, and what was imported before, what stands in the folder, or what "
        "the newer source says does not compile alone: nobody can say what changed.",
        "Import into a folder of its own with `-o`, and put both together by hand.",
        Heading.READING,
    ),
)

_MOST = 20
_LONG = 60


def in_the_way(together: Together, source: str, folder: Path) -> list[Diagnostic]:
    """Return the errors about what keeps a description from being put together, a line each."""
    found = [
        _conflict(conflict, source, together.trees.get(name), folder / name) for name, conflict in together.conflicts
    ]
    return [*found, *(_cannot(one, source, folder) for one in together.cannot)]


def _conflict(conflict: Conflict, source: str, tree: Map | None, file: Path) -> Diagnostic:
    """Return the error about a value that both sides have changed."""
    span = tree.locate(conflict.path).span if tree is not None else Span(Source(str(file), ""), 1, 1, 1)
    return error("import-conflict", f"{named(conflict.path)} {_both(conflict, source)}", span, _way_out(conflict))


def _both(conflict: Conflict, source: str) -> str:
    """Return how a value is on both sides."""
    base, ours, theirs = conflict.base, conflict.ours, conflict.theirs
    if theirs is MISSING:
        return f"is not there any more in the newer {source}, and was changed here: {_steps(base, ours)}"
    if ours is MISSING:
        return f"was removed here, and the newer {source} has it otherwise: {_steps(base, theirs)}"
    was = "it was not there" if base is MISSING else f"it was {shown(base)}"
    return f"is {shown(ours)} here, and {shown(theirs)} in the newer {source}; {was} when that was imported before"


def _way_out(conflict: Conflict) -> str:
    if conflict.theirs is MISSING:
        return "remove it here, too, or keep it with --ours"
    if conflict.ours is MISSING:
        return "put it back as the newer source has it, or leave it out with --ours"
    return f"write {shown(conflict.theirs)} here, or keep what is here with --ours"


def _cannot(cannot: Cannot, source: str, folder: Path) -> Diagnostic:
    lines = [Related(line, None) for line in _few([step(change) for change in cannot.changes])]
    message = f"{folder / cannot.name} cannot take over what the newer {source} changed: {cannot.why}"
    return error("import-cannot-merge", message, None, "make these changes by hand, and import again", lines)


def of_merge(merge: Judged, source: str, folder: Path, keep_ours: bool) -> list[Diagnostic]:
    """Return what compiling a merge has against it; with ``keep_ours`` that are warnings, but for its errors."""
    if merge.errors:
        return merge.errors
    found = [] if keep_ours else [_conflict(one, source, merge.ours, folder) for one in merge.conflicts]
    for one in merge.apart:
        before = "would not be there" if one.old is MISSING else f"would be {shown(one.old)}"
        after = "is not there" if one.new is MISSING else f"is {shown(one.new)}"
        message = f"{named(one.path)} {after} by what was changed here; by the newer {source} it {before}"
        severity, help = (
            (WARNING, "") if keep_ours else (ERROR, "change it for this one alone, or --ours if that is meant")
        )
        found.append(Diagnostic("import-apart", severity, message, None, (), help))
    return found


def merge_report(together: Together, source: str) -> Iterator[str]:
    """Yield the lines about what was put together."""
    taken, own = ([f"  {name}: {step(one)}" for name, one in pairs] for pairs in (together.taken, together.own))
    taken += [f"  {name}: removed, the source has nothing for it" for name in together.gone]
    if taken:
        yield f"{counted(len(taken), 'change')} of the newer {source} taken over:"
        yield from _few(taken)
    else:
        yield f"{source} says what it said when it was imported before"
    if own:
        yield f"{counted(len(own), 'change')} made here since that {'stay' if len(own) > 1 else 'stays'}:"
        yield from _few(own)


def _few(lines: Sequence[str]) -> list[str]:
    left = len(lines) - _MOST
    return [*lines[:_MOST], *([f"  {and_more(left).strip()}"] if left > 0 else [])]


def step(change: Change) -> str:
    """Return a change in words: what, before and after."""
    if change.items is not None and isinstance(change.old, list):
        return f"{named(change.path)}: {_listed(change.old, change.new)}"
    return f"{named(change.path)}: {_between(change.old, change.new)}"


def _listed(old: Sequence[Any], new: Sequence[Any]) -> str:
    gone, fresh = ([one for one in some if one not in others] for some, others in ((old, new), (new, old)))
    words = [*(f"- {shown(one)}" for one in gone), *(f"+ {shown(one)}" for one in fresh)]
    return ", ".join(words) or "in another order"


def _between(old: Any, new: Any) -> str:
    if old is MISSING:
        return f"added, {shown(new)}"
    return "removed" if new is MISSING else f"{shown(old)} -> {shown(new)}"


def _steps(old: Any, new: Any) -> str:
    """Return what changed within a value, in a row."""
    if old is MISSING or new is MISSING:
        return _between(old, new)
    found = merged(old, new, old).own
    steps = [step(one) if one.path else _between(old, new) for one in found]
    return ", ".join(_few(steps)) or "in how it is written"


def named(path: Keys) -> str:
    """Return where something stands, as in an expression: ``links.arm.visual[0].rgba``; of no path the file."""
    text = ""
    for key in path:
        text += f"[{key}]" if isinstance(key, int) else f".{key}" if text else str(key)
    return text or "the file"


def shown(value: Any) -> str:
    """Return a value as it would be written, on one line, and shortened."""
    text = _flow(value)
    return text if len(text) <= _LONG else f"{text[: _LONG - 3]}..."


def _flow(value: Any) -> str:
    if isinstance(value, dict):
        return f"{{{', '.join(f'{key}: {_flow(item)}' for key, item in value.items())}}}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_flow, value))}]"
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    if isinstance(value, Quantity):
        return value.text or repr(float(value))
    return Scalar(value).written(True) if isinstance(value, str) else repr(value)
