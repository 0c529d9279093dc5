# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""How bad something is, in the words of the parts without ROS."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

Level = Literal["info", "warning", "error"]
Tell = Callable[[Level, str], None]
"""Writes a line into a log."""
