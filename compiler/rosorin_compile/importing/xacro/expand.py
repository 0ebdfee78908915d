"""Expand a xacro file in a child process, and read the result as URDF.

Expansion can run arbitrary Python code from the file, because the sandbox of xacro is weak. Therefore a
warning is reported first, and a file without xacro syntax is not expanded.
"""

import hashlib
import json
import os
import re
import signal
import subprocess
import sys
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from rosorin_compile.formats.imported_robot import ImportedRobot, ReadOptions
from rosorin_compile.formats.urdf.read import read_urdf
from rosorin_compile.source import diagnostics as report
from rosorin_compile.source import system
from rosorin_compile.source.diagnostics import Diagnostic, MadeSpan, Related, Source, Span, error
from rosorin_compile.source.files import label, record
from rosorin_compile.source.messages import with_calls
from rosorin_compile.source.wording import and_more
from rosorin_compile.source.xml.elements import attribute_value
from rosorin_compile.source.xml.markup import Document, Element, MarkupError, name_of, parse, read_source

from .child import Place
from .macros import macro_call, no_links, without_mount

MAX_SECONDS = 30  # CPU time; overridden by ROSORIN_COMPILE_XACRO_SECONDS, which ``--xacro-seconds`` sets
_PATIENCE, _START = 4, 60  # wall-clock limit: _PATIENCE * CPU limit + _START, in seconds
_MOST_RELATED = 12
_TRUST = "ROSORIN_COMPILE_TRUST"  # environment variable; "1" means that all files are trusted
_TRUSTED_FILES = Path("rosorin-compile", "trusted")  # SHA-256 digests, in the configuration folder of the user

_CHILD = (
    "import sys\n"
    "if sys.path[:1] == ['']: del sys.path[0]\n"
    "from rosorin_compile.importing.xacro.child import main\n"
    "main()\n"
)
_SYMBOLIC = _CHILD.replace(".child", ".program")
# Names of xacro elements without output (_DEFINING) and with output (_MAKING); other names are macro calls.
_DEFINING = ("arg", "include", "macro", "property")
_MAKING = ("attribute", "call", "element", "if", "insert_block", "unless")
_COMMENT = re.compile("<!--.*?-->", re.DOTALL)
_ARGUMENT = re.compile(r"""<xacro:arg\s[^>]*?\bname\s*=\s*["']([^"']+)["']|\$\(arg\s+([^\s)]+)""")
_EXPRESSION = re.compile(r"when evaluating expression '(.*?)'(?: when|$)")
_FORMS = ("${{{}}}", "$(arg {})", "$(env {})", "(find {})", "package://{}/", "<{}")
_HELPS = {  # regular expression for xacro error messages -> help text; {0} is the first group
    r"substitution argument (\S+)": "give it a value: {0}:=VALUE, or in an include args: {{{0}: VALUE}}",
    r"environment variable '(.+?)' is": "set it: export {0}=VALUE; or write $(optenv {0} VALUE), which has a default",
}
# Lines that start with these words are printed by ``xacro.print_location`` and not reported.
_LOCATION = re.compile("when instantiating macro|instantiated from|included from|in file|when processing file")


class _Origins:
    """Maps elements of an expanded document to the xacro elements and macro calls that created them."""

    def __init__(self, answer: Mapping[str, Any], document: Document, path: Path) -> None:
        self.calls: Sequence[Place] = answer.get("calls", ())
        self.elements: dict[int, dict[int, Element]] = {}  # file -> offset -> element
        for number, name in enumerate(answer.get("read", ())):
            with suppress(MarkupError):  # skip a file that was changed or removed after the expansion
                is_entry = os.path.abspath(name) == os.path.abspath(path)
                opened = document if is_entry else parse(read_source(Path(os.path.normpath(name))))
                self.elements[number] = {element.start: element for element in opened.root.iter()}

    def element(self, place: Place | None) -> Element | None:
        return None if place is None else self.elements.get(place[0], {}).get(place[1])

    def via(self, place: Place) -> tuple[Related, ...]:
        """Return notes on the macro calls that created an element, innermost first."""
        found: list[Related] = []
        call = place[2]
        while call >= 0 and len(found) < _MOST_RELATED:
            if element := self.element(self.calls[call]):
                name = element.tag.removeprefix("xacro:")
                found.append(Related(f'when expanding the macro "{name}"', element.span))
            call = self.calls[call][2]
        return tuple(found)

    def connect(self, made: Document, places: Sequence[Place | None], otherwise: Span) -> None:
        """Map spans of the expanded document ``made`` to xacro files; spans of unknown origin become ``otherwise``."""
        elements = list(made.root.iter())
        starts = [element.start for element in elements]

        def origin(start: int, length: int) -> Span:
            element = elements[max(0, bisect_right(starts, start) - 1)]
            is_in_tag = start < element.opened
            while start >= element.end and element.parent is not None:
                element, is_in_tag = element.parent, False
            place = places[bisect_right(starts, element.start) - 1]
            source = self.element(place)
            if place is None or source is None:
                return otherwise
            span = MadeSpan(*(_span_in_tag(element, source, start, length) if is_in_tag else source.span))
            span.via = self.via(place)
            return span

        made.origin = origin


