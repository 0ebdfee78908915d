"""What may stand at the cursor: asked of the parser of the command, which says what each word and option is.

A place is called by the name that the help has for its value: ``--args FILE``, ``[ROBOT] JOINT=VALUE ...``. What there
is for a name is looked up in ``kinds``; a name that is not there is free text. ``completes`` of an option says another
name, where that of the help is too general. Nothing is printed but candidates, nothing is written, and nothing is run.
"""

from __future__ import annotations

import argparse
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout, suppress
from functools import cache
from io import StringIO
from pathlib import Path
from typing import NamedTuple

from ..calling import called
from ..parser import Parser
from ..registry import names
from . import robot_names

_MAX_HELP = 70
MAX_FILES = 2000
_SLOT = re.compile(r"(\[)?([A-Z][^\s\[\]]*)( \.\.\.)?(\])?(?=\s|$)")
_OPTION = re.compile(r"(^|\s)--?[a-z-]+ [A-Z]+")  # one that the line of usage shows


class Candidate(NamedTuple):
    """A word that may stand at the cursor, and what it is, in few words."""

    word: str
    help: str = ""


class Slot(NamedTuple):
    """A place for a word of a command: what stands there, whether it may be left out, and come again."""

    name: str
    optional: bool = False
    repeats: bool = False


class Typed(NamedTuple):
    """What stands before the cursor, as the parser of the command sees it.

    ``words`` are those that are no options; ``values`` those of options, by the destination of the option. ``open`` is
    the option whose value is next, ``turn`` its number of several; ``ended`` says that ``--`` came.
    """

    words: list[str]
    values: dict[str, list[str]]
    used: list[argparse.Action]
    open: argparse.Action | None
    turn: int
    ended: bool


class CommandLine(NamedTuple):
    """The commands with what they do, and what gives the parser of a line, as ``cli`` has them."""

    commands: Mapping[str, str]
    parser: Callable[[Sequence[str]], Parser]


def candidates(words: Sequence[str], current: str, of: CommandLine) -> list[Candidate]:
    """Return what may stand at the cursor: after ``words``, where ``current`` is typed already."""
    command = next((word for word in words if not word.startswith("-")), "")
    if not command:
        of_all = [Candidate(name, help) for name, help in of.commands.items()]
        found = _options(of.parser([]), current, []) if current.startswith("-") else of_all
        return _beginning(found, current)
    line = called(words)
    if line.found is None:
        return []
    inner: Parser = of.parser(words).within[command]
    rest = line.words[line.words.index(command) + 1 :]
    if inner.within:
        way = next((word for word in rest if word in inner.within), "")
        if not way:
            return _beginning([Candidate(name, one.description or "") for name, one in inner.within.items()], current)
        inner, rest = inner.within[way], rest[rest.index(way) + 1 :]
    return _of_command(inner, _typed(inner, rest), current)


def _of_command(command: Parser, typed: Typed, current: str) -> list[Candidate]:
    """Return what may stand at the cursor behind the name of a command."""
    if typed.open is not None:
        return _values(command, typed, typed.open, typed.turn, current, "")
    if not typed.ended and current.startswith("-"):
        name, equals, value = current.partition("=")
        action = _named(command, name)
        if equals:
            return _values(command, typed, action, 0, value, f"{name}=") if action else []
        short = _named(command, current[:2])
        if len(current) > 2 and not current.startswith("--") and short and short.nargs is None:
            return _values(command, typed, short, 0, current[2:], current[:2])
        return _beginning(_options(command, current, typed.used), current)
    asked = _asked(command, typed)
    found: list[Candidate] = []
    for slot in following(slots(command, typed.used), len(_others(command, typed))):
        found += _of_kind(slot.name, asked, current)
    if _takes_arguments(command):
        found += _of_kind("NAME:=VALUE", asked, current)
    return list({one.word: one for one in found}.values())


def _values(
    command: Parser, typed: Typed, action: argparse.Action, index: int, current: str, before: str
) -> list[Candidate]:
    """Return the values that an option may have; ``before`` stands in the same word."""
    if action.choices is not None:
        found = _beginning([Candidate(str(choice)) for choice in action.choices], current)
    else:
        found = _of_kind(kind(action, index), _asked(command, typed), current)
    return [one._replace(word=before + one.word) for one in found]


