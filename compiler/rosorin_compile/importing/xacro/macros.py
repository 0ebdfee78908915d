"""Call macros of vendors' xacro files from a description: parse their parameters, and generate xacro text with a call.

Parameters are parsed without running xacro, so that calls can be validated before the file is expanded, and editors can
complete parameter names.
"""

import glob
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.formats.compilation import RobotReader
from rosorin_compile.formats.imported_robot import ReadOptions
from rosorin_compile.formats.urdf.read import CHILDREN
from rosorin_compile.language.expand.files import Reader
from rosorin_compile.language.expand.placing import is_vector
from rosorin_compile.language.expression.functions import FUNCTIONS, kind_of
from rosorin_compile.source.diagnostics import Diagnostic, Source, Span, Suggestion, error, phrase, quote
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.units import ANGLE, LENGTH
from rosorin_compile.source.xml.elements import attribute_value
from rosorin_compile.source.xml.markup import Document, MarkupError, parse, read_source

from .child import CALL

# Parameter name -> default, or None if the parameter is required. Names of blocks begin with * or **.
Parameters = Mapping[str, "str | None"]
Values = dict[str, tuple[Any, Span]]

# Usual names of macro parameters that get the keys ``parent``, ``xyz`` and ``rpy`` of an include.
_PARENTS = ("parent", "parent_link", "parent_frame", "connected_to", "attach_to")
_POSES = ("*origin", "*pose")
_DIMENSIONS = {"xyz": LENGTH, "rpy": ANGLE}
_ZERO = "0 0 0"
# Matches a parameter in the syntax of ``xacro.parse_macro_arg``; the default "^" is a property of the caller.
_PARAMETER = re.compile(
    r"""\s*([^\s:=]+)(?:\s*:?=\s*((?:\^\|?)?(?:\$\{.*?\}|\$\(.*?\)|(?:'.*?'|".*?"|[^\s'"]+)+|))(?=\s|$))?""", re.DOTALL
)
_PACKAGE = re.compile(r"package://([^/\s]+)")
_FIND = re.compile(r"\$\(find\s+([^\s)]+)\s*\)")
_EVALUATED = re.compile(r"\$+(?=[{(])")  # another dollar sign before ${ or $( escapes an expression


class Call(NamedTuple):
    """A macro call as xacro text ("" if there are ``problems``); ``passed`` are the include keys that the call uses."""

    text: str = ""
    passed: frozenset[str] = frozenset()
    problems: Sequence[Diagnostic] = ()


def macros_of(document: Document, path: Path, packages: Packages) -> dict[str, Parameters]:
    """Return the parameters of each macro in a xacro file and its includes, except includes with computed names."""
    found: dict[str, Parameters] = {}
    waiting, visited = [(document, path)], {os.path.abspath(path)}
    for opened, file in waiting:
        for element in opened.root.iter():
            if any(above.tag == "xacro:macro" for above in element.ancestors()):
                continue
            name, parameters = element.get("name").removeprefix("xacro:"), _parameters(element.get("params"))
            if element.tag == "xacro:macro" and name:  # if a macro is defined twice, its parameters are optional
                merged = {**found.get(name, {}), **parameters}
                found[name] = {key: default or "" for key, default in merged.items()} if name in found else merged
            if element.tag != "xacro:include" or "ns" in element.attributes:
                continue
            included = _FIND.sub(lambda match: str(packages.find(match[1]) or match[0]), element.get("filename"))
            included = included.replace("$(dirname)", str(file.parent))
            target = None if "$" in included else packages.resolve(included, file.parent)
            if target and (place := os.path.abspath(target)) not in visited:
                visited.add(place)
                with suppress(MarkupError):  # xacro reports the errors of the file
                    waiting.append((parse(read_source(target)), target))
    return found


def _parameters(text: str) -> dict[str, str | None]:
    found: dict[str, str | None] = {}
    while match := _PARAMETER.match(text):
        found[match[1]] = match[2]
        text = text[match.end() :]
    return found


def how_to_call(path: Path, macros: Mapping[str, Parameters]) -> str:
    """Return the help message for a file that only defines macros: an example of an include that calls a macro."""
    name, parameters = next(iter(macros.items()))
    passed = (*_POSES, *_DIMENSIONS)  # an include always passes a pose
    needed = [key for key, default in parameters.items() if default is None and key not in passed]
    keys = _keys_for([*needed, *(key for key in _PARENTS if key in parameters)])
    entry = ", ".join([f"file: {path.name}", f"macro: {name}", *keys])
    others = f"; its macros are {phrase(macros)}" if len(macros) > 1 else ""
    return f"call one in a description: include: [{{{entry}}}]{others}"


def _keys_for(parameters: Iterable[str]) -> list[str]:
    """Return keys of an include that pass the parameters, such as ``with: {radius: VALUE}``, as an example."""
    names = list(parameters)
    values = ", ".join(f"{one.lstrip('*')}: VALUE" for one in names if one not in _PARENTS)
    keys = [f"with: {{{values}}}"] if values else []
    return [*keys, "parent: LINK"] if any(one in _PARENTS for one in names) else keys


