"""Expand a description to a plain tree; warn of names that are unused or look alike; explain missing names.

Scopes are lexical: there is one for the description (all its files), one for each use of a part, and one for each
iteration of a loop. Sections of the same name are joined in this order: sections of included robots, of included files,
of the including file, and of parts in the order of ``use``.
"""

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from itertools import chain, islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, MadeSpan, Related, Suggestion, error
from rosorin_compile.source.load import plain_scalar
from rosorin_compile.source.messages import arrange, merge_by_name, move_to_name, offer
from rosorin_compile.source.project import ENDINGS, PackageFolder, data_folder
from rosorin_compile.source.tree import Map, Place, Seq, value_at
from rosorin_compile.source.wording import and_more, difference, hidden_letter, in_words, look, suggest, swaps

from ..annotations import ENTRIES
from ..expression import pieces
from ..schema import keys_of_xml, merged_sections, of_parts, schema
from ..symbols import WORD, Symbol, SymbolTable
from ..validate import validate
from .declarations import check_controls, check_part, declare
from .files import Reader
from .included_robots import IncludedRobots
from .parts import Parts, apply_types
from .placing import copy, join
from .scope import DisabledEntry, EvaluationFailed, Scope

if TYPE_CHECKING:
    from rosorin_compile.formats.compilation import RobotReader
    from rosorin_compile.source.diagnostics import Span

    from .included_robots import Tell

_FORMS = {"parts": 'write "NAME: {links: ..., joints: ...}"', "use": 'write "NAME: {part: ...}"'}
_FORMS |= {"sensor_types": 'write "NAME: {params: ..., mjcf: ...}"'}
_NOT_EVALUATED = ("args", "modes")
MAX_SHOWN = 40  # maximum number of characters of an argument in a message
_MAX_FILES = 500
_CHECKED = ("argument", "value", "part", "sensor type", "publisher", "mode")
_EXPRESSIONS = ("argument", "value", "parameter")
_QUOTED = r'"([^"]+)"'
MAX_ROUNDS = 100
MAX_RELATED = 6


class ExpandedDescription(NamedTuple):
    """The result of ``expand``: the tree without includes, parts, loops and expressions, or None after an error.

    ``files`` are the files that were read, ``resolved`` the packages that were found. ``scope`` has the arguments and
    named values of the description, or is None if the main file cannot be read. ``unused`` has warnings about unused
    names, to print only if there are no errors. ``symbols`` has the names in the files before expansion.
    """

    tree: Map | None
    diagnostics: list[Diagnostic]
    files: tuple[Path, ...]
    scope: Scope | None = None
    resolved: tuple[PackageFolder, ...] = ()
    unused: tuple[Diagnostic, ...] = ()
    symbols: SymbolTable | None = None


def expand(
    path: Path,
    arguments: Mapping[str, Any],
    robots: "RobotReader | None",
    tell: "Tell | None" = None,
    packages: Mapping[str, Path] | None = None,
    cache: dict[Any, Any] | None = None,
) -> ExpandedDescription:
    """Expand the description with the main file ``path``: resolve includes, parts, loops and expressions.

    ``arguments`` maps names to values; strings are parsed like YAML scalars, as on the command line. If it is a
    ``Map``, errors are reported at positions in its file. ``robots`` reads included robots in other formats; None skips
    them. ``tell`` is called with a warning before a xacro file executes code; if it is None, the warnings are returned.
    ``packages`` maps names of ROS packages to folders. ``cache`` keeps parsed files between calls.
    """
    reader = Reader(path, robots, packages, cache)
    root = reader.read(path)
    if root is None:
        return ExpandedDescription(None, reader.diagnostics, tuple(reader.files))
    scope, expansion = reader.scope, reader.scope.expansion
    scope.values["load()"], scope.values["find()"] = reader.load_function(), reader.find_function()
    for lets in reader.lets:
        scope.define_all(lets)
    _declare_arguments(root, arguments, reader, scope)
    included = IncludedRobots(reader, robots, tell) if robots else None
    tree = _evaluate(root, scope, reader, list(included.fragments()) if included else [])
    if tree is not None and included:
        included.settle(tree)
    with expansion.without_limits():
        scope.evaluate_rest()
    offered = [*reader.offered, *(entry for entry, _, _ in reader.robots)]
    symbols = SymbolTable(root, reader.lets, offered, expansion.is_constant)
    check_letters(symbols, scope)
    for file in reader.sourced:  # check here: a file may have no entries that inherit its "source"
        if isinstance(file["source"], Map) and expansion.is_constant(file["source"]):
            top = Map(root.span)
            top.put("robot", "robot", root.span, root.span)
            top.put("source", file["source"], file.key_spans["source"], file.value_spans["source"])
            expansion.diagnostics += validate(top, {})
    warnings = unused_names(symbols, reader.files) if tree is not None else []
    diagnostics = expansion.diagnostics if tree is not None else _without_misnamed(root, expansion.diagnostics)
    if reader.unread:  # an included file that could not be read may define the missing names
        diagnostics = [one for one in diagnostics if not _is_missing(one)]
    if any(one.severity == ERROR for one in diagnostics):  # report each missing name once, where it was written
        diagnostics = merge_by_name(move_to_name(one, offer(one)) for one in diagnostics)
    diagnostics += included.diagnostics if included else []
    resolved = tuple(dict.fromkeys(reader.resolved))
    return ExpandedDescription(tree, diagnostics, tuple(reader.files), scope, resolved, tuple(warnings), symbols)