def kind(action: argparse.Action, index: int = 0) -> str:
    """Return the name of what an option or a word is, as the help has it, or as its ``completes`` says."""
    named = getattr(action, "completes", None) or action.metavar or action.dest.upper()
    return named[min(index, len(named) - 1)] if isinstance(named, tuple) else str(named)


def slots(command: Parser, used: Sequence[argparse.Action] = ()) -> list[Slot]:
    """Return the places for words of a command, as its line of usage names them, or the ``completes`` of its words.

    A switch such as ``print --list`` may have a ``completes`` of its own: that of the words beside it.
    """
    word = next((action for action in command.options if not action.option_strings), None)
    if word is None:
        return []
    if word.choices is not None:
        return [Slot(f"{{{','.join(map(str, word.choices))}}}")]
    usage = (command.usage or "").partition("[options] ")[2]
    switched = [one.completes for one in used if one.nargs == 0 and hasattr(one, "completes")]
    text = next(iter(switched), getattr(word, "completes", None)) or _OPTION.sub(" ", usage) or str(word.metavar)
    return [Slot(found[2], bool(found[1]), bool(found[3])) for found in _SLOT.finditer(text)]


def following(places: Sequence[Slot], count: int) -> list[Slot]:
    """Return the places that may be next after ``count`` words."""
    at = _reached(places, {0})
    for _ in range(count):
        at = _reached(places, {after for i in at for after in ((i, i + 1) if places[i].repeats else (i + 1,))})
    return [places[index] for index in sorted(at)]


def _reached(places: Sequence[Slot], at: set[int]) -> set[int]:
    """Return where one may be, with what is reached by leaving places out."""
    for index in range(len(places)):
        if index in at and places[index].optional:
            at = at | {index + 1}
    return {index for index in at if index < len(places)}


def _typed(command: Parser, words: Iterable[str]) -> Typed:
    """Return what stands before the cursor, word by word; a line in the making is never wrong."""
    typed = Typed([], {}, [], None, 0, False)
    left = 0
    for word in words:
        if typed.open is not None:
            typed.values.setdefault(typed.open.dest, []).append(word)
            left -= 1
            typed = typed._replace(open=typed.open if left else None, turn=typed.turn + 1)
        elif typed.ended or not word.startswith("-") or word == "-" or re.match(r"-\.?\d", word):
            typed.words.append(word)
        elif word == "--":
            typed = typed._replace(ended=True)
        else:
            name, equals, value = word.partition("=")
            action = _named(command, name)
            if action is None:
                continue
            typed.used.append(action)
            left = 1 if action.nargs in (None, "+") else action.nargs if isinstance(action.nargs, int) else 0
            if equals:
                typed.values.setdefault(action.dest, []).append(value)
            elif left:
                typed = typed._replace(open=action, turn=0)
    return typed


def _named(command: Parser, name: str) -> argparse.Action | None:
    """Return the option of a name, or of the beginning of one."""
    by_name = {text: action for action in command.options for text in action.option_strings}
    close = {id(action): action for text, action in by_name.items() if len(name) > 2 and text.startswith(name)}
    return by_name.get(name) or (next(iter(close.values())) if len(close) == 1 else None)


def _options(command: Parser, current: str, used: Sequence[argparse.Action]) -> Iterator[Candidate]:
    """Yield the options that may still come; the long names alone, where an option has one."""
    for action in command.shown():
        again = isinstance(action, argparse._AppendAction)
        if action.option_strings and (again or action not in used):
            long = [name for name in action.option_strings if name.startswith("--")]
            for name in long or action.option_strings:
                yield Candidate(name, _short(action))
            if len(current) == 2:  # typed to the end
                yield from (Candidate(name, _short(action)) for name in action.option_strings if name == current)


def _short(action: argparse.Action) -> str:
    text = " ".join((action.help or "").replace("%%", "%").split())
    return text if len(text) <= _MAX_HELP else f"{text[:_MAX_HELP].rpartition(' ')[0]} ..."


def _takes_arguments(command: Parser) -> bool:
    return any(action.dest == "arg" for action in command.options)


