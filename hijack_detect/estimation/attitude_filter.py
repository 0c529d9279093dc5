# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The filter that follows IMU and GPS, with a magnetometer where there is one, and its start."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from hijack_detect.estimation.attitude_parameters import AttitudeParameters
from hijack_detect.estimation.course import CourseEstimator, CourseParameters
from hijack_detect.estimation.ekf import (
    ATTITUDE,
    POSITION,
    VELOCITY,
    Ekf,
    Observation,
    ProcessNoise,
    Source,
)
from hijack_detect.estimation.filter_bank import FilterBank
from hijack_detect.estimation.geodesy import LocalFrame
from hijack_detect.estimation.imu_buffer import ImuBuffer
from hijack_detect.estimation.lag_ekf import MOST_GROWTH_S
from hijack_detect.estimation.magnetic import declination, heading_error
from hijack_detect.estimation.rotation import (
    Array,
    from_roll_pitch_yaw,
    heading,
    level,
)
from hijack_detect.streams.samples import (
    NANOSECONDS,
    FixSample,
    ImuSample,
    MagneticSample,
    Quaternion,
    Sample,
    VelocitySample,
)

MakeFilter: TypeAlias = Callable[[Quaternion, Array, ProcessNoise], Ekf]
"""Attitude (FLU → ENU), standard deviations of the error state and process noise to a filter."""

OUTAGE_STEP_NS = NANOSECONDS // 2
"""Without GPS the filter still moves on in steps of this length. Chosen, not swept."""

INITIAL_SIGMAS = np.array([10.0] * 3 + [1.0] * 3 + [0.1, 0.1, math.pi] + [0.15] * 3 + [0.01] * 3)
"""Standard deviations of the first error state: m, m/s, rad, m/s² and rad/s. Chosen;
measured: with 0.3 m/s² of bias instead of 0.15, straight simulated flights trade tilt for bias."""
MAG_REFUSED_NS = 30 * NANOSECONDS
"""Longest time without the magnetometer: then the filter may be the one that is wrong.
Chosen, not swept."""
VERTICAL_LOST_NS = 5 * NANOSECONDS
"""Longest time without height and vertical velocity before the climb is taken to be small.
Chosen, not swept."""
USUAL_CLIMB = 3.0
"""m/s: standard deviation of the climb of a drone of which nothing is known. Chosen, not swept."""
RESTART_SIGMAS = np.array([3.0] * 3 + [1.0] * 3)
"""Standard deviations of position and velocity when they are taken from the GPS again.
Chosen, not swept."""
LONGEST_BRIDGE_S = 30.0
"""A longer gap in the IMU may be another flight. Chosen, not swept."""
BRIDGE_SIGMAS = np.array([1000.0] * 3 + [20.0] * 3)
"""The same after a gap: anything. Chosen, not swept."""
BRIDGE_TILT = 0.2
"""rad: a vehicle in flight is within this of level (one standard deviation), whatever it did.
Chosen, not swept."""
BRIDGE_TURN = 0.5
"""rad/s: how fast it may have turned meanwhile (one standard deviation). Chosen, not swept."""
AHEAD_NS = NANOSECONDS // 10
"""A GPS measurement this far after the newest IMU sample cannot be used: the filter would take the
way since then for an error of its own. Chosen, not swept."""
REGAINED_HEADING = math.radians(6.0)
"""After a gap the filter follows from this standard deviation on, or once it is as sure as it was
before: a heading that is tens of degrees off, as after a turn that no gyroscope saw, is beyond what
is linear. Without GPS velocities 10° make alerts after holes in turning flights, and 4° take longer
than an attack in straight ones."""
LATEST_NS = round(MOST_GROWTH_S * NANOSECONDS)
"""The filter runs later than the nominal lag by this at most."""
LOST_HEADING = math.radians(40.0)
"""Beyond this the heading is looked for in all directions again, unless a compass shows it.
Chosen, not swept."""