def _without_misnamed(root: Map, diagnostics: list[Diagnostic]) -> list[Diagnostic]:
    """If a misspelled section or ``for`` causes errors about missing names, report the misspelled key instead."""
    sections = root.copy()
    for key in sections.keys() & {*schema("description")["properties"], *_FORMS}:
        del sections[key]
    misnamed = [one for one in validate(sections, {}) if one.rule == "unknown-key"] if sections else []
    waiting: list[Any] = [root]
    while waiting:
        node = waiting.pop()
        waiting += [one for one in (node.values() if isinstance(node, Map) else node) if isinstance(one, (Map, Seq))]
        for key, value in node.items() if isinstance(node, Map) else ():
            if isinstance(value, Map) and "for" in swaps(key):
                message, place = f'this entry has no key "{key}"', Place(node.key_spans[key], node.via)
                misnamed.append(error("unknown-key", message, place.span, suggest("for"), place.stack()))
    return [*misnamed, *(one for one in diagnostics if not (misnamed and _is_missing(one)))]


def _is_missing(diagnostic: Diagnostic) -> bool:
    missing = diagnostic.message.startswith("there is no value named ")
    return missing or diagnostic.rule in ("unknown-part", "unknown-sensor-type", "unknown-argument")


def _evaluate(root: Map, scope: Scope, reader: Reader, robots: list[Map | None]) -> Map | None:
    own, good = Map(root.span), None not in robots
    for key, value in root.items():
        place = Place(root.value_spans[key], None)
        if key in _FORMS:
            if not isinstance(value or {}, dict):
                what = "types" if key == "sensor_types" else "parts"
                scope.report("wrong-type", f'"{key}" must map names to {what}', place, _FORMS[key])
                good = False
            continue
        try:
            if key not in _NOT_EVALUATED:
                if key in merged_sections(ENTRIES) and not check_controls("", root, (key,), scope):
                    raise EvaluationFailed
                value = scope.resolve(value, place, key in keys_of_xml())
            own.put(key, copy(value) if key in of_parts() else value, root.key_spans[key], root.value_spans[key])
        except EvaluationFailed:
            good = False
    tree = Map(own.span) if any(robots) else own
    for sections in [*robots, own] if any(robots) else ():
        join(tree, sections or Map(own.span), scope)
    parts = Parts(root.get("parts"), scope, reader.parts_file)
    uses = root.get("use")
    if isinstance(uses, Map):
        good &= check_controls("", root, ("use",), scope) and parts.use(tree, uses, scope)
    for name, body in parts.own.items():  # unused parts have not been checked yet
        if id(body) not in parts.sound:
            check_part(name, parts.own, scope)
    if not good:
        return None
    apply_types(tree, root.get("sensor_types"), scope, data_folder("parts_library") / "sensors.yaml")
    return tree


