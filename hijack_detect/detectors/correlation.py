# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Yaw against GPS course: Feng et al. 2018, §4.3, Algorithms 1 and 2, and a hardened variant."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from hijack_detect.detectors.flight_gate import FlightGate
from hijack_detect.detectors.follow import FollowsCourse
from hijack_detect.detectors.input_watch import InputWatch, patience
from hijack_detect.detectors.persistence import Persistence
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.detectors.window import FULL, Unwrap, WindowSums
from hijack_detect.estimation.rotation import heading
from hijack_detect.parameters import Parameters, param
from hijack_detect.streams.samples import NANOSECONDS, AttitudeSample, CourseSample, PhaseSample
from hijack_detect.streams.silence import sensor_patience


@dataclass(frozen=True)
class CorrelationParameters(Parameters):
    """Defaults are the hardened variant; the faithful values of Feng 2018 are in each text."""

    window_s: float = param(
        2.0,
        "Window of Algorithm 2. Faithful: 2.0 (N = 100 samples at 50 Hz).",
        source="Feng 2018, Algorithm 2: N = 100, §5: 50 Hz",
        unit="s",
        low=0.2,
        high=600.0,
    )
    smoothing_s: float = param(
        0.2,
        "Moving mean over yaw and course before they are compared (§4.3 calls it a median "
        "filter and gives no length). Faithful: 0.2.",
        source="chosen, not swept: Feng 2018, §4.3, gives no length",
        unit="s",
        low=0.0,
        high=10.0,
    )
    course_lag_s: float = param(
        0.35,
        "How far a course lags behind the yaw: GPS lag, half the time between the two fixes it "
        "comes from, and half the time it is held; the yaw is held back by as much. In turns of "
        "30°/s 0.35 s is 10°. Faithful: 0 (ignored).",
        source="physics: 0.15 s of receiver, 0.1 s between fixes of 5 Hz and 0.1 s held",
        basic=True,
        unit="s",
        low=0.0,
        high=5.0,
    )
    epsilon: float = param(
        0.85,
        "ε: trends agree above this correlation coefficient (Eq. 11). Faithful: 0.85.",
        source="Feng 2018, Algorithm 2",
        low=-1.0,
        high=0.999,
    )
    mu_deg: float = param(
        20.0,
        "μ: directions agree below this difference of the means. Faithful: 10. Wind makes "
        "crab angles change by more than 10° in turns; raise it for gusty sites.",
        source="Feng 2018, Algorithm 2, has 10; 20 chosen for crab angles that change in wind",
        unit="deg",
        low=0.1,
        high=180.0,
    )
    min_sigma_deg: float = param(
        2.0,
        "Below this standard deviation of yaw or course in the window the two have not turned "
        "together and ρ means nothing. Faithful: 0 (only an exactly constant angle has no ρ).",
        source="chosen, not swept",
        unit="deg",
        low=0.0,
        high=90.0,
    )
    persist_s: float = param(
        1.0,
        "The condition must hold for this long to be an ALARM; SUSPICIOUS before. Faithful: 0.",
        source="chosen, not swept",
        unit="s",
        low=0.0,
        high=60.0,
    )
    follow_s: float = param(
        8.0,
        "The nose must have followed the course for this long before the window, else "
        "NOT_OBSERVABLE; differences count from the crab angle of that time. Faithful: 0 (off).",
        source="chosen, not swept",
        unit="s",
        low=0.0,
        high=600.0,
    )
    follow_sigma_deg: float = param(
        10.0,
        "Largest standard deviation of course minus yaw in that time that still is following.",
        source="chosen, not swept",
        unit="deg",
        low=0.1,
        high=180.0,
    )
    follow_offset_deg: float = param(
        45.0,
        "Largest mean of course minus yaw in that time: a larger one is flying sideways.",
        source="chosen, not swept",
        unit="deg",
        low=0.1,
        high=180.0,
    )
    max_heading_sigma_deg: float = param(
        10.0,
        "NOT_OBSERVABLE while the estimator's own heading uncertainty is larger: without a "
        "magnetometer the heading drifts on long straight lines. Faithful: 180 (off).",
        source="chosen: half of mu_deg",
        unit="deg",
        low=0.1,
        high=180.0,
    )
    in_flight: bool = param(
        True,
        "Judge only while the vehicle is in the air with a usable IMU. Faithful: false.",
        source="chosen, not swept",
    )
    patience_s: float = patience()
    sensor_patience_s: float = sensor_patience()


