"""Show a robot in the browser while its files change: compile it again, and tell the pages."""

from __future__ import annotations

import secrets
import sys
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.output.watched_files import WatchedFiles
from rosorin_compile.request import Request
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import ERROR
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.system import pip_install

from .page import html
from .page.images import Serving, tables
from .server import LOOPBACK, Data, Page, Server, Unknown, bound, is_loopback
from .showing import Shown, look

if TYPE_CHECKING:
    from rosorin_compile.cli.console import Console

_INTERVAL = 0.15  # seconds between two looks at the files


class LiveRobot:
    """One robot that is shown while its files change.

    ``contacts`` returns the engine that finds links that are inside each other; it is created for the first question.
    """

    def __init__(self, request: Request, console: Console, contacts: Callable[[Shown], Any]) -> None:
        self.console = console
        self.request = replace(request, warn=console.ahead)
        self.contacts = contacts
        self.inputs = WatchedFiles()
        self.page = Page()
        self.server: Server | None = None
        self.numbers: dict[Path, str] = {}  # of mesh files: an older page still finds its own ones
        self.lock = threading.Lock()  # explanations and contacts are computed for one robot at a time

    def bind(self, host: str, port: int | None) -> None:
        """Listen at an address. Raises OSError, UnicodeError."""
        self.server = bound(self.page, host, port)

    def serve(self, open_browser: bool) -> None:
        """Serve the page until Ctrl-C or SIGTERM, also while the robot has errors."""
        import gc
        import signal

        assert self.server is not None  # noqa: S101
        gc.enable()  # it is off in short runs
        signal.signal(signal.SIGTERM, signal.default_int_handler)
        host = self.server.host
        name = "localhost" if host == LOOPBACK else f"[{host}]" if ":" in host else host
        address = f"http://{name}:{self.server.port}/"
        try:
            self.inputs.read(self.compile)
            threading.Thread(target=self.server.serve_forever, daemon=True).start()
            print(f"{self.request.description.name}: {address}  (Ctrl-C ends it)")
            sys.stdout.flush()
            if not is_loopback(host):
                self.console.warn(f"every machine that reaches {host} sees this robot, its meshes and its sources")
            if open_browser:
                import webbrowser

                webbrowser.open(address)
            while True:
                time.sleep(_INTERVAL)
                if self.inputs.changed():
                    self.inputs.settle()
                    self.inputs.read(self.compile)
        except KeyboardInterrupt:
            print()
        finally:
            self.server.socket.close()

    def compile(self) -> None:
        """Read the robot, and notify the pages; after an error they keep the last one."""
        Progress.begin()
        looked = look(self.request)
        Progress.wipe()
        errors = [told for told in looked.diagnostics if told.severity == ERROR]
        self.console.show(errors)
        for file in looked.files:
            with suppress(OSError):
                files.read_bytes(file)  # what the page requests later is followed, too
        page, shown = self.page, looked.shown
        if shown is None:
            if not page.text:
                self._publish({"robot": None})
            page.problem = "".join(told.as_text() for told in errors)
            page.changed()
            return
        if page.problem:
            self.console.warn(f"{self.request.description.name}: that is corrected")

        def explained(frame: str) -> list[str]:
            with self.lock:
                return shown.explained(frame)

        serving = Serving(self.numbers)
        data = {**shown.data, **tables(shown.robot, shown.meshes, serving)}
        page.files, page.explain, page.touching, page.problem = serving.files, explained, self._contacts_of(shown), ""
        self._publish({"robot": data})
        page.changed()

    def _publish(self, data: Data) -> None:
        """Serve a new version of the page."""
        version = secrets.token_hex(8)
        self.page.text, self.page.data = html(data, live=version), {**data, "version": version}
        self.page.version = version

    def _contacts_of(self, shown: Shown) -> Callable[[Mapping[str, Any]], list[list[str]]]:
        """Return a function for the pairs of links that collide at positions by joint (rad or m)."""
        engine: Any = None

        def touching(state: Mapping[str, Any]) -> list[list[str]]:
            nonlocal engine
            engine = engine or self.contacts(shown)
            if missing := engine.lacking():
                raise Unknown(f"{missing} is not installed; {pip_install('physics')} brings it")
            positions = {}
            for name, at in state.items():
                joint = shown.robot.joint.get(name)
                if joint is None:
                    continue
                count = len(joint.coordinates)
                if isinstance(at, list) != joint.is_several or (joint.is_several and len(at) != count):
                    raise Unknown(f"joint {name} is at {count} numbers")
                positions[name] = [*map(float, at)] if isinstance(at, list) else float(at)
            with self.lock:
                try:
                    found: list[list[str]] = engine.pairs(positions)
                    return found
                except Exception as problem:  # the page shows whatever the engine raises
                    raise Unknown(" ".join(str(problem).split())[:200] or type(problem).__name__) from None

        return touching
