# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What the samples of a flight were like: how many, with which stamps, and whether usable."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

from hijack_detect.streams.merge import SILENCE_S
from hijack_detect.streams.samples import (
    NANOSECONDS,
    FixSample,
    ImuSample,
    MagneticSample,
    PressureSample,
    Sample,
    SatelliteSample,
    VelocitySample,
)

NAMES: dict[type, str] = {
    ImuSample: "imu",
    FixSample: "fix",
    VelocitySample: "velocity",
    SatelliteSample: "satellites",
    MagneticSample: "mag",
    PressureSample: "pressure",
}
NEEDED = frozenset({"imu", "fix"})
"""Inputs without which nothing can be judged."""
STUCK = 0.9
"""Share of stamps that repeat the one before from which on an input has no usable stamps."""
JUMP_NS = round(SILENCE_S * NANOSECONDS)
"""A step of the stamps that the order of inputs takes for an outage or a clock that was set."""
LIGHT, HEAVY = 6.9, 29.4
"""m/s²: mean magnitudes of the specific force of no flight. Accelerations cancel out, so gravity
remains (0.7 of it: no flight falls for long), and vibration adds to it: 3 g is 16 m/s² an axis."""


@dataclass
class Stamps:
    """What was noted of the stamps of one input, nanoseconds.

    `set_back` is the largest step back, `ahead` the sum of all steps of more than JUMP_NS.
    """

    count: int = 0
    first: int = 0
    last: int = 0
    repeated: int = 0
    set_back: int = 0
    ahead: int = 0

    def add(self, stamp_ns: int) -> None:
        """Take the next stamp."""
        if self.count:
            step = stamp_ns - self.last
            if step == 0:
                self.repeated += 1
            elif step > JUMP_NS:
                self.ahead += step
            elif -step > self.set_back:
                self.set_back = -step
        else:
            self.first = stamp_ns
        self.count += 1
        self.last = stamp_ns

    @property
    def stuck(self) -> bool:
        """Whether the stamps do not advance."""
        return self.count > 1 and self.repeated >= STUCK * (self.count - 1)


@dataclass
class Inputs:
    """Notes of all samples; `forces` is the sum of the magnitudes of the specific force, m/s²."""

    stamps: dict[str, Stamps] = field(default_factory=dict)
    fixes: int = 0
    forces: float = 0.0

    def add(self, sample: Sample) -> None:
        """Take the next sample."""
        name = NAMES.get(type(sample))
        if name is None:
            return
        stamps = self.stamps.get(name)
        if stamps is None:
            stamps = self.stamps[name] = Stamps()
        stamps.add(sample.stamp_ns)
        if isinstance(sample, ImuSample):
            self.forces += math.hypot(*sample.specific_force)
        elif isinstance(sample, FixSample):
            self.fixes += sample.has_fix

    def count(self, name: str) -> int:
        """Number of samples of an input."""
        return self.stamps[name].count if name in self.stamps else 0

    def unusable(self) -> str:
        """Why nothing can be judged with these inputs; empty if that is not known."""
        stuck = [name for name, one in self.stamps.items() if one.stuck]
        if NEEDED & {*stuck}:
            zero = "" if any(self.stamps[name].last for name in stuck) else ": all are 0"
            return f"the header stamps of {_list(sorted(stuck))} do not advance{zero}"
        if not self.count("fix"):
            return "there is no position of the GPS"
        if not self.fixes:
            return f"no usable fix in {self.count('fix')} messages of the receiver"
        if not self.count("imu"):
            return "there is no IMU"
        mean = self.forces / self.count("imu")
        if not LIGHT < mean < HEAVY:
            return (
                f"the accelerometer reads {mean:.3g} m/s² on average, where a vehicle feels "
                "9.8 m/s²: wrong unit or scale"
            )
        return ""

    def notes(self, duration_s: float) -> Iterator[str]:
        """What is odd about the stamps, a sentence each.

        Args:
            duration_s: From the first to the last message by log time: a clock that was set
                forward looks like an outage, but that its stamps span more than the log does.
        """
        back = {name: one.set_back / 1e9 for name, one in self.stamps.items() if not one.stuck}
        set_back = sorted(name for name, seconds in back.items() if seconds > SILENCE_S)
        if set_back:
            most = max(back[name] for name in set_back)
            yield f"The header stamps of {_list(set_back)} were set back by {most:.1f} s."
        longer = {
            name: (one.last - one.first) / NANOSECONDS - duration_s
            for name, one in self.stamps.items()
            if one.ahead
        }
        ahead = sorted(name for name, seconds in longer.items() if seconds > SILENCE_S)
        if ahead:
            most = max(longer[name] for name in ahead)
            yield f"The header stamps of {_list(ahead)} jumped ahead by {most:.1f} s."
        stuck = sorted(name for name, one in self.stamps.items() if one.stuck)
        if stuck and not NEEDED & {*stuck}:  # else it is why nothing could be judged
            yield f"The header stamps of {_list(stuck)} do not advance."


def _list(names: list[str]) -> str:
    """Names in words."""
    return " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
