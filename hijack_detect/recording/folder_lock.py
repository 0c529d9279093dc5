# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""One recorder for one folder."""

from __future__ import annotations

import fcntl
from pathlib import Path
from typing import IO

LOCK = "recorder.lock"


class FolderInUseError(OSError):
    """Another recorder writes into the folder."""


class FolderLock:
    """A lock that the system takes back when the process ends, however it ends."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._file: IO[str] | None = None

    @property
    def held(self) -> bool:
        """Whether the folder is ours."""
        return self._file is not None

    def acquire(self) -> None:
        """Make the folder and lock it; nothing happens if it is locked by us.

        Raises:
            FolderInUseError: Another recorder has it.
            OSError: It cannot be made or written.
        """
        if self._file is not None:
            return
        self._folder.mkdir(parents=True, exist_ok=True)
        file = (self._folder / LOCK).open("a")
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            file.close()
            raise FolderInUseError(
                f"{self._folder}: another recorder writes here; give each one a 'folder' of its own"
            ) from error
        except OSError:
            file.close()
            raise
        self._file = file

    def release(self) -> None:
        """Give the folder back."""
        if self._file is not None:
            self._file.close()
            self._file = None
