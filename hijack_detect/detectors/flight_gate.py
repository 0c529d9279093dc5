# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Whether a detector that means flight may judge: phase of the flight, and health of the IMU."""

from __future__ import annotations

from hijack_detect.detectors.verdict import State
from hijack_detect.streams.samples import NANOSECONDS, Phase, PhaseSample

INPUT = "phase"
"""Name of the input."""
MIN_IMU_HZ = 22.0
"""Slowest IMU that a detector with an attitude can use, Hz. The same flights have the verdicts of
50 Hz down to 25 Hz; at 20 Hz `coast` and `date` miss carry-offs that they find at 50 Hz
(docs/detection-limits.md, the rate of the IMU)."""
SILENT_NS = 3 * NANOSECONDS
"""Without a phase for this long a detector goes on as in flight: better a false alarm than none."""


def imu_trouble(sample: PhaseSample, min_imu_hz: float = MIN_IMU_HZ) -> str:
    """Why the IMU cannot be used, with figures; empty if it can.

    The rate comes first: samples that are too few alias, and have a wrong mean force from that.
    """
    if sample.imu_rate_hz < min_imu_hz:
        rate = f"the IMU arrives at {sample.imu_rate_hz:.0f} Hz"
        return f"{rate}, {min_imu_hz:.0f} Hz are needed"
    return sample.imu_fault


class FlightGate:
    """Keeps the newest phase of the flight."""

    def __init__(self, min_imu_hz: float = MIN_IMU_HZ) -> None:
        """Judge in flight only.

        Args:
            min_imu_hz: Slowest IMU that the detector can use, Hz; 0 for one that needs none.
        """
        self._min_imu_hz = min_imu_hz
        self._last: PhaseSample | None = None
        self._airborne_ns: int | None = None

    def update(self, sample: PhaseSample) -> bool:
        """Take the next phase; return whether the vehicle is in the air from it on."""
        before, self._last = self._last, sample
        if not sample.phase.airborne:
            self._airborne_ns = None
            return False
        took_off = before is None or not before.phase.airborne
        if took_off:
            self._airborne_ns = sample.stamp_ns
        return took_off

    def airborne_s(self, stamp_ns: int) -> float:
        """Time since the vehicle is known to be in the air, s; infinite where there is no phase."""
        if self._fresh(stamp_ns) is None:
            return float("inf")
        since = self._airborne_ns
        return 0.0 if since is None else max(0, stamp_ns - since) / NANOSECONDS

    def blocked(self, stamp_ns: int) -> tuple[State, str] | None:
        """State and reason where the GPS cannot be judged; None where the gate is open."""
        last = self._fresh(stamp_ns)
        if last is None:
            return None
        if last.phase is Phase.UNKNOWN:
            return State.NOT_READY, f"not known to be in flight: {last.reason}"
        if not last.phase.airborne:
            return State.NOT_OBSERVABLE, f"not in flight: {last.phase.value}, {last.reason}"
        if not self._min_imu_hz:
            return None
        trouble = imu_trouble(last, self._min_imu_hz)
        return (State.NOT_OBSERVABLE, trouble) if trouble else None

    def _fresh(self, stamp_ns: int) -> PhaseSample | None:
        last = self._last
        return last if last is not None and stamp_ns - last.stamp_ns <= SILENT_NS else None
