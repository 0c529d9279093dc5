"""Inertial consistency: has the GPS accelerated in a way that the IMU did not feel?"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from hijack_detect.detectors.coast_bank import CoastBank, Offsets
from hijack_detect.detectors.coast_parameters import CoastParameters
from hijack_detect.detectors.input_watch import InputWatch
from hijack_detect.detectors.noise_scale import NoiseScale
from hijack_detect.detectors.persistence import Persistence
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.estimation.attitude import AttitudeEstimator
from hijack_detect.estimation.attitude_parameters import AttitudeParameters
from hijack_detect.estimation.ekf import Ekf, ProcessNoise
from hijack_detect.estimation.lag_ekf import LagEkf, ModelErrors, Propagated
from hijack_detect.estimation.rotation import Array
from hijack_detect.streams.samples import (
    NANOSECONDS,
    FixSample,
    ImuSample,
    MagneticSample,
    Quaternion,
    VelocitySample,
)

AGES_S = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 36.0)
"""Ages of the onsets that are judged."""
SPACING_S = 0.5
"""An onset begins this often."""
LOWEST_SCALE, HIGHEST_SCALE = 0.3, 3.0


class CoastDetector:
    """Asks how likely a constant offset acceleration is since any onset some seconds ago.

    A filter of its own follows IMU and GPS (`LagEkf`), and a bank of likelihood ratios over its
    innovations (`CoastBank`) tells what an offset acceleration since each onset would have done
    to them. The score is |a| over its standard deviation: that of the filter's own error model
    times the noise scale that this vehicle has shown, and floors for what no model has. Costs per
    fix do not depend on the IMU's rate.
    """

    NAME = "coast"

    def __init__(self, parameters: CoastParameters) -> None:
        """Start without heading."""
        self._parameters = p = parameters
        self.inputs: Mapping[str, float] = dict.fromkeys(
            ("imu", "velocity", "mag", "fix"), p.sensor_patience_s
        )
        self._estimator = AttitudeEstimator(_estimator_parameters(p), _make_filter)
        self._ages = [age for age in AGES_S if age <= p.longest_s]
        self._watch = InputWatch(("imu", "fix"))
        self._persistence = Persistence(p.persist_s)
        self._scale = NoiseScale(
            LOWEST_SCALE, HIGHEST_SCALE, delay_s=p.longest_s, memory_s=90.0, prior_s=10.0, clip=3.5
        )
        self._filter: LagEkf | None = None
        self._since_ns = 0
        self._violent_ns: int | None = None

    def update(
        self, name: str, sample: ImuSample | VelocitySample | MagneticSample | FixSample
    ) -> Verdict | None:
        """Take the next sample in order of stamp; every fix gives a verdict."""
        self._estimator.update(name, sample)
        if isinstance(sample, ImuSample):
            self._watch.see("imu", sample.stamp_ns)
            self._note_violence(sample)
            return self._verdict(sample.stamp_ns) if self._watch.due(sample.stamp_ns) else None
        self._follow(sample.stamp_ns)
        if not isinstance(sample, FixSample):
            return None
        if sample.has_fix:
            self._watch.see("fix", sample.stamp_ns)
        return self._verdict(sample.stamp_ns)

    def _note_violence(self, sample: ImuSample) -> None:
        p = self._parameters
        if (
            math.hypot(*sample.specific_force) > p.max_force
            or math.hypot(*sample.angular_velocity) > p.max_rate
        ):
            self._violent_ns = sample.stamp_ns

    def _follow(self, stamp_ns: int) -> None:
        """Account what the filter has done; begin afresh with another filter."""
        ekf = self._estimator.ekf
        if not isinstance(ekf, LagEkf):
            self._filter = None
            return
        if not self._estimator.decided:
            ekf.steps.clear()
            self._filter = None
            return
        if ekf is not self._filter:
            self._filter, self._since_ns = ekf, stamp_ns
            self._bank = CoastBank(self._ages, SPACING_S)
            self._scale.hold()
        for step in ekf.steps:
            if isinstance(step, Propagated):
                self._bank.propagate(step)
            else:
                self._bank.measure(step)
        ekf.steps.clear()

    def _verdict(self, stamp_ns: int) -> Verdict:
        lost = self._watch.lost(stamp_ns)
        if lost is not None:
            return self._silent(stamp_ns, *lost)
        p = self._parameters
        if self._filter is None:
            reason = "heading unknown: needs a magnetometer or forward flight"
            return self._silent(stamp_ns, State.NOT_READY, reason)
        offsets = self._bank.offsets()
        if self._violent(stamp_ns):
            reason = f"specific force or rate beyond {p.max_force:g} m/s², {p.max_rate:g} rad/s"
            return self._silent(stamp_ns, State.NOT_OBSERVABLE, reason)
        if stamp_ns - self._since_ns < p.settle_s * NANOSECONDS or len(offsets.age_s) == 0:
            if len(offsets.age_s):
                self._scale.add(stamp_ns, float(np.mean(offsets.whitened)))
            reason = f"heading known for less than {p.settle_s:g} s"
            return self._silent(stamp_ns, State.NOT_READY, reason)
        return self._judge(stamp_ns, offsets)

    def _violent(self, stamp_ns: int) -> bool:
        since = self._violent_ns
        return since is not None and (stamp_ns - since <= self._parameters.recover_s * NANOSECONDS)

    def _silent(self, stamp_ns: int, state: State, reason: str) -> Verdict:
        """A verdict that says nothing of the GPS."""
        self._persistence.reset()
        return Verdict(self.NAME, stamp_ns, state, 0.0, self._limit, reason)

    @property
    def _limit(self) -> float:
        p = self._parameters
        wanted = p.threshold_gain * self._scale.value**3
        return min(max(wanted, p.threshold_low), p.threshold_high)

    def _judge(self, stamp_ns: int, offsets: Offsets) -> Verdict:
        p, scale = self._parameters, self._scale.value
        deviation = np.sqrt(
            (scale * offsets.sigma) ** 2
            + p.floor_acceleration**2
            + (p.floor_velocity / offsets.age_s) ** 2
        )
        size = np.hypot(offsets.acceleration[:, 0], offsets.acceleration[:, 1])
        best = int(np.argmax(size / deviation))
        limit = self._limit
        score = float(size[best] / deviation[best])
        east, north = offsets.acceleration[best].tolist()
        smallest = limit * float(np.min(deviation))
        values = self._values(score, east, north, float(offsets.age_s[best]), smallest)
        if score > limit:
            self._scale.hold()
        else:
            self._scale.add(stamp_ns, float(np.mean(offsets.whitened)))
        if scale > p.max_noise_scale:
            self._persistence.reset()
            reason = f"IMU and GPS disagree {scale:.1f} times more than they should"
            return Verdict(self.NAME, stamp_ns, State.NOT_OBSERVABLE, 0.0, limit, reason, values)
        state = self._persistence.state(stamp_ns, score > limit)
        if state is State.NORMAL and score > p.suspicious_margin * limit:
            state = State.SUSPICIOUS
        reason = (
            f"offset acceleration {math.hypot(east, north):.2f} m/s² since "
            f"{values['age']:.1f} s, {score:.1f} σ (limit {limit:.1f}); "
            f"could see {smallest:.2f} m/s²"
        )
        return Verdict(self.NAME, stamp_ns, state, score, limit, reason, values)

    def _values(
        self, score: float, east: float, north: float, age_s: float, smallest: float
    ) -> dict[str, float]:
        assert self._filter is not None
        position_lag, velocity_lag = self._filter.lags.tolist()
        return {
            "acceleration": math.hypot(east, north),
            "direction": math.atan2(north, east),
            "age": age_s,
            "smallest_visible": smallest,
            "noise_scale": self._scale.value,
            "position_lag": self._parameters.gps_lag_s + position_lag,
            "velocity_lag": self._parameters.gps_lag_s + velocity_lag,
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
    )


def _make_filter(attitude: Quaternion, sigmas: Array, noise: ProcessNoise) -> Ekf:
    return LagEkf(attitude, sigmas, noise, ModelErrors())
