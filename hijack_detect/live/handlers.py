# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The answers to requests: the files of the page, and the stream of events."""

from __future__ import annotations

import asyncio
import contextlib
import ipaddress
import json
from collections.abc import Awaitable
from pathlib import Path
from typing import Any

from tornado.http1connection import HTTP1Connection
from tornado.httputil import split_host_and_port
from tornado.iostream import StreamClosedError
from tornado.locks import Condition
from tornado.web import Application, HTTPError, RequestHandler

from hijack_detect.live.picture import Cursor, Frame, Picture


def event(frame: Frame) -> bytes:
    """A frame as a server-sent event: JSON, in which no number is NaN or infinite."""
    text = json.dumps(frame, allow_nan=False, separators=(",", ":"))
    return f"data: {text}\n\n".encode()


class Feed:
    """The events of a picture, for the server's thread."""

    def __init__(self, picture: Picture) -> None:
        """Read this picture."""
        self._picture = picture
        self._made: dict[Cursor | None, tuple[bytes, Cursor]] = {}

    def tick(self) -> None:
        """Look at the picture again from now on."""
        self._made.clear()

    def next(self, cursor: Cursor | None) -> tuple[bytes, Cursor]:
        """The event with what a reader does not have yet, and its next cursor."""
        if cursor not in self._made:
            frame, after = self._picture.frame(cursor)
            self._made[cursor] = event(frame), after
        return self._made[cursor]


SLOW_S = 10.0
"""Timeout of a reader that takes nothing. Chosen, not swept."""
MOST_READERS = 32
"""Most readers at once. Chosen, not swept; it bounds memory and processor."""
PAGE = Path(__file__).with_name("page")
KINDS = {".html": "text/html", ".css": "text/css", ".js": "text/javascript"}
HEADERS = {
    "Cache-Control": "no-cache",
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; "
    "connect-src 'self'; img-src data:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


def is_loopback(host: str) -> bool:
    """Whether only this machine can reach an address."""
    with contextlib.suppress(ValueError):
        return ipaddress.ip_address(host).is_loopback
    return host == "localhost"


class Readers:
    """The readers of the events, and their feed."""

    def __init__(self, picture: Picture) -> None:
        """Nobody reads yet."""
        self.feed = Feed(picture)
        self.count = 0
        self.served = True
        self._news = Condition()

    def tick(self) -> None:
        """Wake all readers."""
        self.feed.tick()
        self._news.notify_all()

    def end(self) -> None:
        """Let all readers go."""
        self.served = False
        self.tick()

    def news(self) -> Awaitable[bool]:
        """Wait until the next tick."""
        return self._news.wait()


class Reading(RequestHandler):
    """A handler that rejects all but reading, and names that are not this server's."""

    def initialize(self, local: bool) -> None:
        """See RequestHandler; `local` if the server is for this machine alone."""
        self._local = local

    def set_default_headers(self) -> None:
        """See RequestHandler."""
        self.clear_header("Server")
        for name, value in HEADERS.items():
            self.set_header(name, value)

    def prepare(self) -> None:
        """Check a request before it is answered.

        A page of somebody else's can have its name resolve to this machine (DNS rebinding), and
        would then read what is served here; its name is in the request.
        """
        if self.request.method not in ("GET", "HEAD"):
            raise HTTPError(405)
        if "Upgrade" in self.request.headers:
            raise HTTPError(400, reason="There are no websockets here")
        name, _ = split_host_and_port(self.request.host)
        if self._local and not is_loopback(name.strip("[]").lower()):
            raise HTTPError(403, reason="This is served to localhost only")

    def write_error(self, status_code: int, **kwargs: Any) -> None:
        """See RequestHandler; the reason as plain text."""
        self.set_header("Content-Type", "text/plain")
        if status_code == 405:
            self.set_header("Allow", "GET, HEAD")
        self.finish(f"{status_code} {self._reason}\n")


class Missing(Reading):
    """Every path that there is not."""

    def get(self, *_: str) -> None:
        """Answer 404."""
        raise HTTPError(404)

    head = get


class File(Reading):
    """One file of the page."""

    def initialize(self, local: bool, content: bytes = b"", kind: str = "") -> None:
        """See RequestHandler; the content of the file and its type."""
        super().initialize(local)
        self._content, self._kind = content, kind

    def get(self) -> None:
        """Send it."""
        self.set_header("Content-Type", f"{self._kind}; charset=utf-8")
        self.finish(self._content)

    head = get


class Events(Reading):
    """The stream of events: the history first, then what is new ten times a second.

    Nothing is queued for a reader: a slow one gets fewer and larger events.
    """

    def initialize(self, local: bool, readers: Readers | None = None) -> None:
        """See RequestHandler."""
        super().initialize(local)
        assert readers is not None
        self._readers = readers
        self._gone = False

    def head(self) -> None:
        """Send the type of the stream."""
        self.set_header("Content-Type", "text/event-stream")

    async def get(self) -> None:
        """Stream until the reader leaves, or takes nothing for too long."""
        if self._readers.count >= MOST_READERS:
            raise HTTPError(503, reason=f"There are {MOST_READERS} readers already")
        self.set_header("Content-Type", "text/event-stream")
        self._readers.count += 1
        try:
            await self._stream()
        except (StreamClosedError, asyncio.TimeoutError):
            self._drop()
        finally:
            self._readers.count -= 1

    async def _stream(self) -> None:
        cursor: Cursor | None = None
        self.write(b"retry: 1000\n\n")
        while self._readers.served and not self._gone:
            data, cursor = self._readers.feed.next(cursor)
            self.write(data)
            await asyncio.wait_for(self.flush(), SLOW_S)
            await self._readers.news()

    def on_connection_close(self) -> None:
        """See RequestHandler."""
        self._gone = True

    def _drop(self) -> None:
        connection = self.request.connection
        if isinstance(connection, HTTP1Connection):
            connection.close()


def application(readers: Readers, *, local: bool) -> Application:
    """The paths of the page."""
    files: dict[str, dict[str, Any]] = {}
    for path in sorted(PAGE.iterdir()):
        if path.suffix in KINDS:
            shown = "/" if path.name == "index.html" else f"/{path.name}"
            content = {"content": path.read_bytes(), "kind": KINDS[path.suffix]}
            files[shown] = {"local": local, **content}
    handlers: list[Any] = [(path, File, given) for path, given in files.items()]
    handlers.append(("/events", Events, {"local": local, "readers": readers}))
    handlers.append((".*", Missing, {"local": local}))
    return Application(handlers, log_function=lambda _: None)
