# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Writes the page: one HTML file with everything in it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from html import escape
from pathlib import Path
from string import Template

from plotly.offline import get_plotlyjs

from hijack_detect import __version__
from hijack_detect.analysis.analyse import CLEAN, OPEN, SPOOFED, Analysed, found
from hijack_detect.analysis.report import methods, tables
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
    score_panel,
)
from hijack_detect.analysis.report.tables import events
from hijack_detect.detectors.verdict import State

CSS = """
:root { --ink: #1f2933; --soft: #5b6776; --line: #e1e6ec; --ground: #f5f7f9; }
* { box-sizing: border-box; }
body { margin: 0; background: var(--ground); color: var(--ink);
  font: 15px/1.5 system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', sans-serif; }
main { max-width: 1180px; margin: 0 auto; padding: 28px 20px 48px; }
h1 { font-size: 24px; line-height: 1.25; margin: 0 0 4px; }
h1, dd { overflow-wrap: anywhere; }
h2 { font-size: 17px; margin: 0 0 2px; }
p { margin: 0; }
.soft { color: var(--soft); font-size: 13px; }
section { background: white; border: 1px solid var(--line); border-radius: 10px;
  padding: 16px 18px; margin-top: 16px; }
#verdict { border-left: 6px solid var(--mark); }
#verdict p { font-size: 19px; font-weight: 600; line-height: 1.4; }
#verdict p.cause { font-size: 16px; font-weight: 500; margin-top: 8px; overflow-wrap: anywhere; }
#verdict .found { background: var(--mark); color: white; border-radius: 5px; font-size: 13px;
  padding: 2px 9px; margin-right: 10px; vertical-align: 2px; white-space: nowrap; }
#verdict ul { margin: 14px 0 0; padding-left: 18px; }
.good { --mark: #1f7f56; } .bad { --mark: #d7263d; } .open { --mark: #a86a00; }
dl { display: grid; grid-template-columns: repeat(auto-fit, minmax(150px, 1fr)); gap: 10px 20px;
  margin: 14px 0 0; }
dt { color: var(--soft); font-size: 12px; } dd { margin: 0; font-weight: 600; }
.key { display: flex; flex-wrap: wrap; gap: 4px 18px; margin-top: 16px; }
.key i { display: inline-block; width: 22px; height: 12px; margin-right: 6px; border-radius: 2px;
  vertical-align: -1px; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; margin-top: 10px; font-size: 14px; }
th { text-align: left; color: var(--soft); font-size: 12px; font-weight: 600; }
th, td { padding: 6px 14px 6px 0; border-bottom: 1px solid var(--line); vertical-align: top; }
.n { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; width: 1%; }
td:last-child { min-width: 170px; }
.dot::before { content: ''; display: inline-block; width: 9px; height: 9px; border-radius: 50%;
  background: var(--dot, #c3c9d1); margin-right: 8px; }
tr.alert td { font-weight: 600; color: #b01c30; }
@media (max-width: 600px), (pointer: coarse) { .modebar { display: none; } }
@media (max-width: 600px) {
  main { padding: 16px 8px 32px; } section { padding: 12px 10px; border-radius: 8px; }
  h1 { font-size: 20px; } #verdict p { font-size: 17px; }
  dl { grid-template-columns: 1fr 1fr; } td, th { padding-right: 8px; }
}
"""

SCRIPT = """
const timed = [...document.querySelectorAll('.timed .plotly-graph-div')];
const touch = matchMedia('(pointer: coarse)').matches;
let following = false;
for (const plot of timed) plot.on('plotly_relayout', change => {
  const range = change['xaxis.range'] || [change['xaxis.range[0]'], change['xaxis.range[1]']];
  const home = change['xaxis.autorange'];
  if (following || !(home || range[0] !== undefined)) return;
  following = true;
  const update = {'xaxis.range': home ? [0, DURATION] : range, 'xaxis.autorange': false};
  Promise.all(timed.map(other => other === plot && !home ? null : Plotly.relayout(other, update)))
    .finally(() => { following = false; });
});
if (touch) for (const plot of document.querySelectorAll('.plotly-graph-div'))
  Plotly.relayout(plot, {dragmode: false});
"""

PAGE = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<link rel="icon" href="data:,">
<title>$title</title>
<style>$css</style>
<script>$plotly</script>
</head>
<body>
<main>
<p class="soft">GPS spoofing analysis</p>
<h1>$title</h1>
<section id="verdict" class="$mood">
<p><span class="found">$found</span><span class="said">$verdict</span></p>
$causes
<dl>$facts</dl>
<ul class="soft"$noted>$notes</ul>
</section>
$track
<div class="key soft">$key</div>
$figures
<section id="events">
<h2>Events</h2>
<p class="soft">$events_note</p>
<div class="wide"><table>
<thead><tr><th class="n">second</th><th>what</th><th>why</th></tr></thead>
<tbody>$events</tbody>
</table></div>
</section>
<section id="detectors">
<h2>Detectors</h2>
<p class="soft">Could tell: share of the time in the air. Then the share of the whole log in each
state; only normal, suspicious and alarm judge the GPS.</p>
<div class="wide"><table>
<thead><tr><th>detector</th><th class="n">could tell</th>$states
<th class="n">largest margin</th><th>reason then</th></tr></thead>
<tbody>$detectors</tbody>
</table></div>
</section>
<section id="skipped"$clean>
<h2>Messages left out</h2>
<table>
<thead><tr><th class="n">number</th><th>reason</th></tr></thead>
<tbody>$skipped</tbody>
</table>
</section>
<p class="soft" style="margin-top: 18px">$footer</p>
</main>
<script>$script</script>
</body>
</html>
""")


MOST_EVENTS = 200
"""Rows of a table. Chosen, not swept."""
CONFIG = {
    "responsive": True,
    "displaylogo": False,
    "modeBarButtonsToRemove": ["select2d", "lasso2d", "autoScale2d"],
}
"""Configuration of plotly.js for each figure."""
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
        for make in methods.PANELS.get(name, (score_panel,)):
            yield replace(make(done, recorded, name), detectors=(name,))
    yield from quality_panels(done, recorded)


def _shade(panel: Panel, done: Analysed) -> None:
    """Attack and alarms behind the curves, and the alert as a line."""
    add_bands(panel.figure, attack_bands(done), ATTACK_BAND)
    detectors = done.analysis.detectors
    for name in panel.detectors:
        bands = [(one.start_s, one.end_s) for one in detectors[name].alarms]
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
