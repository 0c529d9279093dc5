# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Colours and the look that all figures share."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import Any, TypeAlias

import numpy as np
import plotly.graph_objects as go

from hijack_detect.analysis.analyse import Analysed
from hijack_detect.analysis.report.curves import SCORE, THRESHOLD, Curve, lonely, thinned
from hijack_detect.analysis.report.recording import Recording
from hijack_detect.detectors.verdict import State

STATE_COLOURS = {
    State.NOT_READY: "#c3c9d1",
    State.NOT_OBSERVABLE: "#8fa9c4",
    State.NORMAL: "#2f9e6e",
    State.SUSPICIOUS: "#f0a30a",
    State.ALARM: "#d7263d",
    State.STALE: "#8e5ea2",
}
ATTACK, ALERT = "#7c3aed", "#d7263d"
ATTACK_BAND, ALARM_BAND = "rgba(124,58,237,0.09)", "rgba(215,38,61,0.16)"
BLUE, ORANGE, TEAL, GREY, INK = "#2563eb", "#e0700a", "#0d9488", "#9aa4b2", "#1f2933"
GRID, LINE = "#e6eaef", "#c3c9d1"
PURPLE, GREEN, PINK, GOLD, BROWN = "#9333ea", "#65a30d", "#be185d", "#ca8a04", "#7c4a2d"
DETECTOR_COLOURS = (BLUE, ORANGE, TEAL, PURPLE, GREEN, PINK, GOLD, BROWN)
FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', sans-serif"
LEFT_PX = 82
"""Left margin of every figure over time, so that their axes lie under each other."""


@dataclass(frozen=True)
class Panel:
    """One figure with its heading.

    `note` describes the figure in a sentence or two. `timed` figures share their time axis. The
    alarms of `detectors` are shaded.
    """

    name: str
    title: str
    note: str
    figure: Any
    timed: bool = True
    detectors: tuple[str, ...] = ()


def blank(height: int) -> Any:
    """An empty figure with the common look; `height` in pixels."""
    figure = go.Figure()
    figure.update_layout(
        template="none",
        height=height,
        margin={"l": LEFT_PX, "r": 14, "t": 30, "b": 26},
        font={"family": FONT, "size": 12, "color": INK},
        paper_bgcolor="rgba(0,0,0,0)",
        plot_bgcolor="rgba(0,0,0,0)",
        modebar={"bgcolor": "rgba(0,0,0,0)", "color": LINE, "activecolor": INK},
        hoverlabel={"bgcolor": "white", "font": {"family": FONT, "size": 12}},
        legend={"orientation": "h", "x": 0, "xanchor": "left", "y": 1.02, "yanchor": "bottom"},
    )
    axis = {"gridcolor": GRID, "linecolor": LINE, "zeroline": False, "showline": True}
    figure.update_xaxes(**axis, ticks="outside", tickcolor=LINE, title_standoff=6)
    figure.update_yaxes(**axis)
    return figure


def over_time(duration_s: float, height: int = 250) -> Any:
    """An empty figure over the time of the flight."""
    figure = blank(height)
    figure.update_layout(hovermode="x unified")
    figure.update_xaxes(range=[0.0, duration_s], hoverformat=".1f", ticksuffix=" s")
    return figure


def add_curve(figure: Any, curve: Curve, name: str, colour: str, unit: str, **line: Any) -> None:
    """Draw a curve, thinned to what a screen can show."""
    few = thinned(curve)
    figure.add_scatter(
        x=few.time_s,
        y=few.value,
        name=name,
        mode="lines",
        line={"color": colour, "width": 1.6, **line},
        hovertemplate=f"%{{y:.4~g}}{unit}",
    )
    alone = lonely(few)
    if len(alone.time_s):
        figure.add_scatter(
            x=alone.time_s,
            y=alone.value,
            mode="markers",
            marker={"color": colour, "size": 3},
            hoverinfo="skip",
            showlegend=False,
        )