def _span_in_tag(element: Element, origin: Element, start: int, length: int) -> Span:
    for name, attribute in element.attributes.items():
        source = origin.attributes.get(name)
        if source is None or not attribute.name_start <= start <= attribute.start + len(attribute.raw):
            continue
        if source.raw == attribute.raw and start >= attribute.start:
            return origin.document.span(source.start + start - attribute.start, length)
        return source.name_span if start < attribute.start else source.span
    return origin.span


def is_xacro(document: Document, path: Path) -> bool:
    """Return True if a document has xacro elements or attributes, or declares the prefix and contains ${} or $()."""
    elements = document.root.iter() if "xacro:" in document.source.text else ()
    if any(name.startswith("xacro:") for element in elements for name in (element.tag, *element.attributes)):
        return True
    declared = path.suffix.lower() == ".xacro" or "xmlns:xacro" in document.root.attributes
    # Ignore comments, because files expanded by xacro declare the prefix and keep expressions in comments.
    return declared and re.search(r"\$[{(]", _COMMENT.sub("", document.source.text)) is not None


def _only_left_over(document: Document, path: Path) -> bool:
    """Return True if a .urdf file is expanded, except for leftover xacro elements, which URDF parsers ignore.

    The file must have links, and no expressions outside of xacro elements. Calls to undefined macros count as leftover.
    If the xacro prefix is not declared, xacro cannot read the file at all.
    """
    if path.suffix.lower() != ".urdf" or not any(child.tag == "link" for child in document.root.children):
        return False
    if "xmlns:xacro" not in document.source.text:
        return True
    inner = {id(one) for above in document.root.iter() if above.tag.startswith("xacro:") for one in [*above.iter()][1:]}
    elements = [one for one in document.root.iter() if id(one) not in inner]
    words = {one.tag.removeprefix("xacro:") for one in elements if one.tag.startswith("xacro:")}
    values = [value.raw for one in elements if not one.tag.startswith("xacro:") for value in one.attributes.values()]
    calls_macros = bool(words & {"include", "macro"} and words.difference(_DEFINING))
    return not calls_macros and not words.intersection(_MAKING) and not any("${" in v or "$(" in v for v in values)


