"""Import a robot from a file in any format, which is detected from the file name and the content.

The YAML tree of an imported robot is validated. Existing robots violate some rules that other programs do not enforce,
such as that an axis has length 1. An entry of ``accept`` suppresses each of these violations; all others are errors.
"""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from rosorin_compile.language.lower import lower
from rosorin_compile.language.suppressions import apply
from rosorin_compile.language.validate import validate
from rosorin_compile.model import Robot
from rosorin_compile.rules.check import acceptable, check
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, Span, error, has_errors
from rosorin_compile.source.messages import add_suggestions, gather
from rosorin_compile.source.plugins import PluginFailed
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import ENDINGS, stdin_of
from rosorin_compile.source.tree import Map
from rosorin_compile.source.xml import markup
from rosorin_compile.source.xml.markup import Document, MarkupError, parse, read_source

from . import FORMATS, Format, ImportFile, plugged_diagnostics
from .format import SourceValue
from .imported_robot import ImportedRobot, Outputs, ReadOptions, as_tree, convert_result, file_name

_OTHER_FORMATS = {
    "world": ("a world of Gazebo", "name the SDF, URDF or xacro of the robot"),
    "html": ("a web page", "download the file itself, with the Raw button on GitHub"),
    "svg": ("a picture", "name the file of the robot"),
    "collada": ("a mesh (COLLADA)", "name the file of the robot, which names its meshes"),
    "package": ("the package.xml of a ROS package", "name the file of the robot in that package"),
    "launch": ("a launch file", "name the file of the robot that it loads"),
    "mujocoinclude": ("a part of an MJCF, to be included", "name the MJCF that includes it: its root is <mujoco>"),
}


def read_robot(path: Path, options: ReadOptions | None = None, asked: Span | None = None) -> ImportedRobot:
    """Import a robot from a file. Errors become diagnostics, at the position ``asked`` if the file is unreadable."""
    Progress.step(f"reading {path.name}")
    notes, more = list[Diagnostic](), plugged_diagnostics()  # an invalid plug-in may define this format
    try:
        format, opened, notes = _open(path, options or ReadOptions(), asked)
        more = ()
        read = convert_result(format.load(opened) if format.load is not None else {}, opened)
    except (MarkupError, PluginFailed) as problem:
        more = () if isinstance(problem, PluginFailed) else more
        return ImportedRobot(None, [*notes, problem.diagnostic, *more], files=(path,))
    if not read.checked and read.tree is not None and opened.options.checked:
        tree, diagnostics = accept(read.tree, opened.options.lenient)
        read = read._replace(tree=tree, diagnostics=[*read.diagnostics, *diagnostics], checked=True)
    read = read._replace(diagnostics=add_suggestions([*notes, *read.diagnostics]), format=format.becomes or format.name)
    return read._replace(takes_arguments=format.takes_arguments and not read.unexpanded)


def _open(path: Path, options: ReadOptions, asked: Span | None) -> tuple[Format, ImportFile, list[Diagnostic]]:
    suffix = path.suffix.lower()
    if suffix in ENDINGS:
        message = f"{path.name} is a description already, or another file in YAML"
        raise MarkupError(error("wrong-format", message, asked, f"import reads {known_formats()}"))
    by_name = next((one for one in _readable() if suffix in one.endings and not one.is_xml), None)
    if by_name is not None:
        return by_name, ImportFile(path, options, asked=asked), []
    document, notes = _parsed(path, options, asked)
    other = next((one for one in FORMATS.values() if one.is_other is not None and one.is_other(document)), None)
    if other is not None:
        message = f"this is {other.article_name}, which belongs to a robot and has none itself"
        help = f"name the robot; import ROBOT --{other.name} {document.source.path} reads both"
        raise MarkupError(error("wrong-format", message, document.root.span, help))
    recognised = [one for one in _readable() if one.recognises is not None and one.recognises(document, path)]
    matching = [*recognised, *(one for one in _readable() if document.root.tag in one.roots)]
    format = min(matching, key=lambda one: not FORMATS.is_own(one.name), default=None)  # prefer built-in formats
    if format is None:
        raise MarkupError(_wrong_root(document))
    if stdin_of(path) is not None and format is not FORMATS.published_format():
        message = f"this is {format.list_name}, which is read with the files next to it, and not from standard input"
        expanded = f"; or expand it before the pipe: {format.name} FILE | rosorin-compile ..."
        help = f"name the file{expanded if format.takes_arguments else ''}"
        raise MarkupError(error("wrong-format", message, document.root.span, help))
    return format, ImportFile(path, options, document, asked), notes