def macro_call(entry: Map, document: Document, path: Path, options: ReadOptions) -> Call:
    """Build the xacro text for an include with the key ``macro``; other keys of ``entry`` become macro arguments."""
    packages = Packages(options.packages, options.environment or os.environ, path)
    macros, name = macros_of(document, path, packages), entry["macro"]
    if name not in macros:
        message = f'{path.name} defines no macro "{name}"'
        suggestion = Suggestion(name, macros, none="it has none: remove macro to include it as a robot")
        return Call(problems=[error("unknown-macro", message, entry.value_spans["macro"], suggestion)])
    parameters = macros[name]
    values, passed, problems = _values(entry, parameters)
    attributes, blocks, missing = "", "", []
    for parameter, default in parameters.items():
        key = parameter.lstrip("*")
        if key not in values:
            missing += [parameter] if default is None else []
            continue
        value, span = values[key]
        try:
            if key != parameter:
                blocks += _block(parameter, value)
            elif isinstance(value, (dict, list)):
                attributes += f" {key}={attribute_value(f'${{{_literal(value)}}}')}"
            else:
                attributes += f" {key}={attribute_value(_as_text(str(FUNCTIONS['str'](value))))}"
        except ValueError as problem:
            problems.append(error("bad-argument", f'"{key}" of the macro "{name}" {problem}', span))
        package = _PACKAGE.match(value) if isinstance(value, str) else None
        if package is not None and packages.find(package[1]) is None:
            help = f'write "packages: {{{package[1]}: FOLDER}}"'
            problems.append(error("package-missing", f'the package "{package[1]}" is not found', span, help))
    if missing:
        message = f'the macro "{name}" needs {quote(parameter.lstrip("*") for parameter in missing)}'
        help = f"write {', '.join(_keys_for(missing))}"
        problems.append(error("missing-argument", message, entry.value_spans["macro"], help))
    if problems:
        return Call(problems=problems)
    file = attribute_value(_as_text(glob.escape(os.path.abspath(path))))
    text = (
        f'<robot name={attribute_value(name)} xmlns:xacro="http://www.ros.org/wiki/xacro">'
        f"<xacro:include filename={file}/>"
        f"<{CALL}><xacro:{name}{attributes}>{blocks}</xacro:{name}></{CALL}></robot>"
    )
    return Call(text, passed)


def no_links(document: Document, path: Path, options: ReadOptions) -> Diagnostic | None:
    """Return the error if a macro creates no link, or if a file only defines macros, else None."""
    if options.call is not None:
        message, span = f'the macro "{options.call["macro"]}" creates no link', options.call.value_spans["macro"]
        return error("no-links", message, span, "call a macro that creates links")
    macros = macros_of(document, path, Packages(options.packages, options.environment or os.environ, path))
    message = f"{path.name} creates no link: it only defines macros for other files"
    return error("no-links", message, document.root.span, how_to_call(path, macros)) if macros else None


def without_mount(tree: Map, mount: str) -> Map:
    """Remove ``mount``, a link of the including robot to which a macro attaches its links, from the expanded robot."""
    made = tree.copy()
    made["links"] = made["links"].copy()
    del made["links"][mount]
    if (accept := tree.get("accept")) is not None:
        made["accept"] = Seq(accept.span)
        for entry, span in zip(accept, accept.value_spans, strict=True):
            if mount not in entry["of"]:
                made["accept"].put(entry, span)
    return made


def _values(entry: Map, parameters: Parameters) -> tuple[Values, frozenset[str], list[Diagnostic]]:
    """Return ({parameter: (value, source span)}, keys of the include that are passed, diagnostics)."""
    written, passed, problems = entry.get("with") or Map(entry.span), set[str](), list[Diagnostic]()
    values = {key: (value, written.value_spans[key]) for key, value in written.items() if value is not None}
    name, keys = entry["macro"], [parameter.lstrip("*") for parameter in parameters]
    for key in written:
        if key not in keys:
            message = f'the macro "{name}" has no parameter "{key}"'
            suggestion = Suggestion(key, keys, none="it has none")
            problems.append(error("unknown-argument", message, written.key_spans[key], suggestion))
    parent = next((key for key in _PARENTS if key in parameters), None)
    if parent is not None and entry.get("parent") is not None:
        if parent in values:
            message = f'"{parent}" is passed to the macro "{name}" twice'
            problems.append(error("bad-argument", message, values[parent][1], 'remove it: "parent" is set already'))
        values[parent] = entry["parent"], entry.value_spans["parent"]
        passed.add("parent")
        if entry.get("joint") is not None:
            message = f'the macro "{name}" ignores "joint": it creates the joint on its parent itself'
            problems.append(error("bad-argument", message, entry.key_spans["joint"], 'remove "joint"'))
    texts: dict[str, str] = {}
    for key in [one for one in _DIMENSIONS if entry.get(one) is not None]:
        if is_vector(entry[key], _DIMENSIONS[key]):
            texts[key] = " ".join(repr(float(number)) for number in entry[key])
        else:
            message = f'"{key}" must be a list of three {"lengths" if key == "xyz" else "angles"}'
            problems.append(error("wrong-type", message, entry.value_spans[key]))
    span = entry.value_spans[next(iter(texts), "macro")]
    block = next((key[1:] for key in _POSES if key in parameters and key[1:] not in values), None)
    if block is not None:
        values[block] = f'<origin xyz="{texts.get("xyz", _ZERO)}" rpy="{texts.get("rpy", _ZERO)}"/>', span
        passed |= texts.keys()
    for key in [one for one in _DIMENSIONS if block is None and one in parameters and one not in values]:
        if key in texts or parameters[key] is None:
            values[key] = texts.get(key, _ZERO), span
            passed |= {key} & texts.keys()
    for key in texts:
        if key not in passed and "parent" in passed:
            message = f'the macro "{name}" ignores "{key}": it has no block "origin" and no parameter "{key}"'
            help = f'pass the pose in "with" (parameters of the macro: {phrase(keys)})'
            if twice := next((one for one in (key, "origin", "pose") if one in values), ""):
                message = f'the pose is passed to the macro "{name}" twice: by "{key}" and by "{twice}" in "with"'
                help = "remove one of them"
            problems.append(error("bad-argument", message, entry.key_spans[key], help))
    return values, frozenset(passed), problems