def read_xacro(document: Document, path: Path, options: ReadOptions) -> ImportedRobot:
    """Expand a xacro file and read the robot; a URDF with leftover xacro elements is read without xacro."""
    if options.call is None and _only_left_over(document, path):
        left_over = read_urdf(document, path, options)
        if left_over.tree is not None:
            return left_over._replace(unexpanded=True)
    first = document.root.span
    call = None if options.call is None else macro_call(options.call, document, path, options)
    if call is not None and call.problems:
        return ImportedRobot(None, [*call.problems], files=(path,))
    message = f"{document.source.path} is expanded by xacro, which runs any Python code that the file contains"
    help = "continue only if you trust the author of the file; --trust silences this warning"
    warning = Diagnostic("xacro-runs-code", report.WARNING, message, first, (), help)
    trusted = options.trust or not untrusted_files([path])
    diagnostics = [] if trusted else [warning]
    if options.tell is not None:
        options.tell(replace(warning, numbers=report.TRUSTED) if trusted else warning)
        diagnostics = []
    system.needs("resource", system.NO_LIMITS)
    answer = _expand(path, options, None, call.text if call else None)
    for name, version in answer.get("recorded", ()):
        record(name, tuple(version))
    found = {os.path.abspath(path): path}
    for name in answer.get("files", ()):
        found.setdefault(os.path.abspath(name), Path(os.path.normpath(name)))
    files = tuple(found.values())
    if trusted and not options.trust and (others := untrusted_files(files)):  # an included file is not trusted
        diagnostics.append(replace(warning, message=f"{message}: {label(others[0])} is not a trusted file"))
    origins = _Origins(answer, document, path)
    diagnostics += _remarks(answer, first)
    problems = _errors(answer, document, origins, options, files)
    if problems:
        return ImportedRobot(None, [*diagnostics, *problems], (), files)
    try:
        made = parse(Source(document.source.path, answer["text"]))
        links = {child.get("name") for child in made.root.children if child.tag == "link"}
        joints = [child for child in made.root.children if child.tag == "joint"]
        parents = [inner.get("link") for joint in joints for inner in joint.children if inner.tag == "parent"]
        mount = next((name for name in parents if call is not None and name not in links), "")
        if mount:  # the macro attaches its links to ``mount``, a link of the including robot
            text = f"{answer['text'].rstrip().removesuffix('</robot>')}<link name={attribute_value(mount)}/></robot>"
            made = parse(Source(document.source.path, text))
    except MarkupError as failure:
        message = f"xacro makes something of {path.name} that is not XML: {failure.diagnostic.message}"
        return ImportedRobot(None, [*diagnostics, replace(failure.diagnostic, message=message, span=first)], (), files)
    origins.connect(made, [*answer["places"], None], first)  # the mount link has no source position
    problem = None if links or mount else no_links(document, path, options)
    if problem is None and made.root.tag != "robot":
        help = f"write it to a file first: xacro {path.name} > {path.name.split('.')[0]}.xml"
        problem = error("wrong-root", f"{path.name} expands to <{made.root.tag}>, not to <robot>", made.root.span, help)
    if problem is not None:
        return ImportedRobot(None, [*diagnostics, problem], (), files)
    read = read_urdf(made, path, options, files)
    if mount and read.tree is not None:
        read = read._replace(tree=without_mount(read.tree, mount), mount=mount)
    packages = {name: Path(folder) for name, folder in answer["packages"].items()}
    more = map(with_calls, [*read.diagnostics, *_of_this_machine(made, answer["folders"])])
    passed = call.passed if call is not None else frozenset()
    return read._replace(packages=packages, passed=passed, diagnostics=[*diagnostics, *more])


def _errors(
    answer: Mapping[str, Any], document: Document, origins: _Origins, options: ReadOptions, files: Sequence[Path]
) -> list[Diagnostic]:
    """Return the errors that prevented the expansion of a file, or an error for an undeclared argument."""
    first = document.root.span
    if "absent" in answer:
        message = "xacro, which expands .xacro files, is not installed"
        return [error("extra-missing", message, first, system.pip_install("import"))]
    missing = answer.get("package")
    if "markup" not in answer and missing is None:  # all files were read: report undeclared arguments
        known: set[str] = set()
        for file in files:
            with suppress(MarkupError):
                known |= {declared or read for declared, read in _ARGUMENT.findall(read_source(file).text)}
        if unknown := [one for one in options.arguments if one not in known]:
            message = f'{files[0].name} has no argument "{unknown[0]}"'
            suggestion = report.Suggestion(unknown[0], sorted(known), none="it has none")
            return [error("unknown-argument", message, options.spans.get(unknown[0], first), suggestion)]
    if "text" in answer:
        return []
    stack = [document]
    for name in list(dict.fromkeys(answer.get("stack", ())))[1:]:
        with suppress(MarkupError):
            stack.append(Document(read_source(Path(os.path.normpath(name)))))
    element = origins.element(answer.get("at"))
    text = " ".join(re.sub(r"<class '[^']*'>:", "", answer.get("error", "")).split())
    text = re.sub(r"^(.+) \1$", r"\1", text)  # some xacro messages repeat themselves
    span = stack[-1].span(0) if element is None else element.span
    if element is not None:  # narrow the span to the word in the message
        tag = element.document.source.text[element.start : element.opened]
        names = [*_EXPRESSION.findall(text), *re.findall(r"'([^']+)'", text), text.rpartition(" ")[2]]
        words = [form.format(name) for name in ([missing] if missing else names) for form in _FORMS]
        words.append(Path(answer.get("markup", "/")).name)
        word = next((one for one in words if one and one in tag), "")
        span = element.document.span(element.start + tag.index(word), len(word)) if word else span
    calls = () if element is None else origins.via(answer["at"])
    includes = [Related("included from", one.span(0)) for one in reversed(stack[:-1])]
    related = (*calls, *includes[:_MOST_RELATED])
    if "markup" in answer:
        try:
            parse(read_source(Path(os.path.normpath(answer["markup"])), span))
        except MarkupError as problem:
            return [replace(problem.diagnostic, related=(*problem.diagnostic.related, *related))]
    if missing is not None:
        help = f"define its folder: --package {missing}=PATH"
        return [error("package-missing", f'the ROS package "{missing}" is not found', span, help, related)]
    message = f"xacro cannot expand the file: {text}"[:600]
    helps = [help.format(found[1]) for said, help in _HELPS.items() if (found := re.search(said, text))]
    return [error("xacro-error", message, span, answer.get("help") or next(iter(helps), ""), related)]