def _declare_arguments(root: Map, arguments: Mapping[str, Any], reader: Reader, scope: Scope) -> None:
    """Define the arguments of the description; values from the caller override values from includes and defaults."""
    declared = root.get("args")
    declared = declared if isinstance(declared, Map) else Map(root.span)
    given: dict[str, tuple[Any, Place]] = {}
    for name, (value, place) in reader.given.items():
        with suppress(EvaluationFailed):
            given[name] = scope.resolve(value, place), place
    spans: Mapping[str, Span] = getattr(arguments, "value_spans", {})
    for name, value in arguments.items():
        if name not in declared:
            key, help = getattr(arguments, "key_spans", {}).get(name), Suggestion(name, declared, none="it has none")
            unknown = error("unknown-argument", f'the description has no argument "{name}"', key, help)
            scope.expansion.diagnostics.append(unknown)
            continue
        declaration = declared[name]
        kind = declaration.get("type") if isinstance(declaration, Map) else None
        if value == "" and type(value) is str and kind != "text":
            continue  # use the default, as xacro does: launch files cannot omit an argument, and pass "name:=" instead
        span = spans.get(name)
        if span is None:  # the value is from the command line or Python: report errors at the declaration
            span = MadeSpan(*declared.key_spans[name])
            span.via = (Related(f"passed as an argument: {name}={str(value)[:MAX_SHOWN]}", None),)
        given[name] = _given(value, kind, span), Place(span, None)
    declare(scope, declared, given, "the description")


def _given(value: Any, kind: Any, span: "Span") -> Any:
    if type(value) is str:
        if kind == "boolean" and value in ("0", "1"):
            return value == "1"
        return value if kind == "text" else plain_scalar(value)
    if type(value) is list:
        items = Seq(span)
        for item in value:
            items.put(_given(item, None, span), span)
        return items
    if type(value) is dict:
        table = Map(span)
        for key, item in value.items():
            table.put(key, _given(item, None, span), span, span)
        return table
    return value


def check_letters(symbols: SymbolTable, scope: Scope) -> None:
    """Report invisible characters in the names that a description defines, and warn about names that look alike."""
    first: dict[tuple[str, ...], Symbol] = {}
    for one in symbols.definitions():
        if one.place is None:
            continue
        ignore_case = one.kind in ("part", "sensor type")  # named values may differ only in case: r, R
        if letter := hidden_letter(one.name):
            message = f'{one.kind} "{one.name}" contains an invisible character: {in_words(letter)}'
            scope.report("invisible-letter", message, one.place, "retype the name without this character")
            continue
        similar = first.setdefault((one.kind, one.owner, look(one.name, ignore_case)), one)
        if similar.name != one.name and similar.place:
            other = f'{one.kind} "{similar.name}" only in {difference(one.name, similar.name)}'
            related = (Related("the similar name", similar.place.span), *one.place.stack())
            message, help = f'{one.kind} "{one.name}" differs from {other}', "give one of them another name"
            warning = Diagnostic("names-look-alike", WARNING, message, one.place.span, related, help)
            scope.expansion.diagnostics.append(warning)


def unused_names(symbols: SymbolTable, read: Iterable[Path]) -> list[Diagnostic]:
    """Return a warning for each defined name that is never used; ``read`` are the files of the description."""
    tree, uses = symbols.tree, list(symbols.references(_CHECKED))
    used = {(one.kind, one.name, one.owner) for one in uses if (one.kind, *one.path[:2]) != ("part", "parts", one.name)}
    hidden = {one.kind for one in uses if "$" in one.name}
    outputs = tree.get("outputs")
    if isinstance(outputs, Map):  # templates may use any publisher or mode, output options any mode
        templates = any(isinstance(entry, Map) and "template" in entry for entry in outputs.values())
        hidden |= {"publisher", "mode"} if templates else set()
        used |= {("mode", word, "") for word in WORD.findall(str(outputs))}
    shared: dict[str, bool] = {}
    warnings = []
    for one in symbols.definitions():
        kind = "value" if one.kind in _EXPRESSIONS else one.kind
        if kind not in _CHECKED or kind in hidden or "$" in one.name or (kind, one.name, one.owner) in used:
            continue
        place, entry = one.place or tree.locate(one.path, key=True), value_at(tree, one.path)
        if one.kind == "publisher" and (isinstance(entry, str) or (entry or {}).get("stamps")):
            continue
        what, file = f'{one.kind} "{one.name}"', place.span.source.path
        message = f"{one.owner} never uses its {what}" if one.owner else f"nothing uses the {what}"
        if file not in shared:
            shared[file] = file != tree.span.source.path and _is_shared(files.resolve(file), read)
        if not shared[file]:
            warnings.append(Diagnostic("unused", WARNING, message, place.span, place.stack(), "use it, or remove it"))
    return warnings


def _is_shared(file: Path, read: Iterable[Path]) -> bool:
    """Return True if a YAML file of another description nearby mentions ``file``, and so may use its names."""
    own, siblings = {files.resolve(path) for path in read}, chain(file.parent.glob("*"), file.parent.parent.glob("*/*"))
    others = (path for path in islice(siblings, _MAX_FILES) if path.suffix in ENDINGS)
    with suppress(OSError):
        return any(file.name in files.read_text(p, errors="replace") for p in others if files.resolve(p) not in own)
    return False


