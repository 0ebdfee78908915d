"""Expand a xacro file in a child process: read a JSON request from stdin, and write a JSON answer to stdout.

Every file is first parsed by our XML reader, which rejects entities. Each element keeps its source position (``Place``)
through the expansion: the index of its file, its offset in the text, and the index of the macro call that created it
(-1 for none). The list ``calls`` has the source position of each macro call.
"""

import glob
import json
import math
import os
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from importlib import import_module
from io import StringIO
from pathlib import Path
from traceback import walk_tb
from types import ModuleType, SimpleNamespace
from typing import Any
from urllib.parse import unquote
from xml.dom import minidom

from rosorin_compile.source.files import read_text, record_reads
from rosorin_compile.source.packages import Packages, package_name
from rosorin_compile.source.xml.markup import Document, MarkupError, parse, read_source

Place = tuple[int, int, int]  # file index, offset in its text, index of the macro call or -1

MAX_MEMORY = 8 << 30  # bytes
_GRACE = 2  # seconds of CPU time, to report an error before the kernel kills the process
_PR_SET_PDEATHSIG = 1  # from include/uapi/linux/prctl.h: set the signal sent when the parent process ends
MARK = "rosorin_place"
CALL = "rosorin-call"  # tag of the element that contains the macro call in generated xacro text


class OutOfTime(BaseException):
    """The time limit is exceeded; a BaseException, so that ``except Exception`` in xacro does not catch it."""


class NotMarkup(Exception):
    """A file is not XML, or not safe to read; the exception arguments are (file name, reason)."""


class MissingPackage(Exception):
    """A ROS package cannot be found; the exception argument is the package name."""

    def __str__(self) -> str:
        return f'the package "{self.args[0]}" is not found'


def main(run: Callable[[dict[str, Any]], dict[str, Any]] = lambda request: Expansion(request).answer()) -> None:
    """Read a request from stdin, pass it to ``run`` (default: expand a xacro file), and write the answer to stdout."""
    request = json.loads(sys.stdin.buffer.read())
    answer_to = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # redirect print() in a xacro to stderr, because stdout is for the answer
    _limit(request["seconds"])
    if request["environment"] is not None:
        os.environ.clear()
        os.environ.update(request["environment"])
    with record_reads() as paths:
        answer = run(request)
    answer["recorded"] = [[os.path.abspath(path), version] for path, version in paths.items()]
    with answer_to:
        json.dump(answer, answer_to)
    sys.stderr.flush()
    os._exit(0)  # do not wait for threads and exit handlers that the xacro started


def _limit(seconds: float) -> None:
    """Limit the memory and CPU time (s) of the process, and end it with its parent, where the system supports this."""

    def end(*_: object) -> None:
        raise OutOfTime

    with suppress(ImportError):
        import resource

        until = math.ceil(seconds) + _GRACE
        for kind, most in ((resource.RLIMIT_AS, (MAX_MEMORY,) * 2), (resource.RLIMIT_CPU, (until, until + _GRACE))):
            with suppress(OSError, ValueError):  # fails if a lower limit is already set
                resource.setrlimit(kind, most)
    with suppress(AttributeError, OSError):  # not available on Windows
        signal.signal(signal.SIGPROF, end)
        signal.setitimer(signal.ITIMER_PROF, seconds)
    with suppress(ImportError, OSError, AttributeError):  # not available outside of Linux
        import ctypes

        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


