"""The server of the page gives the robot to this machine, and nothing else to anybody."""

import json
import socket
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.viewer.server import LOOPBACK, HttpRefusal, Page, Server, create_server
from support.commands import Shown
from support.viewing import Events, asked


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    mesh = tmp_path / "arm.stl"
    mesh.write_bytes(b"solid")
    (tmp_path / "secret").write_text("secret")
    page = Page()
    page.text, page.data, page.version, page.files = (
        "<p>",
        {"robot": {}, "version": "a"},
        "a",
        {"0": (mesh, "model/stl")},
    )
    page.touching = lambda state: [["a", "b"]] if state else []
    page.explain = lambda frame: [f"about {frame}"]
    made = create_server(page, LOOPBACK, 0)
    threading.Thread(target=made.serve_forever, args=(0.02,), daemon=True).start()
    yield made
    made.shutdown()
    made.server_close()


def test_it_serves_the_robot(server: Server) -> None:
    assert asked(server.port, "/") == (200, b"<p>")
    assert json.loads(asked(server.port, "/robot.json")[1]) == {"robot": {}, "version": "a"}
    assert asked(server.port, "/mesh/0?1") == (200, b"solid")
    assert json.loads(asked(server.port, "/explain?frame=a%20%3C")[1]) == ["about a <"]
    assert asked(server.port, "/touching", "POST", b'{"j": 1}', Content_Type="application/json") == (
        200,
        b'[["a", "b"]]',
    )


def test_it_says_why_it_does_not_know_what_touches(server: Server) -> None:
    def unknown(_: object) -> list[list[str]]:
        raise HttpRefusal(501, "mujoco is not installed")

    server.page.touching = unknown
    found = asked(server.port, "/touching", "POST", b"{}", Content_Type="application/json")
    assert found == (501, b"mujoco is not installed\n")
    server.page.touching = Page().touching
    assert (
        asked(server.port, "/touching", "POST", b"{}", Content_Type="application/json")[1] == b"there is no robot yet\n"
    )


PATHS = ["/mesh/1", "/mesh/-1", "/mesh/00", "/mesh/", "/mesh/../secret", "/mesh/%2e%2e/secret", "/mesh/0/../../secret"]
PATHS += ["/../secret", "/..%2fsecret", "//etc/passwd", "/etc/passwd", "/mesh//etc/passwd", "/arm.stl", "/index.html"]
PATHS += ["/mesh/²", "/mesh/0%00", "/robot.json/..", "/.", "/mesh/1" + "0" * 5000]


@pytest.mark.parametrize("path", PATHS, ids=lambda path: path[:20])
def test_no_other_path_is_served(server: Server, path: str) -> None:
    with socket.create_connection((LOOPBACK, server.port), timeout=30) as connection:
        request = f"GET {path} HTTP/1.1\r\nHost: localhost:{server.port}\r\nConnection: close\r\n\r\n"
        connection.sendall(request.encode())
        answer = b"".join(iter(lambda: connection.recv(4096), b""))
    assert answer.startswith(b"HTTP/1.1 404 "), answer[:80]
    assert b"secret" not in answer.partition(b"\r\n\r\n")[2]


def hosts(port: int) -> list[tuple[str, int]]:
    good = [f"localhost:{port}", f"LOCALHOST:{port}", f"127.0.0.1:{port}", f"[::1]:{port}"]
    bad = ["", "localhost", f"localhost:{port + 1}", "evil.example", f"evil.example:{port}", f"localhost.evil:{port}"]
    bad += [
        f"[::2]:{port}",
        f"::1:{port}",
        f"192.168.0.1:{port}",
        f"localhost:{port}:1",
        f"a@localhost:{port}",
        "[",
        ":",
    ]
    bad += [f"a@localhost:{port}", f"localhost:0{port}:", f"localhost:{port} evil", f"localhost:{'9' * 5000}"]
    return [*((host, 200) for host in good), *((host, 403) for host in bad)]


def test_it_answers_to_the_names_of_this_machine_alone(server: Server) -> None:
    """A site that lets its own name lead here sends that name, and reads nothing."""
    for path in ("/", "/robot.json", "/mesh/0", "/explain?frame=a", "/events"):
        for host, meant in hosts(server.port):
            if path == "/events" and meant == 200:
                continue  # that does not end
            status, content = asked(server.port, path, Host=host)
            assert (status, host) == (meant, host)
            assert meant == 200 or content == b"this robot is shown only to this machine\n"


