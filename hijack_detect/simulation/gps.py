# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The GPS receiver of the vehicle: late, noisy, and as honest as what answers its antenna."""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from typing import NamedTuple, Protocol

import numpy as np
import pymap3d
from pymap3d import ecef

from hijack_detect.estimation.geodesy import LocalFrame
from hijack_detect.simulation.conditions import Conditions
from hijack_detect.simulation.noise import Array, gauss_markov
from hijack_detect.simulation.plan import FlightPlan, Place
from hijack_detect.streams.samples import FixSample, SatelliteSample, Vector3, VelocitySample


class Receiver(Protocol):
    """The map from honest measurements to reported samples.

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
    """A receiver without an attack."""

    def fix(self, sample: FixSample) -> FixSample:
        """See Receiver."""
        return sample

    def velocity(self, sample: VelocitySample) -> VelocitySample:
        """See Receiver."""
        return sample

    def satellites(self, sample: SatelliteSample) -> SatelliteSample:
        """See Receiver."""
        return sample


GPS_HZ = 5
"""Feng 2018, section 5: GPS at 5 Hz."""
FIRST_S = 0.263
"""Arrival of the first fix, s. Chosen: no multiple of the IMU's period."""
VERTICAL = 1.5
"""Noise of the height over that of East and North. Physics: no satellite is below the horizon;
chosen."""


class Reading(NamedTuple):
    """A value with its stamp in nanoseconds."""

    stamp_ns: int
    value: float


class Gps:
    """The receiver's antenna and its output: measures, asks the receiver, keeps the report.

    A fix is stamped on arrival and holds the position of `gps_lag_s` before. Position:
    correlated and white noise; velocity: white noise. All noise is drawn in advance, also for the
    times at which the receiver is silent.

    Attributes:
        measured_fixes: What an honest receiver would have reported.
        fixes: The reported ones.
        velocities: Reported velocities, with the stamps of the fixes.
        satellites: Reported numbers of satellites, with the stamps of the fixes.
    """

    def __init__(
        self,
        plan: FlightPlan,
        conditions: Conditions,
        receiver: Receiver,
        rng: np.random.Generator,
    ) -> None:
        """Draw the noise of the whole flight."""
        self._place = (
            plan.place.latitude_deg,
            plan.place.longitude_deg,
            plan.place.altitude_m,
        )
        self._frame = LocalFrame(FixSample(0, *self._place))
        self._receiver = receiver
        self.lag_s = conditions.gps_lag_s
        times = np.arange(FIRST_S, plan.duration_s, 1.0 / GPS_HZ)
        size = (len(times), 3)
        noise = conditions.fix_noise_m * gauss_markov(
            rng.normal(size=size), conditions.fix_noise_s, GPS_HZ
        )
        noise += conditions.fix_white_m * rng.normal(size=size)
        noise = noise * [1.0, 1.0, VERTICAL] + plan.disturbances.jumped(times)
        velocity_noise = conditions.velocity_noise_m_s * rng.normal(size=size)
        counts = conditions.satellites + gauss_markov(rng.normal(size=size), 20.0, GPS_HZ)[:, 0]
        silent = np.array([plan.disturbances.silent(time) for time in times.tolist()])
        self._missed: deque[float] = deque(times[silent].tolist())
        self._arrivals: list[float] = times[~silent].tolist()
        self._stamps = [plan.start_ns + round(1e3 * time) * 1_000_000 for time in self._arrivals]
        self._position_noise: list[Vector3] = noise[~silent].tolist()
        self._velocity_noise: list[Vector3] = velocity_noise[~silent].tolist()
        self._counts = [round(count) for count in counts[~silent].tolist()]
        self.measured_fixes: list[FixSample] = []
        self.fixes: list[FixSample] = []
        self.velocities: list[VelocitySample] = []
        self.satellites: list[SatelliteSample] = []

    def arrived(self, now_s: float) -> bool:
        """Whether the next measurement is there, `now_s` seconds after the start."""
        index = len(self.fixes)
        return index < len(self._arrivals) and self._arrivals[index] <= now_s

    def missed(self, now_s: float) -> bool:
        """Whether a measurement was due at `now_s` seconds and the receiver is silent."""
        missed = False
        while self._missed and self._missed[0] <= now_s:
            self._missed.popleft()
            missed = True
        return missed

    @property
    def measured_s(self) -> float:
        """When the next measurement was true, seconds from the start."""
        return self._arrivals[len(self.fixes)] - self.lag_s

    def report(self, position: Vector3, velocity: Vector3) -> tuple[Vector3, Vector3]:
        """Measure a state (metres, m/s, ENU), and return what the receiver makes of it."""
        index = len(self.fixes)
        stamp = self._stamps[index]
        x, y, z = _sum(position, self._position_noise[index])
        u, v, w = _sum(velocity, self._velocity_noise[index])
        latitude, longitude, altitude = pymap3d.enu2geodetic(x, y, z, *self._place)
        measured = FixSample(
            stamp, round(float(latitude), 7), round(float(longitude), 7), round(float(altitude), 3)
        )
        speed = VelocitySample(stamp, (round(u, 3) + 0.0, round(v, 3) + 0.0, round(w, 3) + 0.0))
        self.measured_fixes.append(measured)
        self.fixes.append(self._receiver.fix(measured))
        self.velocities.append(self._receiver.velocity(speed))
        count = SatelliteSample(stamp, self._counts[index])
        self.satellites.append(self._receiver.satellites(count))
        return self._frame.enu(self.fixes[-1]), self.velocities[-1].velocity


def _sum(one: Vector3, other: Vector3) -> Vector3:
    return (one[0] + other[0], one[1] + other[1], one[2] + other[2])


def velocity_there(place: Place, fix: FixSample, velocity: VelocitySample) -> VelocitySample:
    """A velocity in the East and North of the start, in those of where the vehicle is.

    Simulated receivers report the former, which makes a difference near the poles only: 1 km East
    of the start it is 0.2 mm/s for each m/s at 50° of latitude, 9 mm/s at 89°.
    """
    fixed = ecef.enu2uvw(*velocity.velocity, place.latitude_deg, place.longitude_deg)
    east, north, up = ecef.uvw2enu(*fixed, fix.latitude_deg, fix.longitude_deg)
    return replace(velocity, velocity=(float(east), float(north), float(up)))


def geodetic(plan: FlightPlan, position: Array) -> list[Vector3]:
    """Latitude and longitude (degrees, to 1e-9) and height (metres, to 0.1 mm) of ENU (n, 3)."""
    place = plan.place
    latitude, longitude, altitude = pymap3d.enu2geodetic(
        *position.T, place.latitude_deg, place.longitude_deg, place.altitude_m
    )
    rows = zip(latitude.tolist(), longitude.tolist(), altitude.tolist(), strict=True)
    return [(round(north, 9), round(east, 9), round(up, 4)) for north, east, up in rows]
