# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The figures of the flight: map, states over time, distance from the truth, GPS quality."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hijack_detect.analysis.account import MONITOR
from hijack_detect.analysis.alarms import Span
from hijack_detect.analysis.analyse import Analysed
from hijack_detect.analysis.report.curves import Array, Curve
from hijack_detect.analysis.report.recording import Recording, Track
from hijack_detect.analysis.report.style import (
    ALERT,
    ATTACK,
    BLUE,
    GREY,
    INK,
    STATE_COLOURS,
    TEAL,
    Panel,
    add_curve,
    add_limit,
    blank,
    over_time,
)
from hijack_detect.detectors.verdict import State
from hijack_detect.estimation.course import CourseParameters

MOST_PLACES = 4000
"""Points of a track."""
WORDS = {state: state.value.replace("_", " ") for state in State}


def track_panel(done: Analysed, recorded: Recording) -> Panel:
    """The map: the reported track coloured by the monitor's state, and the true one."""
    figure = blank(560)
    track, spans = _fewer(recorded.reported), done.spans[MONITOR]
    true = None if recorded.true is None else _fewer(recorded.true)
    if true is not None:
        figure.add_scatter(
            x=true.east_m,
            y=true.north_m,
            name="true track",
            mode="lines",
            line={"color": INK, "width": 1.4, "dash": "dot"},
            customdata=true.time_s,
            hovertemplate="true position at %{customdata:.1f} s<extra></extra>",
        )
    states = _states_at(track.time_s, spans, done)
    for state in State:
        mine = states == list(State).index(state)
        if mine.any():
            drawn = mine | np.roll(mine, 1) & (np.arange(len(mine)) > 0)
            figure.add_scatter(
                x=np.where(drawn, track.east_m, np.nan),
                y=np.where(drawn, track.north_m, np.nan),
                name=WORDS[state],
                mode="lines",
                line={"color": STATE_COLOURS[state], "width": 3},
                customdata=track.time_s,
                hovertemplate=f"reported at %{{customdata:.1f}} s: {WORDS[state]}<extra></extra>",
            )
    for name, time_s, symbol, colour in _marks(done):
        if len(track.time_s):
            at = min(int(np.searchsorted(track.time_s, time_s)), len(track.time_s) - 1)
            figure.add_scatter(
                x=track.east_m[at : at + 1],
                y=track.north_m[at : at + 1],
                name=name,
                mode="markers",
                marker={
                    "symbol": symbol,
                    "size": 13,
                    "color": colour,
                    "line": {"color": "white", "width": 1.5},
                },
                hovertemplate=f"{name} at {time_s:.1f} s<extra></extra>",
            )
    figure.update_layout(hovermode="closest", margin={"b": 44})
    tracks = [track] if true is None else [track, true]
    east = _extent(np.concatenate([one.east_m for one in tracks]))
    north = _extent(np.concatenate([one.north_m for one in tracks]))
    figure.update_xaxes(title="East (m)", range=east)
    figure.update_yaxes(title="North (m)", range=north, scaleanchor="x")
    note = "Metres from the first fix. The reported track is coloured by the state of the monitor."
    if true is None:
        note += " Where the vehicle really was is not known."
    return Panel("track", "Track", note, figure, timed=False)


def _marks(done: Analysed) -> Iterator[tuple[str, float, str, str]]:
    yield "start", 0.0, "circle", GREY
    if done.analysis.spoof is not None:
        yield "attack begins", done.analysis.spoof.onset_s, "diamond", ATTACK
    for alert in done.analysis.alerts[:1]:
        yield "alert", alert.start_s, "star", ALERT


def _states_at(time_s: Array, spans: list[Span], done: Analysed) -> Array:
    """Number of the monitor's state at each time."""
    starts = np.array([done.seconds(span.start_ns) for span in spans])
    numbers = np.array([list(State).index(span.state) for span in spans], dtype=float)
    if not len(starts):
        return np.zeros(len(time_s))
    found: Array = numbers[np.maximum(np.searchsorted(starts, time_s, side="right") - 1, 0)]
    return found


def _extent(metres: Array) -> list[float]:
    """Smallest and largest, with some air, and no closer than 10 m."""
    low, high = float(metres.min(initial=0.0)), float(metres.max(initial=0.0))
    air = max(0.05 * (high - low), 5.0)
    return [low - air, high + air]


