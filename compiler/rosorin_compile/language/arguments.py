"""Read and convert the arguments of a description, and add the outputs that a caller requests."""

import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import count, product
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.source.diagnostics import Diagnostic, Span, Suggestion, error, has_errors
from rosorin_compile.source.files import is_folder, label
from rosorin_compile.source.load import LoadError, load_mapping
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.tree import Instance, Map, Seq
from rosorin_compile.source.wording import first_of

from .expand.description import expand
from .expand.files import Reader
from .expression.functions import FUNCTIONS, ExpressionError, KindError, kind_of, plain_value, type_of
from .origins import SourceEntries

if TYPE_CHECKING:
    from rosorin_compile.formats import Format

UNKNOWN = "unknown-output"
_MOST_NAMED = 20
_ADDED = "taken with the defaults of its format; an entry under outputs can say more"

Choice = tuple[str, tuple[str, ...]]  # the name of an argument and its possible values, the default first
Combination = tuple[str, ...]  # one value per argument, in the order of the choices

NO_ARGUMENTS = "leave the arguments out"
# ``declared_arguments`` returns only the errors of these rules, and ignores all other errors in the description.
_OF_ARGUMENTS = ("unknown-argument", "bad-argument")


class Argument(NamedTuple):
    """An argument that a description declares; text fields are as written in the file, or "" if absent.

    ``allowed`` are the values of ``one_of``. ``value`` is the value that this run sets, or "" if the default is used.
    ``set_at`` is the position of that value in a file, or None if it is not from a file.
    """

    name: str
    type: str
    allowed: tuple[str, ...]
    required: bool
    default: str
    help: str
    span: Span
    value: str = ""
    set_at: Span | None = None


def declared_arguments(
    path: Path, arguments: Mapping[str, Any], packages: Mapping[str, Path] | None = None
) -> tuple[list[Argument], list[Diagnostic]]:
    """Return the arguments that a description declares, and errors in the values ``arguments``.

    ``path`` is the main file of the description; ``packages`` maps names of ROS packages to folders.
    """
    reader = Reader(path, None, packages)
    root = reader.read(path)
    if root is None or has_errors(reader.diagnostics):
        return [], reader.diagnostics
    entries = root["args"] if isinstance(root.get("args"), Map) else Map(root.span)
    expanded = expand(path, arguments, None, packages=packages)
    written, found = SourceEntries(), list[Argument]()
    for name, entry in entries.items():
        table: Mapping[str, Any] = entry if isinstance(entry, Map) else {"default": entry} if entry is not None else {}
        choice, spans = table.get("one_of"), entry.value_spans if isinstance(entry, Map) else {}
        span = spans.get("default", entries.value_spans[name])
        default = written.text(span) if "default" in table else ""
        choices = choice.value_spans if isinstance(choice, Seq) else [spans["one_of"]] if choice else []
        kind, allowed = str(table.get("type") or "any"), tuple(map(written.text, choices))
        help, place = " ".join(str(table.get("help") or "").split()), entries.key_spans[name]
        argument = Argument(name, kind, allowed, "default" not in table, default, help, place)
        if name in arguments or name in reader.given:
            values = getattr(arguments, "value_spans", {})
            set_at = values.get(name) if name in arguments else reader.given[name][1].span
            text = str(arguments[name]) if set_at is None else written.text(set_at)
            argument = argument._replace(value=text, set_at=set_at)
        found.append(argument)
    return found, arrange(d for d in expanded.diagnostics if d.rule in _OF_ARGUMENTS)


def choices(arguments: Sequence[Argument], values: Mapping[str, Any]) -> list[Choice]:
    """Return (name, possible values) of each boolean or ``one_of`` argument that neither ``values`` nor a file sets."""
    found = []
    for argument in arguments:
        allowed = argument.allowed or (("true", "false") if argument.type == "boolean" else ())
        if allowed and argument.name not in values and argument.set_at is None:
            first = [value for value in allowed if value == argument.default]
            found.append((argument.name, tuple(dict.fromkeys([*first, *allowed]))))
    return found


def combinations(varied: Sequence[Choice]) -> Iterator[Combination]:
    """Yield all combinations of values: first the defaults, then all with one value changed, then the rest."""
    defaults = tuple(values[0] for _, values in varied)
    near = [defaults]
    for index, (_, values) in enumerate(varied):
        near += [(*defaults[:index], value, *defaults[index + 1 :]) for value in values[1:]]
    yield from near
    known = set(near)
    yield from (row for row in product(*(values for _, values in varied)) if row not in known)


def read(paths: Iterable[Path], texts: Mapping[str, str]) -> Map:
    """Merge YAML files of argument values; later files override earlier files, and ``texts`` overrides all files."""
    first, *others = (load_mapping(path, label(path)) for path in paths)
    merged = Map(first.span)
    for values in (first, *others):
        for name in values.expression_keys():
            message = f'the argument "{name}" is an expression; a file of arguments holds values'
            raise LoadError(error("bad-argument", message, values.value_spans[name], "write its result"))
        for name in values:
            merged.put_from(values, name)
    for name, text in texts.items():
        merged[name] = text
        merged.key_spans.pop(name, None)
        merged.value_spans.pop(name, None)
    return merged


