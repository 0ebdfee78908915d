"""The child process that expands a xacro file: a request in JSON comes in, the expanded text in JSON goes out.

The library is told where packages are, what the arguments are, and in which folder a file stands; and every file that
it reads is first read safely, so that no entity is ever expanded.
"""

from __future__ import annotations

import glob
import json
import math
import os
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import suppress
from importlib import import_module
from io import StringIO
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any
from urllib.parse import unquote

from rosorin_compile.source.files import read_text, recording
from rosorin_compile.source.packages import Packages, package_name
from rosorin_compile.source.xml.files import read_source
from rosorin_compile.source.xml.markup import MarkupError, parse

from .tracing import Traces, elements, places, where
from .wanting import MissingPackage, Wanting

MAX_MEMORY = 8 << 30  # bytes
# The elements that name files for any reader.
_NAMING = ("mesh", "texture")


_GRACE = 2  # seconds of CPU to say where it was; who is in the midst of one number then says nothing any more


class OutOfTime(BaseException):
    """The file calculates for too long; what xacro forgives, it does not forgive this."""


def out_of_time(seconds: float) -> str:
    """Return what is wrong with a file that calculates for so many seconds."""
    return f"it calculates for more than {seconds:g} s"


class NotMarkup(Exception):
    """A file that is no XML, or not safe to read."""


class Arguments(dict[str, str]):
    """The arguments of a run; remembers which names were asked for."""

    def __init__(self, given: dict[str, str]) -> None:
        super().__init__(given)
        self.asked: dict[str, None] = {}

    def __contains__(self, name: object) -> bool:
        self.asked[str(name)] = None
        return super().__contains__(name)

    def __getitem__(self, name: str) -> str:
        self.asked[name] = None
        return super().__getitem__(name)


class Context(dict[str, Any]):
    """What substitutions see. xacro 2.1.1 forgets to say which file is read, which $(dirname) asks for."""

    def __init__(self, stack: Any) -> None:
        super().__init__()
        self.stack = stack

    def get(self, key: str, default: Any = None) -> Any:
        return self.stack()[-1] if key == "filename" and self.stack() else super().get(key, default)

    def __getitem__(self, key: str) -> Any:
        return self.stack()[-1] if key == "filename" and self.stack() else super().__getitem__(key)


# include/uapi/linux/prctl.h: which signal a process gets when its parent is gone.
_PR_SET_PDEATHSIG = 1


def main() -> None:
    """Answer one request."""
    request = json.loads(sys.stdin.buffer.read())
    # What the file prints must not mix with the answer.
    answer_to = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    _limit(request["seconds"])
    if request["environment"] is not None:
        os.environ.clear()
        os.environ.update(request["environment"])
    with recording() as paths:
        answer = expand(request)
    answer["recorded"] = [[os.path.abspath(path), version] for path, version in paths.items()]
    with answer_to:
        json.dump(answer, answer_to)
    # Threads or exit handlers of the file are not waited for.
    sys.stderr.flush()
    os._exit(0)


def _limit(seconds: float) -> None:
    """Bound what the process may take, and let it end with the one that asks; as far as the system can."""
    with suppress(ImportError):
        import resource

        until = math.ceil(seconds) + _GRACE
        for kind, most in ((resource.RLIMIT_AS, (MAX_MEMORY,) * 2), (resource.RLIMIT_CPU, (until, until + _GRACE))):
            with suppress(OSError, ValueError):  # a shell may have set less
                resource.setrlimit(kind, most)
    with suppress(AttributeError, OSError):  # Windows
        signal.signal(signal.SIGPROF, _end)
        signal.setitimer(signal.ITIMER_PROF, seconds)
    with suppress(ImportError, OSError, AttributeError):  # Linux
        import ctypes

        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def _end(*_: object) -> None:
    raise OutOfTime


