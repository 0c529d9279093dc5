# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A picture of the live page that a test feeds as the node does."""

from __future__ import annotations

from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.live.picture import Picture
from hijack_detect.monitor.parts import DETECTORS
from hijack_detect.monitor.verdict_messages import FusionStatus
from hijack_detect.streams.samples import FixSample

START_NS = 1_700_000_000_000_000_000
SECOND = 1_000_000_000


class Flown:
    """A flight to the North East at 10 m/s; `now` is the clock on the wall."""

    def __init__(self) -> None:
        self.now = 100.0
        self.picture = Picture(DETECTORS, lambda: self.now)
        self.time_s = 0.0

    @property
    def stamp_ns(self) -> int:
        return START_NS + round(self.time_s * SECOND)

    def fly(
        self,
        seconds: float,
        state: State = State.NORMAL,
        margin: float = 0.2,
        *,
        alert: bool = False,
        degraded: tuple[str, ...] = (),
        reason: str = "consistent",
        rate_hz: float = 5.0,
    ) -> None:
        """Let fixes, verdicts of all detectors and what the fusion says come in."""
        for _ in range(round(seconds * rate_hz)):
            self.time_s += 1.0 / rate_hz
            self.now += 1.0 / rate_hz
            north = 1e-4 * self.time_s
            self.picture.receive_fix(FixSample(self.stamp_ns, 48.0 + north, 11.0 + north, 500.0))
            for name in DETECTORS:
                given = Verdict(name, self.stamp_ns, state, margin, 1.0, reason)
                self.picture.receive_verdict(name, given)
            since = self.stamp_ns if alert else None
            told = State.ALARM if alert else state
            causes = tuple(DETECTORS) if alert else ()
            self.picture.receive_fused(
                FusionStatus(
                    self.stamp_ns, told, alert, since, margin, degraded, degraded, causes, reason
                )
            )
            self.picture.receive_alert(alert)
            self.picture.receive_confidence(0.9 if alert else 0.1)
