# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What makes a clean flight hard: gusts, spins, a bent field, a silent or jumping GPS, vibration.

Nothing here draws random numbers, so that a flight is the same with and without it up to its
begin. Only `Vibration` is noise; it has a generator of its own, see `sensors.py`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hijack_detect.simulation.noise import Array
from hijack_detect.streams.samples import Vector3


@dataclass(frozen=True)
class Pulse:
    """Something that comes, stays and goes, along half a cosine each way.

    Without a stay it is the discrete 1-cos gust of the airworthiness rules (CS-25.341).

    Attributes:
        start_s: When it begins, seconds from the start of the recording.
        rise_s: Seconds to rise, and to fall again; 0 is a step.
        hold_s: Seconds at full height in between; infinite for ever.
    """

    start_s: float
    rise_s: float
    hold_s: float = 0.0

    def __post_init__(self) -> None:
        """Check the times.

        Raises:
            ValueError: A time is negative or not a number; the text names it.
        """
        _not_negative("start", self.start_s)
        _not_negative("rise", self.rise_s)
        if not self.hold_s >= 0.0:
            raise ValueError(f"hold is {self.hold_s!r} s, it must not be negative")

    def height(self, time: Array) -> Array:
        """Part of the full height, 0 to 1, at times in seconds; shape as `time`."""
        since, left = time - self.start_s, self.start_s + 2.0 * self.rise_s + self.hold_s - time
        inside = np.minimum(since, left)
        if self.rise_s == 0.0:
            return np.where(inside >= 0.0, 1.0, 0.0)
        risen = np.clip(inside / self.rise_s, 0.0, 1.0)
        height: Array = 0.5 - 0.5 * np.cos(np.pi * risen)
        return height


@dataclass(frozen=True)
class Gust:
    """A gust over the wind of the flight: its course over time, and m/s in ENU at full height."""

    pulse: Pulse
    velocity: Vector3


@dataclass(frozen=True)
class Anomaly:
    """A foreign magnetic field at the magnetometer: its course over time, tesla in ENU.

    The heading of the autopilot does not follow it: see docs/simulator.md.
    """

    pulse: Pulse
    field_enu_t: Vector3


@dataclass(frozen=True)
class Spin:
    """The nose turns round, and the vehicle flies on as before.

    Whole turns leave the nose where it was, so that it follows the course again.

    Attributes:
        start_s: Begin, seconds from the start of the recording.
        turns: How many turns to the left; negative to the right.
        rate_deg_s: How fast, degrees a second, 10 to 180.
    """

    start_s: float
    turns: float
    rate_deg_s: float

    def __post_init__(self) -> None:
        """Check the values.

        Raises:
            ValueError: A value is outside what is allowed; the text names it.
        """
        _not_negative("start", self.start_s)
        if not 10.0 <= self.rate_deg_s <= 180.0:
            raise ValueError(f"rate is {self.rate_deg_s!r} °/s, not within [10, 180]")
        if not math.isfinite(self.turns):
            raise ValueError(f"turns are {self.turns!r}, they must be finite")

    @property
    def end_s(self) -> float:
        """When the last turn is done, seconds from the start of the recording."""
        return self.start_s + 360.0 * abs(self.turns) / self.rate_deg_s

    def angle(self, time: Array) -> Array:
        """How far it has turned at times in seconds, radians; shape as `time`."""
        turned: Array = np.interp(time, [self.start_s, self.end_s], [0.0, math.tau * self.turns])
        return turned


@dataclass(frozen=True)
class Outage:
    """An outage of the receiver; its noise goes on as without one.

    Attributes:
        start_s: Begin, seconds from the start of the recording.
        duration_s: How long.
    """

    start_s: float
    duration_s: float

    def __post_init__(self) -> None:
        """Check the times.

        Raises:
            ValueError: A time is negative or not finite; the text names it.
        """
        _not_negative("start", self.start_s)
        _not_negative("duration", self.duration_s)

    def covers(self, time_s: float) -> bool:
        """Whether nothing arrives at this time."""
        return self.start_s <= time_s < self.start_s + self.duration_s


