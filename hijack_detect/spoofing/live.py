# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A spoofer on a live stream: attacks can be set and changed while it runs."""

from __future__ import annotations

from collections import deque

from hijack_detect.spoofing.scenario import Scenario
from hijack_detect.spoofing.spoofer import RECENT, Spoofer
from hijack_detect.streams.merge import RESTART_S
from hijack_detect.streams.samples import NANOSECONDS, FixSample, SatelliteSample, VelocitySample

NOTHING = Scenario("none", ())
"""The scenario without an attack."""
NEW_FLIGHT_S = 3600.0
"""A stamp that is later than the last one by more than this belongs to another flight."""


class LiveSpoofer:
    """Turns true samples into reported ones, under attacks that are set while it runs.

    An attack takes effect at the next fix, and its times count from the stamp of that fix, so a
    scenario that is set before the first fix counts from the first fix. It starts from the true
    samples before that, not from what was reported of them; setting it again starts it anew.
    Velocities and numbers of satellites that arrive later than that fix and have an older stamp
    are still under the attack before.

    When the stamps run far backwards, or ahead by an hour (a looped bag, a clock that was set),
    the attack starts anew with nothing known of the vehicle.

    Attributes:
        start_ns: Stamp of the fix from which the times of the scenario count, None before it.
        offset_m: Separation of the last true and the last reported fix, metres in three
            dimensions; 0 after a fix that was passed on as it is.
        restarts: How often the stamps have jumped to another flight.
    """

    def __init__(self, scenario: Scenario = NOTHING) -> None:
        """Begin with an attack."""
        self.start_ns: int | None = None
        self.offset_m = 0.0
        self.restarts = 0
        self._scenario = scenario
        self._pending = True
        self._before = self._spoofer = Spoofer(NOTHING, 0)
        self._last_ns: int | None = None
        self._fixes: deque[FixSample] = deque(maxlen=RECENT)
        self._velocities: deque[VelocitySample] = deque(maxlen=RECENT)

    def set(self, scenario: Scenario) -> None:
        """Replace the attack from the next fix on, or start the same one anew."""
        self._scenario = scenario
        self._pending = True

    def fix(self, sample: FixSample) -> FixSample:
        """Return what is reported in place of a true fix."""
        self._follow(sample.stamp_ns)
        if self._pending:
            self._begin(sample.stamp_ns)
        spoofer = self._at(sample.stamp_ns)
        reported = spoofer.fix(sample)
        self.offset_m = 0.0 if reported is sample else spoofer.offset_m
        if sample.has_fix:
            self._fixes.append(sample)
        return reported

    def velocity(self, sample: VelocitySample) -> VelocitySample:
        """Return what is reported in place of a true velocity."""
        self._velocities.append(sample)
        return self._at(sample.stamp_ns).velocity(sample)

    def satellites(self, sample: SatelliteSample) -> SatelliteSample:
        """Return what is reported in place of a true number of satellites."""
        return self._at(sample.stamp_ns).satellites(sample)

    def active(self, stamp_ns: int) -> bool:
        """Ground truth: whether an attack covers the stamp of a sample that was given."""
        return self._at(stamp_ns).active(stamp_ns)

    @property
    def onset_ns(self) -> int | None:
        """Stamp at which the attack on the last fix began, None if it was not attacked."""
        return None if self._last_ns is None else self._spoofer.onset_ns(self._last_ns)

    def _at(self, stamp_ns: int) -> Spoofer:
        """The spoofer in force at a stamp."""
        if self.start_ns is None or stamp_ns < self.start_ns:
            return self._before
        return self._spoofer

    def _follow(self, stamp_ns: int) -> None:
        """Notice the stamps of another flight."""
        last_ns, self._last_ns = self._last_ns, stamp_ns
        if last_ns is None:
            return
        ahead_s = (stamp_ns - last_ns) / NANOSECONDS
        if -RESTART_S <= ahead_s <= NEW_FLIGHT_S:
            return
        self.restarts += 1
        self._fixes.clear()
        self._velocities.clear()
        self._spoofer = Spoofer(NOTHING, 0)
        self._pending = True

    def _begin(self, stamp_ns: int) -> None:
        """Put the attack into force, with the last true samples known to it."""
        self._pending = False
        self._before, self._spoofer = self._spoofer, Spoofer(self._scenario, stamp_ns)
        self.start_ns = stamp_ns
        recent: list[FixSample | VelocitySample] = [*self._fixes, *self._velocities]
        for sample in sorted(recent, key=lambda one: one.stamp_ns):
            self._spoofer.report(sample)
