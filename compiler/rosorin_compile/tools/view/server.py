"""The server of the page: this robot, its meshes and what explains it, on this machine alone; nothing else is served.

A page of somebody else in the same browser cannot read it: requests are answered only under the names of this machine
(which a foreign page that points its own name here has not), and what they ask is never sent to another origin.
"""

from __future__ import annotations

import json
import queue
import threading
from collections.abc import Callable, Mapping
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

Data = dict[str, Any]

LOOPBACK = "127.0.0.1"
PORT = 8642  # where no other page is; else the system chooses one
_NAMES = ("localhost", "127.0.0.1", "[::1]")
_LARGEST = 1_000_000  # bytes of a question
_BEAT = 15.0  # seconds between signs of life, by which a page that has gone is noticed
_HEADERS = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
}


class Page:
    """What is served at present; the files are followed in another thread than pages are answered in."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.text = ""
        self.data: Data = {}
        self.files: list[Path] = []
        self.problem = ""
        self.explain: Callable[[str], list[str]] = lambda _: []
        self.touching: Callable[[Mapping[str, Any]], list[list[str]] | None] = lambda _: None
        self.listeners: list[queue.SimpleQueue[str]] = []

    def publish(self, event: str, data: object) -> None:
        """Tell every page that is open."""
        text = f"event: {event}\ndata: {json.dumps(data)}\n\n"
        with self.lock:
            listeners = list(self.listeners)
        for listener in listeners:
            listener.put(text)

    def listen(self) -> queue.SimpleQueue[str]:
        """Return what a new page is told from now on; first of all what is wrong now."""
        mine: queue.SimpleQueue[str] = queue.SimpleQueue()
        with self.lock:
            self.listeners.append(mine)
            if self.problem:
                mine.put(f"event: problem\ndata: {json.dumps({'text': self.problem})}\n\n")
        return mine

    def leave(self, mine: queue.SimpleQueue[str]) -> None:
        """Tell a page no more."""
        with self.lock:
            self.listeners.remove(mine)


class Server(ThreadingHTTPServer):
    """Answers pages. ``names`` are the names under which it is asked; None: under any."""

    daemon_threads = True

    def __init__(self, page: Page, host: str, port: int) -> None:
        self.page = page
        super().__init__((host, port), _Handler)
        self.port = int(self.server_address[1])
        local = host in (LOOPBACK, "localhost", "::1")
        self.names = {f"{name}:{self.port}" for name in _NAMES} if local else None

    def handle_error(self, request: object, client_address: object) -> None:
        """Say nothing of a browser that went away."""


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
        elif asked.path.startswith("/mesh/"):
            self._mesh(asked.path.removeprefix("/mesh/"))
        else:
            self._refuse(HTTPStatus.NOT_FOUND, "there is nothing here but the robot")

    def do_POST(self) -> None:
        if not self._is_for_us():
            return
        size = self.headers.get("Content-Length", "")
        if self.headers.get_content_type() != "application/json" or not size.isdecimal() or int(size) > _LARGEST:
            self._refuse(HTTPStatus.BAD_REQUEST, "this is no question about the robot")
            return
        content = self.rfile.read(int(size))
        if self.path != "/touching":
            self._refuse(HTTPStatus.NOT_FOUND, "there is nothing here but the robot")
            return
        try:
            state = json.loads(content)
            found = self.server.page.touching(state)
        except (ValueError, TypeError, KeyError):
            self._refuse(HTTPStatus.BAD_REQUEST, "these are no positions of joints")
            return
        if found is None:
            self._refuse(HTTPStatus.NOT_IMPLEMENTED, "what touches is not known here")
            return
        self._json(found)

    def _is_for_us(self) -> bool:
        """Say whether a request came by a name of this machine, and from no page of somebody else."""
        names = self.server.names
        host = self.headers.get("Host", "").lower()
        origin = self.headers.get("Origin")
        if (names is not None and host not in names) or (origin is not None and origin.lower() != f"http://{host}"):
            self._refuse(HTTPStatus.FORBIDDEN, "this robot is shown to this machine alone")
            return False
        return True

    def _mesh(self, number: str) -> None:
        files = self.server.page.files
        try:
            content = files[int(number)].read_bytes() if number.isdecimal() else None
        except (IndexError, OSError):
            content = None
        if content is None:
            self._refuse(HTTPStatus.NOT_FOUND, "there is no such mesh")
            return
        self._send(content, "application/octet-stream")

    def _events(self) -> None:
        self.send_response(HTTPStatus.OK)
        for name, value in {**_HEADERS, "Content-Type": "text/event-stream", "Connection": "close"}.items():
            self.send_header(name, value)
        self.end_headers()
        mine = self.server.page.listen()
        try:
            while True:
                try:
                    text = mine.get(timeout=_BEAT)
                except queue.Empty:
                    text = ": here\n\n"
                self.wfile.write(text.encode())
                self.wfile.flush()
        except OSError:  # the page was closed
            self.close_connection = True
        finally:
            self.server.page.leave(mine)

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
