# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Dead-reckoned position against the reported one: the naive comparison of Feng 2018, §3.3."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hijack_detect.detectors.input_watch import InputWatch, patience
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.estimation.ekf import GRAVITY
from hijack_detect.estimation.geodesy import LocalFrame
from hijack_detect.estimation.motion import GpsMotion, Motion
from hijack_detect.estimation.rotation import Array, matrix
from hijack_detect.parameters import Parameters, param
from hijack_detect.streams.samples import (
    NANOSECONDS,
    AttitudeSample,
    FixSample,
    VelocitySample,
)
from hijack_detect.streams.silence import SENSOR_PATIENCE_S

GRAVITY_ENU = np.array([0.0, 0.0, GRAVITY])


@dataclass(frozen=True)
class InsPositionParameters(Parameters):
    """One threshold; there is no hardened variant, the method is only compared with."""

    max_distance_m: float = param(
        10.0,
        "Largest horizontal distance between the dead-reckoned and the reported position that is "
        "normal. The paper gives none; an offset b of the acceleration alone exceeds it after "
        "sqrt(2 · 10 / b), 20 s at 0.05 m/s².",
        source="chosen, not swept; Feng 2018 gives none",
        unit="m",
        low=0.1,
        high=100_000.0,
    )
    max_velocity_age_s: float = param(
        1.0,
        "A GPS velocity older than this does not start the dead reckoning; then it comes from "
        "the last two fixes.",
        source="chosen, not swept",
        unit="s",
        low=0.1,
        high=60.0,
    )
    patience_s: float = patience()


class InsPosition:
    """Integrates `R f + g` twice (§3.2) from the first fix after the heading is known.

    Position and velocity start on the GPS and are never corrected, so every error of attitude
    and accelerometer grows without bound: Figure 3 of the paper shows why nobody flies with it.
    When the estimator loses the attitude, dead reckoning ends, and starts again with the heading.

    The GPS lag is ignored. It is in the start as in the comparison, so at a constant velocity
    it cancels.
    """

    NAME = "ins_position"
    PARAMETERS = InsPositionParameters
    ASKS = "dead-reckoned position against GPS (Feng 2018, §3.3), a baseline"

    def __init__(self, parameters: InsPositionParameters) -> None:
        """Start without position."""
        self._parameters = p = parameters
        self.inputs = {
            "attitude": p.patience_s,
            "velocity": SENSOR_PATIENCE_S,
            "fix": SENSOR_PATIENCE_S,
        }
        self._watch = InputWatch(("attitude", "fix"))
        self._gps = GpsMotion(p.max_velocity_age_s, p.max_velocity_age_s)
        self._reported: Motion | None = None
        self._frame: LocalFrame | None = None
        """East, north and up about the fix where dead reckoning began, None before."""
        self._position = self._velocity = np.zeros(3)
        self._acceleration: Array | None = None
        self._stamp_ns = 0

    def update(
        self, name: str, sample: AttitudeSample | FixSample | VelocitySample
    ) -> Verdict | None:
        """Take the next sample in order of stamp; every fix gives a verdict."""
        if isinstance(sample, VelocitySample):
            self._reported = self._gps.velocity(sample)
            return None
        if isinstance(sample, AttitudeSample):
            self._watch.see(name, sample.stamp_ns)
            self._integrate(sample)
            return self._verdict(sample.stamp_ns) if self._watch.due(sample.stamp_ns) else None
        if sample.has_fix:
            self._watch.see(name, sample.stamp_ns)
            motion = self._gps.fix(sample)
            if self._frame is None:
                recent = self._gps.measured(sample.stamp_ns)
                self._start(sample, self._reported if recent else motion)
        return self._verdict(sample.stamp_ns)

    def _integrate(self, sample: AttitudeSample) -> None:
        """Carry position and velocity to a sample; the acceleration between two is linear."""
        if sample.orientation is None:
            self._frame = self._acceleration = None
            return
        after = matrix(sample.orientation) @ np.array(sample.specific_force) - GRAVITY_ENU
        before, self._acceleration = self._acceleration, after
        dt = (sample.stamp_ns - self._stamp_ns) / NANOSECONDS
        self._stamp_ns = sample.stamp_ns
        if self._frame is not None and before is not None:
            self._position = (
                self._position + dt * self._velocity + dt * dt * (before / 3 + after / 6)
            )
            self._velocity = self._velocity + dt * (before + after) / 2

    def _start(self, fix: FixSample, motion: Motion | None) -> None:
        """Take position and velocity from the GPS, once there is an attitude to go on with."""
        if self._acceleration is None or motion is None:
            return
        self._frame = LocalFrame(fix)
        self._position, self._velocity = np.zeros(3), np.nan_to_num(motion.velocity)

    def _verdict(self, stamp_ns: int) -> Verdict:
        limit = self._parameters.max_distance_m
        lost = self._watch.lost(stamp_ns)
        if lost is not None:
            return Verdict(self.NAME, stamp_ns, lost[0], 0.0, limit, lost[1])
        fix = self._gps.last_fix
        if self._frame is None or fix is None:
            reason = "no attitude and GPS velocity to start from"
            return Verdict(self.NAME, stamp_ns, State.NOT_READY, 0.0, limit, reason)
        east, north, _ = self._frame.enu(fix)
        apart = math.hypot(east - self._position[0], north - self._position[1])
        state = State.ALARM if apart > limit else State.NORMAL
        reason = f"{apart:.1f} m from the dead-reckoned position (limit {limit:g} m)"
        values = {
            "gps_east": east,
            "gps_north": north,
            "ins_east": float(self._position[0]),
            "ins_north": float(self._position[1]),
        }
        return Verdict(self.NAME, stamp_ns, state, apart, limit, reason, values)
