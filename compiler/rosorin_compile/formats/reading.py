"""Reading: one function for every format; the name of the file and what stands in it decide which one it is."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.source.diagnostics import ERROR, NOTE, Diagnostic, Source, Span, error, has_errors
from rosorin_compile.source.messages import worded
from rosorin_compile.source.plugins import PluginFailed
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import ENDINGS, stdin_of
from rosorin_compile.source.rule_registry import READING, Rule
from rosorin_compile.source.xml.files import mended, read_source, without_late_declaration
from rosorin_compile.source.xml.markup import RULE as SYNTAX
from rosorin_compile.source.xml.markup import Document, MarkupError, parse

from . import FORMATS, Format, Opened, plugged_diagnostics
from .checked import accept
from .described import as_tree
from .imported import Imported, Outputs, ReadOptions, converted

if TYPE_CHECKING:
    from rosorin_compile.source.tree import Map

    from .format import Joined

RULES = (
    Rule(
        "file-syntax",
        "A file is not written as its format wants; the reader of another package says so.",
        "Correct the place that is named.",
        READING,
    ),
    Rule(
        "wrong-format",
        "The file is of a format that is not read.",
        "The message says what it is, and what to name in its place.",
        READING,
    ),
    Rule(
        "wrong-root",
        "The root element is not that of a robot.",
        "The message says what it is, and what to name in its place.",
        READING,
    ),
)


_OTHER_FORMATS = {
    "world": ("a world of Gazebo", "name the SDF, URDF or xacro of the robot"),
    "html": ("a web page", "download the file itself: on GitHub by the button Raw"),
    "svg": ("a picture", "name the file of the robot"),
    "collada": ("a mesh (COLLADA)", "name the file of the robot, which names its meshes"),
    "package": ("the package.xml of a ROS package", "name the file of the robot in that package"),
    "launch": ("a launch file", "name the file of the robot that it loads"),
    "mujocoinclude": ("a part of an MJCF, to be included", "name the MJCF that includes it: its root is <mujoco>"),
}


def read(path: Path, options: ReadOptions, asked: Span | None = None) -> Imported:
    """Return the robot of a file (see ``read_robot``)."""
    try:
        imported = _read_any(path, options, asked)
        return imported._replace(diagnostics=worded(imported.diagnostics))
    except PluginFailed as problem:
        return _refused(problem.diagnostic, path)


def _read_any(path: Path, options: ReadOptions, asked: Span | None) -> Imported:
    Progress.step(f"reading {path.name}")
    suffix = path.suffix.lower()
    if suffix in ENDINGS:
        message = f"{path.name} is a description already, or another file in YAML"
        return _refused(error("wrong-format", message, asked, f"import reads {known_formats()}"), path)
    format = next((one for one in _readable() if suffix in one.endings and not one.is_xml), None)
    if format is not None:
        return _read(format, Opened(path, options, asked=asked))
    try:
        source = read_source(path, asked)
        _check_text(source)
        document = _parsed(source, options)
    except MarkupError as problem:
        return _refused(problem.diagnostic, path, *plugged_diagnostics())
    other = next((one for one in FORMATS.values() if one.is_other is not None and one.is_other(document)), None)
    if other is not None:
        return _refused(_companion(other, document), path)
    format = _format_of(document, path)
    if format is None:
        return _refused(_wrong_root(document), path, *plugged_diagnostics())
    if stdin_of(path) is not None and format is not FORMATS.published():
        return _refused(_not_on_stdin(format, document), path)
    read = _read(format, Opened(path, options, document, asked))
    return read._replace(diagnostics=[*_mending(source, document), *read.diagnostics])


def _companion(format: Format, document: Document) -> Diagnostic:
    """Return the error about a file that belongs to a robot, and is none."""
    message = f"this is {format.named}, which belongs to a robot and has none itself"
    option = f"--{format.name} {document.source.path}"
    return error("wrong-format", message, document.root.span, f"name the robot; import ROBOT {option} reads both")


def join(imported: Imported, name: str, path: Path, options: ReadOptions) -> Imported:
    """Return a robot with what a file says that belongs to it, of the format ``name``; broken, it has no tree."""
    format, tree = FORMATS[name], imported.tree
    if format.join is None or tree is None:
        return imported
    try:
        source = read_source(path)
        _check_text(source)
        document = _parsed(source, options)
        if document.root.tag != "robot":
            raise MarkupError(_wrong_root(document))
        joined = format.join(Opened(path, options, document), tree)
    except MarkupError as problem:
        return imported._replace(tree=None, diagnostics=[*imported.diagnostics, problem.diagnostic])
    diagnostics = [*_mending(source, document), *joined.diagnostics]
    made, told = None, list[Diagnostic]()
    if not has_errors(diagnostics):
        made, told = _with(tree, joined, document, options)
    return imported._replace(
        tree=made,
        diagnostics=[*imported.diagnostics, *diagnostics, *told],
        files=(*imported.files, path),
        left_out=(*imported.left_out, *joined.left_out),
    )


def _with(tree: Map, joined: Joined, document: Document, options: ReadOptions) -> tuple[Map | None, list[Diagnostic]]:
    """Return a tree with more sections, held against the rules; an entry that it has stays."""
    made = tree.copied()
    source = made.get("source")
    if source is not None and "note" in source:
        made["source"] = source.copied()
        made["source"]["note"] = f"{source['note']} and {Path(document.source.path).name}"
    for key, entries in joined.sections.items():
        more = as_tree(entries, document.root.span, [key])
        if key in made:
            more = more.copied()
            for name, entry in made[key].items():
                more.put(name, entry, made[key].key_spans[name], made[key].value_spans[name])
        made.put(key, more, document.root.span, document.root.span)
    accepted, told = accept(made, options.lenient) if options.checked else (made, [])
    return accepted, [
        one for one in told if one.severity == ERROR or one.span is None or one.span.source is document.source
    ]


def _not_on_stdin(format: Format, document: Document) -> Diagnostic:
    """Return the error about a robot that is read together with the files beside its own."""
    message = f"this is {format.listed}, which is read with the files beside it, and not from standard input"
    help = "name the file"
    if format.takes_arguments:
        help += f"; or expand it before the pipe: {format.name} FILE | rosorin-compile ..."
    return error("wrong-format", message, document.root.span, help)


def known_formats() -> str:
    """Return the formats that are read, as the end of a sentence."""
    *others, last = [one.listed for one in _readable()]
    return f"{', '.join(others)}, or {last}"


def _readable() -> list[Format]:
    return [one for one in FORMATS.values() if one.load is not None]


def _format_of(document: Document, path: Path) -> Format | None:
    """Return the format of an XML file: the one that recognises it, else that of its root element.

    What is built in is asked first.
    """
    for built_in in (True, False):
        readable = [one for one in _readable() if FORMATS.is_own(one.name) is built_in]
        recognised = (one for one in readable if one.recognises is not None and one.recognises(document, path))
        format = next(recognised, None) or next((one for one in readable if document.root.tag in one.roots), None)
        if format is not None:
            return format
    return None


def _read(format: Format, opened: Opened) -> Imported:
    if format.load is None:
        raise ValueError(f"{format.word} is not read")
    try:
        read = converted(format.load(opened), opened)
    except MarkupError as problem:
        return _refused(problem.diagnostic, opened.path)
    if not read.checked and read.tree is not None and opened.options.checked:
        tree, told = accept(read.tree, opened.options.lenient)
        read = read._replace(tree=tree, diagnostics=[*read.diagnostics, *told], checked=True)
    asked = format.takes_arguments and not read.unexpanded
    return read._replace(format=format.becomes or format.name, takes_arguments=asked)


def _parsed(source: Source, options: ReadOptions) -> Document:
    """Return a source as XML; what other readers pass over is blanked out, most of it leniently. Raises MarkupError."""
    source = without_late_declaration(source)
    try:
        return parse(source)
    except MarkupError as problem:
        if problem.diagnostic.rule != SYNTAX:
            raise
        try:
            document = parse(mended(source))
        except MarkupError:
            raise problem from None
        if options.lenient or any(one.engine_reads for one in _readable() if document.root.tag in one.roots):
            return document
        raise


def _mending(source: Source, document: Document) -> list[Diagnostic]:
    """Return the note about a text that was mended before it could be read."""
    if document.source.text == source.text:
        return []
    what = "this is no XML to the letter, and is read all the same"
    if without_late_declaration(source).text == document.source.text:
        what = "the declaration <?xml ...?> is not at the very beginning of the file, and has no effect"
    return [Diagnostic(SYNTAX, NOTE, what, document.root.span)]


def _refused(diagnostic: Diagnostic, path: Path, *others: Diagnostic) -> Imported:
    """Return what comes of a file that is not read; ``others`` are plug-ins that might have read it."""
    return Imported(None, [diagnostic, *others], (), (path,))


def _check_text(source: Source) -> None:
    """Refuse a text that is not XML at all, with a guess of what it is. Raises MarkupError."""
    start = source.text.lstrip()[:200].lower()
    span = Span(source, 1, 1, 1)
    if start.startswith(("<!doctype html", "<html")):
        what, help = _OTHER_FORMATS["html"]
        raise MarkupError(error("wrong-root", f"{source.path} is {what}, not a robot", span, help))
    if start.startswith("version https://git-lfs"):
        message = f"{source.path} is a pointer of Git LFS, not the file itself"
        raise MarkupError(error("wrong-format", message, span, "fetch the file: git lfs pull"))
    if not start.startswith("<"):
        raise MarkupError(error("wrong-format", f"{source.path} is not XML", span, f"import reads {known_formats()}"))


def _wrong_root(document: Document) -> Diagnostic:
    """Return the message about a root element of another format."""
    root = document.root
    tag = root.tag.lower()
    what, help = _OTHER_FORMATS.get(tag, ("", f"import reads {known_formats()}"))
    if tag == "robot":
        return error("wrong-root", f"the root element is <{root.tag}>, not <robot>", root.span, "did you mean <robot>?")
    message = (
        f"the root element is <{root.tag}>: this is {what}"
        if what
        else f"the root element is <{root.tag}>, not <robot>"
    )
    return error("wrong-root", message, root.span, help)


def read_robot(path: Path, options: ReadOptions | None = None, asked: Span | None = None) -> Imported:
    """Return the robot of a file in any format. Never raises: what is wrong is a diagnostic, and then no tree.

    The name of the file and what stands in it decide on the format. ``asked`` is the place that names the file, if a
    description does.
    """
    return read(path, options or ReadOptions(), asked)


def outputs_of(imported: Imported, why: str = "") -> Outputs:
    """Return the outputs for the description of an imported robot; ``why`` optional formats are left out.

    Raises ValueError for a broken source.
    """
    made = Outputs({}, {}, {})
    for format in FORMATS.values():
        if format.asked is None:
            continue
        asked = format.asked(imported.whole, imported.version, imported.file_name)
        if asked is None:
            continue
        if format.optional and why:
            made.left_out[format.name] = why
            continue
        made.entries[format.name] = asked.entry
        if asked.remark:
            made.remarks[format.name] = asked.remark
    return made
