# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""GPS height and vertical velocity against the accelerometer."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from hijack_detect.detectors.altitude_parameters import AltitudeParameters
from hijack_detect.detectors.barometer_check import Finding
from hijack_detect.detectors.height_error import claimed_height
from hijack_detect.detectors.onset_bank import OnsetBank
from hijack_detect.estimation.ekf import GRAVITY
from hijack_detect.estimation.kalman import Innovation, update
from hijack_detect.estimation.learning import Scatter
from hijack_detect.estimation.rotation import Array, rotate, up_component
from hijack_detect.streams.samples import NANOSECONDS, AttitudeSample, FixSample, VelocitySample

MAX_GAP_NS = NANOSECONDS // 4
"""After a longer gap in the attitude the vertical force is lost. Chosen, not swept."""


@dataclass(frozen=True, slots=True)
class Sum:
    """Sums since the start of an unbroken piece of flight.

    `velocity`: of Up specific force less gravity, m/s. `manoeuvre`: of the amount by which the
    specific force differs from gravity, m/s. Sums of different pieces cannot be compared.
    """

    stamp_ns: int
    piece: int
    velocity: float
    manoeuvre: float


class VerticalForce:
    """Turns the specific force into ENU and sums its Up part, keeping the last seconds.

    A gap, an unknown attitude or too much tilt ends a piece.
    """

    def __init__(self, max_tilt_deg: float, kept_s: float) -> None:
        """Start without samples.

        Args:
            max_tilt_deg: Tilt that ends a piece, degrees.
            kept_s: How long sums are kept, seconds.
        """
        self._lowest_up = math.cos(math.radians(max_tilt_deg))
        self._kept_ns = round(kept_s * NANOSECONDS)
        self._sums: deque[Sum] = deque()
        self._piece = 0
        self._last_ns: int | None = None
        self.why = "no attitude"
        """Why there is no sum now, empty while there is."""

    def add(self, sample: AttitudeSample) -> None:
        """Take the next attitude."""
        last_ns, self._last_ns = self._last_ns, sample.stamp_ns
        self.why = self._refused(sample)
        if self.why:
            self._piece += 1
            return
        assert sample.orientation is not None
        before = self._sums[-1] if self._sums else None
        if before is None or last_ns is None or before.piece != self._piece:
            self._sums.append(Sum(sample.stamp_ns, self._piece, 0.0, 0.0))
            return
        dt_ns = sample.stamp_ns - last_ns
        if dt_ns > MAX_GAP_NS:
            self._piece += 1
            self._sums.append(Sum(sample.stamp_ns, self._piece, 0.0, 0.0))
            return
        dt = dt_ns / NANOSECONDS
        up = rotate(sample.orientation, sample.specific_force)[2] - GRAVITY
        manoeuvre = abs(math.hypot(*sample.specific_force) - GRAVITY)
        self._sums.append(
            Sum(
                sample.stamp_ns,
                self._piece,
                before.velocity + up * dt,
                before.manoeuvre + manoeuvre * dt,
            )
        )
        while self._sums[0].stamp_ns < sample.stamp_ns - self._kept_ns:
            self._sums.popleft()

    def _refused(self, sample: AttitudeSample) -> str:
        if sample.orientation is None:
            return "attitude unknown"
        if up_component(sample.orientation) < self._lowest_up:
            return "tilted too far"
        return ""

    def at(self, stamp_ns: int) -> Sum | None:
        """Sums at a stamp, interpolated, and older ones forgotten; None where unknown."""
        while len(self._sums) > 1 and self._sums[1].stamp_ns <= stamp_ns:
            self._sums.popleft()
        if len(self._sums) < 2 or self._sums[0].stamp_ns > stamp_ns:
            return None
        a, b = self._sums[0], self._sums[1]
        if a.piece != b.piece:
            return None
        share = (stamp_ns - a.stamp_ns) / (b.stamp_ns - a.stamp_ns)
        return Sum(
            stamp_ns,
            a.piece,
            a.velocity + share * (b.velocity - a.velocity),
            a.manoeuvre + share * (b.manoeuvre - a.manoeuvre),
        )


