# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What `hijack-detect analyze` shows on a terminal: one sentence, then a small table."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table
from rich.text import Text

from hijack_detect.detectors.verdict import JUDGED
from hijack_detect.evaluation.analysis.analysis import Analysis, DetectorAnalysis, Outcome

STYLES = {
    Outcome.DETECTED: "bold green",
    Outcome.NO_ATTACK_NO_ALERT: "bold green",
    Outcome.NO_ALERT_UNLABELLED: "bold green",
}
"""All others are what a person has to look at."""


def summary(analysis: Analysis) -> None:
    """Print the verdict, what each detector said, and what was left out."""
    console = Console()
    console.print(Text(analysis.verdict, STYLES.get(analysis.outcome, "bold red")))
    for alert in analysis.alerts:
        console.print(Text(f"Cause: {alert.cause}"))
    table = Table(title_justify="left")
    table.add_column("detector")
    for column in ("could tell", "alarms", "first alarm", "largest margin", "at"):
        table.add_column(column, justify="right")
    for name, said in analysis.detectors.items():
        table.add_row(name, *_cells(said))
    console.print(table)
    bag = f"{analysis.bag}, {analysis.duration_s:.0f} s, policy {analysis.policy}"
    console.print(Text(f"{bag}. A margin above 1 is over the threshold."), style="dim")
    for reason, number in analysis.skipped.items():
        console.print(Text(f"{number} messages left out: {reason}", "yellow"))


def _cells(said: DetectorAnalysis) -> tuple[str, ...]:
    told = sum(said.state_s[state] for state in JUDGED)
    whole = sum(said.state_s.values())
    first = f"{said.alarms[0].start_s:.1f} s" if said.alarms else "–"
    peak = said.largest_margin
    margin = ("–", "–") if peak is None else (f"{peak.margin:.2f}", f"{peak.at_s:.1f} s")
    part = f"{100.0 * told / whole:.0f} %" if whole > 0.0 else "–"
    return part, str(len(said.alarms)), first, *margin
