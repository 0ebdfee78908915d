"""Expand a xacro in a child process, and read what comes out as URDF.

Expanding can run Python code of the authors of the file: xacro guards its expressions, but not well enough (see docs).
So a warning comes first, and nothing is expanded if there is nothing to expand. Everything that is missing is reported
at once, each at its place in the source.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from rosorin_compile.formats.imported_robot import Imported, ReadOptions
from rosorin_compile.formats.urdf.read import read_urdf
from rosorin_compile.source import system
from rosorin_compile.source.diagnostics import NOTE, TRUSTED, WARNING, Diagnostic, Source, Span, error
from rosorin_compile.source.files import label, record
from rosorin_compile.source.messages import with_calls
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.wording import and_more
from rosorin_compile.source.xml.elements import attribute_value
from rosorin_compile.source.xml.markup import Document, MarkupError, name_of, parse, read_source

from .child import out_of_time
from .expand_errors import COMMENT, Origins, Sources, expand_errors
from .macros import how_to_call, macro_call, macros_of

_TRUST = "ROSORIN_COMPILE_TRUST"  # 1: trust all files
_TRUSTED_FILES = Path("rosorin-compile", "trusted")  # digests, in the configuration folder of the user
MAX_SECONDS = 30  # of CPU; ROSORIN_COMPILE_XACRO_SECONDS, which ``--xacro-seconds`` sets, says another number
_PATIENCE, _START = 4, 60  # so many times as long, and seconds more, may one take that waits
_MORE_TIME = "make it smaller, or give it more time: --xacro-seconds S"

_CHILD = (
    "import sys\n"
    "if sys.path[:1] == ['']: del sys.path[0]\n"
    "from rosorin_compile.importing.xacro.child import main\n"
    "main()\n"
)
_SYMBOLIC = _CHILD.replace(".child", ".program")
# Elements of xacro that make nothing by themselves.
_DEFINING = ("arg", "include", "macro", "property")
# Those that make something, where other names are macros.
_MAKING = ("attribute", "call", "element", "if", "insert_block", "unless")


def is_xacro(document: Document, path: Path) -> bool:
    """Return True if a document has elements or attributes of xacro, or, in a .xacro, ${} or $()."""
    text = document.source.text
    if "xacro:" in text:
        for element in document.root.iter():
            if element.tag.startswith("xacro:") or any(name.startswith("xacro:") for name in element.attributes):
                return True
    declared = path.suffix.lower() == ".xacro" or "xmlns:xacro" in document.root.attributes
    # What xacro has made declares its prefix too, and often holds comments that it left alone.
    return declared and re.search(r"\$[{(]", COMMENT.sub("", text)) is not None


def only_left_over(document: Document, path: Path) -> bool:
    """Return True if a .urdf file is a URDF except for leftover elements of xacro, which readers of URDF ignore.

    It has links, and nothing outside of those elements has to be expanded. The call of a macro that nothing defines
    makes nothing either; without a declaration of the prefix, xacro cannot read the file at all.
    """
    if path.suffix.lower() != ".urdf" or not any(child.tag == "link" for child in document.root.children):
        return False
    if "xmlns:xacro" not in document.source.text:
        return True
    elements = list(document.root.iter())
    can_define = any(one.tag in ("xacro:include", "xacro:macro") for one in elements)
    for element in elements:
        if any(above.tag.startswith("xacro:") for above in element.ancestors()):
            continue
        word = element.tag.removeprefix("xacro:")
        if element.tag == word:
            if any("${" in one.raw or "$(" in one.raw for one in element.attributes.values()):
                return False
        elif word not in _DEFINING and (word in _MAKING or can_define):
            return False
    return True


def read_xacro(document: Document, path: Path, options: ReadOptions) -> Imported:
    """Return the robot of a xacro file."""
    first = document.root.span
    call = None if options.call is None else macro_call(options.call, document, path, options)
    if call is not None and call.problems:
        return Imported(None, call.problems, files=(path,))
    warning = Diagnostic(
        "xacro-runs-code",
        WARNING,
        f"{document.source.path} is expanded by xacro, which can run Python code of whoever wrote it",
        first,
        (),
        "go on only with files of people whom you trust; --trust says that you do",
    )
    trusted = options.trust or not untrusted_files([path])
    diagnostics = [] if trusted else [warning]
    if options.tell is not None:
        options.tell(replace(warning, numbers=TRUSTED) if trusted else warning)
        diagnostics = []
    system.needs("resource", system.NO_LIMITS)
    answer = _expand(path, options, None, call.text if call else None)
    for name, version in answer.get("recorded", ()):
        record(name, tuple(version))
    files = _files(path, answer)
    if trusted and not options.trust and (others := untrusted_files(files)):  # the list has the first file, not those
        diagnostics.append(replace(warning, message=f"{warning.message}: {label(others[0])} is not a trusted file"))
    sources = Sources(_read_files(answer, document, path), answer.get("calls", ()))
    diagnostics += _remarks(answer, first)
    problems = expand_errors(answer, document, path, sources, list(options.arguments), files)
    if problems:
        return Imported(None, [*diagnostics, *problems], (), files)
    try:
        made = parse(Source(document.source.path, answer["text"]))
        mount = _mount(made) if call else ""
        if mount:
            text = f"{answer['text'].rstrip().removesuffix('</robot>')}<link name={attribute_value(mount)}/></robot>"
            made = parse(Source(document.source.path, text))
    except MarkupError as failure:
        message = f"xacro makes something of {path.name} that is no XML: {failure.diagnostic.message}"
        return Imported(None, [*diagnostics, replace(failure.diagnostic, message=message, span=first)], (), files)
    made.origin = Origins(made, answer["places"], sources, first)
    problem = None if any(child.tag == "link" for child in made.root.children) else _no_links(document, path, options)
    if problem is None and made.root.tag != "robot":
        help = f"write it to a file first: xacro {path.name} > {path.name.split('.')[0]}.xml"
        message = f"{path.name} expands to <{made.root.tag}>, not to <robot>"
        problem = error("wrong-root", message, made.root.span, help)
    if problem is not None:
        return Imported(None, [*diagnostics, problem], (), files)
    read = read_urdf(made, path, options, files)
    if mount and read.tree is not None:
        read = read._replace(tree=_without_mount(read.tree, mount), mount=mount)
    if call is not None:
        read = read._replace(passed=call.passed)
    read = read._replace(packages={name: Path(folder) for name, folder in answer["packages"].items()})
    own = _of_this_machine(made, answer["folders"])
    return read._replace(diagnostics=[*diagnostics, *map(with_calls, [*read.diagnostics, *own])])


def _no_links(document: Document, path: Path, options: ReadOptions) -> Diagnostic | None:
    """Return the error for a macro that makes no link, or for a file that only defines macros."""
    if options.call is not None:
        message, span = f'the macro "{options.call["macro"]}" makes no link', options.call.value_spans["macro"]
        return error("no-links", message, span, "call one that does")
    macros = macros_of(document, path, Packages(options.packages, options.environment or os.environ, path))
    message = f"{path.name} makes no link: it defines macros for other files"
    return error("no-links", message, document.root.span, how_to_call(path, macros)) if macros else None


def _mount(made: Document) -> str:
    """Return the first parent of a joint that is no link of an expanded macro; empty if there is none."""
    links = {child.get("name") for child in made.root.children if child.tag == "link"}
    joints = (child for child in made.root.children if child.tag == "joint")
    parents = (inner.get("link") for joint in joints for inner in joint.children if inner.tag == "parent")
    return next((name for name in parents if name not in links), "")


def _without_mount(tree: Map, mount: str) -> Map:
    """Return the robot of a macro without the link of another robot that it is attached to."""
    made = tree.copy()
    made["links"] = made["links"].copy()
    del made["links"][mount]
    accept = tree.get("accept")
    if accept is not None:
        made["accept"] = Seq(accept.span)
        for entry, span in zip(accept, accept.value_spans, strict=True):
            if mount not in entry["of"]:
                made["accept"].put(entry, span)
    return made


def _of_this_machine(made: Document, folders: Sequence[str]) -> Iterator[Diagnostic]:
    found: list[tuple[str, Span]] = []
    for element in made.root.iter() if any(folder in made.source.text for folder in folders) else ():
        values = [(attribute.value, attribute.span) for attribute in element.attributes.values()]
        for value, span in (*values, (element.text, element.span)):
            if any(f"{folder}{os.sep}" in value for folder in folders):
                found.append((f"{name_of(element)} names a file of this machine: {value.strip()[:200]}", span))
    if found:
        (message, span), *more = found
        help = "artifacts have it, too; let the xacro write package://PACKAGE/FILE where the reader takes that"
        message += f",{and_more(len(more))}" if more else ""
        yield Diagnostic("import-machine-path", WARNING, message, span, (), help)


def _expand(
    path: Path, options: ReadOptions, plan: Mapping[str, Any] | None = None, text: str | None = None
) -> dict[str, Any]:
    """Run xacro in a child process on a file, or on a ``text`` in its place; with a ``plan``, on symbols."""
    seconds = _seconds()
    wait = _PATIENCE * seconds + _START
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
    try:
        child = subprocess.run(  # noqa: S603 - our own module; the warning about what it runs is given
            [sys.executable, "-c", _CHILD if plan is None else _SYMBOLIC],
            input=json.dumps(request).encode(),
            capture_output=True,
            env=variables,
            timeout=wait,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return {"error": f"it does not end within {wait:g} s", "help": _MORE_TIME, "stack": [str(path)]}
    except OSError as problem:
        return {"error": f"no child process can be started: {problem}", "stack": [str(path)]}
    output = child.stderr.decode("utf-8", "replace")
    if child.returncode == -getattr(signal, "SIGXCPU", 0) < 0:  # in the midst of one number
        return {"error": out_of_time(seconds), "help": _MORE_TIME, "stack": [str(path)]}
    try:
        answer: dict[str, Any] = json.loads(child.stdout)
    except ValueError:
        last = output.strip().splitlines()[-1:] or [f"the process ended with {child.returncode}"]
        answer = {"error": f"xacro broke down: {last[0]}", "stack": [str(path)]}
    answer["said"] = output
    if answer.get("error") == out_of_time(seconds):
        answer["help"] = _MORE_TIME
    return answer


def _seconds() -> float:
    text = os.environ.get("ROSORIN_COMPILE_XACRO_SECONDS", "")
    return int(text) if text.isascii() and text.isdigit() and 0 < len(text) < 9 and int(text) else MAX_SECONDS


def _files(path: Path, answer: dict[str, Any]) -> tuple[Path, ...]:
    files = {os.path.abspath(path): path}
    for name in answer.get("files", ()):
        files.setdefault(os.path.abspath(name), Path(os.path.normpath(name)))
    return tuple(files.values())


MAX_REMARKS = 10
# How ``xacro.print_location`` begins its lines, with the file in those about files.
_LOCATION = re.compile(
    r"(?:when instantiating macro|instantiated from|(?:included from|in file|when processing file): *(.*))"
)


def _remarks(answer: dict[str, Any], span: Span) -> list[Diagnostic]:
    """Return what xacro printed while it made a robot as notes."""
    lines: list[str] = []
    for line in re.sub("\x1b\\[[0-9;]*m", "", answer["said"]).splitlines() if "text" in answer else ():
        location = _LOCATION.match(line)
        if location is None:
            lines += [line.strip()] if line.strip() else []
        elif lines and location[1] and not lines[-1].endswith(")"):  # further lines say what that is included from
            lines[-1] += f" ({label(Path(location[1]))})"
    return [Diagnostic("xacro-says", NOTE, line[:200], span) for line in list(dict.fromkeys(lines))[:MAX_REMARKS]]


def _read_files(answer: dict[str, Any], document: Document, path: Path) -> dict[int, Document]:
    found: dict[int, Document] = {}
    for number, name in enumerate(answer.get("read", ())):
        if os.path.abspath(name) == os.path.abspath(path):
            found[number] = document
            continue
        try:
            found[number] = parse(read_source(Path(os.path.normpath(name))))
        except MarkupError:
            continue
    return found


def untrusted_files(files: Iterable[Path]) -> list[Path]:
    """Return the files that are trusted neither by the environment variable nor by a digest in the user's list.

    Trust comes from the person who runs the command; a description cannot grant it. Each line of the list begins with
    the SHA-256 digest of a file, as ``sha256sum`` prints it. A file that cannot be read is not trusted.
    """
    if os.environ.get(_TRUST) == "1":
        return []
    digests = _digests()
    return [file for file in files if not digests or _digest(file) not in digests]


def _digests() -> set[str]:
    base = Path(os.environ.get("XDG_CONFIG_HOME", ""))
    folder = base if base.is_absolute() else Path("~/.config").expanduser()
    try:
        lines = (folder / _TRUSTED_FILES).read_text("utf-8").splitlines()
    except (OSError, ValueError):
        return set()
    return {line.split()[0].lower() for line in lines if line.strip() and not line.startswith("#")}


def _digest(file: Path) -> str:
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError:
        return ""
