"""Load formats from plug-ins: validate each ``Format``, and report exceptions of its functions as diagnostics."""

import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import fields, is_dataclass, replace
from functools import cache, partial
from typing import Any

from rosorin_compile.language.annotations import check_schema
from rosorin_compile.language.schema import schema
from rosorin_compile.source.diagnostics import Diagnostic, has_errors
from rosorin_compile.source.files import exists
from rosorin_compile.source.plugins import Plugin, PluginFailed, diagnostic_of, divert_stdout, failed_plugin, load
from rosorin_compile.source.project import ENDINGS, data_folder
from rosorin_compile.source.rule_registry import OF_PLUGINS, Rule, find
from rosorin_compile.source.xml.markup import MarkupError

from .format import Format, OutputEntry, Refusal
from .imported_robot import ImportedRobot, convert_result
from .templating import TemplateProblem


@cache
def plugin_formats(built_in: tuple[Format, ...]) -> tuple[dict[str, Format], tuple[Diagnostic, ...]]:
    """Load the formats of plug-ins. Return the valid formats by name, and diagnostics about the others."""
    readable = [one for one in built_in if one.load is not None]
    files = {mark for one in readable for mark in (*one.endings, *(f"<{root}>" for root in one.roots))}
    names = {one.name for one in built_in}

    def is_taken(name: str) -> bool:
        return name in {*names, *ENDINGS, *files} or ("-" in name and bool(find([name])))

    loaded, diagnostics = load("formats", Format, partial(_unique_names, names), is_taken)
    OF_PLUGINS.update((rule.id, rule) for _, format in loaded for rule in format.rules)
    return {format.name: _guarded(plugin, format) for plugin, format in loaded}, diagnostics


def _unique_names(built_in: Collection[str], format: Format) -> list[str]:
    for field in fields(format):
        value, default = getattr(format, field.name), field.default
        if field.name in ("options", "unsupported"):
            fits = isinstance(value, Mapping) or (field.name == "unsupported" and callable(value))
        elif default is None:
            fits = value is None or callable(value)
        elif isinstance(default, tuple):
            item = {"rules": Rule, "rounding": float}.get(field.name, str)
            fits = isinstance(value, tuple) and all(isinstance(one, item) for one in value)
        else:
            fits = isinstance(value, str if field.name in ("name", "word") else type(default))
        if not fits:
            raise TypeError(f"{field.name} of its format is {str(value)[:60]!r}")
    if not (format.name.isidentifier() and format.name == format.name.lower()):
        raise ValueError(f'"{format.name}" cannot be the name of a format: small letters, digits and _')
    if format.write is None and format.load is None:
        raise ValueError(f"{format.name} is neither written nor loaded")
    if format.becomes and format.becomes not in built_in:
        raise ValueError(f'becomes is "{format.becomes}", which is not a format')
    if format.schema and not exists(data_folder("schemas") / f"{format.schema}.schema.json"):
        raise ValueError(f'schema is "{format.schema}", which is none of those that ship with the tool')
    if format.load and not all(re.fullmatch(r"\.[a-z0-9_+-]+", one) for one in format.endings):
        raise ValueError(f"what is read ends like .{format.name}, in small letters, not {', '.join(format.endings)}")
    own = {"type": "object", "properties": {key: dict(option) for key, option in format.options.items()}}
    check_schema(own, {**schema(), "properties": {"outputs": own}})
    files = [f"<{root}>" for root in format.roots] if format.is_xml else list(format.endings)
    return [format.name, *(files if format.load else ()), *(rule.id for rule in format.rules)]


def _guarded(plugin: Plugin, format: Format) -> Format:
    def guarded(name: str, function: Callable[..., Any], *arguments: Any) -> Any:
        try:
            with divert_stdout():
                return _converted(format, name, function(*arguments), arguments)
        except (Exception, SystemExit) as problem:
            diagnostic = failed_plugin(plugin, problem)
            if isinstance(problem, TemplateProblem if name == "write" else MarkupError if name == "load" else ()):
                raise  # the template or the file is damaged, not the plug-in
            if name == "write":
                return "", [diagnostic]
            if name == "check":
                return [diagnostic]
            if name == "load":
                return ImportedRobot(None, [diagnostic], files=(arguments[0].path,))
            if name in ("read", "syntax", "data"):
                raise problem if isinstance(problem, ValueError) else ValueError(diagnostic.message) from None
            raise PluginFailed(diagnostic) from None

    functions = {field.name: getattr(format, field.name) for field in fields(format)}
    changed: dict[str, Any] = {name: partial(guarded, name, one) for name, one in functions.items() if callable(one)}
    return replace(format, **changed)


def _converted(format: Format, name: str, result: Any, arguments: tuple[Any, ...]) -> Any:
    if name == "load":
        return convert_result(result, *arguments)
    if name == "check":
        return [diagnostic_of(one) for one in result or ()]
    if name == "write":
        text, diagnostics = result[0], [diagnostic_of(one) for one in result[1]]
        if not isinstance(text, str):
            raise TypeError(f"write gives a text and diagnostics, and this text is of type {type(text).__name__}")
        if format.read is not None and not has_errors(diagnostics):
            _converted(format, "read", format.read(text), ())  # the reader of the format must accept the artifact
        return text, diagnostics
    if name in ("view", "read") and (not is_dataclass(result) or isinstance(result, type)):
        raise TypeError(f"view and read return a dataclass, such as a Robot, not {str(result)[:60]!r}")
    kinds = {"refusal": Refusal, "asked": OutputEntry}
    return kinds[name](*(result if isinstance(result, tuple) else (result,))) if name in kinds else result