def expand(request: dict[str, Any]) -> dict[str, Any]:
    """Return the answer to a request: ``text`` or what went wrong, the files that were read, the arguments.

    ``places`` are those of the elements of the text, ``at`` that of what went wrong (see ``tracing``); ``read`` and
    ``calls`` are what places count. ``missing`` is everything that was asked for and is not there.
    """
    try:
        xacro = import_module("xacro")
    except ImportError:
        return {"absent": "xacro"}
    packages = Packages({k: Path(v) for k, v in request["packages"].items()}, os.environ, Path(request["file"]))
    arguments = Arguments(request["arguments"])
    traces = Traces()
    wanting = _prepare(xacro, packages, traces)
    answer: dict[str, Any] = {}
    try:
        document = _expanded(xacro, request["file"], arguments)
        _name_packages(document, packages, [*map(str, xacro.all_includes), request["file"]])
        answer["places"] = places(document)
        answer["folders"] = _folders(packages, xacro.all_includes, request["file"])
        answer["text"] = document.toprettyxml(indent="  ")
    except Exception as problem:  # whatever the file does is an answer
        answer |= _what(problem) | {"at": where(problem)}
    except OutOfTime as problem:
        answer |= {"error": out_of_time(request["seconds"]), "at": where(problem)}
    except (SystemExit, KeyboardInterrupt):
        answer["error"] = "it ends the program that expands it"
    if "text" not in answer:
        answer["stack"] = [name for name in xacro.filestack or [] if name]
        answer["macros"] = [macro.body.getAttribute("name") for macro in xacro.macrostack or []]
    if "text" not in answer and answer.get("error") != out_of_time(request["seconds"]):
        answer["missing"] = wanting.gathered(xacro, request["file"], dict(request["arguments"]))
    answer["files"] = list(dict.fromkeys(map(str, xacro.all_includes)))
    answer["arguments"] = list(arguments.asked)
    answer["read"] = list(traces.files)
    answer["calls"] = traces.calls
    return answer


def _expanded(xacro: Any, file: str, arguments: Arguments) -> Any:
    """Return the expanded document: as xacro makes it, without the banner that names the file."""
    xacro.init_stacks(file)
    document = xacro.parse(None, file)
    xacro.process_doc(document, mappings=arguments)
    return document


def _prepare(xacro: Any, packages: Packages, traces: Traces) -> Wanting:
    """Make xacro find packages without ROS, know its folder, read files safely, and know where elements stood."""
    wanting = Wanting()

    def share(name: str) -> str:
        folder = packages.find(name)
        if folder is None:
            return wanting.package(name)
        return str(folder)

    index: Any = ModuleType("ament_index_python")
    inner: Any = ModuleType("ament_index_python.packages")
    inner.get_package_share_directory = index.get_package_share_directory = share
    inner.PackageNotFoundError = index.PackageNotFoundError = MissingPackage
    index.packages = inner
    sys.modules |= {"ament_index_python": index, "ament_index_python.packages": inner}
    own_path, own_parse = xacro.abs_filename_spec, xacro.parse

    def absolute(name: str) -> str:
        if name.startswith(("package://", "file://")):
            package = name.partition("://")[2].partition("/")[0]
            if name.startswith("package://"):
                share(package)
            return str(packages.resolve(name, Path()))
        return str(own_path(name))

    def read(text: Any, filename: str = "") -> Any:
        if text is not None:
            return own_parse(text, filename)
        name = os.path.join(xacro.root_dir, filename)
        try:
            source = read_source(Path(name))
            parsed = parse(source)
        except MarkupError as problem:
            xacro.filestack.pop()
            raise NotMarkup(name, problem.diagnostic.message) from None
        made = own_parse(_without_declaration(source.text), filename)
        traces.mark(made, name, parsed)
        return made

    xacro.abs_filename_spec, xacro.parse = absolute, read
    # It calls these itself for its load_yaml and its includes of patterns.
    xacro.open, xacro.glob = _opened, SimpleNamespace(glob=_matching)
    xacro.substitution_args_context = Context(lambda: xacro.filestack)
    traces.follow(xacro)
    wanting.watch(import_module("xacro.substitution_args"))
    return wanting


