# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What stands between the antenna and everybody who trusts it."""

from __future__ import annotations

from typing import Protocol

from hijack_detect.streams.samples import FixSample, SatelliteSample, VelocitySample


class Receiver(Protocol):
    """Turns what an honest receiver would have measured into what is reported.

    It is given every sample in order of stamp, of one stamp the fix, then the velocity, then the
    number of satellites.
    """

    def fix(self, sample: FixSample) -> FixSample:
        """Return the reported fix in place of a measured one."""
        ...

    def velocity(self, sample: VelocitySample) -> VelocitySample:
        """Return the reported velocity (m/s, ENU) in place of a measured one."""
        ...

    def satellites(self, sample: SatelliteSample) -> SatelliteSample:
        """Return the reported number of satellites in place of the true one."""
        ...


class HonestReceiver:
    """Reports what it measures."""

    def fix(self, sample: FixSample) -> FixSample:
        """See Receiver."""
        return sample

    def velocity(self, sample: VelocitySample) -> VelocitySample:
        """See Receiver."""
        return sample

    def satellites(self, sample: SatelliteSample) -> SatelliteSample:
        """See Receiver."""
        return sample
