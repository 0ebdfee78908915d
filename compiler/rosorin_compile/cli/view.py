"""rosorin-compile view: show a robot in the browser, and follow its files; or write it as one page."""

from __future__ import annotations

import errno
import secrets
import sys
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.model import Joint
from rosorin_compile.source import files
from rosorin_compile.source.console import Console
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.installing import pip_install
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import Description
from rosorin_compile.source.watched_files import WatchedFiles
from rosorin_compile.viewer.page import html
from rosorin_compile.viewer.server import LOOPBACK, Data, Page, Server, Unknown, bound, is_loopback
from rosorin_compile.viewer.showing import Shown, look, served

from .answer import give_result
from .command import Options, command, option
from .options import page_options, robot_argument, robot_options
from .run import Run
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.output.request import Request


_LOOK = 0.15  # seconds between two looks at the files
_HOW = "rosorin-compile view ROBOT"
_LAST_PORT = 65535


@command("view", exits="0 stopped with Ctrl-C or SIGTERM, or page written, 1 errors (with --html)")
@robot_argument
@page_options("write the page to a file instead of serving it")
@option("--no-open", is_flag=True, help="do not open a browser")
@option("--port", type=int, metavar="NUMBER", help="port of the server; default: 8642, or another one if it is in use")
@option(
    "--host",
    default=LOOPBACK,
    metavar="ADDRESS",
    help="address of the server, to make the page accessible from other machines; default: this machine only",
)
@robot_options
def run(options: Options) -> int:
    """Show a robot."""
    run, description = Run.alone(options, "a page shows one robot", _HOW)
    if options.html is None and options.format != "text":
        raise WrongUsage("JSON goes with --html FILE: without a file there is a page to look at, and no answer")
    if options.html is None and (options.no_meshes or options.max_megabytes is not None):
        raise WrongUsage("--no-meshes and --max-megabytes go with --html FILE")
    if options.html is not None:
        return _write(run, description)
    return _Followed(run.request(description), options.quiet).serve(options)


def _write(run: Run, description: Description) -> int:
    """Write the page of a robot into a file."""
    from rosorin_compile import api

    options, console = run.options, run.console
    request = run.request(description)
    page = api.view(request, options.html, meshes=not options.no_meshes, max_megabytes=options.max_megabytes)
    console.show(page.diagnostics)
    if not page.written:
        console.warn(f"{description.name}: no page was written")
        return PROBLEMS
    if page.left_out:
        console.warn(f"not shown: {page.left_out}")
    console.say(f"{description.name}: {page.file}, {page.bytes / 1e6:.1f} MB")
    give_result(options, page, str)
    return FINE


class _Followed:
    """One robot that is shown while its files change."""

    def __init__(self, request: Request, quiet: bool) -> None:
        self.console = Console("text", quiet)
        self.request = replace(request, warn=self.console.ahead)
        self.description = request.description
        self.inputs = WatchedFiles()
        self.page = Page()
        self.numbers: dict[Path, str] = {}  # of mesh files: a page that is older than a save finds its own ones
        self.compiled = threading.Lock()  # explanations and contacts are made of one robot at a time

    def serve(self, options: Options) -> int:
        """Serve the page until Ctrl-C or SIGTERM; one with errors is waited for."""
        import gc
        import signal

        gc.enable()  # this run is a long one
        signal.signal(signal.SIGTERM, signal.default_int_handler)
        server = _bound(self.page, options)
        try:
            self.inputs.read(self._compile)
            threading.Thread(target=server.serve_forever, daemon=True).start()
            self._tell(server, options)
            self._follow()
        except KeyboardInterrupt:
            print()
        finally:
            server.socket.close()
        return FINE

    def _tell(self, server: Server, options: Options) -> None:
        """Say where the page is, and to whom; open it."""
        address = _address(server)
        print(f"{self.description.name}: {address}  (Ctrl-C ends it)")
        sys.stdout.flush()
        if not is_loopback(server.host):
            self.console.warn(f"every machine that reaches {server.host} sees this robot, its meshes and its sources")
        if not options.no_open:
            import webbrowser

            webbrowser.open(address)

    def _follow(self) -> None:
        while True:
            time.sleep(_LOOK)
            if self.inputs.changed():
                self.inputs.settle()
                self.inputs.read(self._compile)

    def _compile(self) -> None:
        """Read the robot, and tell the pages; after an error the last one stays."""
        Progress.begin()
        looked = look(self.request)
        Progress.wipe()
        errors = [one for one in looked.diagnostics if one.severity == "error"]
        self.console.show(errors)
        for file in looked.files:
            with suppress(OSError):
                files.read_bytes(file)  # what the page asks for later is followed, too
        if looked.shown is None:
            self._failed(errors)
            return
        if self.page.problem:
            self.console.warn(f"{self.description.name}: that is corrected")
        self._show(looked.shown)

    def _failed(self, errors: list[Diagnostic]) -> None:
        if not self.page.text:
            self._serve({"robot": None}, {})
        self.page.problem = "".join(one.as_text() for one in errors)
        self.page.changed()

    def _serve(self, data: Data, files: Mapping[str, tuple[Path, str]]) -> None:
        """Have a new version of the page served."""
        page = self.page
        version = secrets.token_hex(8)
        text = html(data, live=version)
        page.files, page.data, page.text, page.version = files, {**data, "version": version}, text, version

    def _show(self, shown: Shown) -> None:
        data = dict(shown.data)
        tables, files = served(shown, self.numbers)
        data |= tables
        page = self.page

        def explained(frame: str) -> list[str]:
            with self.compiled:
                return shown.explained(frame)

        page.explain, page.touching = explained, _Touching(shown, self.compiled)
        page.problem = ""
        self._serve({"robot": data}, files)
        page.changed()