HEIGHT_NOISE = 0.7
"""m, of a fix on the next. Chosen, not swept."""
VELOCITY_NOISE = 0.25
"""m/s. Chosen, not swept."""
NO_VELOCITY = 1e4
"""m/s: noise of a velocity that was not given."""
WANDER_M, WANDER_S = 4.0, 60.0
"""GPS height error: standard deviation of a receiver that claims no more, and time constant.
Chosen, not swept."""
WORST_WANDER_M = 8.0
"""The most that a receiver may claim, m: a jump of 10 m is still seen. Chosen, not swept."""
INITIAL_BIAS = 0.3
"""m/s², standard deviation. Chosen, not swept."""
HISTORY_S = 20.0
"""Scatter is learnt from innovations older than this, so never from those under test.
Chosen, not swept."""
GROW_S, SHRINK_S = 40.0, 200.0
"""The scatter grows faster than it shrinks: a calm minute on the ground shows little of flight.
Chosen, not swept."""
MAX_SCALE = 3.0
"""Largest growth of the velocity limits with the scatter. Chosen, not swept."""
MAX_INTERVAL_S = 2.0
"""After a longer time between fixes the filter restarts. Chosen, not swept."""
RECENT = 25
"""Intervals whose strongest manoeuvre widens the velocity limits: 5 s at 5 Hz.
Chosen, not swept."""
NOISE_RECENT = 10
"""Intervals whose mean manoeuvre is in the noise of the velocity: 2 s at 5 Hz.
Chosen, not swept."""
CALM_MANOEUVRE = 0.5
"""m/s²: specific force is off gravity by less in calm flight. Chosen, not swept."""
FROZEN_MARGIN = 0.7
"""From this margin on nothing is learnt of the scatter. Chosen, not swept."""
ACCELERATION, VELOCITY, RATE, STEP = range(4)
"""Offsets: an acceleration; a velocity; a height that moves without the velocity; a jump."""
SIGNATURES = 4
SPACING_S = 0.79
"""Onsets are this far apart; no whole number of fixes, so that they differ."""
YOUNGEST_S = 1.0
"""A younger onset is not judged: two fixes are no evidence. Chosen, not swept."""
OLDEST_S = 21.0
"""Older onsets are forgotten. Chosen, not swept."""
FLOOR_ACCELERATION = 0.15
"""m/s²: error of scale and attitude that lasts. Chosen, not swept."""
FLOOR_VELOCITY = 0.4
"""m/s: error of a GPS velocity that lasts. Chosen, not swept."""
FLOOR_HEIGHT = 2.0
"""m: jump of a GPS height when the satellites in use change. Chosen, not swept."""
STATES = 4
"""Height, velocity, accelerometer bias, GPS height error."""
MEASURES = np.array([[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0]])
WORDS = (
    "The GPS accelerates vertically by {size:+.2f} m/s² that the accelerometer does not feel",
    "The GPS velocity changed by {size:+.1f} m/s upwards that the accelerometer did not feel",
    "The GPS height moves at {size:+.1f} m/s without the vertical velocity",
    "The GPS height jumped by {size:+.1f} m",
)


@dataclass(frozen=True, slots=True)
class Evidence:
    """The most likely offset of one signature: standard deviations, its size and its age."""

    score: float
    size: float
    age_s: float


