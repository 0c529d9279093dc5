# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""ArduPilot's gate, EKF3 of Copter (libraries/AP_NavEKF3; PosVelFusion as of commit 0005fc0).

Facts and names only, no code of it:

* `NavEKF3_core::FuseVelPosNED` (AP_NavEKF3_PosVelFusion.cpp): one test ratio for the horizontal
  position and one for the velocity: sum of innovations² / (gate² · sum of their variances), gates
  EK3_POS_I_GATE and EK3_VEL_I_GATE (500 is five standard deviations). Below 1 all axes are used.
* Noise: EK3_POSNE_M_NSE and what the receiver claims, the larger; EK3_VELNE_M_NSE and
  EK3_VELD_M_NSE; where nothing is claimed they grow with the acceleration by `gpsPosVarAccScale`,
  `gpsNEVelVarAccScale` and `gpsDVelVarAccScale`. The velocity's gate uses EK3_VELNE_M_NSE for all
  axes and never what is claimed.
* `NavEKF3_core::setAidingMode` (AP_NavEKF3_Control.cpp): position not accepted for
  `posRetryTimeUseVel_ms`, 10 s, while the velocity is, or for `posRetryTimeNoVel_ms`, 7 s, while
  it is not, is a time-out of both: both are set to the GPS (`ResetPosition`, `ResetVelocity`), and
  the position's standard deviation to half of EK3_GLITCH_RAD. A rejected velocity alone never
  times out. Position is also reset when its own uncertainty has grown beyond EK3_GLITCH_RAD.
* Height: from the barometer (EK3_SRC1_POSZ), EK3_ALT_M_NSE, EK3_HGT_I_GATE; the GPS altitude is not
  used, its vertical velocity is. Reset to the barometer after `hgtRetryTimeMode0_ms`, 10 s.
* Noise of the IMU: EK3_ACC_P_NSE, EK3_GYRO_P_NSE, EK3_ABIAS_P_NSE, EK3_GBIAS_P_NSE at steps of
  12 ms. EK3_MAG_M_NSE, 0.05 gauss, is 0.25 rad in a horizontal field of 0.2 gauss.

Left out: several lanes and their switching, the emergency yaw reset (EKFGSF), the states of wind
and field, ground effect, and `badIMUdata`, which opens the gates when barometer and vertical
velocity both disagree by more than three standard deviations (6 m and 1.5 m/s) the same way.
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

POS_I_GATE = VEL_I_GATE = HGT_I_GATE = 5.0
POSNE_M_NSE, VELNE_M_NSE, VELD_M_NSE, ALT_M_NSE = 0.5, 0.3, 0.5, 2.0
POS_ACC_SCALE, VEL_NE_ACC_SCALE, VEL_D_ACC_SCALE = 0.05, 0.05, 0.07
GLITCH_RAD_M = 25.0
RETRY_USE_VEL_S, RETRY_NO_VEL_S, HEIGHT_RETRY_S = 10.0, 7.0, 10.0
"""All of these are defaults of ArduPilot, see above."""


def pooled_ratio(innovation: Array, variance: Array, gate: float) -> float:
    """The one test ratio of all axes; from 1 on none of them is used.

    Args:
        innovation: Measured minus predicted of each axis.
        variance: Variance of each innovation: of the state plus of the observation.
        gate: Standard deviations.
    """
    return float(np.sum(innovation**2) / (gate**2 * np.sum(variance)))


def timed_out(since_position_s: float, since_velocity_s: float) -> bool:
    """Whether position and velocity are to be reset to the GPS.

    Args:
        since_position_s: Time since a position was accepted, s.
        since_velocity_s: Time since a velocity was accepted, s.
    """
    aided = since_velocity_s <= RETRY_NO_VEL_S
    return since_position_s > (RETRY_USE_VEL_S if aided else RETRY_NO_VEL_S)


