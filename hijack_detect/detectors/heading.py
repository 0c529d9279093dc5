# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Headings of gyroscope, compass and GPS against each other: which one disagrees."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from hijack_detect.detectors.flight_gate import FlightGate
from hijack_detect.detectors.heading_evidence import HeadingHistory, Headings, NoseCourse, Turn
from hijack_detect.detectors.input_watch import InputWatch, patience
from hijack_detect.detectors.persistence import Persistence
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.detectors.window import Unwrap, WindowSums
from hijack_detect.estimation.compass import Compass, FieldGate, Reading, earth_field
from hijack_detect.estimation.rotation import heading
from hijack_detect.parameters import Parameters, param
from hijack_detect.streams.samples import (
    NANOSECONDS,
    AttitudeSample,
    FixSample,
    ImuSample,
    MagneticSample,
    PhaseSample,
    Sample,
    VelocitySample,
)
from hijack_detect.streams.silence import SENSOR_PATIENCE_S, sensor_patience


def _limit(default: float, seconds: int) -> float:
    limit: float = param(
        default,
        f"How far the estimator's heading may turn away from compass and gyro within {seconds} s. "
        "Take 1.5 times the largest of clean flights of the vehicle; raise it for a compass near "
        "motor currents.",
        source="measured: 1.5 times the largest of clean flights (docs/detection-limits.md)",
        unit="deg",
        low=1.0,
        high=180.0,
    )
    return limit


@dataclass(frozen=True)
class HeadingParameters(Parameters):
    """Parameters of the comparison of the headings of gyro, compass and GPS."""

    limit_2_deg: float = _limit(7.0, 2)
    limit_5_deg: float = _limit(6.0, 5)
    limit_10_deg: float = _limit(11.0, 10)
    limit_20_deg: float = _limit(17.0, 20)
    persist_s: float = param(
        0.6,
        "The estimator must be away for this long to be an ALARM; SUSPICIOUS before.",
        source="chosen, not swept",
        unit="s",
        low=0.0,
        high=60.0,
    )
    settle_s: float = param(
        10.0,
        "The compass is not compared before it has had a heading for this long: roll and pitch "
        "settle on the accelerometer first.",
        source="chosen, not swept",
        unit="s",
        low=1.0,
        high=120.0,
    )
    compass_deg: float = param(
        25.0,
        "Compass and gyro disagree when their turns over 2 to 20 s differ by more. The compass "
        "of a vehicle that accelerates hard is off by the dip times the error of its tilt: clean "
        "flights reach 17°.",
        source="measured: 1.5 times the largest of clean flights",
        unit="deg",
        low=1.0,
        high=180.0,
    )
    tolerated_deg: float = param(
        6.0,
        "A swing of the compass against the gyro within 45 s that exceeds this is added "
        "twice to every limit: an estimator that uses the compass is pulled along by as much.",
        source="chosen, not swept",
        unit="deg",
        low=0.0,
        high=180.0,
    )
    field_heading_deg: float = param(
        20.0,
        "A magnetometer reading this far from the heading of compass and gyro is an anomaly and "
        "is not used.",
        source="chosen, not swept",
        unit="deg",
        low=2.0,
        high=180.0,
    )
    field_dip_deg: float = param(
        10.0,
        "A reading whose dip (angle below the horizon) is this far from the usual one is an "
        "anomaly and is not used.",
        source="chosen, not swept",
        unit="deg",
        low=1.0,
        high=90.0,
    )
    field_strength: float = param(
        0.15,
        "A reading whose strength differs from the usual one by this part is an anomaly and is "
        "not used. Raise it for a compass near motor currents.",
        source="chosen, not swept",
        low=0.01,
        high=10.0,
    )
    recover_s: float = param(
        60.0,
        "At the start and after an anomaly of the compass the estimator is not judged until it "
        "agrees with the compass within limit_2_deg for 5 s, or for this long.",
        source="chosen, not swept",
        unit="s",
        low=1.0,
        high=600.0,
    )
    course_deg: float = param(
        30.0,
        "SUSPICIOUS when the course has turned by more than this from where it was to the nose "
        "while the nose followed it. Never an ALARM: a pilot who begins to fly sideways does the "
        "same. Clean turns in 8 m/s of wind change the crab angle by 19°.",
        source="measured: 1.5 times the largest of clean turns",
        unit="deg",
        low=1.0,
        high=180.0,
    )
    min_speed: float = param(
        3.0,
        "Below this speed over ground there is no course.",
        source="chosen, not swept",
        unit="m/s",
        low=0.5,
        high=50.0,
    )
    gps_lag_s: float = param(
        0.15,
        "Time from when a GPS velocity was true to its header stamp.",
        source="measured: recorded receivers 0.02 to 0.28 s (docs/detectors.md)",
        basic=True,
        unit="s",
        low=0.0,
        high=1.0,
    )
    patience_s: float = patience()
    sensor_patience_s: float = sensor_patience()