@dataclass(frozen=True)
class Jump:
    """An honest receiver steps aside and stays there, as it does when a satellite sets.

    Attributes:
        start_s: When, seconds from the start of the recording.
        offset: From the next fix on, metres in ENU. The velocity knows nothing of it.
    """

    start_s: float
    offset: Vector3

    def __post_init__(self) -> None:
        """Check the time.

        Raises:
            ValueError: It is negative or not finite.
        """
        _not_negative("start", self.start_s)


@dataclass(frozen=True)
class Vibration:
    """Rotors out of balance on a hard mount, read without a filter before the sampling.

    Attributes:
        force_rms: Vibration of the accelerometer in flight, m/s² rms on each axis.
        rotor_hz: Mean revolutions a second of the rotors. What is above half of the sampling rate
            is read as a lower frequency.
        wander_hz: Deviation of each rotor from that, as the motors are regulated.
        white: White noise of the IMU in units of what the flight has drawn.
    """

    force_rms: float
    rotor_hz: float
    wander_hz: float = 4.0
    white: float = 3.0

    def __post_init__(self) -> None:
        """Check the values.

        Raises:
            ValueError: A value is negative or not finite; the text names it.
        """
        _not_negative("force", self.force_rms)
        _not_negative("rotor frequency", self.rotor_hz)
        _not_negative("wander", self.wander_hz)
        _not_negative("white noise", self.white)


@dataclass(frozen=True)
class Disturbances:
    """Everything that makes a flight harder than its seed; without any it is as the seed has it.

    Attributes:
        turbulence_m_s: Deviation of the horizontal gusts, m/s; None leaves 5 to 20 % of the wind.
        gusts: Discrete gusts; they add up.
        spins: Spins of the nose, over the heading of the route.
        anomalies: Foreign magnetic fields.
        outages: When the receiver is silent.
        jumps: Steps of the receiver; they add up.
        vibration: Strong vibration in flight, over the usual one.
    """

    turbulence_m_s: float | None = None
    gusts: tuple[Gust, ...] = ()
    spins: tuple[Spin, ...] = ()
    anomalies: tuple[Anomaly, ...] = ()
    outages: tuple[Outage, ...] = ()
    jumps: tuple[Jump, ...] = ()
    vibration: Vibration | None = None

    def __post_init__(self) -> None:
        """Check the turbulence.

        Raises:
            ValueError: It is negative or not finite.
        """
        if self.turbulence_m_s is not None:
            _not_negative("turbulence", self.turbulence_m_s)

    def gust(self, time: Array) -> Array:
        """What the gusts add to the wind at times in seconds, m/s in ENU, shape (n, 3)."""
        return _sum(time, [(one.pulse, one.velocity) for one in self.gusts])

    def field(self, time: Array) -> Array:
        """What the anomalies add to the field of the place, tesla in ENU, shape (n, 3)."""
        return _sum(time, [(one.pulse, one.field_enu_t) for one in self.anomalies])

    def jumped(self, time: Array) -> Array:
        """What the jumps add to the fixes that arrive at times in seconds, metres, shape (n, 3)."""
        steps = [(Pulse(one.start_s, 0.0, math.inf), one.offset) for one in self.jumps]
        return _sum(time, steps)

    def silent(self, time_s: float) -> bool:
        """Whether the receiver is silent at this time."""
        return any(one.covers(time_s) for one in self.outages)


def _sum(time: Array, parts: list[tuple[Pulse, Vector3]]) -> Array:
    total: Array = np.zeros((len(time), 3))
    for pulse, vector in parts:
        total += pulse.height(time)[:, None] * np.array(vector)
    return total


def _not_negative(name: str, value: float) -> None:
    if not 0.0 <= value < math.inf:
        raise ValueError(f"{name} is {value!r}, it must be finite and not negative")