def join(imported: ImportedRobot, name: str, path: Path, options: ReadOptions) -> ImportedRobot:
    """Add a companion file in the format ``name``, such as an SRDF, to a robot; after errors, its tree is None."""
    format, tree = FORMATS[name], imported.tree
    if format.join is None or tree is None:
        return imported
    try:
        document, notes = _parsed(path, options)
        if document.root.tag != "robot":
            raise MarkupError(_wrong_root(document))
        sections, found = format.join(ImportFile(path, options, document), tree)
    except MarkupError as problem:
        return imported._replace(tree=None, diagnostics=[*imported.diagnostics, problem.diagnostic])
    diagnostics = [*notes, *found]
    made: Map | None = None
    if not has_errors(diagnostics):
        made, root = tree.copy(), document.root.span
        note = made.get("source") and made["source"].get("note")
        if note is not None:
            made["source"] = made["source"].copy()
            made["source"]["note"] = f"{note} and {Path(document.source.path).name}"
        for key, entries in sections.items():
            more = as_tree(entries, root, [key]).copy()
            for name, entry in (made.get(key) or {}).items():  # existing entries take precedence
                more.put(name, entry, made[key].key_spans[name], made[key].value_spans[name])
            made.put(key, more, root, root)
        if options.checked:
            made, found = accept(made, options.lenient)
            here = document.source
            diagnostics += [d for d in found if d.severity == ERROR or d.span is None or d.span.source is here]
    diagnostics = [*imported.diagnostics, *diagnostics]
    return imported._replace(tree=made, diagnostics=diagnostics, files=(*imported.files, path))


def known_formats() -> str:
    """Return the names of all formats that can be imported, joined by commas and "or"."""
    *first, last = [one.list_name for one in _readable()]
    return f"{', '.join(first)}, or {last}"


def _readable() -> list[Format]:
    return [one for one in FORMATS.values() if one.load is not None]


def _parsed(path: Path, options: ReadOptions, asked: Span | None = None) -> tuple[Document, list[Diagnostic]]:
    original = read_source(path, asked)
    start, rule, help = original.text.lstrip()[:200].lower(), "wrong-format", f"import reads {known_formats()}"
    if start.startswith(("<!doctype html", "<html")):
        rule, what, help = "wrong-root", "a web page, not a robot", _OTHER_FORMATS["html"][1]
    elif start.startswith("version https://git-lfs"):
        what, help = "a pointer of Git LFS, not the file itself", "fetch the file: git lfs pull"
    else:
        what = "" if start.startswith("<") else "not XML"
    if what:
        raise MarkupError(error(rule, f"{original.path} is {what}", Span(original, 1, 1, 1), help))
    source = markup.without_late_declaration(original)
    what = "the declaration <?xml ...?> is not at the very beginning of the file, and has no effect"
    what = "" if source.text == original.text else what
    try:
        document = parse(source)
    except MarkupError as problem:
        if problem.diagnostic.rule != markup.RULE:
            raise
        try:
            document = parse(markup.repair(source))
        except MarkupError:
            raise problem from None
        if not options.lenient and not any(one.engine_reads for one in _readable() if document.root.tag in one.roots):
            raise
        what = "this is not well-formed XML, but it can be read"
    return document, [Diagnostic(markup.RULE, NOTE, what, document.root.span)] if what else []


def _wrong_root(document: Document) -> Diagnostic:
    tag = document.root.tag
    what, help = _OTHER_FORMATS.get(tag.lower(), ("", f"import reads {known_formats()}"))
    message = f"the root element is <{tag}>" + (f": this is {what}" if what else ", not <robot>")
    return error("wrong-root", message, document.root.span, "did you mean <robot>?" if tag.lower() == "robot" else help)