class HeightOffsets:
    """`OnsetBank` of four constant offsets of GPS height and vertical velocity.

    Each is judged alone: its size is d/C with variance 1/C. The floors are systematic errors that
    do not average out.
    """

    def __init__(self) -> None:
        """Start without onsets."""
        nothing = np.zeros((STATES, SIGNATURES))
        self._bank = OnsetBank(nothing, nothing)
        self._t_s: float | None = None
        self._next_s = -math.inf

    def update(self, t_s: float, phi: Array, found: Innovation) -> None:
        """Account one measurement of height and velocity.

        Args:
            t_s: Its time, seconds.
            phi: Transition to this time, shape (4, 4).
            found: What the filter made of it.
        """
        self._bank.propagate(0.0 if self._t_s is None else t_s - self._t_s, phi)
        self._t_s, age = t_s, self._bank.age_s
        offset = np.zeros((2, len(age), SIGNATURES))
        offset[0, :, ACCELERATION] = 0.5 * age * age
        offset[1, :, ACCELERATION] = age
        offset[0, :, VELOCITY] = age
        offset[1, :, VELOCITY] = 1.0
        offset[0, :, RATE] = age
        offset[0, :, STEP] = 1.0
        self._bank.measure(found, offset)
        if t_s >= self._next_s:
            self._next_s = t_s + SPACING_S
            self._bank.forget(OLDEST_S)
            self._bank.begin()

    def evidence(self, wander: float = 1.0) -> list[Evidence]:
        """The strongest evidence for each signature, in their order.

        Args:
            wander: Jumps of the height that do not count, over FLOOR_HEIGHT.
        """
        age = self._bank.age_s
        judged = age >= YOUNGEST_S
        if not judged.any():
            return [Evidence(0.0, 0.0, 0.0)] * SIGNATURES
        age, d = age[judged], self._bank.d[judged]
        c = np.maximum(np.einsum("nii->ni", self._bank.c[judged]), 1e-12)
        height = FLOOR_HEIGHT * wander
        slow = FLOOR_VELOCITY**2 + (height / age) ** 2
        floors = np.stack(
            [
                FLOOR_ACCELERATION**2 + (FLOOR_VELOCITY / age) ** 2,
                slow,
                slow,
                np.full(len(age), height**2),
            ],
            axis=1,
        )
        size = d / c
        score = np.abs(size) / np.sqrt(1.0 / c + floors)
        best = np.argmax(score, axis=0)
        return [
            Evidence(float(score[at, one]), float(size[at, one]), float(age[at]))
            for one, at in enumerate(best)
        ]


