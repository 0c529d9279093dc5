# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Output of `hijack-detect analyze` on a terminal: one sentence, then a small table."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table
from rich.text import Text

from hijack_detect.analysis.analyse import (
    CLEAN,
    OPEN,
    SPOOFED,
    duration,
    found,
    percent,
)
from hijack_detect.analysis.analysis import Analysis, DetectorAnalysis

STYLES = {SPOOFED: "bold red", CLEAN: "bold green", OPEN: "bold yellow"}
MOST_TIMES = 8
"""Repeated alarms that are listed."""


def summary(analysis: Analysis) -> None:
    """Print the verdict with its cause, what each detector could tell, and what was left out."""
    console = Console()
    console.print(Text(analysis.verdict, STYLES[found(analysis)]))
    for alert in analysis.alerts:
        console.print(Text(f"Cause: {alert.cause}", "bold"))
    again = analysis.alarms[1:]
    if again:
        times = ", ".join(f"{one.start_s:.1f} s" for one in again[:MOST_TIMES])
        more = f" and {len(again) - MOST_TIMES} times more" if len(again) > MOST_TIMES else ""
        console.print(Text(f"Taken back each time, it would have come again at {times}{more}."))
    for note in analysis.notes:
        console.print(Text(note, "yellow"))
    table = Table(title_justify="left")
    table.add_column("detector")
    for column in ("could tell", "alarms", "first alarm", "largest margin", "at"):
        table.add_column(column, justify="right")
    for name, one in analysis.detectors.items():
        table.add_row(name, *_cells(one, analysis.in_air_s))
    console.print(table)
    lasted = f"{duration(analysis.duration_s)}, {duration(analysis.in_air_s)} in the air"
    bag = f"{analysis.bag}: {lasted}, policy {analysis.policy}"
    explained = "Could tell: share of the time in the air. A margin above 1 is over the threshold."
    console.print(Text(f"{bag}. {explained}"), style="dim")
    for reason, number in analysis.skipped.items():
        console.print(Text(f"{number} messages left out: {reason}", "yellow"))


def _cells(one: DetectorAnalysis, in_air_s: float) -> tuple[str, ...]:
    first = f"{one.alarms[0].start_s:.1f} s" if one.alarms else "–"
    peak = one.largest_margin
    margin = ("–", "–") if peak is None else (f"{peak.margin:.2f}", f"{peak.at_s:.1f} s")
    part = f"{percent(one.told_s, in_air_s):.0f} %" if in_air_s > 0.0 else "–"
    return part, str(len(one.alarms)), first, *margin