def _as_text(text: str) -> str:
    """Escape xacro expressions in a string, so that a description cannot run code through a trusted file."""
    return _EVALUATED.sub(r"$\g<0>", text)


def _literal(value: Any) -> str:
    """Format a value as a Python expression without braces and dollar signs, which xacro would parse."""
    if isinstance(value, dict):
        pairs = (f"({_literal(key)}, {_literal(inner)})" for key, inner in value.items())
        return f"xacro.dotify(dict([{', '.join(pairs)}]))"  # the type of mappings from load_yaml
    if isinstance(value, list):
        return f"[{', '.join(map(_literal, value))}]"
    if isinstance(value, str):
        return repr(str(value)).replace("}", r"\x7d").replace("$", r"\x24")
    return repr(float(value) if isinstance(value, float) else value)


def _block(parameter: str, value: Any) -> str:
    """Format a block argument such as ``*origin`` as XML. Raises ValueError if the value is not plain XML."""
    key = parameter.lstrip("*")
    if not isinstance(value, str):
        raise ValueError(f"must be the text of an XML element, not {kind_of(value)}")
    text = f"<{key}>{_as_text(value)}</{key}>"
    try:
        root = parse(Source("", text)).root
    except MarkupError as problem:
        raise ValueError(f"is not XML: {problem.diagnostic.message}") from None
    if any(element.tag.startswith("xacro:") for element in root.iter()):
        raise ValueError("has elements of xacro, which only a xacro file may have")
    is_wrapped = [one.tag for one in root.children] == [key] and not any(key in tags for tags in CHILDREN.values())
    if parameter.startswith("**") and is_wrapped:  # as in a call in a xacro
        return _as_text(value)
    if not parameter.startswith("**") and len(root.children) != 1:
        raise ValueError(f"must be one XML element, not {len(root.children)}")
    return text if parameter.startswith("**") else _as_text(value)


def with_macros(schema: dict[str, Any], roots: Iterable[Path]) -> dict[str, Any]:
    """Return the JSON schema for editors with the macros of included xacro files and their parameters.

    ``roots`` are the paths of the descriptions.
    """
    found: dict[str, dict[str, Parameters]] = {}
    for root in roots:
        reader = Reader(root, RobotReader())
        reader.read(root)
        for item, _, by in reader.robots:
            with suppress(MarkupError, TypeError, AttributeError):  # skip an invalid include
                packages = reader.packages_of(item, by)
                path = reader.target(item["file"], item.get("package"), by, packages)
                found[item["file"]] = macros_of(parse(read_source(path)), path, Packages(packages, os.environ, path))
    conditions: list[dict[str, Any]] = []
    for file, macros in [(file, macros) for file, macros in found.items() if macros]:
        is_file = {"properties": {"file": {"const": file}}, "required": ["file"]}
        names = {"anyOf": [{"enum": list(macros)}, {"pattern": r"\$\{"}]}
        conditions.append({"if": is_file, "then": {"properties": {"macro": names}}})
        for name, parameters in macros.items():
            keys: dict[str, Any] = {}
            for parameter, default in parameters.items():
                text = "Required." if default is None else f"Default: {default or 'none.'}"
                text = "A block: the text of an element of XML." if parameter.startswith("*") else text
                keys[parameter.lstrip("*")] = {"description": text}
            values = {"properties": keys, "additionalProperties": False, "patternProperties": {r"\$\{": True}}
            is_call = {"properties": {"file": {"const": file}, "macro": {"const": name}}, "required": ["file", "macro"]}
            conditions.append({"if": is_call, "then": {"properties": {"with": values}}})
    include = schema["properties"]["include"]
    items = {**include["items"], **({"allOf": conditions} if conditions else {})}
    return {**schema, "properties": {**schema["properties"], "include": {**include, "items": items}}}