def _others(command: Parser, typed: Typed) -> list[str]:
    """Return the words of the line but those of the form NAME:=VALUE."""
    return [word for word in typed.words if not (":=" in word and _takes_arguments(command))]


def _asked(command: Parser, typed: Typed) -> robot_names.Subject:
    """Return which robots a line asks about, with which arguments."""
    names = [word for dest in ("robot", "words") for word in typed.values.get(dest, ())]
    for index, word in enumerate(_others(command, typed)):
        here = {slot.name for slot in following(slots(command, typed.used), index)}
        if here & {"ROBOT", "SOURCE"} and "=" not in word:
            names.append(word)
    texts: dict[str, str] = {}
    for text in [*(word for word in typed.words if ":=" in word), *typed.values.get("arg", ())]:
        name, equals, value = text.partition("=")
        if equals:
            texts[name.removesuffix(":")] = value
    folders = dict.fromkeys(typed.values.get("packages", ()))
    packages = {name: Path(path) for name, _, path in (text.partition("=") for text in folders) if name and path}
    return robot_names.Subject(tuple(names), texts, packages)


def _of_kind(name: str, asked: robot_names.Subject, current: str) -> list[Candidate]:
    """Return what there is for a place of a name such as FRAME or JOINT=VALUE."""
    left, equals, right = name.partition("=")
    if name.startswith("{"):
        return _beginning(map(Candidate, name[1:-1].split(",")), current)
    if not equals:
        return _beginning(_all(left, asked, current), current)
    mark = ":=" if left.endswith(":") else "="
    left = left.removesuffix(":")
    typed, found, rest = current.partition(mark)
    if left == "NAME" and right == "VALUE":
        left, right = "ARGUMENT", f"VALUE OF {typed.removesuffix(':')}"
    if not found:
        return _beginning((one._replace(word=one.word + mark) for one in _all(left, asked, typed)), current)
    values = _all(right, asked, rest)
    return [one._replace(word=f"{typed}{mark}{one.word}") for one in _beginning(values, rest)]


def _all(name: str, asked: robot_names.Subject, current: str) -> Iterable[Candidate]:
    """Return all there is of a kind, files only as far as they are typed."""
    if name.startswith("VALUE OF "):
        return [Candidate(value) for value in robot_names.values(asked, name.removeprefix("VALUE OF "))]
    of_kind = kinds().get("FILE" if name.startswith("FILE") else name)
    return of_kind(asked, current) if of_kind else ()


def _beginning(found: Iterable[Candidate], current: str) -> list[Candidate]:
    return [one for one in found if one.word.startswith(current)]


def _names(of_robot: str) -> Callable[[robot_names.Subject, str], list[Candidate]]:
    return lambda asked, _: [Candidate(name, help) for name, help in robot_names.names(asked, of_robot).items()]


def _robots(asked: robot_names.Subject, current: str) -> list[Candidate]:
    """Return the robots of this project, then files and folders that may be one; each once."""
    given = {*asked.robots}
    named = [Candidate(name, "robot of this project") for name in robot_names.robots() if name not in given]
    with_endings = robot_names.robot_endings()
    return [*named, *map(Candidate, files(current, with_endings))]


def _checks(_: robot_names.Subject, __: str) -> list[Candidate]:
    return [Candidate(name, help) for name, help in names("checks").items()]


def _rules(_: robot_names.Subject, __: str) -> list[Candidate]:
    from ..rule import every

    return [Candidate(id, _plain(rule.what)) for id, rule in sorted(every().items())]


def _plain(text: str) -> str:
    text = text.replace("`", "")
    return text if len(text) <= _MAX_HELP else f"{text[:_MAX_HELP].rpartition(' ')[0]} ..."


def _templates(_: robot_names.Subject, __: str) -> list[Candidate]:
    from ..init import TEMPLATES

    return [Candidate(name, template.what) for name, template in TEMPLATES.items()]


def _schemas(_: robot_names.Subject, __: str) -> list[Candidate]:
    from ..schema import names

    return [Candidate(name, what) for name, what in names().items()]


