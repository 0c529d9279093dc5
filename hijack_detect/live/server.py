# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Serves the live page over HTTP: reading only, in a thread of its own."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import os
import socket
import threading

from tornado.httpserver import HTTPServer
from tornado.ioloop import PeriodicCallback

from hijack_detect.live.handlers import Readers, application, is_loopback
from hijack_detect.live.picture import Picture

PERIOD_MS = 100.0
"""Period of the events. Chosen: twice the rate of usual fixes; the eye needs no more."""
STOP_S = 5.0
"""Longest wait for the thread at the end. Chosen, not swept."""
MOST_BODY = 4096
"""Most bytes of the body of a request. Chosen: reading needs none."""


class ServerError(ValueError):
    """The page cannot be served at this address."""


class Server:
    """The server, bound when it is made, and serving between `start` and `stop`.

    Attributes:
        url: Where the page is.
        local: Whether only this machine can reach it.
    """

    def __init__(self, picture: Picture, host: str, port: int) -> None:
        """Bind to an address; port 0 is any that is free.

        Raises:
            ServerError: It cannot be bound; the text has the remedy.
        """
        self.local = is_loopback(host)
        try:
            family = socket.AF_INET6 if ":" in host else socket.AF_INET
            self._socket = socket.create_server((host, port), family=family)
        except OSError as error:
            raise ServerError(_advice(host, port, error.errno or 0)) from error
        self._socket.setblocking(False)
        everywhere = host in ("0.0.0.0", "::")
        shown = socket.gethostname() if everywhere else f"[{host}]" if ":" in host else host
        self.url = f"http://{shown}:{self._socket.getsockname()[1]}/"
        self._picture = picture
        self._loop: asyncio.AbstractEventLoop | None = None
        self._end: asyncio.Event | None = None
        self._ready = threading.Event()
        self._thread = threading.Thread(target=self._run, name="live page", daemon=True)

    @property
    def alive(self) -> bool:
        """Whether it serves."""
        return self._thread.is_alive()

    def start(self) -> None:
        """Serve from now on."""
        self._thread.start()
        self._ready.wait()

    def stop(self) -> None:
        """End it, and all connections."""
        if self._loop is not None and self._end is not None:
            with contextlib.suppress(RuntimeError):  # it has ended by itself
                self._loop.call_soon_threadsafe(self._end.set)
            self._thread.join(STOP_S)
        self._socket.close()

    def _run(self) -> None:
        try:
            asyncio.run(self._serve())
        finally:
            self._ready.set()

    async def _serve(self) -> None:
        self._loop, self._end = asyncio.get_running_loop(), asyncio.Event()
        readers = Readers(self._picture)
        server = HTTPServer(
            application(readers, local=self.local),
            max_body_size=MOST_BODY,
            idle_connection_timeout=60.0,
        )
        server.add_socket(self._socket)
        ticking = PeriodicCallback(readers.tick, PERIOD_MS)
        ticking.start()
        self._ready.set()
        await self._end.wait()
        ticking.stop()
        server.stop()
        readers.end()
        await asyncio.sleep(0)  # they end by themselves
        await server.close_all_connections()


def _advice(host: str, port: int, number: int) -> str:
    """Why an address cannot be bound, and what to do; the numbers of getaddrinfo are negative."""
    if number < 0 or number == errno.EADDRNOTAVAIL:
        return f"--host {host}: this machine has no such address"
    why = f"{host}:{port} cannot be served: {os.strerror(number)}; "
    if number == errno.EADDRINUSE:
        why += "another viewer may be running there: "
    return f"{why}give another --port, or --port 0 for any that is free"