def _of_this_machine(made: Document, folders: Sequence[str]) -> Iterator[Diagnostic]:
    found: list[tuple[str, Span]] = []
    for element in made.root.iter() if any(folder in made.source.text for folder in folders) else ():
        values = [(attribute.value, attribute.span) for attribute in element.attributes.values()]
        for value, span in (*values, (element.text, element.span)):
            if any(f"{folder}{os.sep}" in value for folder in folders):
                found.append((f"{name_of(element)} names a file of this machine: {value.strip()[:200]}", span))
    help = "artifacts have it, too; let the xacro write package://PACKAGE/FILE where the reader takes that"
    for message, span in found[:1]:
        message += f",{and_more(len(found) - 1)}" if len(found) > 1 else ""
        yield Diagnostic("import-machine-path", report.WARNING, message, span, (), help)


def _remarks(answer: Mapping[str, Any], span: Span) -> list[Diagnostic]:
    text = re.sub("\x1b\\[[0-9;]*m", "", answer["printed"]) if "text" in answer else ""
    lines = [line.strip() for line in text.splitlines() if line.strip() and not _LOCATION.match(line)]
    return [Diagnostic("xacro-says", report.NOTE, one[:200], span) for one in list(dict.fromkeys(lines))[:10]]


def _expand(
    path: Path, options: ReadOptions, plan: Mapping[str, Any] | None = None, text: str | None = None
) -> dict[str, Any]:
    """Expand a xacro file or ``text`` in a child process, or translate it with ``plan``. Return the JSON answer."""
    setting = os.environ.get("ROSORIN_COMPILE_XACRO_SECONDS", "")
    seconds = (int(setting) if re.fullmatch("[0-9]{1,8}", setting) else 0) or MAX_SECONDS
    request = {
        "file": str(path),
        "text": text,
        "arguments": dict(options.arguments),
        "packages": {name: os.path.abspath(folder) for name, folder in options.packages.items()},
        "seconds": seconds,
        "environment": None if options.environment is None else dict(options.environment),
        **(plan or {}),
    }
    variables = {**os.environ, "PYTHONHASHSEED": "0", "PYTHONDONTWRITEBYTECODE": "1", "PYTHONIOENCODING": "utf-8"}
    answer: dict[str, Any]
    try:
        child = subprocess.run(  # noqa: S603 - runs our own module; the user was warned
            [sys.executable, "-c", _CHILD if plan is None else _SYMBOLIC],
            input=json.dumps(request).encode(),
            capture_output=True,
            env=variables,
            timeout=_PATIENCE * seconds + _START,
            check=False,
        )
        output = child.stderr.decode("utf-8", "replace")
        if child.returncode == -getattr(signal, "SIGXCPU", 0) < 0:  # killed by the kernel at the CPU limit
            answer = {"is_late": True}
        else:
            answer = {**json.loads(child.stdout), "printed": output}
    except subprocess.TimeoutExpired:
        answer = {"is_late": True}
    except OSError as problem:
        answer = {"error": f"no child process can be started: {problem}"}
    except ValueError:
        last = output.strip().splitlines()[-1:] or [f"the process ended with {child.returncode}"]
        answer = {"error": f"xacro broke down: {last[0]}"}
    if answer.get("is_late"):
        answer["error"] = f"it takes more than {seconds:g} s"
        answer["help"] = "make it smaller, or give it more time: --xacro-seconds S"
    return answer


def untrusted_files(files: Sequence[Path]) -> list[Path]:
    """Return the files that are not trusted, neither by the environment variable nor by the user's list of digests.

    Only the person who runs the command can trust a file; a description cannot. Each line of the list begins with the
    SHA-256 digest of a file, in the format of ``sha256sum``. A file that cannot be read is not trusted.
    """
    if os.environ.get(_TRUST) == "1":
        return []
    base = Path(os.environ.get("XDG_CONFIG_HOME", ""))
    folder = base if base.is_absolute() else Path("~/.config").expanduser()
    digests: set[str] = set()
    with suppress(OSError, ValueError):
        lines = (folder / _TRUSTED_FILES).read_text("utf-8").splitlines()
        digests = {line.split()[0].lower() for line in lines if line.strip() and not line.startswith("#")}
    trusted = []
    for file in files if digests else ():
        with suppress(OSError):
            trusted += [file] if hashlib.sha256(file.read_bytes()).hexdigest() in digests else []
    return [file for file in files if file not in trusted]
