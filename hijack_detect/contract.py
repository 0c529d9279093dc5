# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Timing contract of hijack_alert, and what writes a line into a log."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

Level = Literal["info", "warning", "error"]
Tell = Callable[[Level, str], None]
"""Writes a line into a log."""


REPEAT_S = 1.0
"""It is repeated this often, by a clock that nobody sets."""
SILENT_S = 2.5
"""Two repetitions are missing: the monitor is dead, or hangs."""
START_S = 30.0
"""The monitor may take so long to start."""
