# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Frames as server-sent events, made once for all readers that are equally far."""

from __future__ import annotations

import json

from hijack_detect.live.picture import Cursor, Frame, Picture


def event(frame: Frame) -> bytes:
    """A frame as a server-sent event: JSON, in which no number is NaN or infinite."""
    text = json.dumps(frame, allow_nan=False, separators=(",", ":"))
    return f"data: {text}\n\n".encode()


class Feed:
    """Hands out the events of a picture, in the server's thread."""

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