class _Touching:
    """Finds overlapping links for the page; the scene in MuJoCo is built at the first request."""

    def __init__(self, shown: Shown, lock: threading.Lock) -> None:
        self.shown = shown
        self.lock = lock
        self.scene: Any = None

    def __call__(self, state: Mapping[str, Any]) -> list[list[str]]:
        """Return overlapping pairs of links at positions by joint (rad or m), without neighbours. Raises Unknown."""
        from rosorin_compile.mujoco.physics.checking import missing_packages, overlapping_links, scene_of

        if missing := missing_packages():
            raise Unknown(f"{missing} is not installed; {pip_install('physics')} brings it")
        with self.lock:
            try:
                self.scene = self.scene or scene_of(self.shown.case, self.shown.meshes)
                joints = self.shown.robot.joint
                positions = {name: _position(joints[name], at) for name, at in state.items() if name in joints}
                return overlapping_links(self.scene, positions)
            except Exception as problem:  # whatever an engine stumbles over: the page says it, and goes on
                raise Unknown(" ".join(str(problem).split())[:200] or type(problem).__name__) from None


def _position(joint: Joint, at: object) -> float | list[float]:
    """Return where a joint is. Raises ValueError unless there is a number for each of its coordinates."""
    numbers = [float(one) for one in at] if isinstance(at, list) else [float(at)]  # type: ignore[arg-type]
    if isinstance(at, list) != joint.is_several or len(numbers) != len(joint.coordinates):
        raise ValueError(f"joint {joint.name} is at {len(joint.coordinates)} numbers, not at {len(numbers)}")
    return numbers if isinstance(at, list) else numbers[0]


def _bound(page: Page, options: Options) -> Server:
    """Return the server at the address and the port that are asked for. Raises WrongUsage."""
    port, host = options.port, options.host
    if port is not None and not 0 <= port <= _LAST_PORT:
        raise WrongUsage(f"there is no port {port}: they go from 0 to {_LAST_PORT}")
    try:
        return bound(page, host, port)
    except OSError as problem:
        if problem.errno == errno.EADDRINUSE:
            raise WrongUsage(f"port {port} is taken; without --port a free one is found") from None
        if problem.errno in (errno.EACCES, errno.EPERM):
            raise WrongUsage(f"port {port} is not for everybody; take one above 1023, or leave --port out") from None
        raise WrongUsage(f"{host} is no address of this machine ({problem.strerror or problem})") from None
    except UnicodeError:
        raise WrongUsage(f"{host} is no address of this machine") from None


def _address(server: Server) -> str:
    host = server.host
    name = "localhost" if host == LOOPBACK else f"[{host}]" if ":" in host else host
    return f"http://{name}:{server.port}/"