EVALUATE_NS = NANOSECONDS // 5
"""Verdicts are given this often. Chosen, not swept."""
SMOOTH_NS = NANOSECONDS
"""The compass is averaged over this time: a magnetometer is noisy, and the dip multiplies it."""
GLITCH_NS = NANOSECONDS // 2
"""Readings that are off for less than this are single glitches. Chosen, not swept."""
AFTER_NS = 5 * NANOSECONDS
"""How long the estimator must agree with the compass at the start, and again after an anomaly.
Chosen, not swept."""
BELOW_ALARM = 0.99
"""Largest margin of the course alone, which never alarms. Chosen, not swept."""


@dataclass
class _Anomaly:
    """When compass and gyro disagreed."""

    since_ns: int | None = None
    """Start of the present run of readings that are off."""
    last_ns: int | None = None
    """When it last was an anomaly; None once everything has agreed again."""
    agree_ns: int | None = None
    """Since when everything agrees again."""
    reason: str = ""


class HeadingDetector:
    """Compares the turns of gyroscope, compass and GPS over 2, 5, 10 and 20 s.

    `estimation.Compass` gives the headings of gyroscope and compass without the GPS. What the
    GPS implies for the heading is seen in the attitude estimator: it believes the GPS, so a false
    acceleration turns its heading away, even if the false course goes on along the nose. When
    that turns away from gyro and compass, which agree with each other, the GPS is suspected.

    When the compass disagrees, the verdict names it and is NOT_OBSERVABLE. A course that turns
    from the nose is SUSPICIOUS at most. The score is a margin, in units of the limits.
    """

    NAME = "heading"
    PARAMETERS = HeadingParameters

    def __init__(self, parameters: HeadingParameters) -> None:
        """Start without history."""
        self._parameters = p = parameters
        self.inputs: Mapping[str, float] = {
            "phase": p.patience_s,
            "imu": p.sensor_patience_s,
            "mag": p.sensor_patience_s,
            "fix": p.sensor_patience_s,
            "velocity": p.sensor_patience_s,
            "attitude": p.patience_s,
        }
        limits = {
            2.0: math.radians(p.limit_2_deg),
            5.0: math.radians(p.limit_5_deg),
            10.0: math.radians(p.limit_10_deg),
            20.0: math.radians(p.limit_20_deg),
        }
        self._gate = FieldGate(
            math.radians(p.field_heading_deg), math.radians(p.field_dip_deg), p.field_strength
        )
        self._flight = FlightGate()
        self._compass: Compass | None = None
        self._first_ns: int | None = None
        self._evaluated_ns: int | None = None
        self._aligned_ns: int | None = None
        self._history = HeadingHistory(limits, math.radians(p.tolerated_deg))
        self._reading: Reading | None = None
        self._compass_gyro = WindowSums(SMOOTH_NS, 1)
        self._estimated_gyro, self._unwrapped = Unwrap(), Unwrap()
        self._nose = NoseCourse(p.min_speed, p.gps_lag_s)
        self._anomaly = _Anomaly()
        self._persistence = Persistence(p.persist_s)
        self._watch = InputWatch(("IMU", "attitude", "GPS"))
        self._mag_watch = InputWatch(("magnetometer",))
        self._mag_seen = False

    def update(self, name: str, sample: Sample) -> Verdict | None:
        """Take the next sample in order of stamp; attitudes give five verdicts a second."""
        stamp = sample.stamp_ns
        if isinstance(sample, PhaseSample):
            self._flight.update(sample)
            return None
        if self._first_ns is None:
            self._first_ns = stamp
        if isinstance(sample, ImuSample):
            self._imu(sample)
            return self._verdict(stamp) if self._watch.due(stamp) else None
        if isinstance(sample, AttitudeSample):
            self._watch.see("attitude", stamp)
            if self._evaluated_ns is None or stamp - self._evaluated_ns >= EVALUATE_NS:
                self._evaluated_ns = stamp
                return self._evaluate(sample)
        elif isinstance(sample, MagneticSample):
            self._mag(sample)
        elif isinstance(sample, FixSample):
            self._fix(sample)
        elif isinstance(sample, VelocitySample):
            self._watch.see("GPS", stamp)
            self._nose.velocity(sample)
        return None

    def _imu(self, sample: ImuSample) -> None:
        self._watch.see("IMU", sample.stamp_ns)
        if self._compass is None:
            return
        if not self._compass.imu(sample):
            self._begin_again()
        elif self._compass.aligned:
            self._nose.turned(sample.stamp_ns, self._compass.heading)

    def _begin_again(self) -> None:
        self._aligned_ns = self._reading = None
        self._history.clear()
        self._compass_gyro.clear()
        self._nose.interrupt()
        self._anomaly = _Anomaly()
        self._persistence.reset()

    def _fix(self, fix: FixSample) -> None:
        if not fix.has_fix:
            return
        self._watch.see("GPS", fix.stamp_ns)
        if self._compass is None:  # kept for good: a spoofed place must not turn North
            self._compass = Compass(earth_field(fix), gate=self._gate)
        self._nose.fix(fix)

    def _mag(self, sample: MagneticSample) -> None:
        self._mag_watch.see("magnetometer", sample.stamp_ns)
        self._mag_seen = True
        if self._compass is None:
            return
        self._reading = reading = self._compass.mag(sample)
        if reading is None:
            return
        if self._aligned_ns is None:
            self._aligned_ns = sample.stamp_ns
        difference = self._compass.heading + reading.heading - self._compass.gyro_heading
        self._compass_gyro.add(sample.stamp_ns, (self._unwrapped(difference),))
        anomaly = self._anomaly
        if reading.margin(self._gate) < 1.0:
            anomaly.since_ns = None
            return
        if anomaly.since_ns is None:
            anomaly.since_ns = sample.stamp_ns
        if sample.stamp_ns - anomaly.since_ns >= GLITCH_NS:
            anomaly.reason = (
                "compass against gyro and GPS: magnetic anomaly, heading "
                f"{math.degrees(reading.heading):+.0f}°, dip {math.degrees(reading.dip):+.0f}°, "
                f"strength {100.0 * reading.strength:+.0f} %"
            )
            anomaly.last_ns = sample.stamp_ns

    def _evaluate(self, sample: AttitudeSample) -> Verdict:
        if sample.orientation is None:
            self._history.clear()
            self._persistence.reset()
            return self._verdict(sample.stamp_ns)
        if self._ready(sample.stamp_ns) and self._compass is not None:
            gyro, nose = self._compass.gyro_heading, self._compass.heading
            estimated = heading(sample.orientation) - gyro
            course = self._nose.difference
            if not self._history.span_s:  # what the compass did before is unknown
                self._anomaly.last_ns, self._anomaly.reason = sample.stamp_ns, "the start"
            self._history.add(
                Headings(
                    sample.stamp_ns,
                    self._estimated_gyro(estimated),
                    self._compass_gyro.mean(0),
                    None if course is None else course + nose - gyro,
                )
            )
        return self._verdict(sample.stamp_ns)

    def _ready(self, stamp_ns: int) -> bool:
        """Whether the compass has settled."""
        since = self._aligned_ns
        settle_ns = self._parameters.settle_s * NANOSECONDS
        return since is not None and stamp_ns - since >= settle_ns and len(self._compass_gyro) > 0

    def _unavailable(self, stamp_ns: int) -> tuple[State, str] | None:
        """State and reason where there is nothing to compare."""
        assert self._first_ns is not None
        if not self._mag_seen:
            if stamp_ns - self._first_ns >= SENSOR_PATIENCE_S * NANOSECONDS:
                return State.NOT_OBSERVABLE, "no magnetometer"
            return State.NOT_READY, "no magnetometer yet"
        lost = self._watch.lost(stamp_ns) or self._mag_watch.lost(stamp_ns)
        if lost is not None:
            return lost
        if not self._ready(stamp_ns):
            return State.NOT_READY, "compass has not settled yet"
        if self._history.span_s < min(2.0, self._parameters.settle_s):
            return State.NOT_READY, "less than 2 s of the estimator's heading"
        return self._flight.blocked(stamp_ns)

    def _verdict(self, stamp_ns: int) -> Verdict:
        problem = self._unavailable(stamp_ns)
        if problem is not None:
            self._persistence.reset()
            if problem[0] is State.STALE:
                self._history.clear()
            return Verdict(self.NAME, stamp_ns, problem[0], 0.0, 1.0, problem[1])
        p = self._parameters
        turn = self._history.estimator()
        apart, gyro = self._history.compass(math.radians(p.compass_deg))
        course = self._nose.turn(stamp_ns)
        values = self._values(turn, apart, course)
        blocked = self._blocked(stamp_ns, apart, gyro)
        if blocked:
            self._persistence.reset()
            return Verdict(self.NAME, stamp_ns, State.NOT_OBSERVABLE, 0.0, 1.0, blocked, values)
        state = self._persistence.state(stamp_ns, turn.margin > 1.0)
        score = turn.margin
        off = math.degrees(abs(turn.angle))
        limit = f"(limit {math.degrees(turn.limit):.0f}°)"
        reason = f"compass, gyro and GPS agree: {off:.1f}° apart in {turn.seconds:g} s {limit}"
        if state is not State.NORMAL:
            reason = (
                "compass and gyro against GPS: the estimator's heading turned "
                f"{off:.0f}° away in {turn.seconds:g} s {limit}"
            )
        elif abs(course) > math.radians(p.course_deg):
            state, score = State.SUSPICIOUS, max(score, BELOW_ALARM)
            reason = (
                "compass and gyro against GPS: the course turned "
                f"{math.degrees(course):+.0f}° from the nose (limit {p.course_deg:g}°)"
            )
        return Verdict(self.NAME, stamp_ns, state, score, 1.0, reason, values)

    def _values(self, turn: Turn, apart: Turn, course: float) -> dict[str, float]:
        assert self._compass is not None
        field = 0.0 if self._reading is None else self._reading.margin(self._gate)
        return {
            "difference": self._history.difference,
            "turned": turn.angle,
            "course_turn": course,
            "compass_gyro": apart.angle,
            "compass_anomaly": max(field, apart.margin),
            "compass_sigma": self._compass.heading_sigma,
        }

    def _blocked(self, stamp_ns: int, apart: Turn, gyro: bool) -> str:
        """Why the estimator is not judged: compass and gyro disagree, or did; empty if not."""
        anomaly = self._anomaly
        if apart.margin >= 1.0:
            anomaly.last_ns = stamp_ns
            pair = "gyro against compass and GPS" if gyro else "compass against gyro and GPS"
            anomaly.reason = (
                f"{pair}: {'gyro fault' if gyro else 'magnetic anomaly'}, "
                f"{math.degrees(apart.angle):+.0f}° apart in {apart.seconds:g} s"
            )
        if anomaly.last_ns is None:
            off = "compass against gyro and GPS: a glitch, or a magnetic anomaly begins"
            return "" if anomaly.since_ns is None else off
        since_ns = stamp_ns - anomaly.last_ns
        if since_ns <= GLITCH_NS:
            anomaly.agree_ns = None
            return anomaly.reason
        agrees = abs(self._history.difference) <= math.radians(self._parameters.limit_2_deg)
        if not agrees:
            anomaly.agree_ns = None
        elif anomaly.agree_ns is None:
            anomaly.agree_ns = stamp_ns
        recovered = anomaly.agree_ns is not None and stamp_ns - anomaly.agree_ns >= AFTER_NS
        if recovered or since_ns > self._parameters.recover_s * NANOSECONDS:
            self._anomaly = _Anomaly()
            self._history.judge_from(stamp_ns)
            return ""
        return f"estimator does not agree with the compass yet, after {anomaly.reason}"
