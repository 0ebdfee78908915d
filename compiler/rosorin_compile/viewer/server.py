"""Serve the page of a robot, with its meshes and the sources of its numbers, and update it when files change.

Other websites in the same browser cannot read the page: the server only accepts requests with a Host header of this
machine (which protects against DNS rebinding), and never allows cross-origin access.
"""

from __future__ import annotations

import json
import math
import re
import secrets
import select
import socket
import sys
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from ipaddress import ip_address
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qs, urlsplit

from rosorin_compile.output.watched_files import WatchedFiles
from rosorin_compile.request import Request
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import ERROR
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.system import pip_install

from .page import html
from .page.images import Data, ServedFiles, tables
from .robot_view import RobotView, load

if TYPE_CHECKING:
    from rosorin_compile.cli.console import Console

LOOPBACK = "127.0.0.1"
PORT = 8642  # default port; if it is in use, the system chooses another port
_LARGEST = 1_000_000  # maximum size of a request in bytes
_BEAT = 1.0  # seconds between checks that a page is still open
_PATIENCE = 60.0  # timeout of a request in seconds
_HTTP = 80  # default HTTP port, which browsers omit in the Host header
_HOST = re.compile(r"(?:\[([0-9a-f:.]{2,45})\]|([0-9a-z._-]{1,253}))(?::([0-9]{1,5}))?")
_TEXT = "text/plain; charset=utf-8"
_HEADERS = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
}


class HttpRefusal(Exception):
    """Raised to refuse a request; the arguments are the HTTP status and the reason."""


class Page:
    """The current page, which the thread that watches files and the threads that answer requests share."""

    def __init__(self) -> None:
        self.change = threading.Condition()
        self.changes = 0
        self.listeners = 0  # number of browser tabs that show the page
        self.text = ""
        self.data: Data = {}
        self.version = ""
        self.files: Mapping[str, tuple[Path, str]] = {}
        self.problem = ""
        self.explain: Callable[[str], list[str]] = lambda _: []
        self.touching: Callable[[Mapping[str, Any]], list[list[str]]] | None = None

    def notify(self) -> None:
        """Notify all open browser tabs of a new version of the robot, or of an error."""
        with self.change:
            self.changes += 1
            self.change.notify_all()

    def events(self) -> bytes:
        """Format the version of the page, and any errors, as server-sent events."""
        text = f"event: robot\ndata: {json.dumps(self.version)}\n\n"
        text += f"event: problem\ndata: {json.dumps({'text': self.problem})}\n\n" if self.problem else ""
        return text.encode()


def _address(text: str) -> Any:
    with suppress(ValueError):
        return ip_address(text)
    return None


def is_loopback(host: str) -> bool:
    """Return True if a host name or IP address is a loopback address."""
    return host == "localhost" or bool(getattr(_address(host), "is_loopback", False))


class Server(ThreadingHTTPServer):
    """The HTTP server of a page; ``host`` is the address of this machine to which the server is bound."""

    daemon_threads = True

    def __init__(self, page: Page, host: str, port: int) -> None:
        self.page = page
        self.host = host
        self.address_family = socket.AF_INET6 if ":" in host else socket.AF_INET
        super().__init__((host, port), _Handler)
        self.port = int(self.server_address[1])

    def server_bind(self) -> None:
        """Bind the port without a reverse DNS lookup."""
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.socket.bind(self.server_address)
        self.server_address = self.socket.getsockname()

    def is_mine(self, name: str) -> bool:
        """Return True if a Host header is a name of this server; this protects against DNS rebinding.

        On a loopback address, only loopback names are accepted; otherwise also IP addresses and the host name.
        """
        found = _HOST.fullmatch(name)
        if found is None or int(found[3] or _HTTP) != self.port:
            return False
        bare, machine = found[1] or found[2], socket.gethostname().lower()
        if is_loopback(self.host):
            return bare in ("localhost", "127.0.0.1", "::1", self.host.lower())
        return _address(bare) is not None or bare in ("localhost", self.host.lower(), machine, f"{machine}.local")

    def handle_error(self, request: object, client_address: object) -> None:
        """Ignore errors that occur after a browser has closed the connection."""


def create_server(page: Page, host: str, port: int | None) -> Server:
    """Create a server on ``port``; by default on ``PORT``, or on any free port if that is in use. Raises OSError."""
    if port is None:
        with suppress(OSError):
            return Server(page, host, PORT)
    return Server(page, host, port or 0)


