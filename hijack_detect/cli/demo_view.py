# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Output of the demonstration: a few live lines, then the timeline."""

from __future__ import annotations

from collections.abc import Iterator

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from hijack_detect.cli.listener import Listener
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.replay.offline import OfflineRun
from hijack_detect.replay.truth import Attack, alert_is_right, detector_outcome
from hijack_detect.streams.samples import NANOSECONDS

STYLES = {
    State.NOT_READY: "dim",
    State.NOT_OBSERVABLE: "cyan",
    State.NORMAL: "green",
    State.SUSPICIOUS: "yellow",
    State.ALARM: "bold red",
    State.STALE: "magenta",
}


WORDS = {
    State.NOT_READY: "not ready",
    State.NOT_OBSERVABLE: "cannot tell",
    State.SUSPICIOUS: "{:.2f} susp.",
    State.ALARM: "{:.2f} alarm",
    State.STALE: "silent",
}
"""Words for a state, with the margin; normal is the margin alone."""


COLUMNS = 3
NAME_WIDTH, CELL_WIDTH = 11, 26
"""Cells of the live view: three side by side fit into 80 columns."""


def live_view(listener: Listener) -> Text:
    """Time, attack and alert, then state and margin of each detector, in a grid of cells."""
    head = Text(f"{listener.position_s:5.1f} s ")
    head.append(*(("SPOOFED", "red") if listener.spoofed else ("clean  ", "")))
    head.append(*((" ALERT", "bold white on red") if listener.alert else ("", "")))
    cells = [head]
    for name, verdicts in listener.verdicts.items():
        cell = Text(f"{name:<{NAME_WIDTH}} ")
        cells.append(cell.append(*_state(verdicts[-1] if verdicts else None)))
    for cell in cells:
        cell.truncate(CELL_WIDTH, pad=True)
    rows = [Text.assemble(*cells[at : at + COLUMNS]) for at in range(0, len(cells), COLUMNS)]
    return Text("\n", no_wrap=True, overflow="crop").join(rows)


def _state(verdict: Verdict | None) -> tuple[str, str]:
    if verdict is None:
        return "silent", "dim"
    return WORDS.get(verdict.state, "{:.2f}").format(verdict.margin), STYLES[verdict.state]


def timeline(listener: Listener, attack: Attack | None, run: OfflineRun) -> RenderableType:
    """Onset, first alarm of each detector, alert, and whether that was right."""
    table = Table(title="Timeline", title_justify="left")
    for column in ("second", "event", "after onset", "reported off by"):
        table.add_column(column, justify="left" if column == "event" else "right")
    for stamp_ns, event in sorted(_events(listener, attack)):
        after = "" if attack is None else f"{(stamp_ns - attack.onset_ns) / NANOSECONDS:+.1f} s"
        table.add_row(
            f"{(stamp_ns - run.start_ns) / NANOSECONDS:.1f}",
            event,
            after,
            f"{run.separation_at(stamp_ns):.1f} m",
        )
    return Group(table, _conclusion(listener, attack, run))


def _events(listener: Listener, attack: Attack | None) -> Iterator[tuple[int, str]]:
    if attack is not None:
        yield attack.onset_ns, "attack begins"
        if attack.end_ns is not None:
            yield attack.end_ns, "attack ends"
    for name, verdicts in listener.verdicts.items():
        outcome = detector_outcome(verdicts, attack)
        if outcome.first_alarm_ns is not None:
            yield outcome.first_alarm_ns, f"{name}: first alarm"
        early = [v for v in verdicts if v.state is State.ALARM]
        if outcome.false_alarms:
            yield early[0].stamp_ns, f"{name}: alarm without attack ({outcome.false_alarms}×)"
    if listener.alert_ns is not None:
        yield listener.alert_ns, "hijack_alert"


def _conclusion(listener: Listener, attack: Attack | None, run: OfflineRun) -> Text:
    right = alert_is_right(listener.alert_ns, attack)
    if listener.alert_ns is None:
        text = "No alert, and no attack." if right else "MISSED: the attack raised no alert."
    elif attack is not None and right:
        late = (listener.alert_ns - attack.onset_ns) / NANOSECONDS
        metres = run.separation_at(listener.alert_ns)
        text = (
            f"Detected {late:.1f} s after the onset, with the reported position {metres:.1f} m "
            f"from the true one.\nCause: {listener.cause}"
        )
    else:
        text = f"FALSE ALERT outside the attack.\nCause: {listener.cause}"
    return Text(text, "bold green" if right else "bold red")
