# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The thread that owns a link: it waits for bytes and for jobs."""

from __future__ import annotations

import contextlib
import os
import queue
import select
import threading
import time
from collections.abc import Callable
from typing import Protocol

from hijack_detect.mavlink.link import Address, Link, LinkLost, Place, open_link

TICK_S = 0.02
"""Longest time between two ticks. Chosen: far below every period of the bridge (0.1 s)."""
FIRST_WAIT_S, LONGEST_WAIT_S = 0.5, 8.0
"""First and longest wait before a link is opened again; it doubles. Chosen, not swept."""
LASTS_S = 5.0
"""A link that lasted this long was good: the next try comes soon. Chosen, not swept."""
END_S = 5.0
"""Longest wait for the thread at the end. Chosen: longer than CONNECT_S of a link."""


class Handler(Protocol):
    """The user of the link; everything is called in the worker's thread."""

    def connected(self) -> None:
        """It was opened."""

    def lost(self, why: str) -> None:
        """It was lost, or cannot be opened."""

    def receive(self, data: bytes, source: Address) -> None:
        """Bytes came."""

    def failed(self, error: Exception) -> None:
        """One of these functions, or a job, has raised something."""

    def tick(self) -> None:
        """At least every TICK_S."""


class Worker:
    """A thread that opens a link, again and again if it must, and hands over what arrives."""

    def __init__(self, where: Place, handler: Handler) -> None:
        """Prepare."""
        self._where, self._handler = where, handler
        self._link: Link | None = None
        self._jobs: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._wake_read, self._wake_write = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
        self._ends = threading.Event()
        self._next_s, self._wait_s = 0.0, FIRST_WAIT_S
        self._opened_s = 0.0
        self._thread = threading.Thread(target=self._run, name="mavlink", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def do(self, job: Callable[[], None]) -> None:
        """Run a job in the worker's thread, at once; from any thread."""
        self._jobs.put(job)
        with contextlib.suppress(BlockingIOError):  # it is awake already
            os.write(self._wake_write, b"x")

    def send(self, data: bytes, to: Address) -> None:
        """Send, if the link is open; in the worker's thread."""
        if self._link is None:
            return
        try:
            self._link.write(data, to)
        except LinkLost as error:
            self._lose(error)

    def stop(self) -> None:
        """End the thread and close the link."""
        self._ends.set()
        self.do(lambda: None)
        if self._thread.is_alive():
            self._thread.join(END_S)
        if self._link is not None:
            self._link.close()
            self._link = None

    def _run(self) -> None:
        while not self._ends.is_set():
            try:
                self._step()
            except Exception as error:  # a mistake with one message must not end the link
                self._handler.failed(error)
                self._ends.wait(TICK_S)

    def _step(self) -> None:
        if self._link is None and time.monotonic() >= self._next_s:
            self._open()
        waited = [self._wake_read, *([] if self._link is None else [self._link.fileno()])]
        ready, _, _ = select.select(waited, [], [], TICK_S)
        if self._wake_read in ready:
            os.read(self._wake_read, 65_536)
        while not self._jobs.empty() and not self._ends.is_set():
            self._jobs.get()()
        if self._link is not None and self._link.fileno() in ready:
            self._read(self._link)
        if not self._ends.is_set():
            self._handler.tick()

    def _open(self) -> None:
        try:
            self._link = open_link(self._where)
        except (LinkLost, ValueError) as error:
            self._lose(error)
            return
        self._opened_s = time.monotonic()
        self._handler.connected()

    def _read(self, link: Link) -> None:
        try:
            for data, source in link.read():
                self._handler.receive(data, source)
                if self._link is not link:  # it could not be written to
                    return
        except LinkLost as error:
            self._lose(error)

    def _lose(self, error: Exception) -> None:
        """Close the link, and try again later."""
        if self._link is not None:
            self._link.close()
            self._link = None
            if time.monotonic() - self._opened_s > LASTS_S:
                self._wait_s = FIRST_WAIT_S
        self._next_s = time.monotonic() + self._wait_s
        self._wait_s = min(2.0 * self._wait_s, LONGEST_WAIT_S)
        self._handler.lost(str(error) or repr(error))
