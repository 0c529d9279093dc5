# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Current problems: each is logged once, and its end too."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from hijack_detect.contract import Log
from hijack_detect.recording.folder_lock import FolderInUseError


class JournalError(ValueError):
    """The file cannot be used as a journal; the text has its name and the remedy."""


_ADVICE = {
    "full": "make room on the disk",
    "no space": "make room on the disk",
    "too large": "make room, or raise the limit for the size of files",
    "disk i/o error": "check the disk, and whether it is full",
    "readonly": "make the folder writable, or choose another 'folder'",
    "read-only": "make the folder writable, or choose another 'folder'",
    "permission": "make the folder writable, or choose another 'folder'",
    "locked": "close the other program that uses the file",
}
_OTHERWISE = "check the disk, or choose another 'folder'"


def problem_text(path: Path, error: Exception) -> str:
    """One sentence: the file, the problem, the remedy."""
    if isinstance(error, (FolderInUseError, JournalError)):
        return str(error)
    text = " ".join(str(error).split())
    advice = next((do for key, do in _ADVICE.items() if key in text.lower()), _OTHERWISE)
    return f"{path}: cannot be written ({text}); {advice}"


RETRY_S = 3.0
"""Period of retries. Chosen, not swept; a full disk is no matter of seconds."""


class Problems:
    """Problems by kind, as `journal` or `snapshot`.

    Attributes:
        current: The sentence of each current problem, by kind.
        last: The latest problem, empty for none.
    """

    def __init__(self, log: Log, note_event: Callable[[str, str], None]) -> None:
        """Begin without problems.

        Args:
            log: Writes a log line.
            note_event: Takes kind and text of an event for the journal.
        """
        self.log = log
        self._note_event = note_event
        self._retry_s: dict[str, float] = {}
        self.current: dict[str, str] = {}
        self.last = ""

    @property
    def text(self) -> str:
        """All current problems."""
        return "; ".join(self.current.values())

    def set(self, kind: str, text: str) -> None:
        """Begin a problem; logged if it is new."""
        self._retry_s[kind] = time.monotonic() + RETRY_S
        if kind not in self.current:
            self.note(text)
        self.current[kind] = self.last = text

    def note(self, text: str) -> None:
        """Log a problem that is over."""
        self.last = text
        self.log("error", text)
        self._note_event("problem", text)

    def clear(self, kind: str) -> None:
        """End a problem; logged if there was one."""
        before = self.current.pop(kind, None)
        self._retry_s.pop(kind, None)
        if before is not None:
            text = f"{kind}: works again after: {before}"
            self.log("info", text)
            self._note_event("recovered", text)

    def may_retry(self, kind: str) -> bool:
        """Whether the last attempt is long enough ago."""
        return time.monotonic() >= self._retry_s.get(kind, 0.0)