class _Handler(BaseHTTPRequestHandler):
    server: Server
    protocol_version = "HTTP/1.1"
    server_version = "rosorin-compile"
    sys_version = ""
    timeout = _PATIENCE

    def log_message(self, format: str, *args: object) -> None:
        """Do not log requests, because the terminal shows the messages of the compiler."""

    def do_GET(self) -> None:
        self._answer(self._get)

    def do_POST(self) -> None:
        self._answer(self._post)

    def _answer(self, answer: Callable[[], None]) -> None:
        try:
            self._check_origin()
            answer()
        except HttpRefusal as problem:
            status, why = problem.args
            self._send(f"{why}\n".encode(), _TEXT, status)

    def _check_origin(self) -> None:
        """Refuse a request that has the Host header of another machine, or that is sent by another website."""
        hosts = self.headers.get_all("Host", [])
        host = hosts[0].lower() if len(hosts) == 1 else ""
        origin = self.headers.get("Origin", f"http://{host}").lower()
        foreign = self.headers.get("Sec-Fetch-Site", "none") not in ("none", "same-origin")
        followed = self.path == "/" and self.headers.get("Sec-Fetch-Mode") == "navigate"  # the user followed a link
        if not self.server.is_mine(host) or origin != f"http://{host}" or (foreign and not followed):
            self.close_connection = True
            raise HttpRefusal(HTTPStatus.FORBIDDEN, "this robot is shown only to this machine")

    def _get(self) -> None:
        url, page = urlsplit(self.path), self.server.page
        file, kind = page.files.get(url.path.removeprefix("/mesh/"), (None, ""))
        if url.path == "/":
            self._send(page.text.encode(), "text/html; charset=utf-8")
        elif url.path == "/robot.json":
            self._json(page.data)
        elif url.path == "/explain":
            self._json(page.explain(parse_qs(url.query).get("frame", [""])[0]))
        elif url.path == "/events":
            self._events()
        elif url.path == "/favicon.ico":  # avoid an error, because browsers always request this file
            self._send(b"", "image/x-icon")
        elif url.path.startswith("/mesh/") and file is not None:
            try:
                self._send(files.read_bytes(file), kind)
            except FileNotFoundError:
                raise HttpRefusal(HTTPStatus.NOT_FOUND, "there is no such mesh") from None
        else:
            raise HttpRefusal(HTTPStatus.NOT_FOUND, "there is nothing here but the robot")

    def _post(self) -> None:
        size = self.headers.get("Content-Length", "")
        fits = size.isascii() and size.isdecimal() and len(size) <= len(str(_LARGEST)) and int(size) <= _LARGEST
        if not fits or self.headers.get_content_type() != "application/json":
            self.close_connection = True  # because the body of the request is not read
            raise HttpRefusal(HTTPStatus.BAD_REQUEST, "this is not a question about the robot")
        content = self.rfile.read(int(size))
        if self.path != "/touching":
            raise HttpRefusal(HTTPStatus.NOT_FOUND, "there is nothing here but the robot")
        try:
            state = json.loads(content)
            values = [number for at in state.values() for number in (at if isinstance(at, list) else [at])]
            if not all(type(number) in (int, float) and math.isfinite(number) for number in values):
                raise ValueError("no position")
        except (ValueError, OverflowError, RecursionError, AttributeError):
            raise HttpRefusal(HTTPStatus.BAD_REQUEST, "these are not positions of joints") from None
        if self.server.page.touching is None:
            raise HttpRefusal(HTTPStatus.NOT_IMPLEMENTED, "there is no robot yet")
        self._json(self.server.page.touching(state))

    def _events(self) -> None:
        page, seen = self.server.page, -1
        self._head("text/event-stream", HTTPStatus.OK, Connection="close")
        page.listeners += 1
        try:  # the socket becomes readable when the browser closes the page
            while not select.select([self.connection], [], [], 0)[0] or self.connection.recv(1, socket.MSG_PEEK):
                with page.change:
                    page.change.wait_for(lambda: page.changes != seen, _BEAT)  # noqa: B023
                    is_new, seen = page.changes != seen, page.changes
                if is_new:
                    self.wfile.write(page.events())
                    self.wfile.flush()
        except OSError:  # the browser closed the connection
            pass
        finally:
            self.close_connection = True
            page.listeners -= 1

    def _json(self, data: object) -> None:
        self._send(json.dumps(data).encode(), "application/json")

    def _head(self, kind: str, status: HTTPStatus, **headers: str) -> None:
        self.send_response(status)
        for name, value in {**_HEADERS, "Content-Type": kind, **headers}.items():
            self.send_header(name, value)
        self.end_headers()

    def _send(self, content: bytes, kind: str, status: HTTPStatus = HTTPStatus.OK) -> None:
        self._head(kind, status, **{"Content-Length": str(len(content))})
        self.wfile.write(content)


