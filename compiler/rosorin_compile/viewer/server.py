"""The server of the page: this robot, its meshes and what explains it, on this machine alone; nothing else is served.

A page of somebody else in the same browser cannot read it: requests are answered only under the names of this machine
(which a foreign page that points its own name here has not), and what they ask is never sent to another origin.
"""

from __future__ import annotations

import json
import math
import queue
import re
import select
import socket
import threading
from collections.abc import Callable, Mapping
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from ipaddress import ip_address
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

from rosorin_compile.source import files

Data = dict[str, Any]

LOOPBACK = "127.0.0.1"
PORT = 8642  # where no other page is; else the system chooses one
_LARGEST = 1_000_000  # bytes of a question
_BEAT = 1.0  # seconds between two looks whether a page is still there
_PATIENCE = 60.0  # seconds that a browser may take for a question
_HTTP = 80  # the port that browsers leave out of names
_HOST = re.compile(r"(?:\[([0-9a-f:.]{2,45})\]|([0-9a-z._-]{1,253}))(?::([0-9]{1,5}))?")
_HEADERS = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
}


class Unknown(Exception):
    """What is asked for is not known; its text says why."""


def _nobody_knows(state: Mapping[str, Any]) -> list[list[str]]:  # noqa: ARG001
    raise Unknown("there is no robot yet")