class VerticalChannel:
    """Kalman filter of height, velocity, accelerometer bias and GPS height error, and its bank.

    The accelerometer carries the state from fix to fix; each fix and velocity gives an
    innovation, and `HeightOffsets` gives the likelihood of an offset since some moment of the
    last 20 s.
    """

    def __init__(self, parameters: AltitudeParameters) -> None:
        """Start without a state."""
        self._p = parameters
        self._force = VerticalForce(parameters.max_tilt_deg, 4.0)
        self._lag_ns = round(parameters.gps_lag_s * NANOSECONDS)
        self._scatter = Scatter(
            parameters.calm_innovation,
            MAX_SCALE,
            delay_s=HISTORY_S,
            rise_s=GROW_S,
            fall_s=SHRINK_S,
        )
        self._bias = 0.0
        self._wander_m = WANDER_M
        self._x: Array | None = None
        self._covariance = np.zeros((4, 4))
        self._bank = HeightOffsets()
        self._sum: Sum | None = None
        self._ready_ns = 0
        self._begun = False
        self._manoeuvres: deque[float] = deque(maxlen=RECENT)
        self.why = "attitude unknown"
        """Why the last fix could not be judged."""
        self.learning = False
        """Whether it could not be judged because too little is learnt yet."""

    @property
    def bias(self) -> float:
        """Vertical bias of the accelerometer, m/s²."""
        return self._bias

    @property
    def scale(self) -> float:
        """How much the velocity limits are widened for this vehicle, 1 to 3."""
        return self._scatter.scale

    def attitude(self, sample: AttitudeSample) -> None:
        """Take an attitude with its specific force."""
        self._force.add(sample)

    def forget(self) -> None:
        """Forget the evidence of the past, as at take-off; what is learnt of the IMU is kept."""
        self._bank = HeightOffsets()
        self._manoeuvres.clear()
        self._scatter.hold()

    def fix(self, fix: FixSample, velocity: VelocitySample | None) -> Finding | None:
        """Judge a fix with the velocity of the same time; None where it cannot be judged."""
        self._wander_m = min(WORST_WANDER_M, max(WANDER_M, claimed_height(fix) or 0.0))
        now = self._force.at(fix.stamp_ns - self._lag_ns)
        before, self._sum = self._sum, now
        self.learning = False
        if now is None:
            self._x = None
            self.why = self._force.why or "too little attitude"
            return None
        if velocity is not None and not velocity.has_vertical:
            velocity = None
        measured = np.array([fix.altitude_m, velocity.velocity[2] if velocity else 0.0])
        if self._x is None or before is None or not self._joined(before, now):
            self._restart(fix.stamp_ns, measured, velocity is not None)
            return None
        self._step(before, now, measured, fix.stamp_ns, velocity is not None)
        if fix.stamp_ns < self._ready_ns:
            self._learning((self._ready_ns - fix.stamp_ns) / NANOSECONDS)
            return None
        finding = self._judge()
        if finding.margin > FROZEN_MARGIN:
            self._scatter.hold()
        return finding

    def _joined(self, before: Sum, now: Sum) -> bool:
        dt = (now.stamp_ns - before.stamp_ns) / NANOSECONDS
        return before.piece == now.piece and 0.0 < dt <= MAX_INTERVAL_S

    def _learning(self, seconds: float) -> None:
        self.learning = True
        self.why = f"the accelerometer's vertical bias is learnt for {seconds:.0f} s more"

    def _restart(self, stamp_ns: int, measured: Array, with_velocity: bool) -> None:
        settle_s = self._p.settle_s / (3.0 if self._begun else 1.0)
        self._ready_ns = stamp_ns + round(settle_s * NANOSECONDS)
        self._x = np.array([measured[0], measured[1], self._bias, 0.0])
        speed = 1.0 if with_velocity else 25.0
        self._covariance = np.diag([0.01, speed, INITIAL_BIAS**2, self._wander_m**2])
        self._bank = HeightOffsets()
        self._manoeuvres.clear()
        self._scatter.hold()
        self._learning(settle_s)

    def _step(self, a: Sum, b: Sum, measured: Array, stamp_ns: int, with_velocity: bool) -> None:
        """Carry the state from a to b, and correct it."""
        assert self._x is not None
        p = self._p
        dt = (b.stamp_ns - a.stamp_ns) / NANOSECONDS
        gained = b.velocity - a.velocity
        self._manoeuvres.append((b.manoeuvre - a.manoeuvre) / dt)
        recent = list(self._manoeuvres)[-NOISE_RECENT:]
        manoeuvre = math.fsum(recent) / len(recent)
        kept = math.exp(-dt / WANDER_S)
        f = np.eye(4)
        f[0, 1], f[0, 2], f[1, 2], f[3, 3] = dt, -0.5 * dt * dt, -dt, kept
        power = (p.force_noise + p.manoeuvre_noise * manoeuvre) ** 2
        noise = np.zeros((4, 4))
        noise[0, 0] = power * dt**3 / 3.0
        noise[0, 1] = noise[1, 0] = power * dt * dt / 2.0
        noise[1, 1] = power * dt
        noise[2, 2] = p.bias_walk**2 * dt
        noise[3, 3] = self._wander_m**2 * (1.0 - kept * kept)
        x = f @ self._x + np.array([0.5 * gained * dt, gained, 0.0, 0.0])
        covariance = f @ self._covariance @ f.T + noise
        speed_noise = VELOCITY_NOISE if with_velocity else NO_VELOCITY
        variances = np.array([HEIGHT_NOISE**2, speed_noise**2])
        found, self._covariance = update(covariance, MEASURES, measured - MEASURES @ x, variances)
        self._bank.update(b.stamp_ns / NANOSECONDS, f, found)
        x = x + found.correction
        x[2] = min(p.max_bias, max(-p.max_bias, x[2]))
        self._x, self._bias, self._begun = x, float(x[2]), True
        if with_velocity:
            self._scatter.add(stamp_ns, float(found.residual[1]), dt)

    def _judge(self) -> Finding:
        p, scale = self._p, self._scatter.scale
        scale *= 1.0 + p.manoeuvre_gain * max(0.0, max(self._manoeuvres) - CALM_MANOEUVRE)
        limits = (
            p.limit_acceleration * scale,
            p.limit_velocity * scale,
            p.limit_rate,
            p.limit_step,
        )
        best: tuple[float, Evidence, str] = (-1.0, Evidence(0.0, 0.0, 0.0), "")
        evidence = self._bank.evidence(self._wander_m / WANDER_M)
        for limit, one, words in zip(limits, evidence, WORDS, strict=True):
            if one.score / limit > best[0]:
                best = (one.score / limit, one, words)
        margin, one, words = best
        return Finding(margin, f"{words.format(size=one.size)} since {one.age_s:.0f} s")