def _fewer(track: Track) -> Track:
    step = -(-len(track.time_s) // MOST_PLACES) or 1
    return Track(track.time_s[::step], track.east_m[::step], track.north_m[::step])


def states_panel(done: Analysed) -> Panel:
    """One row each for attack, alert, monitor and detectors, coloured by state."""
    rows = [*(("attack",) if done.attack else ()), "alert", *done.spans]
    figure = over_time(done.analysis.duration_s, 70 + 30 * len(rows))
    for state in State:
        bars = [
            (row, span)
            for row, spans in done.spans.items()
            for span in spans
            if span.state is state
        ]
        if bars:
            figure.add_bar(
                orientation="h",
                name=WORDS[state],
                y=[row for row, _ in bars],
                base=[done.seconds(span.start_ns) for _, span in bars],
                x=[span.seconds for _, span in bars],
                marker={"color": STATE_COLOURS[state], "line": {"width": 0}},
                customdata=[(f"{span.seconds:.1f} s", span.reason) for _, span in bars],
                hovertemplate="%{y}: " + WORDS[state] + " from %{base:.1f} s for %{customdata[0]}"
                "<br>%{customdata[1]}<extra></extra>",
            )
    for row, colour, bands in (
        ("attack", ATTACK, attack_bands(done)),
        ("alert", ALERT, alert_bands(done)),
    ):
        figure.add_bar(
            orientation="h",
            y=[row] * len(bands),
            base=[start for start, _ in bands],
            x=[end - start for start, end in bands],
            marker={"color": colour, "line": {"width": 0}},
            hovertemplate=row + " from %{base:.1f} s<extra></extra>",
            showlegend=False,
        )
    figure.update_layout(barmode="overlay", bargap=0.25, hovermode="closest")
    figure.update_yaxes(
        categoryorder="array", categoryarray=rows, range=[len(rows) - 0.5, -0.5], showgrid=False
    )
    note = (
        "Point at a bar for its reason. Drag over a figure to zoom into all of them, double-click "
        "to go back."
    )
    return Panel("states", "States over time", note, figure)


def attack_bands(done: Analysed) -> list[tuple[float, float]]:
    """The attack as start and end, s."""
    spoof, end = done.analysis.spoof, done.analysis.duration_s
    return [] if spoof is None else [(spoof.onset_s, end if spoof.end_s is None else spoof.end_s)]


def alert_bands(done: Analysed) -> list[tuple[float, float]]:
    """All alerts as start and end, s."""
    return [(alert.start_s, alert.end_s) for alert in done.analysis.alerts]


def deviation_panel(done: Analysed) -> Panel | None:
    """Distance between reported and true position, where that is known."""
    pairs = done.flight.separations
    if not pairs:
        return None
    figure = over_time(done.analysis.duration_s, 200)
    curve = Curve(
        np.array([done.seconds(stamp_ns) for stamp_ns, _ in pairs]),
        np.array([metres for _, metres in pairs]),
    )
    add_curve(figure, curve, "reported off by", INK, " m")
    figure.update_yaxes(rangemode="tozero")
    figure.update_layout(showlegend=False)
    note = "How far the reported position was from the true one."
    return Panel("deviation", "Distance between reported and true position (m)", note, figure)


def quality_panels(done: Analysed, recorded: Recording) -> Iterator[Panel]:
    """Quality figures of the receiver."""
    duration_s = done.analysis.duration_s
    figure = over_time(duration_s, 200)
    add_curve(figure, recorded.speed, "speed", BLUE, " m/s")
    slowest = done.parameters.of(CourseParameters).min_speed
    add_limit(figure, slowest, "no course below", below=False)
    figure.update_yaxes(rangemode="tozero")
    figure.update_layout(showlegend=False)
    yield Panel("speed", "GPS: speed over ground (m/s)", "As reported.", figure)

    figure = over_time(duration_s, 200)
    add_curve(figure, recorded.interval, "since the fix before", TEAL, " s")
    lost = len(recorded.no_fix)
    if lost:
        figure.add_scatter(
            x=recorded.no_fix,
            y=np.zeros(lost),
            name="message without a fix",
            mode="markers",
            marker={"symbol": "x", "size": 7, "color": ALERT},
            hovertemplate="no fix<extra></extra>",
        )
    figure.update_yaxes(rangemode="tozero")
    figure.update_layout(showlegend=bool(lost))
    gap = float(recorded.interval.value.max(initial=0.0))
    note = f"Longest gap {gap:.2f} s; {lost} messages without a fix."
    yield Panel("interval", "GPS: time between fixes (s)", note, figure)

    receiver = (
        ("satellites", "GPS: satellites in use", recorded.satellites, ""),
        ("sigma", "GPS: reported horizontal accuracy, 1σ (m)", recorded.sigma, " m"),
    )
    for name, title, curve, unit in receiver:
        if len(curve.time_s):
            figure = over_time(duration_s, 180)
            add_curve(figure, curve, name, TEAL, unit, shape="hv")
            figure.update_yaxes(rangemode="tozero")
            figure.update_layout(showlegend=False)
            yield Panel(name, title, "As the receiver reports.", figure)
