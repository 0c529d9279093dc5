# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The figures of the detectors that compare the GPS with other sensors and with itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hijack_detect.analysis.analyse import Analysed
from hijack_detect.analysis.report.curve import Curve
from hijack_detect.analysis.report.recording import Recording
from hijack_detect.analysis.report.style import (
    BLUE,
    GREY,
    ORANGE,
    TEAL,
    Panel,
    add_curve,
    over_time,
)
from hijack_detect.analysis.report.trace import SCORE
from hijack_detect.analysis.report.verdict_curves import (
    MakePanel,
    add_limit_in_force,
    against_thresholds,
)

CHECKS = (
    "jump",
    "vertical",
    "freeze",
    "velocity_mismatch",
    "speed",
    "acceleration",
    "time",
    "publishers",
    "satellites",
    "covariance",
)
"""Checks of `gnss`, in the order of the legend."""


def coast_panel(done: Analysed, recorded: Recording, name: str) -> Panel:
    """Offset acceleration of the GPS in its standard deviations, and the limit in force."""
    figure = over_time(done.analysis.duration_s, 220)
    add_curve(figure, recorded.said(name, SCORE), "offset acceleration", BLUE, " σ")
    add_limit_in_force(figure, recorded, name, " σ")
    figure.update_yaxes(rangemode="tozero")
    note = "Has the GPS accelerated, since any onset, in a way that the IMU did not feel?"
    return Panel(name, "Inertial consistency: offset acceleration (σ)", note, figure)


def checks_panel(done: Analysed, recorded: Recording, name: str) -> Panel:
    """Margin of every check of the GPS against itself."""
    curves = {check: recorded.said(name, check) for check in CHECKS}
    figure, logarithmic = against_thresholds(done, curves, 240)
    title = "GPS against itself: each check over its limit" + logarithmic
    note = (
        "Jumps, freezes, velocities that do not lead to the positions, impossible motion, stamps."
    )
    return Panel("checks", title, note, figure)


def altitude_panel(done: Analysed, recorded: Recording, name: str) -> Panel:
    """Margins of the two checks of the height."""
    curves = {check: recorded.said(name, f"{check}_margin") for check in ("barometer", "inertial")}
    figure, logarithmic = against_thresholds(done, curves, 220)
    title = "GPS height: difference over its limit" + logarithmic
    note = "Does the height of the GPS agree with barometer and vertical specific force?"
    return Panel(name, title, note, figure)


def heading_panel(done: Analysed, recorded: Recording, name: str) -> Panel:
    """Headings of estimator, compass and gyroscope against each other."""
    figure = over_time(done.analysis.duration_s, 220)
    for key, words, colour in (
        ("difference", "estimator − compass", BLUE),
        ("turned", "estimator has turned away by", ORANGE),
        ("compass_gyro", "compass has turned away from gyro by", TEAL),
    ):
        curve = recorded.said(name, key)
        add_curve(figure, Curve(curve.time_s, np.degrees(curve.value)), words, colour, "°")
    figure.update_yaxes(ticksuffix="°")
    note = "Does the heading that follows the GPS turn away from compass and gyroscope?"
    return Panel(name, "Heading: estimator against compass and gyroscope (°)", note, figure)


def drag_panel(done: Analysed, recorded: Recording, name: str) -> Panel:
    """Change of wind that the GPS needs, and the limit in force."""
    figure = over_time(done.analysis.duration_s, 220)
    add_curve(figure, recorded.said(name, "wind_speed"), "wind before", GREY, " m/s")
    add_curve(figure, recorded.said(name, "wind_change"), "change of wind", BLUE, " m/s")
    add_limit_in_force(figure, recorded, name, " m/s")
    figure.update_yaxes(rangemode="tozero")
    note = "Would the air have to change as no weather does, for the GPS velocity to be true?"
    return Panel(name, "Drag: the wind that the GPS needs (m/s)", note, figure)


PANELS: Mapping[str, Sequence[MakePanel]] = {
    "coast": (coast_panel,),
    "gnss": (checks_panel,),
    "altitude": (altitude_panel,),
    "heading": (heading_panel,),
    "drag": (drag_panel,),
}
"""Figures by detector; one that has none here gets `score_panel`."""