def of_api(
    path: object, arguments: object, packages: object
) -> tuple[str, dict[str, Any], dict[str, Path], list[Diagnostic]]:
    """Validate the path, arguments and package folders that were passed to the Python API.

    Return (path, arguments, folders, errors); the values are unusable if there are errors.
    """
    values, diagnostics = from_python({} if arguments is None else arguments)
    name = os.fsdecode(path) if isinstance(path, (str, os.PathLike)) else ""
    if not isinstance(path, (str, os.PathLike)):
        message = f"the path of a robot is text or a Path; this is {type_of(path)}"
        diagnostics.insert(0, error("wrong-type", message, None))
    folders: dict[str, Path] = {}
    if not isinstance(packages or {}, Mapping):
        message = f"packages map names to folders; this is {type_of(packages)}"
        diagnostics.append(error("package-missing", message, None, 'write {"NAME": FOLDER}'))
    for package, folder in packages.items() if isinstance(packages, Mapping) else ():
        if isinstance(package, str) and isinstance(folder, (str, os.PathLike)) and is_folder(folder):
            folders[package] = Path(os.fsdecode(folder))
        else:
            message = f'there is no folder "{folder!s:.200}" for the package {package!s:.60}'
            diagnostics.append(error("package-missing", message, None))
    return name, values, folders, diagnostics


def takes_no_arguments(path: Path) -> Diagnostic:
    """Return the error for passing arguments to a file that cannot have any, such as a URDF."""
    message = f"{path.name} takes no arguments: only descriptions and xacro files do"
    return error("unknown-argument", message, None, NO_ARGUMENTS)


def from_python(arguments: object) -> tuple[dict[str, Any], list[Diagnostic]]:
    """Convert a mapping of Python objects to argument values; return (values by name, errors).

    Numbers are in SI units; strings are parsed like ``-a NAME=TEXT``. Other objects are converted by ``plain_value``.
    """
    if not isinstance(arguments, Mapping):
        message = f"arguments map names to values; this is {type_of(arguments)}"
        return {}, [error("bad-argument", message, None, 'write {"NAME": VALUE}')]
    values: dict[str, Any] = {}
    diagnostics: list[Diagnostic] = []
    for name, value in arguments.items():
        try:
            if not isinstance(name, str):
                raise ExpressionError("is not a name: a name is text")
            values[str(name)] = plain_value(value)
        except ExpressionError as problem:
            help = "a value is text, a number, true or false, None, a list or a table of them"
            diagnostics.append(error("bad-argument", f'the argument "{name!s:.60}" {problem}', None, help))
    return values, diagnostics


def as_texts(values: Mapping[str, Any]) -> tuple[dict[str, str], list[Diagnostic]]:
    """Convert argument values to strings for xacro, quantities in SI units; return (strings by name, errors)."""
    texts: dict[str, str] = {}
    diagnostics: list[Diagnostic] = []
    for name, value in values.items():
        try:
            texts[name] = FUNCTIONS["str"](value)
        except KindError:
            message = f'the argument "{name}" of a xacro is text or a number, not {kind_of(value)}'
            diagnostics.append(error("bad-argument", message, None))
    return texts, diagnostics


def with_wanted(tree: Map, wanted: Sequence[str], formats: "Mapping[str, Format]") -> tuple[Map, list[Diagnostic]]:
    """Add the requested outputs ``wanted`` to ``outputs`` of a tree; return (new tree, errors about unknown names)."""
    listed = Map(tree.span, tree.via) if tree.get("outputs") is None else tree["outputs"]
    new = [name for name in dict.fromkeys(wanted) if name not in listed] if isinstance(listed, Map) else []
    if not new:  # nothing to add, or not a mapping (reported by validation)
        return tree, []
    written = [name for name, format in formats.items() if format.write is not None]
    robot, span = str(tree.get("robot", "robot")), tree.key_spans.get("robot", tree.span)
    if unknown := [name for name in new if name not in written]:
        has = f"its outputs: {first_of(list(listed), _MOST_NAMED)}" if listed else "it lists no outputs"
        if others := [one for one in written if one not in listed]:
            has += f"; with their defaults: {first_of(others, _MOST_NAMED)}"
        errors = []
        for name in unknown:
            message = f'{robot} has no output "{name}", and there is no format of that name'
            errors.append(error(UNKNOWN, message, None, Suggestion(name, [*listed, *written], details=has)))
        return tree, errors
    section = listed.copy()
    for name in new:
        entry, format = Map(span, Instance(_ADDED, span, tree.via)), formats[name]
        usual = (format.file or f"{{}}.{format.name}").format(re.sub(r"[^\w.-]", "_", robot))
        taken = {str(one.get("file")).casefold() for one in section.values() if isinstance(one, Map)}
        names = (usual if number == 1 else f"{number}_{usual}" for number in count(1))
        entry.put("file", next(file for file in names if file.casefold() not in taken), span, span)
        section.put(name, entry, span, span)
    made = tree.copy()
    place = (tree.key_spans["outputs"], tree.value_spans["outputs"]) if "outputs" in tree else (span, span)
    made.put("outputs", section, *place)
    return made, []


def is_listed(entry: object) -> bool:
    """Return True if an entry of ``outputs`` is from the description, False if ``with_wanted`` added it."""
    return not (isinstance(entry, Map) and entry.via is not None and entry.via.message == _ADDED)
