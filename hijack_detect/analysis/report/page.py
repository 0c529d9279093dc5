# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Writes the page: one HTML file with everything in it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from html import escape
from pathlib import Path

from plotly.offline import get_plotlyjs

from hijack_detect import __version__
from hijack_detect.analysis.analyse import Analysed
from hijack_detect.analysis.report import consistency, methods, tables
from hijack_detect.analysis.report.events import events
from hijack_detect.analysis.report.flight import (
    WORDS,
    alert_bands,
    attack_bands,
    deviation_panel,
    quality_panels,
    states_panel,
    track_panel,
)
from hijack_detect.analysis.report.recording import Recording
from hijack_detect.analysis.report.style import (
    ALARM_BAND,
    ATTACK_BAND,
    Panel,
    add_alert,
    add_bands,
    say_if_empty,
)
from hijack_detect.analysis.report.template import CSS, PAGE, SCRIPT
from hijack_detect.analysis.report.verdict_curves import score_panel
from hijack_detect.analysis.sentence import CLEAN, OPEN, SPOOFED, found
from hijack_detect.detectors.verdict import State

MOST_EVENTS = 200
CONFIG = {
    "responsive": True,
    "displaylogo": False,
    "modeBarButtonsToRemove": ["select2d", "lasso2d", "autoScale2d"],
}
"""How plotly.js shows each figure."""
EVENTS_NOTE = "Attack and alert, and each time that a detector was suspicious, alarmed or silent."
FOOTER = (
    "Made by hijack-detect {version}, policy {policy}. Times are seconds from the bag's first "
    "message. No alert is no proof that the GPS was honest: see what each detector cannot see."
)
MOODS = {SPOOFED: "bad", CLEAN: "good", OPEN: "open"}


def write_page(folder: Path, done: Analysed, recorded: Recording) -> Path:
    """Write `index.html` into a folder and return its path.

    Raises:
        OSError: It cannot be written.
    """
    panels = [panel for panel in _panels(done, recorded) if panel is not None]
    for panel in panels:
        if panel.timed and panel.name != "states":
            _shade(panel, done)
            say_if_empty(panel.figure)
    path = folder / "index.html"
    path.write_text(page(done, panels), encoding="utf-8")
    return path


def page(done: Analysed, panels: Sequence[Panel]) -> str:
    """The text of the page; the first panel is the map."""
    analysis = done.analysis
    rows = events(done)
    left = f" The first {MOST_EVENTS} of {len(rows)}." if len(rows) > MOST_EVENTS else ""
    return PAGE.substitute(
        title=escape(Path(analysis.bag).resolve().name),
        css=CSS,
        plotly=get_plotlyjs(),
        mood=MOODS[found(analysis)],
        found=found(analysis),
        verdict=escape(analysis.verdict),
        causes="\n".join(tables.causes(analysis)),
        facts="\n".join(tables.facts(analysis)),
        track=_section(panels[0]),
        key="".join(tables.key(done)),
        figures="\n".join(map(_section, panels[1:])),
        events="\n".join(tables.event_rows(rows[:MOST_EVENTS])),
        events_note=EVENTS_NOTE + left,
        states="".join(f'<th class="n">{WORDS[state]}</th>' for state in State),
        detectors="\n".join(tables.detector_rows(analysis)),
        skipped="\n".join(tables.skipped_rows(analysis)),
        notes="\n".join(tables.notes(analysis)),
        noted="" if analysis.notes else " hidden",
        clean="" if analysis.skipped else " hidden",
        footer=FOOTER.format(version=__version__, policy=escape(analysis.policy)),
        script=SCRIPT.replace("DURATION", f"{analysis.duration_s:.3f}"),
    )


def _panels(done: Analysed, recorded: Recording) -> Iterator[Panel | None]:
    yield track_panel(done, recorded)
    yield states_panel(done)
    yield methods.margins_panel(done, recorded)
    yield deviation_panel(done)
    for name in done.analysis.detectors:
        for make in {**methods.PANELS, **consistency.PANELS}.get(name, (score_panel,)):
            yield replace(make(done, recorded, name), detectors=(name,))
    yield from quality_panels(done, recorded)


def _shade(panel: Panel, done: Analysed) -> None:
    """Attack and alarms behind the curves, and the alert as a line."""
    add_bands(panel.figure, attack_bands(done), ATTACK_BAND)
    said = done.analysis.detectors
    for name in panel.detectors:
        bands = [(one.start_s, one.end_s) for one in said[name].alarms]
        add_bands(panel.figure, bands, ALARM_BAND)
    for start, _ in alert_bands(done):
        add_alert(panel.figure, start)


def _section(panel: Panel) -> str:
    """A figure under its heading."""
    figure = panel.figure.to_html(
        full_html=False,
        include_plotlyjs=False,
        div_id=f"plot-{panel.name}",
        default_height=f"{panel.figure.layout.height}px",
        config=CONFIG,
    )
    timed = ' class="timed"' if panel.timed else ""
    return (
        f'<section id="{panel.name}"{timed}>\n<h2>{escape(panel.title)}</h2>\n'
        f'<p class="soft">{escape(panel.note)}</p>\n{figure}\n</section>'
    )
