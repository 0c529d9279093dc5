# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A progress bar for a node's terminal."""

from __future__ import annotations

import sys

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn


class ProgressBar:
    """Draws on stderr; does nothing if that is no terminal."""

    def __init__(self, total: float, unit: str, *, wanted: bool = True) -> None:
        """Start a bar that is full at `total`."""
        self._bar: Progress | None = None
        if wanted and sys.stderr.isatty():
            self._bar = Progress(
                BarColumn(),
                TextColumn(f"{{task.completed:.1f}} of {{task.total:.1f}} {unit}"),
                TextColumn("{task.description}"),
                console=Console(stderr=True),
                auto_refresh=False,
            )
            self._task = self._bar.add_task("", total=total)
            self._bar.start()

    def show(self, done: float, text: str) -> None:
        """Draw it."""
        if self._bar is not None:
            self._bar.update(self._task, completed=done, description=text)
            self._bar.refresh()

    def stop(self) -> None:
        """Leave the terminal as it was."""
        if self._bar is not None:
            self._bar.stop()
