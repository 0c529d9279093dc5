# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What to do about a disk that does not take what is written."""

from __future__ import annotations

from pathlib import Path

from hijack_detect.recording.folder_lock import FolderInUseError
from hijack_detect.recording.journal import JournalError

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


def told(path: Path, error: Exception) -> str:
    """One sentence: which file, what is wrong, what to do."""
    if isinstance(error, (FolderInUseError, JournalError)):
        return str(error)
    text = " ".join(str(error).split())
    advice = next((say for key, say in _ADVICE.items() if key in text.lower()), _OTHERWISE)
    return f"{path}: cannot be written ({text}); {advice}"
