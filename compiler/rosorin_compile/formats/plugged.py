"""Formats of other packages: entry points of ``rosorin_compile.formats``, held so that none of them stops the tool.

What a record of theirs is and gives is looked at before anything else sees it: a mistake there is a diagnostic that
names the package.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import fields, is_dataclass, replace
from functools import cache, partial
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.files import exists
from rosorin_compile.source.plugins import Plugin, PluginFailed, aside, diagnostic_of, failed, load
from rosorin_compile.source.project import ENDINGS, data_folder
from rosorin_compile.source.rule_registry import OF_PLUGINS, Rule, check_texts, find
from rosorin_compile.source.xml.markup import MarkupError

from .format import Asked, Format, Refusal
from .imported import Imported, converted
from .templating import TemplateProblem

_ENDING = re.compile(r"\.[a-z0-9_+-]+")


class Plugged(NamedTuple):
    """The formats that plug-ins add, by name, and what is wrong with plug-ins of this kind."""

    formats: dict[str, Format]
    diagnostics: tuple[Diagnostic, ...]


@cache
def plugged(built_in: Collection[str], files: Callable[[], Collection[str]]) -> Plugged:
    """Return the formats of plug-ins; ``built_in`` are the names that they may not have, ``files`` the endings."""

    def is_taken(name: str) -> bool:
        return name in built_in or name in ENDINGS or name in files() or ("-" in name and bool(find([name])))

    loaded, diagnostics = load("formats", Format, partial(_marks, built_in), is_taken)
    OF_PLUGINS.update((rule.id, rule) for _, format in loaded for rule in format.rules)
    return Plugged({format.name: _guarded(plugin, format) for plugin, format in loaded}, diagnostics)


def _marks(built_in: Collection[str], format: Format) -> list[str]:
    """Return what nobody else may have: a format's name, by what its files are known, the ids of its rules.

    Raises ValueError or TypeError for a record that is none.
    """
    _check_types(format)
    if not (format.name.isidentifier() and format.name == format.name.lower()):
        raise ValueError(f'"{format.name}" cannot be the name of a format: small letters, digits and _')
    if format.write is None and format.load is None:
        raise ValueError(f"{format.name} is neither written nor loaded")
    if format.becomes and format.becomes not in built_in:
        raise ValueError(f'becomes is "{format.becomes}", which is no format')
    if format.schema and not exists(data_folder("schemas") / f"{format.schema}.schema.json"):
        raise ValueError(f'schema is "{format.schema}", which is none of those that ship with the tool')
    _check_options(format)
    files = [f"<{root}>" for root in format.roots] if format.is_xml else list(format.endings)
    if format.load is not None and not all(_ENDING.fullmatch(ending) for ending in format.endings):
        raise ValueError(f"what is read ends like .{format.name}, in small letters, not {', '.join(format.endings)}")
    for rule in format.rules:
        check_texts(rule)
    return [format.name, *(files if format.load else ()), *(rule.id for rule in format.rules)]


# The fields of a record with several items, and the type of each.
_MANY = {"endings": str, "roots": str, "feeds": str, "lacks": str, "rules": Rule}


def _check_types(format: Format) -> None:
    """Raise TypeError if a field of a record has a value of another type than it needs."""
    for field in fields(format):
        if not _fits(field.name, getattr(format, field.name), field.default):
            raise TypeError(f"{field.name} of its format is {str(getattr(format, field.name))[:60]!r}")


def _fits(name: str, value: Any, default: Any) -> bool:
    if name in _MANY:
        kind = frozenset if name == "lacks" else tuple
        return isinstance(value, kind) and all(isinstance(one, _MANY[name]) for one in value)
    if name == "options":
        return isinstance(value, Mapping) and all(isinstance(one, Mapping) for one in value.values())
    if name == "unsupported":
        return isinstance(value, Mapping) or callable(value)
    if default is None:
        return value is None or callable(value)
    return isinstance(value, str if name in ("name", "word") else type(default))


def _check_options(format: Format) -> None:
    """Raise ValueError if the options of a format are no JSON Schema of draft 7."""
    from rosorin_compile.language.schema import schema
    from rosorin_compile.language.validator import check_schema

    own = {"type": "object", "properties": {key: dict(option) for key, option in format.options.items()}}
    check_schema(own, {**schema(), "properties": {"outputs": own}})


def _guarded(plugin: Plugin, format: Format) -> Format:
    """Return a format whose functions raise and return nothing that their callers do not expect."""

    def stop(problem: BaseException, *_: Any) -> Any:
        raise PluginFailed(failed(plugin, problem)) from None

    def refuse(problem: BaseException, *_: Any) -> Any:
        raise problem if isinstance(problem, ValueError) else ValueError(failed(plugin, problem).message) from None

    def report(problem: BaseException, *_: Any) -> list[Diagnostic]:
        return [failed(plugin, problem)]

    def unwritten(problem: BaseException, *_: Any) -> tuple[str, list[Diagnostic]]:
        if isinstance(problem, TemplateProblem):
            raise problem
        return "", [failed(plugin, problem)]

    def unread(problem: BaseException, opened: Any) -> Imported:
        if isinstance(problem, MarkupError):
            raise problem  # the file is damaged, not the plug-in
        return Imported(None, [failed(plugin, problem)], files=(opened.path,))

    def written(made: Any, *_: Any) -> tuple[str, list[Diagnostic]]:
        text, diagnostics = made
        reported = [diagnostic_of(one) for one in diagnostics]
        if not isinstance(text, str):
            raise TypeError(f"write gives a text and diagnostics, and this text is of type {type(text).__name__}")
        if changed["read"] is not None and not any(one.severity == "error" for one in reported):
            changed["read"](text)  # its own reader has to understand it
        return text, reported

    def guard(name: str, convert: Callable[..., Any], otherwise: Callable[..., Any]) -> None:
        function = getattr(format, name)

        def guarded(*arguments: Any) -> Any:
            try:
                with aside(plugin):
                    return convert(function(*arguments), *arguments)
            except (Exception, SystemExit) as problem:
                return otherwise(problem, *arguments)

        changed[name] = function and guarded

    changed: dict[str, Any] = {}
    for name, convert in _RETURNS.items():
        guard(name, convert, stop)
    for name in ("syntax", "data"):
        guard(name, _first, refuse)
    guard("read", _contents, refuse)
    guard("check", lambda found, *_: [diagnostic_of(one) for one in found or ()], report)
    guard("write", written, unwritten)
    guard("load", converted, unread)
    return replace(format, **changed)


def _first(value: Any, *_: Any) -> Any:
    return value


def _contents(value: Any, *_: Any) -> Any:
    if not is_dataclass(value) or isinstance(value, type):
        raise TypeError(f"view and read return a dataclass, such as a Robot, not {str(value)[:60]!r}")
    return value


def _texts(value: Any, *_: Any) -> list[str]:
    texts = list(value)
    if isinstance(value, str) or not all(isinstance(one, str) for one in texts):
        raise TypeError(f"texts are wanted, not {str(value)[:60]!r}")
    return texts


def _text_by_text(value: Any, *_: Any) -> dict[str, str]:
    texts = dict(value)
    _texts([*texts, *texts.values()])
    return texts


def _text(value: Any, *_: Any) -> str:
    return _texts([value])[0]


def _flag(value: Any, *_: Any) -> bool:
    return bool(value)


def _refusal(value: Any, *_: Any) -> Refusal:
    """Return why an engine does not load an artifact, from the reason or from a pair with whether it is outdated."""
    reason, outdated = value if isinstance(value, tuple) else (value, False)
    return Refusal(_text(reason), bool(outdated))


def _asked(value: Any, *_: Any) -> Asked:
    """Return the output of an imported robot, from an entry or from a pair with a remark."""
    entry, remark = value if isinstance(value, tuple) else (value, "")
    return Asked(dict(entry), _text(remark))


# The other functions of a record, and what converts or refuses their results.
_RETURNS: Mapping[str, Callable[..., Any]] = {
    **dict.fromkeys(("links", "beside", "brings"), _texts),
    **dict.fromkeys(("withheld", "leaves_out", "adds", "is_other"), _flag),
    **dict.fromkeys(("robot_of", "opens", "differ"), _text),
    **dict.fromkeys(("join", "prove"), _first),
    "names": _text_by_text,
    "refusal": _refusal,
    "asked": _asked,
    "view": _contents,
}