class AttitudeFilter:
    """A bank of filters at the time that the newest GPS measurement was valid, stamp minus lag.

    It levels itself on the accelerometer first. Until the heading is known, GPS steers only the
    vertical channel and the horizontal velocity is held near zero, which keeps roll and pitch
    upright. The heading comes from the magnetometer, or from the first course above a speed
    gate: there a bank of filters starts in eight directions about the course, and the
    accelerations leave one. From then on position and velocity are used in full.

    Attributes:
        inputs: Its inputs, and how long each is waited for, s.
        buffer: IMU samples that the filter has not used yet, and the one before.
        first_heading: Heading with which it began to use the GPS in full, rad; None before.
        bridged: Gaps in the IMU over which attitude and biases were kept.
        bridged_s: Length of the last of them, s.
        regaining: Whether the last of them still weighs on the attitude.
    """

    def __init__(
        self, parameters: AttitudeParameters, make_filter: MakeFilter = Ekf, regained: float = 1.0
    ) -> None:
        """Start without a filter.

        Args:
            parameters: Its parameters.
            make_filter: Makes the filter from attitude, standard deviations and noise.
            regained: The attitude is regained after a gap when `worse` is below this.
        """
        self._parameters = p = parameters
        self.inputs: Mapping[str, float] = dict.fromkeys(
            ("imu", "fix", "velocity", "mag"), p.sensor_patience_s
        )
        self._make_filter, self._regained = make_filter, regained
        self._noise = ProcessNoise(p.accel_noise, p.gyro_noise, p.accel_bias_walk, p.gyro_bias_walk)
        self.bridged = 0
        self.bridged_s = 0.0
        self._restart()

    def _restart(self) -> None:
        self._lag_ns = round(self._parameters.gps_lag_s * NANOSECONDS)
        self._bank: FilterBank | None = None
        self.regaining = False
        self._sure_before: float | None = None
        """Standard deviation of the heading before a gap that is not overcome yet, rad."""
        self._bridged_ns = 0
        """End of the last gap in the IMU over which attitude and biases were kept."""
        self._filter_ns = 0
        """Time that the filter has reached; counts once there is a filter."""
        self._magnetic: deque[MagneticSample] = deque()
        self._mag_used_ns: int | None = None
        self.buffer = ImuBuffer()
        self.first_heading: float | None = None
        self._frame: LocalFrame | None = None
        self._declination: float | None = None
        self._last_position: Array | None = None
        self._vertical_ns: int | None = None
        """Stamp of the last measurement with a vertical part."""
        self._course = CourseEstimator(CourseParameters(min_speed=self._parameters.align_speed))

    @property
    def ekf(self) -> Ekf | None:
        """The filter, None while levelling."""
        return None if self._bank is None else self._bank.best

    @property
    def decided(self) -> bool:
        """Whether the filter has a heading, and only one."""
        return self._bank is not None and self._aligned and self._bank.decided

    @property
    def valid_ns(self) -> int:
        """Time that the filter has reached, nanoseconds; counts once there is a filter."""
        return self._filter_ns

    @property
    def lag_s(self) -> float:
        """Time by which the filter runs behind the stamps of the GPS, s."""
        return self._lag_ns / NANOSECONDS

    @property
    def worse(self) -> float:
        """Share of a gap of the IMU that still weighs on the heading, from 1 down to 0."""
        if self._bank is None or self._sure_before is None:
            return 0.0
        return min(max(self._worse(self._bank.best, self._sure_before), 0.0), 1.0)

    def _worse(self, ekf: Ekf, before: float) -> float:
        """Uncertainty of the heading, 0 for what it was before a gap, 1 for REGAINED_HEADING."""
        sigma, span = math.sqrt(ekf.heading_variance), REGAINED_HEADING - before
        return (sigma - before) / span if span > 0.0 else float(sigma > before)

    @property
    def _aligned(self) -> bool:
        return self.first_heading is not None

    def update(self, name: str, sample: Sample) -> bool:
        """Take the next sample in order of stamp; return whether the filter's attitude changed."""
        if isinstance(sample, ImuSample):
            return self._imu(sample)
        if self._bank is None:
            return False
        if isinstance(sample, FixSample):
            return self._fix(self._bank, sample)
        if isinstance(sample, VelocitySample):
            return self._velocity(self._bank, sample)
        if isinstance(sample, MagneticSample) and self._parameters.use_mag:
            self._magnetic.append(sample)
        return False

    def _imu(self, sample: ImuSample) -> bool:
        gap_s = (sample.stamp_ns - self.buffer.newest_ns) / NANOSECONDS if self.buffer else 0.0
        if gap_s > self._parameters.max_imu_gap_s:
            if self.decided and gap_s <= LONGEST_BRIDGE_S:
                self._bridge(sample, gap_s)
                return True
            self._restart()
        self.buffer.append(sample)
        if self._bank is None:
            return self._level(sample)
        if sample.stamp_ns - self._filter_ns <= OUTAGE_STEP_NS + self._lag_ns:
            return False
        self._advance(self._bank, sample.stamp_ns - self._lag_ns)
        return True

    def _bridge(self, sample: ImuSample, gap_s: float) -> None:
        """Go on after a gap: biases and heading are kept, the rest may be anything in flight."""
        assert self._bank is not None
        ekf = self._bank.best
        if self._sure_before is None:
            self._sure_before = math.sqrt(ekf.heading_variance)
        self.regaining = True
        turned = math.sqrt(ekf.heading_variance + (BRIDGE_TURN * gap_s) ** 2)
        ekf.attitude = from_roll_pitch_yaw(0.0, 0.0, heading(ekf.attitude))
        ekf.set_block(POSITION, BRIDGE_SIGMAS[POSITION])
        ekf.set_block(VELOCITY, BRIDGE_SIGMAS[VELOCITY])
        ekf.set_block(ATTITUDE, np.array([BRIDGE_TILT, BRIDGE_TILT, min(turned, math.pi)]))
        if turned > LOST_HEADING:
            ekf.turn(0.0, math.radians(self._parameters.align_sigma_deg))
            self._bank.split(math.radians(self._parameters.align_sigma_deg))
        self.buffer = ImuBuffer()
        self.buffer.append(sample)
        self._filter_ns = self._bridged_ns = sample.stamp_ns
        self._magnetic.clear()
        self.bridged += 1
        self.bridged_s = gap_s

    def _level(self, sample: ImuSample) -> bool:
        if sample.stamp_ns - self.buffer.oldest_ns < self._parameters.level_s * NANOSECONDS:
            return False
        roll, pitch = level(self.buffer.mean_specific_force())
        attitude = from_roll_pitch_yaw(roll, pitch, 0.0)
        self._bank = FilterBank(self._make_filter(attitude, INITIAL_SIGMAS, self._noise))
        self._filter_ns = sample.stamp_ns
        return True

    def _advance(self, bank: FilterBank, to_ns: int) -> None:
        """Propagate the filters to a time, the newest IMU sample at most, with compass updates."""
        to_ns = min(to_ns, self.buffer.newest_ns)
        while self._magnetic and self._magnetic[0].stamp_ns <= to_ns:
            sample = self._magnetic.popleft()
            self._propagate(bank, sample.stamp_ns)
            self._mag(bank, sample)
        self._propagate(bank, to_ns)

    def _propagate(self, bank: FilterBank, to_ns: int) -> None:
        if to_ns > self._filter_ns:
            block = self.buffer.take(self._filter_ns, to_ns)
            bank.apply(lambda ekf: ekf.propagate(block))
            self._filter_ns = to_ns

    def _within_reach(self, stamp_ns: int) -> bool:
        """Whether the IMU brings the filter to the time of a GPS measurement.

        It does not in a gap of the IMU, nor for what was valid before the end of one.
        """
        valid_ns = stamp_ns - self._lag_ns
        return self._bridged_ns <= valid_ns <= self.buffer.newest_ns + AHEAD_NS

    def _follow_lag(self, bank: FilterBank, stamp_ns: int) -> None:
        """Run later where the GPS comes later than the lags that the filter knows, and back.

        At most by half of the time since the last measurement: the filter does not run backwards.
        """
        beyond = bank.best.beyond_band
        if beyond == 0.0 or not self.decided:
            return
        half_ns = (stamp_ns - self._lag_ns - self._filter_ns) // 2
        nominal_ns = round(self._parameters.gps_lag_s * NANOSECONDS)
        step_ns = min(round(beyond * NANOSECONDS), max(half_ns, 0))
        later_ns = max(nominal_ns, min(self._lag_ns + step_ns, nominal_ns + LATEST_NS))
        bank.best.rebase((later_ns - self._lag_ns) / NANOSECONDS)
        self._lag_ns = later_ns

    def _fix(self, bank: FilterBank, fix: FixSample) -> bool:
        course = self._course.update("fix", fix)
        self._follow_lag(bank, fix.stamp_ns)
        if not fix.has_fix or not self._within_reach(fix.stamp_ns):
            return False
        self._advance(bank, fix.stamp_ns - self._lag_ns)
        if self._frame is None:
            self._frame = LocalFrame(fix)
            self._declination = declination(fix.latitude_deg, fix.longitude_deg, fix.altitude_m)
        if fix.has_altitude and not self._frame.has_height:
            # The origin gets the height at which the filter believes to be where it is now.
            height = fix.altitude_m - float(bank.best.position[2])
            self._frame = LocalFrame(replace(self._frame.origin, altitude_m=height))
        self._last_position = position = np.array(self._frame.enu(fix))
        if not self._aligned and course.observable:
            east, north = math.cos(course.angle), math.sin(course.angle)
            velocity = self._course.speed * np.array([east, north, 0.0])
            self._align(bank.best, course.angle - heading(bank.best.attitude), velocity)
            bank.split(math.radians(self._parameters.align_sigma_deg))
        p = self._parameters
        variances = np.square([p.position_sigma, p.position_sigma, p.height_sigma])
        self._measure(bank, Source.POSITION, position, variances, sample_ns=fix.stamp_ns)
        return True

    def _velocity(self, bank: FilterBank, sample: VelocitySample) -> bool:
        self._follow_lag(bank, sample.stamp_ns)
        if not self._within_reach(sample.stamp_ns):
            return False
        self._advance(bank, sample.stamp_ns - self._lag_ns)
        variances = np.full(3, self._parameters.velocity_sigma**2)
        measured = np.array(sample.velocity)
        self._measure(bank, Source.VELOCITY, measured, variances, sample_ns=sample.stamp_ns)
        return True

    def _measure(
        self, bank: FilterBank, source: Source, measured: Array, variances: Array, sample_ns: int
    ) -> None:
        """Use a GPS measurement; before the heading is known only its vertical part.

        Then a horizontal velocity of about zero keeps roll and pitch upright instead. A vertical
        part that was not measured (NaN) is left out; without any for long, a climb of about zero
        keeps the vertical channel from drifting away.
        """
        vertical = not math.isnan(measured[2])
        if vertical:
            self._vertical_ns = sample_ns
        last_ns = self._vertical_ns
        lost = last_ns is None or sample_ns - last_ns > VERTICAL_LOST_NS

        def observe(ekf: Ekf) -> Observation:
            seen = ekf.gps(source, measured, variances)
            H, residual, R = seen.H, seen.residual, seen.R
            if not vertical:
                H, residual, R = H[:2], residual[:2], R[:2]
                if lost:
                    level = np.eye(len(ekf.covariance))[5:6]
                    H = np.vstack([H, level])
                    residual = np.append(residual, -ekf.velocity[2])
                    R = np.append(R, USUAL_CLIMB**2)
            if self._aligned:
                return Observation(source, H, residual, R)
            still = np.eye(len(ekf.covariance))[3:5]
            H = np.vstack([still, H[2:]])
            residual = np.concatenate([-ekf.velocity[:2], residual[2:]])
            R = np.concatenate([[1.0, 1.0], R[2:]])
            return Observation(source, H, residual, R, horizontal=False)

        bank.measure(observe)
        if self._sure_before is not None:
            worse = self._worse(bank.best, self._sure_before)
            self.regaining &= not bank.decided or worse >= self._regained
            if not self.regaining and worse <= 0.0:
                self._sure_before = None

    def _align(self, ekf: Ekf, angle: float, velocity: Array) -> None:
        """Turn the filter to a first heading and start position and velocity on the GPS."""
        assert self._last_position is not None
        ekf.turn(angle, math.radians(self._parameters.align_sigma_deg))
        measured = self._last_position
        ekf.position = np.where(np.isnan(measured), ekf.position, measured)
        ekf.velocity = velocity
        ekf.set_block(POSITION, RESTART_SIGMAS[POSITION])
        ekf.set_block(VELOCITY, RESTART_SIGMAS[VELOCITY])
        self.first_heading = heading(ekf.attitude)

    def _mag(self, bank: FilterBank, sample: MagneticSample) -> None:
        """Heading from the magnetometer; the first one aligns the filter."""
        turn = self._declination
        if turn is None:
            return
        if not self._aligned:
            error, _ = heading_error(bank.best.attitude, sample.field, turn)
            self._align(bank.best, error, np.zeros(3))
        if self._refused(bank, sample, turn):
            return
        self._mag_used_ns = sample.stamp_ns
        variance = np.array([math.radians(self._parameters.mag_sigma_deg) ** 2])

        def observe(ekf: Ekf) -> Observation:
            angle, by_attitude = heading_error(ekf.attitude, sample.field, turn)
            H = np.zeros((1, len(ekf.covariance)))
            H[0, ATTITUDE] = by_attitude
            return Observation(Source.FIELD, H, np.array([angle]), variance)

        bank.measure(observe)

    def _refused(self, bank: FilterBank, sample: MagneticSample, turn: float) -> bool:
        """Whether a magnetic heading is too far from the filter's."""
        last = self._mag_used_ns
        if last is None or not bank.decided or sample.stamp_ns - last > MAG_REFUSED_NS:
            return False
        ekf = bank.best
        angle, _ = heading_error(ekf.attitude, sample.field, turn)
        gate = max(
            math.radians(self._parameters.mag_gate_deg), 3.0 * math.sqrt(ekf.heading_variance)
        )
        return abs(angle) > gate
