"""Commands that run beside a test: ``watch`` and ``view``, their lines, and what the server of a page answers."""

from __future__ import annotations

import http.client
import json
import queue
import re
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from typing_extensions import Self

PATIENCE = 30.0  # seconds until something that does not come fails a test; no test waits for as long otherwise


_SAID = "(Ctrl-C ends it)"


class Running:
    """A command that runs in a process; what it prints is read as it comes."""

    def __init__(self, folder: Path, *words: str) -> None:
        self.folder = folder
        command = [sys.executable, "-m", "rosorin_compile", *words]
        self.process = subprocess.Popen(
            command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, bufsize=1
        )
        self.lines: list[str] = []
        self.fresh: queue.Queue[str] = queue.Queue()
        self.reader = threading.Thread(target=self._read)
        self.reader.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.process.kill()
        self.process.wait()
        self.reader.join()
        assert self.process.stdout is not None
        self.process.stdout.close()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.lines.append(line.rstrip("\n"))
            self.fresh.put(line.rstrip("\n"))

    def until(self, text: str) -> list[str]:
        """Return the new lines up to the first that contains a text."""
        new: list[str] = []
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            try:
                new.append(self.fresh.get(timeout=0.1))
            except queue.Empty:
                assert self.process.poll() is None, self.lines
                continue
            if text in new[-1]:
                return new
        raise AssertionError(f"no {text!r} in {self.lines}")

    def silent(self, seconds: float = 1.0) -> bool:
        """Return True if nothing is printed for some time."""
        time.sleep(seconds)
        return self.fresh.empty()

    def end(self, number: int) -> int:
        """Send a signal; return the exit code."""
        self.process.send_signal(number)
        return self.process.wait(PATIENCE)


class Viewing(Running):
    """A process that shows a robot."""

    def __init__(self, folder: Path, *words: str) -> None:
        super().__init__(folder, "view", "--no-open", *words)

    @property
    def port(self) -> int:
        """The port that it said."""
        said = next((line for line in self.lines if _SAID in line), None) or self.until(_SAID)[-1]
        found = re.search(r":(\d+)/", said)
        assert found is not None
        return int(found[1])

    def get(self, path: str, **headers: str) -> tuple[int, bytes]:
        """Return status and content of what is asked for."""
        return asked(self.port, path, **headers)

    @property
    def robot(self) -> Any:
        """The robot that is served now."""
        status, content = self.get("/robot.json")
        assert status == 200
        return json.loads(content)["robot"]


def asked(port: int, path: str, method: str = "GET", body: bytes | None = None, **headers: str) -> tuple[int, bytes]:
    """Return status and content of a request; words of headers have "_" for "-"; an empty Host is none at all."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE)
    try:
        connection.putrequest(method, path, skip_host="Host" in headers)
        for name, value in headers.items():
            if value or name != "Host":
                connection.putheader(name.replace("_", "-"), value)
        if body is not None and "Content_Length" not in headers:
            connection.putheader("Content-Length", str(len(body)))
        connection.endheaders(body)
        answer = connection.getresponse()
        return answer.status, answer.read()
    finally:
        connection.close()


class Events:
    """What a page is told: pairs of a kind and data, as they come."""

    def __init__(self, port: int) -> None:
        self.connection = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE)
        self.connection.request("GET", "/events")
        self.answer = self.connection.getresponse()
        assert self.answer.headers["Content-Type"] == "text/event-stream"

    def __enter__(self) -> Events:
        return self

    def __exit__(self, *_: object) -> None:
        self.answer.close()
        self.connection.close()

    def next(self) -> tuple[str, Any]:
        """Return the next event."""
        lines = []
        while line := self.answer.readline().decode().rstrip("\n"):
            lines.append(line)
        kind, data = lines
        return kind.removeprefix("event: "), json.loads(data.removeprefix("data: "))

    def until(self, kind: str) -> Any:
        """Return the data of the next event of a kind."""
        while True:
            found, data = self.next()
            if found == kind:
                return data