def outputs_of(imported: ImportedRobot, why: str = "") -> Outputs:
    """Return the entries of ``outputs`` for an imported robot; ``why`` is a reason to omit optional formats."""
    made, tree = Outputs({}, {}, {}), imported.whole
    for format in FORMATS.values():
        asked = format.asked and format.asked(tree, imported.version, file_name(tree["robot"]))
        if asked and format.optional and why:
            made.left_out[format.name] = why
        elif asked:
            made.entries[format.name] = asked.entry
            if asked.remark:
                made.remarks[format.name] = asked.remark
    return made


def accept(tree: Map, lenient: bool) -> tuple[Map | None, list[Diagnostic]]:
    """Suppress tolerated rule violations with ``accept``. Return the tree (None after errors) and diagnostics."""
    Progress.step("validating")
    invalid = [one for one in validate(tree, FORMATS) if one.severity == ERROR]
    if invalid:
        return None, invalid
    rules, problems, count = acceptable(), violations(tree), 0
    names: dict[tuple[str, str], Span] = {}  # {(rule, name): position of the first violation}
    for _ in range(3):  # repeat, because an accepted error may have hidden violations of other rules
        for one in problems:
            if not one.of or one.severity != ERROR or one.rule not in rules:
                continue
            name, imported = one.of[-1 if rules[one.rule].accept == "link" else 0], rules[one.rule].imported
            may = imported == "always" or (lenient and imported == "lenient")
            if one.rule == "mass-not-positive":
                may = lenient or tree["links"][name]["inertial"]["mass"] == 0
            if may:
                names.setdefault((one.rule, name), one.span or tree.span)
        if len(names) == count:
            break
        count, entries = len(names), list[SourceValue]()
        for rule in sorted({rule for rule, _ in names}):
            of = [SourceValue(name, span) for (violated, name), span in names.items() if violated == rule]
            entry = {"rule": rule, "of": of, "reason": "the robot was imported with it"}
            entries.append(SourceValue(entry, of[0].span))
        tree = tree.copy()
        tree.put("accept", as_tree(entries, tree.span, ["accept"]), tree.span, tree.span)
        problems = violations(tree)
    found = [one for one in apply(tree, problems, rules).diagnostics if one.severity == ERROR or one.rule in rules]
    for index, one in enumerate(map(Diagnostic.with_help, [*found])):  # suggest --lenient where it helps
        is_of_lenient = one.severity == ERROR and one.rule in rules and rules[one.rule].imported == "lenient"
        if is_of_lenient and one.of and not lenient:
            found[index] = replace(one, help="; ".join(filter(None, (one.help, "--lenient accepts it as it is"))))
    return (None if has_errors(found) else tree), gather(found, [WARNING])


def violations(tree: Map) -> list[Diagnostic]:
    """Convert a YAML tree to a robot, check the rules, and return all diagnostics."""
    if "outputs" not in tree:
        format, tree = FORMATS.published_format(), tree.copy()
        outputs = {format.name: {"file": f"robot{format.endings[0]}"}}
        tree.put("outputs", as_tree(outputs, tree.span, ["outputs"]), tree.span, tree.span)
    lowered = lower(tree)
    if lowered.robot is None:
        return list(lowered.diagnostics)
    return [*lowered.diagnostics, *check(lowered.robot, tree, lowered.places, FORMATS)]


def lower_artifact(tree: Map, diagnostics: Iterable[Diagnostic]) -> Robot:
    """Convert the YAML tree of a parsed artifact to a robot. Raises ValueError if the tree is invalid."""
    tree["accept"] = [{"rule": "shape-size", "of": [*(tree.get("links") or ())], "reason": ""}]
    wrong = [one.message for one in diagnostics if one.severity == ERROR and one.rule not in acceptable()]
    wrong += [] if "robot" in tree else ["the robot has no name"]
    lowered = None if wrong else lower(tree)
    for one in lowered.diagnostics if lowered is not None else ():
        wrong += [one.message] if one.severity == ERROR and one.rule not in acceptable() else []
    if wrong or lowered is None or lowered.robot is None:
        raise ValueError((*wrong, "it contains no robot")[0])
    return lowered.robot
