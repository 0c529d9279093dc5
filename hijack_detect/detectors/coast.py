# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Inertial consistency: has the GPS accelerated in a way that the IMU did not feel?"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from hijack_detect.detectors.coast_bank import Change, CoastBank, Offsets, Sustained, sustained
from hijack_detect.detectors.coast_parameters import CoastParameters
from hijack_detect.detectors.flight_gate import FlightGate
from hijack_detect.detectors.input_watch import InputWatch
from hijack_detect.detectors.persistence import Excursion, Persistence
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.estimation.air_ekf import SIZE, WIND, AirEkf
from hijack_detect.estimation.attitude_filter import AttitudeFilter
from hijack_detect.estimation.attitude_parameters import AttitudeParameters
from hijack_detect.estimation.ekf import Ekf, ProcessNoise
from hijack_detect.estimation.lag_ekf import LATE, Propagated, late, late_words
from hijack_detect.estimation.learning import NoiseScale
from hijack_detect.estimation.rotation import Array
from hijack_detect.estimation.velocity_error import VelocityNoise
from hijack_detect.streams.samples import (
    NANOSECONDS,
    FixSample,
    ImuSample,
    MagneticSample,
    PhaseSample,
    Quaternion,
    VelocitySample,
)

YOUNGEST_S = 0.7
"""Age from which on an onset is judged. With 0.5 a recorded flight whose usual score was not known
yet came to 0.99 of the limit (0.92 with 0.7 and 0.9)."""
SPACING_S = 0.35
"""An onset begins with the first fix after this. Chosen: four or five onsets in a run of span_s."""
SETTLED, RELEARN_S = 0.25, 30.0
SHORT_GAP_S, LONG_GAP_S = 4.0, 8.0
"""After a gap of the IMU onsets begin when no more of it than the first weighs on the heading, and
the noise that was learnt before counts in full again after the second: less and less of the gap's
from its end on, after a gap longer than the fourth from 15 s on, between these for lengths down to
the third. With onsets as soon as the heading is known and that noise at once, holes of 3 and 9 s
without GPS velocities gave scores of 1.1 and 2.2 times the limit on sitl and the simulator. With
15 s in full after each gap, a carry-off of 1 m/s² 5 s after such a hole of 4 s was missed."""
LEAST_WAIT_S = 2.0
"""After a single excursion. Physics: the lag of the GPS, and the youngest onset."""
LOWEST_SCALE, HIGHEST_SCALE = 0.3, 3.0
"""Bounds of the noise scale. Chosen, not swept: beyond 2.5 nothing is judged."""
NOISE_MEMORY_S, NOISE_PRIOR_S, NOISE_CLIP = 90.0, 5.0, 3.5
"""Of the noise scale: chosen, and not swept. Onsets of 8 s are forgotten within ten times as long,
the prior within the first of them, and 3.5 standard deviations are one value in two thousand."""
RISE_PER_S = 0.02
"""Largest relative rise of the scale once it is known. On a healthy recorded flight it rose by
0.016 a second for 20 s when the vehicle began to manoeuvre; held to 0.005 that flight was an alarm.
Without a bound, noise that a jammed receiver shows for 40 s doubles it, and the carry-off that
follows is lost in it (docs/detection-limits.md)."""
USUAL_POWER = 3.0
"""Of the mean of past scores that is the usual one. At the same largest clean margin (0.85) 3 found
40 of 50 drifts of 1 m/s² on healthy recorded flights, 2 and 4 found 39."""
USUAL_MEMORY_S, USUAL_PRIOR_S, USUAL_CLIP = 120.0, 2.0, 2.0
"""Of the usual score: chosen, and not swept."""
LOWEST_USUAL, HIGHEST_USUAL = 0.3, 3.0
"""Bounds of the usual score. Chosen: wider than what the limit follows."""
VISIBLE_GAIN = 1.2
"""`smallest_visible` is this times the offset whose mean score reaches the limit. Noise takes a
whole run below the limit more often than above, and an offset older than the bank is taken up by
tilt and bias. Measured by experiments/visible_promise.py on vehicles left out: of drifts 1.2 times
as large nine tenths are found, of those 0.8 times as large at most half (docs/detection-limits.md).
"""