class Expansion:
    """Expands the xacro file in a request with the xacro library."""

    def __init__(self, request: dict[str, Any]) -> None:
        self.file: str = request["file"]
        self.text: str | None = request.get("text")  # xacro text to expand instead of the contents of the file
        self.given: dict[str, str] = request["arguments"]
        self.packages = Packages({k: Path(v) for k, v in request["packages"].items()}, os.environ, Path(self.file))
        self.files: dict[str, int] = {}
        self.parsed: dict[int, Document] = {}
        self.calls: list[Place] = []
        self.open_calls: list[int] = []

    def answer(self) -> dict[str, Any]:
        """Return the JSON answer: the expanded text or an error, the files that were read, and source positions.

        ``places`` has the source position of each element in the text, ``at`` the source position of the error, and
        ``folders`` the local folders whose paths may occur in the text.
        """
        try:
            xacro: Any = import_module("xacro")
        except ImportError:
            return {"absent": "xacro"}
        self.prepare(xacro)
        answer: dict[str, Any] = {}
        try:
            document = self.expand(xacro, dict(self.given))
            files = [*map(str, xacro.all_includes), self.file]
            for node in elements(document):
                if node.tagName in ("mesh", "texture") and node.hasAttribute("filename"):
                    node.setAttribute("filename", portable(node.getAttribute("filename"), self.packages, files))
            answer["places"] = [_place(node) for node in elements(document)]
            answer["packages"] = {name: str(folder) for name, folder in self.packages.found_packages()}
            folders = [*answer["packages"].values(), *(str(Path(os.path.abspath(name)).parent) for name in files)]
            answer["folders"] = [folder for folder in dict.fromkeys(folders) if len(Path(folder).parts) > 1]
            answer["text"] = document.toprettyxml(indent="  ")
        except Exception as problem:  # a xacro can run any code, which can raise any exception
            answer |= _error(problem, xacro.filestack) | {"at": _place_of_error(problem)}
        except OutOfTime as problem:
            answer |= {"is_late": True, "at": _place_of_error(problem)}
        except (SystemExit, KeyboardInterrupt):
            answer["error"] = "it ends the program that expands it"
        if "text" not in answer:
            answer["stack"] = [name for name in xacro.filestack or [] if name]
        answer["files"] = [name for name in dict.fromkeys(map(str, xacro.all_includes)) if os.path.lexists(name)]
        return answer | {"read": list(self.files), "calls": self.calls}

    def expand(self, xacro: Any, arguments: dict[str, str]) -> Any:
        """Expand the file and return the XML document, without the banner comment that xacro adds."""
        xacro.init_stacks(self.file)
        document = xacro.parse(self.text, self.file)
        xacro.process_doc(document, mappings=arguments)
        if self.text is not None:
            _keep_call(document.documentElement)
        return document

    def share(self, name: str) -> str:
        """Return the share folder of a ROS package. Raises MissingPackage."""
        folder = self.packages.find(name)
        if folder is None:
            raise MissingPackage(name)
        return str(folder)

    def prepare(self, xacro: Any) -> None:
        """Patch xacro to find packages without ROS, read files safely, and track source positions of elements."""
        index: Any = ModuleType("ament_index_python")
        inner: Any = ModuleType("ament_index_python.packages")
        inner.get_package_share_directory = index.get_package_share_directory = self.share
        inner.PackageNotFoundError = index.PackageNotFoundError = MissingPackage
        index.packages = inner
        sys.modules |= {"ament_index_python": index, "ament_index_python.packages": inner}
        own_path, own_parse = xacro.abs_filename_spec, xacro.parse

        def absolute(name: str) -> str:
            if not name.startswith(("package://", "file://")):
                return str(own_path(name))
            if name.startswith("package://"):
                self.share(name.partition("://")[2].partition("/")[0])
            return str(self.packages.resolve(name, Path()))

        def read(text: Any, filename: str = "") -> Any:
            if text is not None:
                return own_parse(text, filename)
            name = os.path.join(xacro.root_dir, filename)
            try:
                source = read_source(Path(name))
                parsed = parse(source)
            except MarkupError as problem:
                xacro.filestack.pop()
                failure = NotMarkup(name, problem.diagnostic.message)
                if problem.diagnostic.rule == "file-unreadable":  # no error if the include is optional
                    raise xacro.XacroException(exc=OSError(name)) from failure
                raise failure from None
            text = source.text
            if text.startswith("<?xml"):  # remove the encoding declaration, because the text is decoded
                end = text.find("?>") + 2
                text = '<?xml version="1.0"?>' + "\n" * text.count("\n", 0, end) + text[end:]
            made = own_parse(text, filename)
            file = self.files.setdefault(name, len(self.files))
            self.parsed[file] = parsed
            for node, element in zip(elements(made), parsed.root.iter(), strict=True):
                setattr(node, MARK, (file, element.start, -1))
            return made

        xacro.abs_filename_spec, xacro.parse = absolute, read
        # Also replace ``open`` and ``glob``, which xacro calls in load_yaml and for includes with wildcards.
        xacro.open, xacro.glob = _opened, SimpleNamespace(glob=glob.glob)
        own_extension = xacro.eval_extension

        def extension(text: str) -> Any:
            xacro.substitution_args_context["filename"] = xacro.filestack[-1]  # for $(dirname); missing in xacro 2.1.1
            return own_extension(text)

        xacro.eval_extension = extension
        # Copied elements keep the source position of the original, but get the index of the current macro call.
        module: Any = minidom
        own_clone, own_call = module._clone_node, xacro.handle_macro_call
        sys.setrecursionlimit(sys.getrecursionlimit() * 3 // 2)  # the wrapper adds a stack frame to each macro call

        def clone(node: Any, deep: bool, owner: Any) -> Any:
            made = own_clone(node, deep, owner)
            place = getattr(node, MARK, None)
            if place is not None and made is not None:
                setattr(made, MARK, (*place[:2], self.open_calls[-1] if self.open_calls else place[2]))
            return made

        def call(node: Any, macros: Any, symbols: Any) -> Any:
            place = getattr(node, MARK, None)
            if place is None or not node.tagName.startswith("xacro:"):
                return own_call(node, macros, symbols)
            if not self.open_calls or self.calls[self.open_calls[-1]] != place:
                self.calls.append(place)
            self.open_calls.append(len(self.calls) - 1)
            try:
                return own_call(node, macros, symbols)
            finally:
                self.open_calls.pop()

        module._clone_node, xacro.handle_macro_call = clone, call


def _keep_call(root: Any) -> None:
    """Replace <rosorin-call> with its content; remove links and joints that are created outside of the call."""
    (call,) = root.getElementsByTagName(CALL)
    outside = [node for node in root.childNodes if node.nodeType == node.ELEMENT_NODE and node is not call]
    if any(node.tagName == "link" for node in outside):
        for node in outside:
            if node.tagName != "material":
                root.removeChild(node)
    for node in list(call.childNodes):
        root.insertBefore(node, call)
    root.removeChild(call)


def _opened(name: str) -> StringIO:
    opened: Any = StringIO(read_text(name))
    opened.name = name  # yaml reports this name in errors
    return opened  # type: ignore[no-any-return]


def portable(name: str, packages: Packages, files: Sequence[str]) -> str:
    """Convert an absolute file name to a ``package://`` URI, or to a path relative to the last file in ``files``.

    ``$(find arm)/meshes/a.stl`` becomes ``package://arm/meshes/a.stl``; ``$(dirname)/a.stl`` outside of any package
    becomes a path relative to the xacro. A file outside of these folders keeps its name.
    """
    path = unquote(name.removeprefix("file://")) if name.startswith("file://") else name
    if not Path(path).is_absolute():
        return name
    path = os.path.normpath(path)
    for package, folder in packages.found_packages():
        if path.startswith(f"{folder}{os.sep}"):
            return f"package://{package}/{Path(path).relative_to(folder).as_posix()}"
    folders = [Path(os.path.abspath(file)).parent for file in files]
    if not any(folder in Path(path).parents for folder in [*folders, folders[-1].parent]):
        return name
    for above in Path(path).parents:
        if own := package_name(above):
            return f"package://{own}/{Path(path).relative_to(above).as_posix()}"
    return Path(os.path.relpath(path, folders[-1])).as_posix()


def _error(problem: BaseException, stack: Sequence[str]) -> dict[str, Any]:
    """Convert the root cause of an exception that xacro may have wrapped to keys of the JSON answer."""
    for cause in causes(problem):
        if isinstance(cause, MissingPackage):
            return {"package": cause.args[0]}
        if isinstance(cause, NotMarkup):
            return {"markup": cause.args[0], "error": cause.args[1]}
        if isinstance(cause, RecursionError):
            cycle = "files include" if len(stack) > 2 * len({*stack}) else "macros or properties call"
            return {"error": f"{cycle} each other without end"}
        if isinstance(cause, MemoryError):
            return {"error": "it needs more memory than there is"}
    return {"error": str(problem) or repr(problem)}


def causes(problem: BaseException) -> Iterator[BaseException]:
    """Yield an exception, and all exceptions that caused it."""
    visited: set[int] = set()
    waiting: list[BaseException | None] = [problem]
    while waiting:
        cause = waiting.pop()
        if cause is not None and id(cause) not in visited:
            visited.add(id(cause))
            yield cause
            waiting += [cause.__cause__, cause.__context__, getattr(cause, "exc", None)]


def elements(document: minidom.Document) -> Iterator[Any]:
    """Yield all elements of an XML document in document order."""
    root: Any = document.documentElement
    yield from (root, *root.getElementsByTagName("*"))


def _place_of_error(problem: BaseException) -> Place | None:
    """Return the source position of the innermost element in a traceback (outermost for endless recursion), or None."""
    found: list[Place | None] = []
    for frame, _ in walk_tb(problem.__traceback__):
        if frame.f_globals.get("__name__", "").startswith("xacro"):
            nodes = [frame.f_locals.get(name) for name in ("node", "elt")]  # local variables of xacro functions
            found += [place for node in nodes if (place := _place(node))][:1]
    return next(iter(found if isinstance(problem, RecursionError) else reversed(found)), None)


def _place(node: Any) -> Place | None:
    """Return the source position of an XML node, or of the closest ancestor that has a position, or None."""
    while node is not None and not hasattr(node, MARK):
        node = node.parentNode
    return getattr(node, MARK, None)