def add_limit(figure: Any, value: float, text: str, *, below: bool = False) -> None:
    """Draw a threshold with its name at the left end, above or below it.

    The type of the y axis must be set before.
    """
    figure.add_hline(y=value, line={"color": ALERT, "width": 1.2, "dash": "dash"})
    logarithmic = figure.layout.yaxis.type == "log"
    figure.add_annotation(
        text=text,
        font={"color": ALERT, "size": 11},
        bgcolor="rgba(255,255,255,0.75)",
        xref="paper",
        x=0.005,
        xanchor="left",
        y=math.log10(value) if logarithmic else value,
        yanchor="top" if below else "bottom",
        showarrow=False,
    )


def add_bands(figure: Any, bands: Sequence[tuple[float, float]], colour: str) -> None:
    """Shade times (s) behind the curves, over the whole height."""
    figure.update_layout(
        shapes=[
            *figure.layout.shapes,
            *(
                {
                    "type": "rect",
                    "xref": "x",
                    "yref": "paper",
                    "x0": start,
                    "x1": end,
                    "y0": 0,
                    "y1": 1,
                    "fillcolor": colour,
                    "line": {"width": 0},
                    "layer": "below",
                }
                for start, end in bands
            ),
        ]
    )


def add_alert(figure: Any, start: float) -> None:
    """Mark the start of an alert (s)."""
    figure.add_vline(x=start, line={"color": ALERT, "width": 1.6})


def say_if_empty(figure: Any) -> None:
    """Write into a figure without any value that there is none."""
    if all(np.isnan(np.asarray(trace.y, dtype=float)).all() for trace in figure.data):
        figure.add_annotation(
            text="no values: not observable in this flight",
            font={"color": GREY, "size": 13},
            bgcolor="white",
            xref="paper",
            yref="paper",
            x=0.5,
            y=0.5,
            showarrow=False,
        )


MakePanel: TypeAlias = Callable[[Analysed, Recording, str], Panel]
"""Makes a figure of a detector, by its name."""
MOST_LINEAR = 4.0
"""Larger margins are drawn on a logarithmic axis, so that 1 stays visible."""
LIMIT_LINE = {"dash": "dash", "width": 1.2}
LOWEST = 0.01
"""Begin of a logarithmic axis."""


def against_thresholds(
    done: Analysed, curves: Mapping[str, Curve], height: int
) -> tuple[go.Figure, str]:
    """Curves of which 1 is the limit, and what to add to the title if the axis is logarithmic."""
    highest = max(float(np.nanmax(curve.value, initial=0.0)) for curve in curves.values())
    figure = over_time(done.analysis.duration_s, height)
    logarithmic = highest > MOST_LINEAR
    if logarithmic:
        most = math.log10(1.3 * highest)
        figure.update_yaxes(type="log", dtick=1, range=[math.log10(LOWEST), most])
    else:
        figure.update_yaxes(range=[0.0, max(1.5, 1.1 * highest)])
    for colour, (name, curve) in zip(cycle(DETECTOR_COLOURS), curves.items(), strict=False):
        low = LOWEST if logarithmic else 0.0
        shown = Curve(curve.time_s, np.maximum(curve.value, low))
        add_curve(figure, shown, name, colour, "")
    add_limit(figure, 1.0, "threshold")
    return figure, ", logarithmic" if logarithmic else ""


def add_limit_in_force(figure: Any, recorded: Recording, detector: str, unit: str) -> None:
    """Draw the threshold of each verdict: it follows noise and weather."""
    curve = recorded.curve(detector, THRESHOLD)
    add_curve(figure, curve, "limit", ALERT, unit, **LIMIT_LINE)


def score_panel(done: Analysed, recorded: Recording, name: str) -> Panel:
    """Score of a detector, and the limit in force."""
    figure = over_time(done.analysis.duration_s, 220)
    add_curve(figure, recorded.curve(name, SCORE), "score", BLUE, "")
    add_limit_in_force(figure, recorded, name, "")
    figure.update_yaxes(rangemode="tozero")
    note = next(part.question for part in done.parameters.parts if part.name == name)
    return Panel(name, f"{name}: score and limit", note, figure)