class ArduPilotFilter(GateFilter):
    """A filter under ArduPilot's gate."""

    heading_sigma = 0.25
    imu = Imu(step_s=0.012, accel=0.35, gyro=0.015, accel_bias=0.02, gyro_bias=0.001)

    def _forget(self, stamp_ns: int) -> None:
        self._position_ns = self._velocity_ns = self._height_ns = stamp_ns

    def _judge(
        self, epoch: Epoch, position: Array, velocity: Array, acceleration: float, rows: Rows
    ) -> tuple[dict[str, float], tuple[str, ...]]:
        now_ns = epoch.stamp_ns
        timeout = timed_out(
            (now_ns - self._position_ns) / NANOSECONDS, (now_ns - self._velocity_ns) / NANOSECONDS
        )
        ratios: dict[str, float] = {}
        resets: list[str] = []
        self._position(epoch, position, acceleration, timeout, rows, ratios, resets)
        self._velocity(epoch, velocity, acceleration, timeout, rows, ratios, resets)
        self._height(epoch, velocity, rows, ratios, resets)
        return ratios, tuple(resets)

    def _position(
        self,
        epoch: Epoch,
        value: Array,
        acceleration: float,
        timeout: bool,
        rows: Rows,
        ratios: dict[str, float],
        resets: list[str],
    ) -> None:
        claimed = epoch.fix.accuracy_m
        if claimed:
            noise = np.full(2, max(claimed, POSNE_M_NSE) ** 2)
        else:
            noise = np.full(2, POSNE_M_NSE**2 + (POS_ACC_SCALE * acceleration) ** 2)
        innovation = value[:2] - self.ekf.position[:2]
        own = self._variances((EAST, NORTH))
        ratios["position"] = pooled_ratio(innovation, own + noise, POS_I_GATE)
        passed = ratios["position"] < 1.0
        if timeout or (passed and float(np.sum(own)) > GLITCH_RAD_M**2):
            self._reset(slice(EAST, NORTH + 1), value[:2], 0.5 * GLITCH_RAD_M)
            resets.append("position")
        elif passed:
            rows.states((EAST, NORTH), innovation, noise)
        if passed or timeout:
            self._position_ns = epoch.stamp_ns

    def _velocity(
        self,
        epoch: Epoch,
        value: Array,
        acceleration: float,
        timeout: bool,
        rows: Rows,
        ratios: dict[str, float],
        resets: list[str],
    ) -> None:
        horizontal = VELNE_M_NSE**2 + (VEL_NE_ACC_SCALE * acceleration) ** 2
        vertical = VELD_M_NSE**2 + (VEL_D_ACC_SCALE * acceleration) ** 2
        innovation = value - self.ekf.velocity
        own = self._variances((V_EAST, V_NORTH, V_UP))
        ratios["velocity"] = pooled_ratio(innovation, own + horizontal, VEL_I_GATE)
        passed = ratios["velocity"] < 1.0
        if timeout:
            self._reset(slice(V_EAST, V_NORTH + 1), value[:2], VELNE_M_NSE)
            resets.append("velocity")
        elif passed:
            noise = np.array([horizontal, horizontal, vertical])
            rows.states((V_EAST, V_NORTH, V_UP), innovation, noise)
        if passed or timeout:
            self._velocity_ns = epoch.stamp_ns

    def _height(
        self,
        epoch: Epoch,
        velocity: Array,
        rows: Rows,
        ratios: dict[str, float],
        resets: list[str],
    ) -> None:
        innovation = np.array([epoch.barometer_m - self.ekf.position[2]])
        noise = np.array([ALT_M_NSE**2])
        ratios["barometer"] = pooled_ratio(innovation, self._variances((UP,)) + noise, HGT_I_GATE)
        if ratios["barometer"] < 1.0:
            rows.states((UP,), innovation, noise)
            self._height_ns = epoch.stamp_ns
        elif epoch.stamp_ns - self._height_ns > HEIGHT_RETRY_S * NANOSECONDS:
            self._reset(slice(UP, UP + 1), np.array([epoch.barometer_m]), ALT_M_NSE)
            self._reset(slice(V_UP, V_UP + 1), velocity[2:], VELD_M_NSE)
            self._height_ns = epoch.stamp_ns
            resets.append("height")