_INTERVAL = 0.15  # seconds between checks for changed files


class LiveRobot:
    """Serves a robot, and compiles it again when its files change; ``contacts`` creates a collision engine."""

    def __init__(self, request: Request, console: Console, contacts: Callable[[RobotView], Any]) -> None:
        self.console = console
        self.request = replace(request, warn=console.warn_ahead)
        self.contacts = contacts
        self.inputs = WatchedFiles()
        self.page = Page()
        self.numbers: dict[Path, str] = {}  # ids of mesh files; kept, so that older pages can load them
        self.lock = threading.Lock()  # protects explanations and contacts, which are not thread-safe

    def serve(self, server: Server, open_browser: bool) -> None:
        """Serve the page until Ctrl-C or SIGTERM, even while the description has errors."""
        import gc
        import signal

        gc.enable()  # the command line disables garbage collection for short runs
        signal.signal(signal.SIGTERM, signal.default_int_handler)
        host = server.host
        name = "localhost" if host == LOOPBACK else f"[{host}]" if ":" in host else host
        address = f"http://{name}:{server.port}/"
        try:
            self.inputs.read(self.compile)
            threading.Thread(target=server.serve_forever, daemon=True).start()
            print(f"{self.request.description.name}: {address}  (Ctrl-C ends it)")
            sys.stdout.flush()
            if not is_loopback(host):
                self.console.warn(f"every machine that reaches {host} sees this robot, its meshes and its sources")
            if open_browser:
                import webbrowser

                webbrowser.open(address)
            while True:
                time.sleep(_INTERVAL)
                if self.inputs.has_changed():
                    self.inputs.settle()
                    self.inputs.read(self.compile)
        except KeyboardInterrupt:
            print()
        finally:
            server.socket.close()

    def compile(self) -> None:
        """Compile the robot and notify open pages; after an error, the pages keep the last valid version."""
        Progress.begin()
        shown, diagnostics, inputs = load(self.request)
        Progress.wipe()
        errors = [one for one in diagnostics if one.severity == ERROR]
        self.console.show(errors)
        for file in inputs:
            with suppress(OSError):
                files.read_bytes(file)  # watch the file for changes (see WatchedFiles)
        page = self.page
        if shown is None:
            if not page.text:
                self._publish({"robot": None})
            page.problem = "".join(error.as_text() for error in errors)
        else:
            if page.problem:
                self.console.warn(f"{self.request.description.name}: that is corrected")
            serving = ServedFiles(self.numbers)
            data = {**shown.data, **tables(shown.robot, shown.meshes, serving)}
            page.files, page.touching, page.problem = serving.files, self._contacts_of(shown), ""
            page.explain = partial(self._explain, shown)
            self._publish({"robot": data})
        page.notify()

    def _publish(self, data: Data) -> None:
        self.page.version = version = secrets.token_hex(8)
        self.page.text, self.page.data = html(data, live=version), {**data, "version": version}

    def _explain(self, shown: RobotView, frame: str) -> list[str]:
        with self.lock:
            return shown.explain(frame)

    def _contacts_of(self, shown: RobotView) -> Callable[[Mapping[str, Any]], list[list[str]]]:
        engine = self.contacts(shown)

        def touching(state: Mapping[str, Any]) -> list[list[str]]:
            if missing := engine.lacking():
                raise HttpRefusal(
                    HTTPStatus.NOT_IMPLEMENTED, f"{missing} is not installed; {pip_install('physics')} brings it"
                )
            try:
                positions = {name: at for name, at in state.items() if name in shown.robot.joint}
                with self.lock:
                    return [*engine.pairs(positions)]
            except Exception as problem:  # show errors of the collision engine on the page
                reason = " ".join(str(problem).split())[:200] or type(problem).__name__
                raise HttpRefusal(HTTPStatus.NOT_IMPLEMENTED, reason) from None

        return touching