class CoastDetector:
    """Generalised likelihood ratio of a constant offset acceleration of the GPS since some onset.

    A filter of its own follows IMU, GPS and drag (`AirEkf`), and a bank of likelihood ratios over
    its innovations (`CoastBank`) gives what an offset acceleration since each onset would have
    done to them. The score is |a| over its standard deviation: that of the filter's own error
    model times the noise scale that this vehicle has shown, and floors for what no model has. It
    is the least of a run of onsets (`sustained`), and of two beliefs about the wind. The limit
    follows the scores that this vehicle reaches without an attack (`usual_score`). Costs per fix
    do not depend on the IMU's rate.
    """

    NAME = "coast"
    PARAMETERS = CoastParameters

    def __init__(self, parameters: CoastParameters) -> None:
        """Start without heading."""
        self._parameters = p = parameters
        sensors = dict.fromkeys(("imu", "velocity", "mag", "fix"), p.sensor_patience_s)
        self.inputs: Mapping[str, float] = {"phase": p.patience_s, **sensors}
        self._estimator = AttitudeFilter(_estimator_parameters(p), self._make_filter, SETTLED)
        self._gate = FlightGate()
        self._watch = InputWatch(("imu", "fix"))
        self._persistence = Persistence(p.persist_s)
        self._scale = NoiseScale(
            LOWEST_SCALE,
            HIGHEST_SCALE,
            delay_s=p.longest_s,
            memory_s=NOISE_MEMORY_S,
            prior_s=NOISE_PRIOR_S,
            clip=NOISE_CLIP,
            rise_per_s=RISE_PER_S,
        )
        self._usual = NoiseScale(
            LOWEST_USUAL,
            HIGHEST_USUAL,
            delay_s=p.longest_s,
            memory_s=USUAL_MEMORY_S,
            prior_s=USUAL_PRIOR_S,
            clip=USUAL_CLIP,
            prior=min(p.threshold_high / p.threshold_gain, HIGHEST_USUAL),
            rise_per_s=RISE_PER_S,
            power=USUAL_POWER,
        )
        """The score that this vehicle usually has; until it is known, that of the highest limit."""
        self._filter: AirEkf | None = None
        self._bridged = 0
        self._bridged_ns: int | None = None
        """When the last gap of the IMU was noticed."""
        self._since_ns = 0
        self._gps_ns = 0
        self._returned_ns: int | None = None
        """End of the last gap in the GPS."""
        self._excursion = Excursion(p.recover_s, LEAST_WAIT_S, p.recover_gain)
        """Of force or rate, beyond max_force or max_rate."""

    def update(
        self,
        name: str,
        sample: ImuSample | VelocitySample | MagneticSample | FixSample | PhaseSample,
    ) -> Verdict | None:
        """Take the next sample in order of stamp; every fix gives a verdict."""
        if isinstance(sample, PhaseSample):
            self._gate.update(sample)
            return None
        self._estimator.update(name, sample)
        if isinstance(sample, ImuSample):
            self._watch.see("imu", sample.stamp_ns)
            force, rate = math.hypot(*sample.specific_force), math.hypot(*sample.angular_velocity)
            p = self._parameters
            self._excursion.see(sample.stamp_ns, force > p.max_force or rate > p.max_rate)
            return self._verdict(sample.stamp_ns) if self._watch.due(sample.stamp_ns) else None
        self._follow(sample.stamp_ns)
        if isinstance(sample, VelocitySample) or (isinstance(sample, FixSample) and sample.has_fix):
            self._resume(sample.stamp_ns)
        if not isinstance(sample, FixSample):
            return None
        if sample.has_fix:
            self._watch.see("fix", sample.stamp_ns)
        return self._verdict(sample.stamp_ns)

    def _resume(self, stamp_ns: int) -> None:
        """Restart all onsets after a gap in the GPS."""
        outage = stamp_ns - self._gps_ns > self._parameters.outage_s * NANOSECONDS
        if outage and self._filter is not None:
            self._begin_bank()
            self._returned_ns = stamp_ns
        self._gps_ns = stamp_ns

    def _follow(self, stamp_ns: int) -> None:
        """Account what the filter has done; restart with another filter."""
        ekf = self._estimator.ekf
        if not isinstance(ekf, AirEkf):
            self._filter = None
            return
        if not self._estimator.decided:
            ekf.steps.clear()
            self._filter = None
            return
        if ekf is not self._filter:
            # After a gap the noise is known, and the filter's own covariance shows what it can see.
            if self._estimator.bridged == self._bridged:
                self._since_ns = stamp_ns
            self._filter = ekf
            self._begin_bank()
        if self._estimator.bridged != self._bridged:
            self._bridged, self._bridged_ns = self._estimator.bridged, stamp_ns
        if self._estimator.regaining:
            self._begin_bank()
            ekf.steps.clear()
            return
        for step in ekf.steps:
            if isinstance(step, Propagated):
                self._bank.propagate(step)
            else:
                self._bank.measure(step)
        ekf.steps.clear()

    def _make_filter(self, attitude: Quaternion, sigmas: Array, noise: ProcessNoise) -> Ekf:
        p = self._parameters
        receiver = VelocityNoise(sigma=p.velocity_error)
        return AirEkf(attitude, sigmas, noise, p.errors, p.air, receiver)

    def _begin_bank(self) -> None:
        p = self._parameters
        gusts = dict.fromkeys(range(WIND.start, WIND.stop), Change(p.gust, p.gust_rate))
        self._bank = CoastBank(SIZE, YOUNGEST_S, p.longest_s, SPACING_S, gusts)
        self._hold()

    def _verdict(self, stamp_ns: int) -> Verdict:
        lost = self._watch.lost(stamp_ns)
        if lost is not None:
            return self._silent(stamp_ns, *lost)
        p = self._parameters
        blocked = self._gate.blocked(stamp_ns)
        if blocked is not None:
            self._hold()
            return self._silent(stamp_ns, *blocked)
        if self._filter is None:
            reason = "heading unknown: needs a magnetometer or forward flight"
            return self._silent(stamp_ns, State.NOT_READY, reason)
        if self._estimator.regaining:
            reason = "attitude after a gap of the IMU: not known well enough yet"
            return self._silent(stamp_ns, State.NOT_READY, reason)
        if self._excursion.lasts(stamp_ns):
            reason = f"specific force or rate beyond {p.max_force:g} m/s², {p.max_rate:g} rad/s"
            return self._silent(stamp_ns, State.NOT_OBSERVABLE, reason)
        still, free = self._bank.offsets(), self._bank.offsets(changed=True)
        found = self._found(stamp_ns, still, free)
        known_s = min((stamp_ns - self._since_ns) / NANOSECONDS, self._gate.airborne_s(stamp_ns))
        if found is None or known_s < p.settle_s:
            self._learn(stamp_ns, free)
            reason = f"heading known in flight for less than {p.settle_s:g} s"
            if known_s >= p.settle_s:
                reason = f"less than {p.span_s + YOUNGEST_S:g} s of GPS since a gap"
            return self._silent(stamp_ns, State.NOT_READY, reason)
        return self._judge(stamp_ns, still, free, found)

    def _found(self, stamp_ns: int, still: Offsets, free: Offsets) -> Sustained | None:
        """The score of a run of onsets, whether the wind stays or not.

        A gust stands out only if the wind is taken to stay, an error of tilt rather if it is not.
        """
        worse = max(self._estimator.worse, self._adrift(stamp_ns))
        sure = self._deviation(still, worse)
        unsure = self._deviation(free, worse) / self._parameters.gusty_gain
        score = np.minimum(still.size / sure, free.size / unsure)
        return sustained(still.age_s, score, np.maximum(sure, unsure), self._parameters.span_s)

    def _adrift(self, stamp_ns: int) -> float:
        """How much of a gap still weighs on tilt and heading, from 1 down to 0."""
        left = 0.0
        if self._returned_ns is not None:
            ago_s = (stamp_ns - self._returned_ns) / NANOSECONDS
            left = 1.0 - ago_s / self._parameters.longest_s
        if self._bridged_ns is not None:
            ago_s = (stamp_ns - self._bridged_ns) / NANOSECONDS
            long = (self._estimator.bridged_s - SHORT_GAP_S) / (LONG_GAP_S - SHORT_GAP_S)
            gain = 1.0 + min(max(long, 0.0), 1.0)
            left = max(left, gain * (1.0 - ago_s / RELEARN_S))
        return min(max(left, 0.0), 1.0)

    def _deviation(self, offsets: Offsets, worse: float) -> Array:
        """Standard deviation of each offset acceleration on this vehicle, m/s²."""
        p = self._parameters
        # What a gap leaves behind is as large as the filter has it, unlike noise, of which this
        # vehicle may have less.
        learnt = self._scale.value
        scale = max(learnt, worse + (1.0 - worse) * learnt)
        variance: Array = (
            (scale * offsets.sigma) ** 2
            + p.floor_acceleration**2
            + (p.floor_velocity / offsets.age_s) ** 2
        )
        return np.sqrt(variance)

    def _learn(self, stamp_ns: int, offsets: Offsets) -> None:
        if len(offsets.age_s):
            self._scale.add(stamp_ns, float(np.mean(offsets.whitened)))

    def _hold(self) -> None:
        """Learn nothing of the last seconds."""
        self._scale.hold()
        self._usual.hold()

    def _silent(self, stamp_ns: int, state: State, reason: str) -> Verdict:
        """A verdict without a statement about the GPS."""
        self._persistence.reset()
        return Verdict(self.NAME, stamp_ns, state, 0.0, self._limit, reason)

    @property
    def _limit(self) -> float:
        p = self._parameters
        wanted = p.threshold_gain * self._usual.value
        return min(max(wanted, p.threshold_low), p.threshold_high)

    def _judge(self, stamp_ns: int, still: Offsets, free: Offsets, found: Sustained) -> Verdict:
        p, scale, limit, score = self._parameters, self._scale.value, self._limit, found.score
        acceleration, age_s = still.acceleration[found.best], float(still.age_s[found.best])
        smallest = VISIBLE_GAIN * limit * found.deviation
        values = self._values(acceleration, age_s, smallest)
        words = late_words(values)
        beside = f"; {LATE}: {words}" if words else ""
        if score > limit:
            self._hold()
        else:
            self._learn(stamp_ns, free)
        if scale > p.max_noise_scale:
            self._persistence.reset()
            reason = f"IMU and GPS disagree {scale:.1f} times more than they should{beside}"
            return Verdict(self.NAME, stamp_ns, State.NOT_OBSERVABLE, 0.0, limit, reason, values)
        if smallest > p.max_visible:
            self._persistence.reset()
            reason = (
                f"could only see {smallest:.1f} m/s²: tilt or heading are not known well enough"
                f"{beside}"
            )
            return Verdict(self.NAME, stamp_ns, State.NOT_OBSERVABLE, 0.0, limit, reason, values)
        if score <= limit:
            self._usual.add(stamp_ns, score**USUAL_POWER)
        state = self._persistence.state(stamp_ns, score > limit)
        if state is State.NORMAL and score > p.suspicious_margin * limit:
            state = State.SUSPICIOUS
        size = values["acceleration"]
        if state is State.NORMAL:
            reason = f"GPS and IMU agree within {size:.2f} m/s²"
        else:
            reason = f"The GPS accelerates by {size:.2f} m/s² that the IMU does not feel"
        reason += f", since {age_s:.1f} s: {score:.1f} σ (limit {limit:.1f}); "
        reason += f"could see {smallest:.2f} m/s²"
        reason += beside
        return Verdict(self.NAME, stamp_ns, state, score, limit, reason, values)

    def _values(self, acceleration: Array, age_s: float, smallest: float) -> dict[str, float]:
        assert self._filter is not None
        lag, difference = self._filter.lags.tolist()
        velocity_lag = self._estimator.lag_s + lag
        position_lag = velocity_lag + difference
        east, north = acceleration.tolist()
        return {
            "acceleration": math.hypot(east, north),
            "direction": math.atan2(north, east),
            "age": age_s,
            "smallest_visible": smallest,
            "noise_scale": self._scale.value,
            "usual_score": self._usual.value,
            "receiver_noise": self._filter.velocity_error.scale,
            "position_lag": position_lag,
            "velocity_lag": velocity_lag,
            **late(*(self._estimator.lag_s + least for least in self._filter.least_lags)),
        }


def _estimator_parameters(p: CoastParameters) -> AttitudeParameters:
    return AttitudeParameters(
        gps_lag_s=p.gps_lag_s,
        use_mag=p.use_mag,
        mag_sigma_deg=p.mag_sigma_deg,
        position_sigma=p.position_sigma,
        velocity_sigma=p.velocity_sigma,
        accel_bias_walk=p.accel_bias_walk,
        gyro_bias_walk=p.gyro_bias_walk,
        gyro_noise=p.gyro_noise,
    )