def explain_missing_names(scope: Scope, tree: Map, diagnostics: list[Diagnostic]) -> list[Diagnostic]:
    """If an entry that ``if`` or ``for`` removed would define missing names, merge the errors about these names."""
    symbols = SymbolTable(tree)
    existing = {name for kind, some in symbols.contents.names.items() if kind != "robot" for name in some}
    existing.update(one.name for one in symbols.definitions(implied=True) if one.kind != "robot")
    messages = [one.message for one in diagnostics if one.severity != NOTE]
    missing = {name for message in messages for name in re.findall(_QUOTED, message)} - existing
    if not missing:
        return diagnostics
    rounds: Counter[int] = Counter()
    dropped: dict[tuple[int, str], DisabledEntry] = {}  # several iterations may drop the same entry
    for entry in scope.expansion.disabled:
        rounds[id(entry.item)] += 1
        if rounds[id(entry.item)] <= MAX_ROUNDS:
            dropped.setdefault((id(entry.item), _pattern(entry)), entry)
    causes: dict[str, tuple[int, str]] = {}
    for name in missing:
        for key, entry in dropped.items():
            begin = re.match(key[1], name) if entry.is_use else re.fullmatch(key[1], name)
            # A name belongs to a removed ``use`` entry only if no existing name has its prefix.
            if begin is not None and not (entry.is_use and any(one.startswith(begin[0]) for one in existing)):
                causes.setdefault(name, key)
    others: list[Diagnostic] = []
    groups: dict[tuple[tuple[int, str], str], list[Diagnostic]] = {}
    for diagnostic in diagnostics:
        names = re.findall(_QUOTED, diagnostic.message) if diagnostic.severity != NOTE else ()
        cause = next((causes[name] for name in names if name in causes), None)
        (groups.setdefault((cause, diagnostic.severity), []) if cause else others).append(diagnostic)
    return [*others, *(_explained(dropped[cause], arrange(group)) for (cause, _), group in groups.items())]


def _pattern(entry: DisabledEntry) -> str:
    """Return a regular expression for the names that a removed entry would define, or for the prefix of its part."""
    scope, expansion, key, item = entry.scope, entry.scope.expansion, entry.key, entry.item
    texts, patterns = [text for text in (key, *_frames(item)) if text], []
    if entry.is_use:
        prefix = item.get("prefix", f"{key}_")
        texts = [prefix] if isinstance(prefix, str) and prefix else []
    for text in texts:
        if entry.is_empty:
            patterns.append("".join(".+?" if one.is_expression else re.escape(one.text) for one in pieces(text)))
            continue
        reported = len(expansion.diagnostics)
        with expansion.without_limits(), suppress(EvaluationFailed):
            patterns.append(re.escape(scope.name(text, item.span, scope.via)))
        del expansion.diagnostics[reported:]
    # In the same part, names are written without the prefix of the part.
    return f"(?:{re.escape(scope.prefix)})?(?:{'|'.join(patterns) or '(?!)'})"


def _explained(entry: DisabledEntry, group: list[Diagnostic]) -> Diagnostic:
    (first, *others), item, key = group, entry.item, entry.key
    span, why = item.value_spans["for" if entry.is_empty else "if"], "its loop is empty"
    help = 'put the entry that uses the name in the same loop ("for"), or add an item to the loop'
    if not entry.is_empty:
        help = "put the same condition on the entry that uses the name"
        why = f"its condition {item['if']} is false" if isinstance(item["if"], str) else "its condition is false"
        with suppress(EvaluationFailed):
            key = entry.scope.name(key, item.span, entry.scope.via) if "$" in key else key
    what = f'"{key}"' if key else "an item of a list"
    message = f"{first.message}; {what} is left out at {span.source.path}:{span.line} because {why}"
    related = [Related("left out here", span)]
    related += [Related(f"same cause: {one.message}", one.span) for one in others[:MAX_RELATED]]
    if more := and_more(len(others) - MAX_RELATED):
        related.append(Related(f"same cause:{more}", None))
    return replace(first, message=message, help=help, related=(*related, *first.related))


def _frames(item: Any) -> list[str]:
    if not isinstance(item, Map):
        return []
    is_edge = "publisher" in item and "type" not in item
    names = [item.get(key) for key in ("frame", "joint", *(("child",) if is_edge else ()))]
    return [name for name in [*names, *_frames(item.get("optical"))] if isinstance(name, str)]
