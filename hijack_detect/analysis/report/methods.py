# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The figures of the detectors, and the margins of all of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hijack_detect.analysis.analyse import Analysed
from hijack_detect.analysis.report.curves import MARGIN, SCORE, Curve, cut_at, emptiest_direction
from hijack_detect.analysis.report.recording import Recording
from hijack_detect.analysis.report.style import (
    BLUE,
    GREY,
    INK,
    ORANGE,
    TEAL,
    MakePanel,
    Panel,
    add_curve,
    add_limit,
    add_limit_in_force,
    against_thresholds,
    over_time,
)
from hijack_detect.detectors.correlation import CorrelationParameters
from hijack_detect.detectors.kld_values import NAMES, KldParameters


def margins_panel(done: Analysed, recorded: Recording) -> Panel:
    """Score over threshold of every detector."""
    curves = {name: recorded.curve(name, MARGIN) for name in done.analysis.detectors}
    figure, logarithmic = against_thresholds(done, curves, 270)
    title = "Margins: score over threshold" + logarithmic
    note = "Above 1 a detector calls the GPS spoofed. Gaps are times in which it cannot tell."
    return Panel("margins", title, note, figure, detectors=tuple(curves))


def statistics_panel(done: Analysed, recorded: Recording, name: str) -> Panel:
    """Divergence of each parameter of the GPS, over its threshold."""
    kld = done.parameters.of(KldParameters)
    curves = {}
    for value in NAMES:
        forward, backward = (
            recorded.curve(name, f"{value}.{way}") for way in ("forward", "backward")
        )
        total = (forward.value + backward.value) / kld.threshold(value)
        curves[value] = Curve(forward.time_s, total)
    figure, logarithmic = against_thresholds(done, curves, 240)
    title = "GPS statistics: Kullback–Leibler divergence over threshold" + logarithmic
    needed = "One parameter above 1 is" if kld.quorum == 1 else f"{kld.quorum} above 1 at once are"
    note = f"Has a parameter of the GPS changed its statistics? {needed} an alarm, which is kept."
    return Panel("statistics", title, note, figure)


def angles_panel(done: Analysed, recorded: Recording, _: str) -> Panel:
    """Yaw and course."""
    figure = over_time(done.analysis.duration_s)
    cut = emptiest_direction(np.concatenate([recorded.yaw.value, recorded.course.value]))
    add_curve(figure, cut_at(recorded.yaw, cut), "yaw (nose)", BLUE, "°")
    add_curve(figure, cut_at(recorded.course, cut), "course over ground (GPS)", ORANGE, "°")
    ticks = [angle for angle in range(-360, 361, 90) if cut - 360.0 <= angle <= cut]
    figure.update_yaxes(
        range=[cut - 360.0, cut],
        tickvals=ticks,
        ticktext=[f"{'NESW'[angle // 90 % 4]} {angle % 360}°" for angle in ticks],
    )
    note = "Degrees clockwise from North. The course is not known when the vehicle is slow."
    return Panel("angles", "Yaw against course (°)", note, figure)


def rho_panel(done: Analysed, recorded: Recording, name: str) -> Panel:
    """Correlation of yaw and course."""
    figure = over_time(done.analysis.duration_s, 220)
    curve = recorded.curve(name, "coefficient")
    add_curve(figure, curve, "ρ", BLUE, "")
    epsilon = done.parameters.of(CorrelationParameters).epsilon
    add_limit(figure, epsilon, "ε: turn together above", below=True)
    figure.update_yaxes(range=[-1.08, 1.08], tickvals=[-1, -0.5, 0, 0.5, 1])
    figure.update_layout(showlegend=False)
    note = "Do yaw and course turn together? On a straight line there is no turn, and no ρ."
    return Panel("rho", "Correlation ρ of yaw and course", note, figure)