def _artifacts(asked: robot_names.Subject, _: str) -> list[Candidate]:
    """Return the outputs of a robot, and the formats that it does not list."""
    from rosorin_compile.formats import FORMATS

    outputs = robot_names.names(asked, "outputs")
    formats = {name: "format, by its defaults" for name, one in FORMATS.items() if one.write and name not in outputs}
    return [Candidate(name, help) for name, help in {**outputs, **formats}.items()]


def files(current: str, endings: Sequence[str] | None = None) -> list[str]:
    """Return files (those of ``endings``; None: all) and folders, which end in ``/``, as one would go on typing.

    ``~`` is the home folder, and stays as it is typed. Hidden files show when their dot is typed; a name that begins
    with a dash needs ``./`` to be none of the options.
    """
    if current == "~":
        return ["~/"]
    before, slash, start = current.rpartition("/")
    folder = os.path.expanduser(before + slash) or "."
    found = []
    try:
        with os.scandir(folder) as entries:
            inside = {entry.name: entry.is_dir() for entry in entries}
    except OSError:  # no folder, or a name that none can have
        return []
    for name, is_folder in inside.items():
        if not name.startswith(start or tuple(set(name[:1]) - set("."))) or not name.isprintable():
            continue
        if name.startswith("-") and not slash:
            continue
        if is_folder:
            found.append(f"{before}{slash}{name}/")
        elif endings is None or name.lower().endswith(tuple(endings)):
            found.append(f"{before}{slash}{name}")
        if len(found) > MAX_FILES:
            break
    return sorted(found)


# What there is for the name of a place, beside what the entries of a section are called.
_KINDS: dict[str, Callable[[robot_names.Subject, str], Iterable[Candidate]]] = {
    "ROBOT": _robots,
    "CHECK": _checks,
    "FILE": lambda _, current: map(Candidate, files(current)),
    "SOURCE": lambda _, current: map(Candidate, files(current)),
    "PACKAGE": lambda _, current: map(Candidate, files(current, ())),
    "FOLDER": lambda _, current: map(Candidate, files(current, ())),
    "PATH": lambda _, current: map(Candidate, files(current, ())),
    "FRAME": _names("frames"),
    "SERVO": _names("servos.joint"),
    "THING": _names("things"),
    "NODE": _names("nodes"),
    "ARTIFACT": _artifacts,
    "ARGUMENT": _names(robot_names.ARGUMENTS),
    "ID": _rules,
    "SCHEMA": _schemas,
    "TEMPLATE": _templates,
}


@cache
def kinds() -> Mapping[str, Callable[[robot_names.Subject, str], Iterable[Candidate]]]:
    """Return what there is for the name of a place; a name that is not there is free text.

    ``JOINT`` is one of the entries of the section in which a joint is called so.
    """
    from rosorin_compile.language.annotations import sections

    called = {node.called.upper(): _names(section) for section, node in sections().items() if node.called}
    return {**called, **_KINDS}


def answer(words: Sequence[str], of: CommandLine) -> int:
    """Print what may stand at the cursor, a line each; nothing whatever happens, for a shell shows what is printed.

    ``-- WORD ... CURRENT`` are the words of a shell that has taken its line apart: the answer is ``WORD``, a tab and a
    help. ``--bash LINE BREAKS`` is the line of bash up to the cursor: the answer is what it is to insert.
    """
    lines: list[str] = []
    with suppress(Exception, SystemExit, KeyboardInterrupt), redirect_stdout(StringIO()), redirect_stderr(StringIO()):
        lines = _lines(words, of)
    for line in lines:
        print(line)
    return 0


def _shown(found: Iterable[Candidate]) -> list[Candidate]:
    """Return the words that can stand on a line of their own, with helps that do."""
    return [Candidate(one.word, " ".join(one.help.split())) for one in found if one.word.isprintable() and one.word]


def _lines(words: Sequence[str], of: CommandLine) -> list[str]:
    if len(words) == 3 and words[0] == "--bash":
        from .line import split

        line = split(words[1], words[2])
        if line.target:
            return [line.inserted(name) for name in files(line.words[-1])]
        return [line.inserted(one.word) for one in _shown(candidates(line.words[1:-1], line.words[-1], of))]
    if len(words) > 1 and words[0] == "--":
        return [
            f"{one.word}\t{one.help}" if one.help else one.word
            for one in _shown(candidates(words[1:-1], words[-1], of))
        ]
    return []
