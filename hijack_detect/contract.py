# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Timing contract of hijack_alert, and the type of a function that writes a log line."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

Level = Literal["info", "warning", "error"]
Log = Callable[[Level, str], None]
"""Writes a log line."""


REPEAT_S = 1.0
"""Period of its repetition, by a steady clock. Chosen, not swept."""
SILENT_S = 2.5
"""Silence after which the monitor is dead, or hangs. Chosen: two repetitions are missing."""
START_S = 30.0
"""Longest start of the monitor. Chosen, not swept."""