def difference_panel(done: Analysed, recorded: Recording, name: str) -> Panel:
    """Difference of the mean directions, with and without the crab angle."""
    figure = over_time(done.analysis.duration_s)
    mean, crab = (recorded.curve(name, key) for key in ("mean_difference", "crab_angle"))
    raw = Curve(mean.time_s, np.degrees(mean.value))
    judged = Curve(mean.time_s, (np.degrees(mean.value - crab.value) + 180.0) % 360.0 - 180.0)
    add_curve(figure, raw, "course − yaw", GREY, "°", width=1.2)
    chosen = done.parameters.of(CorrelationParameters)
    if chosen.follow_s > 0.0:
        add_curve(figure, judged, "without the usual crab angle (judged)", BLUE, "°")
    mu = chosen.mu_deg
    add_limit(figure, mu, f"μ {mu:g}°")
    add_limit(figure, -mu, f"−μ {mu:g}°", below=True)
    most = max(1.5 * mu, float(np.nanmax(np.abs([raw.value, judged.value]), initial=0.0)) * 1.08)
    figure.update_yaxes(range=[-most, most], ticksuffix="°")
    note = "Do yaw and course point together? Suspicious when outside ±μ while ρ is below ε."
    return Panel("difference", "Δavg: mean course minus mean yaw (°)", note, figure)


def acceleration_panel(done: Analysed, recorded: Recording, name: str) -> Panel:
    """Difference of acceleration, GPS minus accelerometer."""
    figure = over_time(done.analysis.duration_s)
    ax, ay = (recorded.curve(name, key) for key in ("delta_ax", "delta_ay"))
    add_curve(figure, ax, "Δax (forward)", ORANGE, " m/s²", width=1.1)
    add_curve(figure, ay, "Δay (left)", TEAL, " m/s²", width=1.1)
    size = Curve(ax.time_s, np.hypot(ax.value, ay.value))
    add_curve(figure, size, "Δa (horizontal)", INK, " m/s²", width=1.9)
    add_limit_in_force(figure, recorded, name, " m/s²")
    note = "Does the acceleration of the GPS agree with what the accelerometer feels?"
    return Panel("acceleration", "Δa: GPS minus accelerometer (m/s²)", note, figure)


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
    add_curve(figure, recorded.curve(name, SCORE), "offset acceleration", BLUE, " σ")
    add_limit_in_force(figure, recorded, name, " σ")
    figure.update_yaxes(rangemode="tozero")
    note = "Has the GPS accelerated, since any onset, in a way that the IMU did not feel?"
    return Panel(name, "Inertial consistency: offset acceleration (σ)", note, figure)


def checks_panel(done: Analysed, recorded: Recording, name: str) -> Panel:
    """Margin of every check of the GPS against itself."""
    curves = {check: recorded.curve(name, check) for check in CHECKS}
    figure, logarithmic = against_thresholds(done, curves, 240)
    title = "GPS against itself: each check over its limit" + logarithmic
    note = (
        "Jumps, freezes, velocities that do not lead to the positions, impossible motion, stamps."
    )
    return Panel("checks", title, note, figure)


def altitude_panel(done: Analysed, recorded: Recording, name: str) -> Panel:
    """Margins of the two checks of the height."""
    curves = {check: recorded.curve(name, f"{check}_margin") for check in ("barometer", "inertial")}
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
        curve = recorded.curve(name, key)
        add_curve(figure, Curve(curve.time_s, np.degrees(curve.value)), words, colour, "°")
    figure.update_yaxes(ticksuffix="°")
    note = "Does the heading that follows the GPS turn away from compass and gyroscope?"
    return Panel(name, "Heading: estimator against compass and gyroscope (°)", note, figure)


def drag_panel(done: Analysed, recorded: Recording, name: str) -> Panel:
    """Change of wind that the GPS needs, and the limit in force."""
    figure = over_time(done.analysis.duration_s, 220)
    add_curve(figure, recorded.curve(name, "wind_speed"), "wind before", GREY, " m/s")
    add_curve(figure, recorded.curve(name, "wind_change"), "change of wind", BLUE, " m/s")
    add_limit_in_force(figure, recorded, name, " m/s")
    figure.update_yaxes(rangemode="tozero")
    note = "Would the air have to change as no weather does, for the GPS velocity to be true?"
    return Panel(name, "Drag: the wind that the GPS needs (m/s)", note, figure)


PANELS: Mapping[str, Sequence[MakePanel]] = {
    "correlation": (angles_panel, rho_panel, difference_panel),
    "date": (acceleration_panel,),
    "kld": (statistics_panel,),
    "coast": (coast_panel,),
    "gnss": (checks_panel,),
    "altitude": (altitude_panel,),
    "heading": (heading_panel,),
    "drag": (drag_panel,),
}
"""Figures by detector; one that has none here gets `score_panel`."""
