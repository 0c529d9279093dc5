# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Curves from verdicts."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from itertools import cycle
from typing import Any, TypeAlias

import numpy as np
import plotly.graph_objects as go

from hijack_detect.analysis.analyse import Analysed
from hijack_detect.analysis.report.curve import Curve
from hijack_detect.analysis.report.recording import Recording
from hijack_detect.analysis.report.style import (
    ALERT,
    BLUE,
    DETECTOR_COLOURS,
    Panel,
    add_curve,
    add_limit,
    over_time,
)
from hijack_detect.analysis.report.trace import SCORE, THRESHOLD

MakePanel: TypeAlias = Callable[[Analysed, Recording, str], Panel]
"""Makes a figure of a detector, by its name."""
MOST_LINEAR = 4.0
"""Larger margins are drawn on a logarithmic axis, so that 1 stays visible."""
LIMIT_LINE = {"dash": "dash", "width": 1.2}
LOWEST = 0.01
"""Where a logarithmic axis begins."""


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
    curve = recorded.said(detector, THRESHOLD)
    add_curve(figure, curve, "limit", ALERT, unit, **LIMIT_LINE)


def score_panel(done: Analysed, recorded: Recording, name: str) -> Panel:
    """Score of a detector, and the limit in force."""
    figure = over_time(done.analysis.duration_s, 220)
    add_curve(figure, recorded.said(name, SCORE), "score", BLUE, "")
    add_limit_in_force(figure, recorded, name, "")
    figure.update_yaxes(rangemode="tozero")
    note = next(part.question for part in done.parameters.parts if part.name == name)
    return Panel(name, f"{name}: score and limit", note, figure)