def _opened(name: str) -> StringIO:
    """Return a text file open to be read. Raises OSError."""
    opened: Any = StringIO(read_text(name))
    opened.name = name  # yaml says it of what is wrong
    return opened  # type: ignore[no-any-return]


def _matching(pattern: str) -> list[str]:
    """Return the files that a pattern matches, as xacro finds them."""
    return glob.glob(pattern)  # noqa: PTH207 - which follows other rules


def _without_declaration(text: str) -> str:
    """Return a text without the encoding that it declares: it is decoded already."""
    if not text.startswith("<?xml"):
        return text
    end = text.find("?>") + 2
    return '<?xml version="1.0"?>' + "\n" * text.count("\n", 0, end) + text[end:]


def _name_packages(document: Any, packages: Packages, files: Sequence[str]) -> None:
    """Give the meshes and textures of a document names that hold on any machine; ``files`` made it, the first last.

    ``$(find arm)/meshes/a.stl`` becomes ``package://arm/meshes/a.stl``, whichever way it was written;
    ``$(dirname)/a.stl`` outside of any package becomes a name relative to the xacro.
    """
    for node in elements(document):
        if node.tagName in _NAMING and node.hasAttribute("filename"):
            name = node.getAttribute("filename")
            node.setAttribute("filename", _anywhere(name, packages, files))


def _folders(packages: Packages, includes: Sequence[object], file: str) -> list[str]:
    """Return the folders of this machine that may stand in what is expanded: of packages, and of the files read."""
    found = [str(folder) for _, folder in packages.found()]
    found += [str(Path(os.path.abspath(str(name))).parent) for name in (*includes, file)]
    return [folder for folder in dict.fromkeys(found) if len(Path(folder).parts) > 1]


def _anywhere(name: str, packages: Packages, files: Sequence[str]) -> str:
    path = unquote(name.removeprefix("file://")) if name.startswith("file://") else name
    if not Path(path).is_absolute():
        return name
    path = os.path.normpath(path)
    for package, folder in packages.found():
        if path.startswith(f"{folder}{os.sep}"):
            return f"package://{package}/{Path(path).relative_to(folder).as_posix()}"
    folders = [Path(os.path.abspath(file)).parent for file in files]
    if not any(folder in Path(path).parents for folder in [*folders, folders[-1].parent]):
        return name
    for above in Path(path).parents:
        own = package_name(above)
        if own:
            return f"package://{own}/{Path(path).relative_to(above).as_posix()}"
    return Path(os.path.relpath(path, folders[-1])).as_posix()


def _what(problem: BaseException) -> dict[str, Any]:
    """Return what an exception says; xacro wraps one into another."""
    for cause in _causes(problem):
        if isinstance(cause, MissingPackage):
            return {"package": str(cause)}
        if isinstance(cause, NotMarkup):
            return {"markup": cause.args[0], "message": cause.args[1]}
        if isinstance(cause, RecursionError):
            return {"error": "macros or properties call each other without end"}
        if isinstance(cause, MemoryError):
            return {"error": "it needs more memory than there is"}
    if type(problem).__name__ == "ArgException" or "Undefined substitution argument" in str(problem):
        return {"error": f"Undefined substitution argument {str(problem).rsplit(' ', 1)[-1]}"}
    return {"error": str(problem) or repr(problem), "line": getattr(problem, "lineno", 0)}


def _causes(problem: BaseException) -> Iterator[BaseException]:
    """Yield an exception and those that it wraps."""
    seen: set[int] = set()
    waiting: list[BaseException | None] = [problem]
    while waiting:
        here = waiting.pop()
        if here is None or id(here) in seen:
            continue
        seen.add(id(here))
        yield here
        waiting += [here.__cause__, here.__context__, getattr(here, "exc", None)]