def test_it_answers_no_page_of_somebody_else(server: Server) -> None:
    own = f"http://localhost:{server.port}"
    host = f"localhost:{server.port}"
    for origin in ("null", "http://evil.example", own + "0", f"https://{host}", f"http://127.0.0.1:{server.port}", "*"):
        assert asked(server.port, "/robot.json", Host=host, Origin=origin)[0] == 403, origin
        body = {"Content_Type": "application/json", "Origin": origin, "Host": host}
        assert asked(server.port, "/touching", "POST", b"{}", **body)[0] == 403, origin
    assert asked(server.port, "/robot.json", Host=host, Origin=own)[0] == 200
    for site, meant in {"cross-site": 403, "same-site": 403, "same-origin": 200, "none": 200}.items():
        assert asked(server.port, "/robot.json", Sec_Fetch_Site=site)[0] == meant, site
    assert asked(server.port, "/", Sec_Fetch_Site="cross-site", Sec_Fetch_Mode="navigate")[0] == 200, "a link"
    assert asked(server.port, "/", Sec_Fetch_Site="cross-site", Sec_Fetch_Mode="no-cors")[0] == 403


def test_no_other_page_may_embed_or_read_what_is_sent(server: Server) -> None:
    import urllib.request

    with urllib.request.urlopen(f"http://localhost:{server.port}/robot.json") as answer:
        headers = answer.headers
    assert "Access-Control-Allow-Origin" not in headers
    meant = {"X-Frame-Options": "DENY", "Cross-Origin-Resource-Policy": "same-origin", "Cache-Control": "no-store"}
    assert {name: headers[name] for name in meant} == meant
    assert headers["X-Content-Type-Options"] == "nosniff"


QUESTIONS = [b"", b"[", b"[1]", b"null", b'"a"', b'{"j": "1"}', b'{"j": NaN}', b'{"j": 1e999}', b'{"j": {}}', b"\xff"]
QUESTIONS += [b'{"j": true}', b'{"j": [1, null]}', b"[" * 100_000]
QUESTIONS += [b'{"j": ' + b"9" * digits + b"}" for digits in (400, 5_000)]


@pytest.mark.parametrize("body", QUESTIONS, ids=lambda body: repr(body[:12]))
def test_what_is_no_question_is_refused(server: Server, body: bytes) -> None:
    status, content = asked(server.port, "/touching", "POST", body, Content_Type="application/json")
    assert (status, content) == (400, b"these are not positions of joints\n")


@pytest.mark.parametrize(
    ("kind", "length"),
    [
        ("text/plain", "2"),
        ("application/json", "1000001"),
        ("application/json", "9" * 5000),
        ("application/json", "-1"),
        ("application/json", "٢"),
        ("application/json", ""),
    ],
)
def test_a_question_of_another_kind_or_size_is_not_read(server: Server, kind: str, length: str) -> None:
    """What stands in its body is no request, either."""
    with socket.create_connection((LOOPBACK, server.port), timeout=30) as connection:
        head = f"POST /touching HTTP/1.1\r\nHost: localhost:{server.port}\r\nContent-Type: {kind}\r\n"
        inner = f"GET /robot.json HTTP/1.1\r\nHost: localhost:{server.port}\r\n\r\n"
        connection.sendall(f"{head}Content-Length: {length}\r\n\r\n{inner}".encode())
        answer = b""
        try:
            while more := connection.recv(4096):
                answer += more
        except ConnectionResetError:
            pass
    assert answer.startswith(b"HTTP/1.1 400 ")
    assert answer.count(b"HTTP/1.1") == 1


def test_pages_that_go_away_are_forgotten(server: Server) -> None:
    for _ in range(20):
        with Events(server.port) as events:
            assert events.next() == ("robot", "a")
    waiting = threading.Event()
    for _ in range(300):
        if not server.page.listeners:
            break
        waiting.wait(0.1)
    assert server.page.listeners == 0


def test_shown_to_others_it_still_has_only_names_of_this_machine() -> None:
    server = Server(Page(), "0.0.0.0", 0)  # noqa: S104
    try:
        port = server.port
        for host in (f"192.168.1.5:{port}", f"[fe80::1]:{port}", f"{socket.gethostname().lower()}:{port}"):
            assert server.is_mine(host), host
        for host in (f"evil.example:{port}", f"192.168.1.5:{port + 1}", "", f"1.2.3:{port}"):
            assert not server.is_mine(host), host
    finally:
        server.server_close()


PROJECT = {"descriptions/r/robot.yaml": "robot: r\nlinks: {base: {}}\n"}


@pytest.mark.usefixtures("project")
def test_a_port_that_is_taken(server: Server, capsys: Shown) -> None:
    assert main(["view", "--no-open", "--port", str(server.port)]) == 2
    assert f"cannot be served at 127.0.0.1, port {server.port}: " in capsys.readouterr().err
