"""Together: the files of a description with what a newer source changes and what somebody has changed, and the proof.

What is written has to be, value by value, what the newer source says and the changes of its own: the whole of it is
expanded, as it was imported, as it stands here, as the newer source has it, and as it would be written. The last has to
be what the first three make by the same three-way merge.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.diagnostics import ERROR, Diagnostic, Source, error
from rosorin_compile.extending import Description, Map, compile_robot, expand_robot, parse_yaml

from . import three_way
from .editing import CannotEdit, edited
from .three_way import MISSING, Change, Conflict, Merge, merged, same

Files = Mapping[str, str]
_HELP = "import it into a folder of its own with -o, and put both together by hand"
_MOST_VALUES = 8
_STATES = ("what was imported before", "what stands here", "the newer source", "what would be written")


class Cannot(NamedTuple):
    """A file that cannot be edited: why, and what of the newer source would have to go into it."""

    name: str
    why: str
    changes: list[Change]


class Together(NamedTuple):
    """What came of a merge: the files that are to be written, what both sides changed, and what is in the way.

    ``taken``, ``own`` and ``conflicts`` are pairs of the name of a file and what was changed in it. ``gone`` are files
    that the newer source has nothing for, and that nobody changed. ``trees`` are those of our files, to tell places in
    them.
    """

    files: dict[str, str]
    taken: list[tuple[str, Change]]
    own: list[tuple[str, Change]]
    conflicts: list[tuple[str, Conflict]]
    cannot: list[Cannot]
    gone: list[str]
    trees: dict[str, Map]


def put_together(base: Files, ours: Files, theirs: Files, folder: Path, keep_ours: bool) -> Together:
    """Return three states of the files of a description in one; ``folder`` is where they stand.

    With ``keep_ours`` what both have changed stays as it is here. Raises LoadError for a file of ours that is no YAML.
    """
    made = Together({}, [], [], [], [], [], {})
    for name in dict.fromkeys((*theirs, *base)):
        states = [side.get(name) for side in (base, ours, theirs)]
        trees = [None if text is None else _tree(text, folder / name) for text in states]
        if isinstance(trees[1], Map):
            made.trees[name] = trees[1]
        _one_file(made, name, states, trees, keep_ours)
    return made


def _tree(text: str, path: Path) -> Any:
    return parse_yaml(Source(str(path), text.removeprefix("\ufeff")))


def _one_file(made: Together, name: str, states: list[str | None], trees: list[Any], keep_ours: bool) -> None:
    """Add to a merge what becomes of one file."""
    base, ours, theirs = states
    old, own, new = (MISSING if text is None else tree for text, tree in zip(states, trees, strict=True))
    if all(isinstance(tree, Map) for tree in trees):
        found = merged(old, own, new, keep_ours)
    else:  # it is not there on one side, or no mapping
        found = three_way.whole(old, own, new, keep_ours)
    if theirs is None and ours is not None and not found.own and not found.conflicts:
        made.gone.append(name)
        return
    made.taken.extend((name, change) for change in found.taken)
    made.own.extend((name, change) for change in found.own)
    made.conflicts.extend((name, conflict) for conflict in found.conflicts)
    try:
        text = _text(base, ours, theirs, found)
    except CannotEdit as problem:
        made.cannot.append(Cannot(name, str(problem), found.taken))
        return
    if text is not None:
        made.files[name] = text


def _text(base: str | None, ours: str | None, theirs: str | None, found: Merge) -> str | None:
    """Return what a file is to be; None for none. Raises CannotEdit."""
    if ours == base:
        return theirs
    if not found.taken or found.conflicts:
        return ours
    if base is None or ours is None or theirs is None:
        return theirs
    return edited(base, ours, theirs, found.taken, found.value)


def renewed(record: str, text: str) -> str:
    """Return what an import wrote of a file that several robots include, with what one of them makes of it now.

    What the others have of it stays.
    """
    old, new = parse_yaml(Source("", record)), parse_yaml(Source("", text))
    wanted, changes = dict(old), []
    for section, entries in new.items():
        there = old.get(section, MISSING)
        if not isinstance(there, Map) or not isinstance(entries, Map):
            wanted[section] = entries
            changes += [] if same(there, entries) else [Change((section,), there, entries)]
            continue
        wanted[section] = {**there, **entries}
        pairs = ((name, there.get(name, MISSING), entry) for name, entry in entries.items())
        changes += [Change((section, name), was, entry) for name, was, entry in pairs if not same(was, entry)]
    try:
        return edited(record, record, text, changes, wanted) if changes else record
    except CannotEdit:
        return text  # which the proof of the merge holds against what the others have


def with_more(record: str, before: str, after: str) -> str:
    """Return the record of a file that was added to, ``before`` and ``after``, with what was added."""
    old, own, new = (parse_yaml(Source("", text)) for text in (before, record, after))
    found = merged(old, own, new)
    try:
        return record if found.conflicts else edited(before, record, after, found.taken, found.value)
    except CannotEdit:
        return record


class Judged(NamedTuple):
    """What compiling a merge says of it: the errors that it has itself, values that both sides changed, and others.

    ``conflicts`` are values of the robot that both sides have changed, though not at one place of a file; ``apart``
    those that would come out otherwise than the three-way merge of the robots has them. ``ours`` is the robot as it
    stands here.
    """

    errors: list[Diagnostic]
    conflicts: list[Conflict]
    apart: list[Change]
    ours: Map | None = None


def proved(
    folder: Path, base: Files, theirs: Files, made: Files, arguments: Mapping[str, str], packages: Mapping[str, Path]
) -> Judged:
    """Compile what would be written into a folder, and hold it against what was imported, stands there and is new.

    It is held with its arguments as they are by default, and with each other value that can be listed, one at a time.
    """
    root = folder / Description.ROOT_FILE
    states = [_placed(folder, files) for files in (base, {}, theirs, made)]
    alone = expand_robot(root, packages=packages, unsaved=states[2]) is not None
    given = {} if alone else dict(arguments)
    compiled = compile_robot(root, given, packages=packages, unsaved=states[3])
    errors = [one for one in compiled.diagnostics if one.severity == ERROR]
    found = Judged(errors, [], [])
    for values in [] if errors else ({}, *_values(made)):
        trees: list[Map] = []
        for files, what in zip(states, _STATES, strict=True):
            tree = expand_robot(root, {**given, **values}, packages, files)
            if tree is not None:
                trees.append(tree)
            elif not values:
                message = f"{what} does not compile alone: what changed cannot be told"
                return found._replace(errors=[error("import-unproven", message, None, _HELP)])
        if len(trees) == len(states):  # else an argument is new, or gone
            base_tree, ours, newer, result = trees
            wanted = merged(base_tree, ours, newer)
            apart = merged(wanted.value, result, wanted.value).own
            found = Judged([], _more(found.conflicts, wanted.conflicts), _more(found.apart, apart), found.ours or ours)
    return found


def _more(known: list[Any], found: list[Any]) -> list[Any]:
    paths = {one.path for one in known}
    return [*known, *(one for one in found if one.path not in paths)]


def _placed(folder: Path, files: Files) -> dict[Path, bytes]:
    return {folder / name: text.encode() for name, text in files.items()}


def _values(files: Files) -> Iterator[dict[str, Any]]:
    """Yield values of single arguments that a description may be given beside those by default."""
    for name, text in files.items():
        tree = _tree(text, Path(name))
        args = tree.get("args") if isinstance(tree, Map) else None
        for argument, said in args.items() if isinstance(args, Map) else ():
            entry = said if isinstance(said, Map) else {}
            choices = [True, False] if entry.get("type") == "boolean" else list(entry.get("one_of") or ())
            yield from ({argument: value} for value in choices[:_MOST_VALUES] if value != entry.get("default"))
