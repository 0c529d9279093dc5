# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The server of the live page, asked by real clients: reading only, slow readers, hosts, ports."""

from __future__ import annotations

import http.client
import json
import socket
import time
from collections.abc import Callable, Iterator
from typing import Any
from urllib.parse import urlsplit

import pytest
from shown import Flown

pytest.importorskip("tornado", reason="the extra live is not installed")

from hijack_detect.live import handlers
from hijack_detect.live.server import Server, ServerError

FILES = ("/", "/style.css", "/style.js", "/live.js", "/map.js", "/margins.js")
WRITING = ("POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "CONNECT")


@pytest.fixture
def flown() -> Flown:
    made = Flown()
    made.fly(2.0)
    return made


def ask(
    server: Server, method: str, path: str, headers: dict[str, str] | None = None, body: str = ""
) -> tuple[http.client.HTTPResponse, bytes]:
    """Send a request; give the response and what is in it."""
    client = http.client.HTTPConnection(urlsplit(server.url).netloc, timeout=5.0)
    client.request(method, path, body or None, headers or {})
    response = client.getresponse()
    try:
        return response, response.read()
    finally:
        client.close()


@pytest.fixture
def listen() -> Iterator[Callable[[Server], socket.socket]]:
    """Asks for the events, and reads nothing yet."""
    readers: list[socket.socket] = []

    def opened(server: Server) -> socket.socket:
        readers.append(listening(server))
        return readers[-1]

    yield opened
    for reader in readers:
        reader.close()


def listening(server: Server) -> socket.socket:
    """A connection that has asked for the events."""
    url = urlsplit(server.url)
    reader = socket.socket()
    reader.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    reader.settimeout(10.0)
    reader.connect((url.hostname, url.port))
    reader.sendall(f"GET /events HTTP/1.1\r\nHost: {url.netloc}\r\n\r\n".encode())
    return reader


def events(reader: socket.socket) -> Iterator[dict[str, Any]]:
    """The events that a reader gets."""
    rest = b""
    while data := reader.recv(1 << 16):
        *lines, rest = (rest + data).split(b"\n")
        for line in lines:
            if line.startswith(b"data: "):
                yield json.loads(line[6:])


@pytest.mark.parametrize("path", FILES)
def test_every_file_of_the_page_is_there_and_says_what_it_may_do(server: Server, path: str) -> None:
    response, content = ask(server, "GET", path)
    assert response.status == 200
    assert len(content) > 500
    policy = response.headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    assert response.headers["X-Content-Type-Options"] == "nosniff"
    assert response.headers["Access-Control-Allow-Origin"] is None
    assert ask(server, "HEAD", path)[0].headers["Content-Length"] == str(len(content))
    assert b"http://" not in content.replace(b"http://www.w3.org/", b"")


@pytest.mark.parametrize("method", WRITING)
@pytest.mark.parametrize("path", ["/", "/events", "/hijack_alert"])
def test_nothing_can_be_written(server: Server, method: str, path: str) -> None:
    response, _ = ask(server, method, path, body="x=1" if method != "CONNECT" else "")
    assert response.status == 405
    if method != "CONNECT":
        assert response.headers["Allow"] == "GET, HEAD"


def test_a_websocket_and_a_path_that_is_not_there_are_refused(server: Server) -> None:
    upgrade = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Key": "x"}
    for path in ("/", "/events"):
        assert ask(server, "GET", path, upgrade)[0].status == 400
    for path in ("/nothing", "/../setup.py", "/%2e%2e/server.py", "/index.html"):
        assert ask(server, "GET", path)[0].status == 404


@pytest.mark.parametrize(
    ("host", "status"),
    [
        ("localhost:8765", 200),
        ("127.0.0.1", 200),
        ("[::1]:80", 200),
        ("attacker.example", 403),
        ("localhost.attacker.example:8765", 403),
        ("192.168.1.7:8765", 403),
    ],
)
def test_a_name_that_is_not_of_this_machine_is_refused(
    server: Server, host: str, status: int
) -> None:
    for path in ("/", "/live.js"):
        assert ask(server, "GET", path, {"Host": host})[0].status == status
    assert ask(server, "HEAD", "/events", {"Host": host})[0].status == status


def test_a_server_for_others_answers_to_any_name(flown: Flown) -> None:
    server = Server(flown.picture, "0.0.0.0", 0)
    server.start()
    assert not server.local
    assert urlsplit(server.url).hostname == socket.gethostname().lower()
    here = server.url.replace(socket.gethostname(), "127.0.0.1")
    client = http.client.HTTPConnection(urlsplit(here).netloc, timeout=5.0)
    client.request("GET", "/", headers={"Host": "drone.example"})
    assert client.getresponse().status == 200
    client.close()
    server.stop()


def test_readers_get_the_history_then_ten_events_a_second(
    server: Server, flown: Flown, listen
) -> None:
    told = events(listen(server))
    first = next(told)
    assert first["reset"]
    assert len(first["track"]) > 5
    flown.fly(0.4, reason="<script>alert(1)</script>")
    began = time.monotonic()
    news = [next(told) for _ in range(20)]
    assert 1.5 < time.monotonic() - began < 2.6
    assert not any(one["reset"] for one in news)
    assert news[-1]["detectors"][0]["why"] == "<script>alert(1)</script>"


def test_a_reader_that_takes_nothing_is_dropped_and_holds_nobody_up(
    flown: Flown, listen, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(handlers, "SLOW_S", 0.5)
    flown.fly(600.0)
    server = Server(flown.picture, "127.0.0.1", 0)
    server._socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
    server.start()
    slow, quick = listen(server), events(listen(server))
    assert len(next(quick)["track"]) > 2000
    began = time.monotonic()
    for _ in range(10):
        next(quick)
    assert time.monotonic() - began < 1.5
    with pytest.raises((ConnectionError, StopIteration)):
        told = events(slow)
        while True:
            next(told)
    server.stop()


def test_readers_are_not_more_than_there_is_room_for(
    server: Server, listen, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(handlers, "MOST_READERS", 2)
    readers = [listen(server) for _ in range(2)]
    for reader in readers:
        next(events(reader))
    assert ask(server, "GET", "/events")[0].status == 503
    readers[0].close()
    deadline = time.monotonic() + 5.0
    while b" 200 " not in (line := answer(server)):
        assert time.monotonic() < deadline, line


def answer(server: Server) -> bytes:
    """The first line of the answer to a request for the events."""
    with listening(server) as reader, reader.makefile("rb") as lines:
        return lines.readline()


def test_a_port_in_use_and_a_host_that_is_not_there_say_what_to_do(
    server: Server, flown: Flown
) -> None:
    port = urlsplit(server.url).port
    assert port is not None
    with pytest.raises(ServerError, match=rf"127.0.0.1:{port} .*in use.*--port 0"):
        Server(flown.picture, "127.0.0.1", port)
    with pytest.raises(ServerError, match=r"--host no.such.host.invalid: this machine"):
        Server(flown.picture, "no.such.host.invalid", 0)
    with pytest.raises(ServerError, match=r"--host 192.0.2.1: "):
        Server(flown.picture, "192.0.2.1", 0)
