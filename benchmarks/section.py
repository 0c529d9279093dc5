# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""One part of the benchmark: its figures, and the ratios that must not grow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from rich.table import Table


@dataclass(frozen=True)
class Section:
    """What was measured.

    Attributes:
        ratios: By name, to something that was measured in the same run on the same machine.
        figures: Everything that was measured.
        table: The same for the eye.
        remarks: Lines below the table.
    """

    ratios: dict[str, float]
    figures: dict[str, Any]
    table: Table
    remarks: tuple[str, ...] = ()
