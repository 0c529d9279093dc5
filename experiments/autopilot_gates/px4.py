# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""PX4's gate, EKF2 (PX4-Autopilot, src/modules/ekf2; gps_control.cpp as of commit 012e542).

Facts and names only, no code of it:

* `Ekf::updateAidSourceStatus` (EKF/ekf_helper.cpp): test ratio of each axis is innovation² /
  (gate² · innovation variance); one axis above 1 rejects all axes of that measurement.
* `Ekf::updateGnssPos`, `updateGnssVel` (EKF/aid_sources/gnss/gps_control.cpp): observation noise
  is what the receiver claims, at least EKF2_GPS_P_NOISE and EKF2_GPS_V_NOISE; 1.5 times as much
  for the vertical velocity. Gates EKF2_GPS_P_GATE and EKF2_GPS_V_GATE.
* `Ekf::controlGnssPosFusion`, `controlGnssVelFusion`: nothing fused for `reset_timeout_max`, 7 s,
  resets position or velocity to the GPS, each by itself (EKF2_GPS_MODE 0, no other source).
  EKF2_NOAID_TOUT, 5 s, only declares the position invalid.
* `Ekf::controlGnssHeightFusion`, `controlBaroHeightFusion`: EKF2_HGT_REF is GPS, so the height
  follows the GPS (gate EKF2_GPS_P_GATE, noise 1.5 · EKF2_GPS_P_NOISE) and the barometer's bias
  follows the height (`HeightBiasEstimator`, 0.13 m/s/√Hz; EKF2_BARO_NOISE, EKF2_BARO_GATE).
  After `hgt_fusion_timeout_max`, 5 s, the height starts again on the GPS.
* Noise of the IMU: EKF2_ACC_NOISE, EKF2_GYR_NOISE, EKF2_ACC_B_NOISE, EKF2_GYR_B_NOISE at steps
  of EKF2_PREDICT_US (EKF/covariance.cpp, `Ekf::predictCovariance`).

Left out: the emergency yaw reset (EKFGSF), ground effect, the receiver's own flag of spoofing,
gravity fusion, and the checks of GPS quality (EKF2_GPS_CHECK), which no attack here touches.
"""

from __future__ import annotations

import numpy as np

from experiments.autopilot_gates.epochs import Epoch
from experiments.autopilot_gates.gate_filter import (
    EAST,
    NORTH,
    UP,
    V_EAST,
    V_NORTH,
    V_UP,
    GateFilter,
    Imu,
    Rows,
)
from hijack_detect.estimation.rotation import Array
from hijack_detect.streams.samples import NANOSECONDS

GPS_P_GATE = GPS_V_GATE = BARO_GATE = 5.0
GPS_P_NOISE, GPS_V_NOISE, BARO_NOISE = 0.5, 0.3, 2.0
VERTICAL = 1.5
RESET_TIMEOUT_S, HEIGHT_TIMEOUT_S = 7.0, 5.0
BARO_BIAS_NSD = 0.13
"""All of these are defaults of PX4, see above."""


def worst_ratio(innovation: Array, variance: Array, gate: float) -> float:
    """The largest test ratio of the axes; above 1 none of them is used.

    Args:
        innovation: Measured minus predicted of each axis.
        variance: Variance of each innovation: of the state plus of the observation.
        gate: Standard deviations.
    """
    return float(np.max(innovation**2 / (gate**2 * variance)))


class Px4Filter(GateFilter):
    """A filter under PX4's gate."""

    heading_sigma = 0.3  # EKF2_HEAD_NOISE
    imu = Imu(step_s=0.01, accel=0.35, gyro=0.015, accel_bias=0.003, gyro_bias=0.001)

    def _forget(self, stamp_ns: int) -> None:
        self._fused_ns = dict.fromkeys(("position", "velocity", "height"), stamp_ns)
        self._last_ns = stamp_ns
        self._bias: float | None = None
        self._bias_variance = 0.0

    def _judge(
        self, epoch: Epoch, position: Array, velocity: Array, acceleration: float, rows: Rows
    ) -> tuple[dict[str, float], tuple[str, ...]]:
        sigma = max(epoch.fix.accuracy_m or 0.0, GPS_P_NOISE)
        measured = {
            "position": ((EAST, NORTH), position[:2], np.full(2, sigma**2), GPS_P_GATE),
            "velocity": (
                (V_EAST, V_NORTH, V_UP),
                velocity,
                GPS_V_NOISE**2 * np.array([1.0, 1.0, VERTICAL**2]),
                GPS_V_GATE,
            ),
            "height": ((UP,), position[2:], np.full(1, (VERTICAL * sigma) ** 2), GPS_P_GATE),
        }
        state = np.concatenate([self.ekf.position, self.ekf.velocity])
        ratios: dict[str, float] = {}
        resets: list[str] = []
        for name, (states, value, noise, gate) in measured.items():
            innovation = value - state[list(states)]
            ratios[name] = worst_ratio(innovation, self._variances(states) + noise, gate)
            if ratios[name] < 1.0:
                rows.states(states, innovation, noise)
                self._fused_ns[name] = epoch.stamp_ns
        ratios["barometer"] = self._barometer(epoch, rows)
        for name, (states, value, noise, _) in measured.items():
            timeout_s = HEIGHT_TIMEOUT_S if name == "height" else RESET_TIMEOUT_S
            if epoch.stamp_ns - self._fused_ns[name] > timeout_s * NANOSECONDS:
                self._reset(slice(states[0], states[-1] + 1), value, float(np.sqrt(noise[0])))
                self._fused_ns[name] = epoch.stamp_ns
                resets.append(name)
        if "height" in resets:
            self._bias = epoch.barometer_m - float(position[2])
        return ratios, tuple(resets)

    def _barometer(self, epoch: Epoch, rows: Rows) -> float:
        """Test the barometer against the height; its bias takes up what lasts."""
        height, variance = float(self.ekf.position[2]), float(self.ekf.covariance[UP, UP])
        if self._bias is None:
            self._bias, self._bias_variance = epoch.barometer_m - height, BARO_NOISE**2
        self._bias_variance += BARO_BIAS_NSD**2 * (epoch.stamp_ns - self._last_ns) / NANOSECONDS
        self._last_ns = epoch.stamp_ns
        innovation = epoch.barometer_m - self._bias - height
        noise = BARO_NOISE**2 + self._bias_variance
        ratio = worst_ratio(np.array([innovation]), np.array([variance + noise]), BARO_GATE)
        if ratio < 1.0:
            rows.states((UP,), np.array([innovation]), np.array([noise]))
        gain = self._bias_variance / (self._bias_variance + BARO_NOISE**2 + variance)
        self._bias += gain * innovation
        self._bias_variance *= 1.0 - gain
        return ratio
