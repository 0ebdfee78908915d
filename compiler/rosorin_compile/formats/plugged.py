"""Formats of other packages: entry points of ``rosorin_compile.formats``, held so that none of them stops the tool.

What a record of theirs is and gives is looked at before anything else sees it: a mistake there is a diagnostic that
names the package.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from functools import cache, partial
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.files import exists
from rosorin_compile.source.plugins import Plugin, PluginFailed, aside, diagnostic_of, failed, load
from rosorin_compile.source.project import ENDINGS, data_folder
from rosorin_compile.source.rule_registry import OF_PLUGINS, Rule, check_texts, find

from .format import GROUPS, Asked, Format, Refusal
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
    if format.reading.becomes and format.reading.becomes not in built_in:
        raise ValueError(f'becomes is "{format.reading.becomes}", which is no format')
    if format.proving.schema and not exists(data_folder("schemas") / f"{format.proving.schema}.schema.json"):
        raise ValueError(f'schema is "{format.proving.schema}", which is none of those that ship with the tool')
    _check_options(format)
    files = [f"<{root}>" for root in format.roots] if format.is_xml else list(format.endings)
    if format.load is not None and not all(_ENDING.fullmatch(ending) for ending in format.endings):
        raise ValueError(f"what is read ends like .{format.name}, in small letters, not {', '.join(format.endings)}")
    for rule in format.rules:
        check_texts(rule)
    return [format.name, *(files if format.load else ()), *(rule.id for rule in format.rules)]


# The fields of a record that hold many things, and what each of them is; the others say it by their default.
_MANY = {"endings": str, "roots": str, "feeds": str, "lacks": str, "says": str, "rules": Rule}


def _check_types(format: Format) -> None:
    """Raise TypeError where a field of a record, or of one of its groups, holds something else than it is for."""
    for part in (format, *(getattr(format, group) for group in GROUPS)):
        for field in fields(part):
            if not _fits(field.name, getattr(part, field.name), field.default):
                raise TypeError(f"{field.name} of its format is {str(getattr(part, field.name))[:60]!r}")


def _fits(name: str, value: Any, default: Any) -> bool:
    if name in _MANY:
        item, kind = _MANY[name], frozenset if name == "lacks" else tuple
        return isinstance(value, kind) and all(isinstance(one, item) for one in value)
    if name == "options":
        return isinstance(value, Mapping) and all(isinstance(one, Mapping) for one in value.values())
    if name == "unsupported":
        return isinstance(value, Mapping) or callable(value)
    if default is None:
        return value is None or callable(value)
    return isinstance(value, str if name in ("name", "word") else type(default))


def _check_options(format: Format) -> None:
    """Raise ValueError where the options of a format are no JSON Schema of draft 7."""
    from rosorin_compile.language.schema import schema
    from rosorin_compile.language.validator import check_schema

    own = {"type": "object", "properties": {key: dict(option) for key, option in format.options.items()}}
    check_schema(own, {**schema(), "properties": {"outputs": own}})


def _guarded(plugin: Plugin, format: Format) -> Format:
    """Return a format whose functions raise nothing, and give nothing, that their callers do not expect."""

    def guarded(group: Any) -> Any:
        changed: dict[str, Any] = {}
        for field in fields(group):
            name, value = field.name, getattr(group, field.name)
            if name in _GIVES:
                changed[name] = _stopping(plugin, value, _GIVES[name])
            elif name in ("syntax", "data"):
                changed[name] = _to_value_error(plugin, value, _any)
        return replace(group, **changed)

    groups = {name: guarded(getattr(format, name)) for name in GROUPS}
    view, read = _stopping(plugin, format.view, _contents), _to_value_error(plugin, format.read, _contents)
    write, load = _written(plugin, format.write, read), _loaded(plugin, format.load)
    check = _telling(plugin, format.check)
    return replace(format, view=view, read=read, check=check, write=write, load=load, **groups)


def _written(plugin: Plugin, write: Callable[..., Any] | None, read: Callable[..., Any] | None) -> Any:
    """Return a writer whose text its own ``read`` can read back."""

    def guarded(*given: Any) -> tuple[str, list[Diagnostic]]:
        try:
            with aside(plugin):
                text, diagnostics = write(*given)  # type: ignore[misc]
                told = [diagnostic_of(one) for one in diagnostics]
            if not isinstance(text, str):
                raise TypeError(f"write gives a text and diagnostics, and this text is of type {type(text).__name__}")
            if read is not None and not any(one.severity == "error" for one in told):
                read(text)
        except TemplateProblem:
            raise
        except (Exception, SystemExit) as problem:
            return "", [failed(plugin, problem)]
        return text, told

    return write and guarded


def _loaded(plugin: Plugin, load: Callable[..., Any] | None) -> Callable[..., Any] | None:
    def guarded(opened: Any) -> Imported:
        from rosorin_compile.source.xml.markup import MarkupError

        try:
            with aside(plugin):
                made = load(opened)  # type: ignore[misc]
            return converted(made, opened)
        except MarkupError:
            raise  # what the file is like, not the plug-in
        except (Exception, SystemExit) as problem:
            return Imported(None, [failed(plugin, problem)], files=(opened.path,))

    return load and guarded


def _stopping(plugin: Plugin, function: Callable[..., Any] | None, fit: Callable[[Any], Any]) -> Any:
    """Return a function that stops the command that asks where it fails, with a word on whose fault it is."""

    def guarded(*given: Any) -> Any:
        try:
            with aside(plugin):
                return fit(function(*given))  # type: ignore[misc]
        except (Exception, SystemExit) as problem:
            raise PluginFailed(failed(plugin, problem)) from None

    return function and guarded


def _to_value_error(plugin: Plugin, function: Callable[..., Any] | None, fit: Callable[[Any], Any]) -> Any:
    def guarded(*given: Any) -> Any:
        try:
            with aside(plugin):
                return fit(function(*given))  # type: ignore[misc]
        except ValueError:
            raise
        except (Exception, SystemExit) as problem:
            raise ValueError(failed(plugin, problem).message) from None

    return function and guarded


def _telling(plugin: Plugin, check: Callable[..., Any] | None) -> Callable[..., Any] | None:
    def guarded(*given: Any) -> Iterator[Diagnostic]:
        try:
            with aside(plugin):
                found = [diagnostic_of(one) for one in check(*given) or ()]  # type: ignore[misc]
        except (Exception, SystemExit) as problem:
            found = [failed(plugin, problem)]
        yield from found

    return check and guarded


def _contents(value: Any) -> Any:
    """Return what an artifact contains. Raises TypeError for what is no dataclass."""
    if not is_dataclass(value) or isinstance(value, type):
        raise TypeError(f"view and read return a dataclass, such as a Robot, not {str(value)[:60]!r}")
    return value


def _texts(value: Any) -> list[str]:
    texts = list(value)
    if isinstance(value, str) or not all(isinstance(one, str) for one in texts):
        raise TypeError(f"texts are wanted, not {str(value)[:60]!r}")
    return texts


def _text_by_text(value: Any) -> dict[str, str]:
    texts = dict(value)
    _texts([*texts, *texts.values()])
    return texts


def _any(value: Any) -> Any:
    return value


def _text(value: Any) -> str:
    return _texts([value])[0]


def _refusal(value: Any) -> Refusal:
    """Return why an engine does not load an artifact: the reason, or one with whether the engine is too old."""
    reason, outdated = value if isinstance(value, tuple) else (value, False)
    return Refusal(_text(reason), bool(outdated))


def _asked(value: Any) -> Asked:
    """Return the output that the description of an imported robot has: an entry, or one with a remark."""
    entry, remark = value if isinstance(value, tuple) else (value, "")
    return Asked(dict(entry), _text(remark))


# What else of the groups of a record is called, and what each of them has to give.
_GIVES: Mapping[str, Callable[[Any], Any]] = {
    "links": _texts,
    "withheld": bool,
    "names": _text_by_text,
    "leaves_out": bool,
    "adds": bool,
    "beside": _texts,
    "refusal": _refusal,
    "robot_of": _text,
    "asked": _asked,
    "opens": _text,
    "differ": _text,
    "brings": _texts,
    "is_other": bool,
    "join": _any,
    "prove": _any,
}