YAW, COURSE = 0, 1
YAW_YAW, COURSE_COURSE, YAW_COURSE = 0, 1, 2


@dataclass(frozen=True)
class Trends:
    """Yaw and course over one window."""

    coefficient: float | None
    """Pearson's ρ of Eq. 11; None where yaw or course did not turn at all."""
    mean_difference: float
    """Mean course minus mean yaw, rad, wrapped to [-π, π]."""


class CorrelationDetector:
    """Correlation and mean difference of yaw and course: the nose does not follow a spoofed track.

    It is an alarm when the two neither turn together (ρ < ε) nor point together (|Δavg| > μ).
    Between fixes the course is held (§5: one fix for ten IMU samples). It is evaluated at every
    course sample. With σ → 0, on a perfectly straight flight, ρ is undefined and `ρ < ε` of
    Algorithm 2 is not true: the verdict is NORMAL, "no turn to correlate".

    With `follow_s > 0` the mean difference is taken relative to the crab angle of the time
    before, and the verdict is NOT_OBSERVABLE while the nose does not follow the course: see
    `FollowsCourse`.

    ρ has no scale: a course that a spoofer draws straight turns by a millionth of a degree, and
    that may well correlate with a real turn of the nose. So with `min_sigma_deg > 0` ρ counts
    only where both have turned.
    """

    NAME = "correlation"
    PARAMETERS = CorrelationParameters

    def __init__(self, parameters: CorrelationParameters) -> None:
        """Start with empty windows."""
        self._parameters = p = parameters
        # The course follows each fix at once, so it is waited for as a sensor is: the fusion gives
        # up a detector that waits for longer.
        self.inputs = {
            "phase": p.patience_s,
            "attitude": p.patience_s,
            "course": p.sensor_patience_s,
        }
        self._smoothing = WindowSums(max(1, round(p.smoothing_s * NANOSECONDS)), 2)
        self._window_ns = round(p.window_s * NANOSECONDS)
        self._window = WindowSums(self._window_ns, 2, [(0, 0), (1, 1), (0, 1)])
        self._follow = None
        if p.follow_s > 0.0:
            limits = p.follow_sigma_deg, p.follow_offset_deg
            self._follow = FollowsCourse(p.window_s, p.follow_s, *limits)
        self._persistence = Persistence(p.persist_s)
        self._gate = FlightGate()
        self._watch = InputWatch(("attitude", "course"))
        self._unwrap_yaw, self._unwrap_course = Unwrap(), Unwrap()
        self._lag_ns = round(p.course_lag_s * NANOSECONDS)
        self._yaws: deque[tuple[int, float]] = deque()
        self._held_course: float | None = None
        self._heading_variance = math.inf

    def update(
        self, name: str, sample: AttitudeSample | CourseSample | PhaseSample
    ) -> Verdict | None:
        """Take the next sample in order of stamp; every course sample gives a verdict."""
        if isinstance(sample, PhaseSample):
            if self._parameters.in_flight:
                self._gate.update(sample)
            return None
        self._watch.see(name, sample.stamp_ns)
        if isinstance(sample, AttitudeSample):
            self._add(sample)
            return self._silence(sample.stamp_ns)
        if sample.observable:
            self._held_course = self._unwrap_course(sample.angle)
        return self._evaluate(sample)

    def _silence(self, stamp_ns: int) -> Verdict | None:
        """Without courses nothing is evaluated: then this reports it, once a second.

        Values held through the gap are no evidence, so the windows start over.
        """
        lost = self._watch.lost(stamp_ns)
        if lost is None:
            return None
        self._window.clear()
        self._persistence.reset()
        if self._follow is not None:
            self._follow.interrupt()
        if not self._watch.due(stamp_ns):
            return None
        return Verdict(self.NAME, stamp_ns, lost[0], 0.0, 1.0, lost[1])

    def _add(self, sample: AttitudeSample) -> None:
        """Algorithm 1: smoothed yaw and held course enter the window."""
        self._heading_variance = sample.heading_variance
        if sample.orientation is None:
            self._window.clear()
            self._yaws.clear()
            return
        self._yaws.append((sample.stamp_ns, self._unwrap_yaw(heading(sample.orientation))))
        yaw = self._held_back_yaw(sample.stamp_ns)
        if yaw is None or self._held_course is None:
            return
        self._smoothing.add(sample.stamp_ns, (yaw, self._held_course))
        smooth = (self._smoothing.mean(YAW), self._smoothing.mean(COURSE))
        self._window.add(sample.stamp_ns, smooth)
        if self._follow is not None:
            self._follow.add(sample.stamp_ns, smooth[COURSE] - smooth[YAW])

    def _held_back_yaw(self, stamp_ns: int) -> float | None:
        """The yaw that belongs to the course held now."""
        yaw = None
        while self._yaws and self._yaws[0][0] <= stamp_ns - self._lag_ns:
            yaw = self._yaws.popleft()[1]
        return yaw

    def _trends(self) -> Trends:
        yaw, course = (self._window.covariance(pair) for pair in (YAW_YAW, COURSE_COURSE))
        variance = yaw * course
        smallest = math.radians(self._parameters.min_sigma_deg)
        flat = variance <= 0.0 or math.sqrt(min(yaw, course)) < smallest
        coefficient = None if flat else self._window.covariance(YAW_COURSE) / math.sqrt(variance)
        difference = self._window.mean(COURSE) - self._window.mean(YAW)
        return Trends(coefficient, math.remainder(difference, math.tau))

    def _evaluate(self, course: CourseSample) -> Verdict:
        state, reason = self._obstacle(course)
        if state is not None:
            self._persistence.reset()
            if self._follow is not None and not course.observable:
                self._follow.interrupt()
            return Verdict(self.NAME, course.stamp_ns, state, 0.0, 1.0, reason)
        trends = self._trends()
        crab = self._follow.offset if self._follow is not None else 0.0
        difference = math.remainder(trends.mean_difference - crab, math.tau)
        score, reason = self._score(trends.coefficient, abs(math.degrees(difference)))
        state = self._persistence.state(course.stamp_ns, score > 1.0)
        if self._follow is not None:
            self._follow.frozen = state is not State.NORMAL
        values = {"mean_difference": trends.mean_difference, "crab_angle": crab}
        if trends.coefficient is not None:
            values["coefficient"] = trends.coefficient
        return Verdict(self.NAME, course.stamp_ns, state, score, 1.0, reason, values)

    def _obstacle(self, course: CourseSample) -> tuple[State | None, str]:
        """Why there is nothing to evaluate, if so."""
        p = self._parameters
        lost = self._watch.lost(course.stamp_ns)
        if lost is not None:
            return lost
        if self._held_course is None or self._window.span_ns < FULL * self._window_ns:
            return State.NOT_READY, f"less than {p.window_s:g} s of yaw and course"
        if not course.observable:
            return State.NOT_OBSERVABLE, "no course: too slow, or repeated fixes"
        sigma = math.degrees(math.sqrt(self._heading_variance))
        if sigma > p.max_heading_sigma_deg:
            return State.NOT_OBSERVABLE, f"heading uncertain by {sigma:.0f}° without turns"
        problem = self._follow.problem() if self._follow is not None else ""
        if problem:
            return State.NOT_OBSERVABLE, problem
        return self._gate.blocked(course.stamp_ns) or (None, "")

    def _score(self, coefficient: float | None, difference_deg: float) -> tuple[float, str]:
        """Algorithm 2 as one number that exceeds 1 exactly when both conditions hold."""
        p = self._parameters
        direction = difference_deg / p.mu_deg
        direction_text = f"|Δavg| {difference_deg:.1f}° (μ {p.mu_deg:g}°)"
        if coefficient is None:
            if self._follow is None:
                return 0.0, f"no turn to correlate, {direction_text}"
            return direction, f"no turn, {direction_text}"
        trend = (1.0 - coefficient) / (1.0 - p.epsilon)
        return min(trend, direction), f"ρ {coefficient:.2f} (ε {p.epsilon:g}), {direction_text}"