class Page:
    """What is served at present; the files are followed in another thread than pages are answered in."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.text = ""
        self.data: Data = {}
        self.version = ""
        self.files: Mapping[str, tuple[Path, str]] = {}
        self.problem = ""
        self.explain: Callable[[str], list[str]] = lambda _: []
        self.touching: Callable[[Mapping[str, Any]], list[list[str]]] = _nobody_knows
        self.listeners: list[queue.SimpleQueue[str]] = []

    def changed(self) -> None:
        """Tell every page that is open: another version of the robot, or what is wrong now."""
        with self.lock:
            for listener in self.listeners:
                listener.put(self._now())

    def listen(self) -> queue.SimpleQueue[str]:
        """Return what a page is told from now on; first of all what it may have missed."""
        mine: queue.SimpleQueue[str] = queue.SimpleQueue()
        with self.lock:
            mine.put(self._now())
            self.listeners.append(mine)
        return mine

    def _now(self) -> str:
        text = f"event: robot\ndata: {json.dumps(self.version)}\n\n"
        return text + (f"event: problem\ndata: {json.dumps({'text': self.problem})}\n\n" if self.problem else "")

    def leave(self, mine: queue.SimpleQueue[str]) -> None:
        """Tell a page no more."""
        with self.lock:
            self.listeners.remove(mine)


def is_loopback(host: str) -> bool:
    """Say whether an address is of this machine alone."""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


class Server(ThreadingHTTPServer):
    """Answers pages: ``host`` is an address of this machine."""

    daemon_threads = True

    def __init__(self, page: Page, host: str, port: int) -> None:
        self.page = page
        self.host = host
        self.address_family = socket.AF_INET6 if ":" in host else socket.AF_INET
        super().__init__((host, port), _Handler)
        self.port = int(self.server_address[1])

    def server_bind(self) -> None:
        """Take the port, without asking anybody for the name of the address."""
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.socket.bind(self.server_address)
        self.server_address = self.socket.getsockname()

    def is_mine(self, name: str) -> bool:
        """Say whether a Host header names this server: another site can point a name of its own here, but no other.

        Shown to this machine alone, it has the names of loopback; else also addresses, and the name of the machine.
        """
        found = _HOST.fullmatch(name)
        if found is None or int(found[3] or _HTTP) != self.port:
            return False
        bare = found[1] or found[2]
        if is_loopback(self.host):
            return bare in ("localhost", "127.0.0.1", "::1", self.host.lower())
        machine = socket.gethostname().lower()
        return _is_address(bare) or bare in ("localhost", self.host.lower(), machine, f"{machine}.local")

    def handle_error(self, request: object, client_address: object) -> None:
        """Say nothing of a browser that went away."""


def _is_address(text: str) -> bool:
    try:
        ip_address(text)
    except ValueError:
        return False
    return True


def bound(page: Page, host: str, port: int | None) -> Server:
    """Return a server at a port; without one at the usual, or where that is taken at any. Raises OSError."""
    if port is not None:
        return Server(page, host, port)
    try:
        return Server(page, host, PORT)
    except OSError:
        return Server(page, host, 0)


class _Handler(BaseHTTPRequestHandler):
    server: Server
    protocol_version = "HTTP/1.1"
    server_version = "rosorin-compile"
    sys_version = ""
    timeout = _PATIENCE

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing: the terminal belongs to what the compiler says."""

    def do_GET(self) -> None:
        if not self._is_for_us():
            return
        asked = urlsplit(self.path)
        page = self.server.page
        if asked.path == "/":
            self._send(page.text.encode(), "text/html; charset=utf-8")
        elif asked.path == "/robot.json":
            self._json(page.data)
        elif asked.path == "/explain":
            self._json(page.explain(parse_qs(asked.query).get("frame", [""])[0]))
        elif asked.path == "/events":
            self._events()
        elif asked.path == "/favicon.ico":  # browsers ask for it by themselves
            self._send(b"", "image/x-icon")
        elif asked.path.startswith("/mesh/"):
            self._mesh(asked.path.removeprefix("/mesh/"))
        else:
            self._refuse(HTTPStatus.NOT_FOUND, "there is nothing here but the robot")

    def do_POST(self) -> None:
        if not self._is_for_us():
            return
        size = self.headers.get("Content-Length", "")
        asked = self.headers.get_content_type() == "application/json" and size.isascii() and size.isdecimal()
        if not asked or len(size) > len(str(_LARGEST)) or int(size) > _LARGEST:
            self.close_connection = True  # what else was sent is not read
            self._refuse(HTTPStatus.BAD_REQUEST, "this is no question about the robot")
            return
        content = self.rfile.read(int(size))
        if self.path != "/touching":
            self._refuse(HTTPStatus.NOT_FOUND, "there is nothing here but the robot")
            return
        try:
            state = _positions(json.loads(content))
        except (ValueError, OverflowError, RecursionError):
            self._refuse(HTTPStatus.BAD_REQUEST, "these are no positions of joints")
            return
        try:
            found = self.server.page.touching(state)
        except Unknown as problem:
            self._refuse(HTTPStatus.NOT_IMPLEMENTED, str(problem))
            return
        self._json(found)

    def _is_for_us(self) -> bool:
        """Say whether a request came by a name of this machine, and from no page of somebody else."""
        hosts = self.headers.get_all("Host", [])
        host = hosts[0].lower() if len(hosts) == 1 else ""
        origin = self.headers.get("Origin", f"http://{host}").lower()
        foreign = self.headers.get("Sec-Fetch-Site", "none") not in ("none", "same-origin")
        followed = self.path == "/" and self.headers.get("Sec-Fetch-Mode") == "navigate"  # a link to the page
        if not self.server.is_mine(host) or origin != f"http://{host}" or (foreign and not followed):
            self.close_connection = True
            self._refuse(HTTPStatus.FORBIDDEN, "this robot is shown to this machine alone")
            return False
        return True

    def _mesh(self, number: str) -> None:
        file, kind = self.server.page.files.get(number, (None, ""))
        try:
            content = None if file is None else files.read_bytes(file)
        except OSError:
            content = None
        if content is None:
            self._refuse(HTTPStatus.NOT_FOUND, "there is no such mesh")
            return
        self._send(content, kind)

    def _events(self) -> None:
        self.send_response(HTTPStatus.OK)
        for name, value in {**_HEADERS, "Content-Type": "text/event-stream", "Connection": "close"}.items():
            self.send_header(name, value)
        self.end_headers()
        mine = self.server.page.listen()
        try:
            while not self._is_gone():
                try:
                    self.wfile.write(mine.get(timeout=_BEAT).encode())
                    self.wfile.flush()
                except queue.Empty:
                    continue
        except OSError:  # the page was closed
            pass
        finally:
            self.close_connection = True
            self.server.page.leave(mine)

    def _is_gone(self) -> bool:
        """Say whether the browser has closed a connection; it asks nothing more on that of events."""
        readable, _, _ = select.select([self.connection], [], [], 0)
        return bool(readable) and not self.connection.recv(1, socket.MSG_PEEK)

    def _json(self, data: object) -> None:
        self._send(json.dumps(data).encode(), "application/json")

    def _refuse(self, status: HTTPStatus, why: str) -> None:
        self._send(f"{why}\n".encode(), "text/plain; charset=utf-8", status)

    def _send(self, content: bytes, kind: str, status: HTTPStatus = HTTPStatus.OK) -> None:
        self.send_response(status)
        for name, value in {**_HEADERS, "Content-Type": kind, "Content-Length": str(len(content))}.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(content)


def _positions(state: object) -> Mapping[str, Any]:
    """Return positions by joint, all of them numbers or lists of numbers. Raises ValueError, OverflowError."""
    if not isinstance(state, dict):
        raise ValueError("no positions by joint")
    for value in state.values():
        for number in value if isinstance(value, list) else [value]:
            if isinstance(number, bool) or not isinstance(number, int | float) or not math.isfinite(number):
                raise ValueError("no position")
    return state
