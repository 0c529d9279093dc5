# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Phase of the flight from IMU, barometer and GPS speed: standing, handled, flying, crashed."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

from hijack_detect.estimation.barometer import pressure_height
from hijack_detect.estimation.ekf import GRAVITY
from hijack_detect.estimation.imu_health import ImuHealth, moments
from hijack_detect.parameters import Parameters, param
from hijack_detect.streams.samples import (
    NANOSECONDS,
    FixSample,
    ImuSample,
    Phase,
    PhaseSample,
    PressureSample,
    Vector3,
    VelocitySample,
)
from hijack_detect.streams.silence import sensor_patience

EVALUATE_NS = NANOSECONDS // 5
"""A phase is decided this often: those that wait for it lose no more.
Chosen, not swept;"""
WINDOW_NS = NANOSECONDS
"""Deviations of the IMU are over this time, or over `LEAST_SAMPLES` where that is longer.
Chosen, not swept."""
LEAST_SAMPLES = 8
"""Of a window that is judged. Chosen, not swept."""
LONGEST_NS = 8 * NANOSECONDS
"""A longer gap in the IMU empties the window. Chosen, not swept."""
CONFIRM_NS = 2 * NANOSECONDS
"""A change of phase needs evidence for this long: longer than a bump, shorter than a climb.
Chosen, not swept."""
KEEP_NS = 30 * NANOSECONDS
"""After a longer gap in the IMU the phase is unknown: batteries are changed in a minute.
Chosen, not swept."""
FRESH_NS = 2 * NANOSECONDS
"""GPS and barometer older than this are not used. Chosen, not swept."""
STILL_SPEED, STILL_CLIMB = 1.0, 0.4
"""m/s: a vehicle on the ground shows less by GPS and by barometer (measured: 0.1 to 0.7, 0.1)."""
REFERENCE_S = 30.0
"""Time constant of the height of the ground, which follows a barometer that warms up.
Chosen, not swept."""
REST_S, FLIGHT_S = 10.0, 60.0
"""Time constants of the usual deviations at rest and in flight. Chosen, not swept."""
SHARE = 0.3
"""At rest a deviation is nearer than this share (of the logarithms) to what it is at rest.
Chosen, not swept."""
APART = 2.0
"""A deviation separates rest from flight if it is this many times larger in flight.
Chosen, not swept."""
REST = (0.01, 0.05)
"""rad/s and m/s²: deviations at rest before any was seen, of the quietest recorded vehicle."""
DISTURBED = 0.03
"""rad/s: no recorded vehicle at rest has a larger deviation of its angular velocity, motors off."""
RESTLESS = 0.35
"""m/s²: the same for the specific force."""
ASSUME_NS = 20 * NANOSECONDS
"""A vehicle that shakes upright for this long is taken to fly where no barometer shows how high it
is, or where the monitor has just started, perhaps in a hover. Chosen, not swept."""
STEADY = math.cos(math.radians(20.0))
"""Mean lean over a second in a hover or a slow flight; a vehicle in a hand leans more.
Chosen, not swept."""
LEAN, LYING = math.cos(math.radians(35.0)), math.cos(math.radians(60.0))
"""The specific force of a vehicle that flies is along its z axis: thrust or lift. Further off, and
as large as gravity, it hangs in a hand or lies on its side."""
SLOW = 3.0
"""m/s: aerobatics are faster, and hands slower. Chosen, not swept."""
LANDED_M, LANDED_SHARE = 3.0, 0.5
"""A vehicle higher over its take-off than this, and than this share of the flight's height, has
not landed, however quiet its hover is. Chosen, not swept."""
LOW_M, SINKING = 1.5, -0.2
"""A landing: lower than this over the take-off, climbing at less than this, m/s, for 1 s.
Chosen, not swept."""
TOUCH = 2.0
"""A deviation of the specific force this many times the usual one of the flight, lower than LOW_M,
may be the bump of a touch-down. Motors that idle on the ground shake the accelerometer as much as
in flight (recorded: 0.45 and 0.45 m/s²), but they do not turn the vehicle (0.02 and 0.3 rad/s)."""
STOPPED = 0.125
"""After such a bump the vehicle stands when its angular velocity deviates by less than this share
of the usual one of the flight. Recorded with idling motors: 0.05 to 0.1."""
HANDLED_NS = 6 * NANOSECONDS
"""Take-offs show their height within this time; a vehicle that turns for longer is in a hand.
Chosen, not swept."""
HAND_NS = 10 * NANOSECONDS
"""For this long after it hung in a hand or lay, a take-off takes twice the evidence.
Chosen, not swept."""
EARTH_M = 6_371_000.0
"""Mean radius of the Earth, for speeds."""


@dataclass(frozen=True)
class FlightPhaseParameters(Parameters):
    """Evidence for flight or ground."""

    takeoff_height: float = param(
        1.5,
        "A vehicle that is disturbed and this much higher than where it stood, by the barometer, "
        "flies. Barometers indoors and in gusts move by less than 1 m.",
        source="measured: recorded barometers on the ground stay below 1 m",
        basic=True,
        unit="m",
        low=0.3,
        high=50.0,
    )
    moving_speed: float = param(
        2.0,
        "A vehicle that is disturbed and faster than this over ground flies, once it went as far "
        "as that is in 2 s; one in a hand has to be twice as fast.",
        source="chosen: a walking person carries a vehicle at 1.4 m/s",
        basic=True,
        unit="m/s",
        low=0.5,
        high=50.0,
    )
    climb_rate: float = param(
        0.6,
        "Without a barometer a vehicle that climbs faster than this by GPS flies, once it climbed "
        "as far as that is in 2 s.",
        source="chosen, not swept",
        unit="m/s",
        low=0.1,
        high=10.0,
    )
    clip_share: float = param(
        0.01,
        "The accelerometer clips when this share of its samples of 2 s repeats the largest "
        "reading of one axis to the bit.",
        source="chosen, not swept",
        low=0.001,
        high=1.0,
    )
    max_vibration: float = param(
        0.85,
        "The IMU cannot be used above this vibration: the deviation of the difference of "
        "successive specific forces over √2, over the root of the rate. Healthy recorded vehicles "
        "have 0.02 to 0.5 in flight, those whose attitude failed 1.1 to 2.",
        source="measured: between the healthy recorded vehicles and those whose attitude failed",
        unit="m/s²/√Hz",
        low=0.05,
        high=100.0,
    )
    max_force_error: float = param(
        1.5,
        "The specific force cannot be used if at rest it is this far from gravity: wrong unit or "
        "scale. Recorded vehicles are off by up to 0.6 m/s².",
        source="measured: 2.5 times the largest of recorded vehicles",
        unit="m/s²",
        low=0.2,
        high=10.0,
    )
    sensor_patience_s: float = sensor_patience()


HELD = ("up", "fast", "rising", "shaking", "turning", "rest", "off", "sinking")
"""Conditions that have to last."""


class _Held:
    """Time for which a condition has held."""

    def __init__(self) -> None:
        self._since_ns: int | None = None

    def ns(self, stamp_ns: int, condition: bool) -> int:
        """Nanoseconds for which the condition has held, -1 where it does not."""
        if not condition:
            self._since_ns = None
            return -1
        if self._since_ns is None:
            self._since_ns = stamp_ns
        return stamp_ns - self._since_ns


@dataclass(frozen=True, slots=True)
class _Motion:
    """Evidence at one moment; NaN where there is none.

    Attributes:
        gyro: Standard deviation of the angular velocity, rad/s.
        force: Standard deviation of the specific force, m/s².
        upright: Cosine between specific force and body z.
        weight: Mean specific force, m/s².
        speed: Horizontal, by GPS, m/s.
        rise: By GPS, m/s.
        climb: By barometer over 2 s, m/s.
        height: By barometer over the ground, m.
    """

    gyro: float
    force: float
    upright: float
    weight: float
    speed: float
    rise: float
    climb: float
    height: float


class FlightPhaseEstimator:
    """Decides five times a second on the stamps of the IMU.

    Take-off is seen as height over the ground, as speed, or as climb of a vehicle that is
    disturbed. Rest after a flight is seen as the deviations of gyroscope and accelerometer
    returning to what they are at rest; a vehicle whose hover is as quiet as its rest is never
    taken to stand, so hover stays flight. A specific force off body z is a hand or a crash.
    """

    NAME = "phase"

    PARAMETERS = FlightPhaseParameters

    def __init__(self, parameters: FlightPhaseParameters) -> None:
        """Start without data."""
        self._p = p = parameters
        self.inputs: Mapping[str, float] = dict.fromkeys(
            ("imu", "pressure", "velocity", "fix"), p.sensor_patience_s
        )
        self._health = ImuHealth(p.clip_share, p.max_vibration, p.max_force_error)
        self._rest = REST
        self._begin()

    def _begin(self) -> None:
        self._imu: deque[ImuSample] = deque()
        self._baro: deque[tuple[int, float]] = deque()
        self._ground: float | None = None
        self._velocity: VelocitySample | None = None
        self._fix: FixSample | None = None
        self._by_fixes: tuple[int, float, float] | None = None
        self._flight = (0.0, 0.0)
        self._phase, self._since_ns, self._reason = Phase.UNKNOWN, 0, "no evidence yet"
        self._decided_ns: int | None = None
        self._held = {name: _Held() for name in HELD}
        self._disturbed_ns: int | None = None
        self._off_ns: int | None = None
        self._moved = False
        """Whether the flight went faster than a hand does."""
        self._top = 0.0
        """Largest height of the flight over the ground, m."""
        self._touched = False
        """Whether the vehicle may have touched down and has not climbed since."""

    def update(
        self, name: str, sample: ImuSample | PressureSample | VelocitySample | FixSample
    ) -> PhaseSample | None:
        """Take the next sample in order of stamp; an IMU sample may give a phase."""
        if isinstance(sample, ImuSample):
            return self._take(sample)
        if isinstance(sample, PressureSample):
            self._baro.append((sample.stamp_ns, pressure_height(sample.pressure_pa)))
            while self._baro[0][0] < sample.stamp_ns - 2 * NANOSECONDS:
                self._baro.popleft()
        elif isinstance(sample, VelocitySample):
            self._velocity = sample
        elif sample.has_fix:
            self._move(sample)
        return None

    def _move(self, fix: FixSample) -> None:
        """Speed from fixes, for receivers without a velocity: over at least a second."""
        before = self._fix
        if before is None or fix.stamp_ns - before.stamp_ns > 2 * FRESH_NS:
            self._fix = fix
            return
        dt = (fix.stamp_ns - before.stamp_ns) / NANOSECONDS
        if dt < 1.0:
            return
        north = math.radians(fix.latitude_deg - before.latitude_deg) * EARTH_M
        east = math.radians(math.remainder(fix.longitude_deg - before.longitude_deg, 360.0))
        east *= EARTH_M * math.cos(math.radians(fix.latitude_deg))
        rise = (fix.altitude_m - before.altitude_m) / dt
        self._fix, self._by_fixes = fix, (fix.stamp_ns, math.hypot(east, north) / dt, rise)

    def _take(self, sample: ImuSample) -> PhaseSample | None:
        stamp = sample.stamp_ns
        if self._imu and stamp - self._imu[-1].stamp_ns > KEEP_NS:
            self._begin()
        elif self._imu and stamp - self._imu[-1].stamp_ns > LONGEST_NS:
            self._imu.clear()
        self._health.add(sample)
        self._imu.append(sample)
        while len(self._imu) > LEAST_SAMPLES and self._imu[1].stamp_ns <= stamp - WINDOW_NS:
            self._imu.popleft()
        if self._decided_ns is None:
            self._decided_ns = self._since_ns = stamp
        if stamp - self._decided_ns < EVALUATE_NS or len(self._imu) < LEAST_SAMPLES:
            return None
        seconds = (stamp - self._decided_ns) / NANOSECONDS
        self._decided_ns = stamp
        motion = self._motion(stamp)
        decided = self._decide(stamp, motion)
        if decided is not None and decided[0] is not self._phase:
            self._change(stamp, *decided, motion)
        self._learn(motion, min(seconds, 1.0))
        return PhaseSample(
            stamp,
            self._phase,
            self._since_ns,
            self._reason,
            self._health.rate_hz,
            self._health.fault(self._phase),
        )

    def _change(self, stamp_ns: int, phase: Phase, reason: str, motion: _Motion) -> None:
        if phase.airborne and not self._phase.airborne:
            self._flight, self._moved = (motion.gyro, motion.force), False
            self._top, self._touched = 0.0, False
        elif not phase.airborne:
            self._ground = None
        self._phase, self._since_ns, self._reason = phase, stamp_ns, reason
        for held in self._held.values():
            held.ns(stamp_ns, False)

    def _motion(self, stamp_ns: int) -> _Motion:
        gyro, _ = _deviation([one.angular_velocity for one in self._imu])
        force, (x, y, z) = _deviation([one.specific_force for one in self._imu])
        weight = math.hypot(x, y, z)
        speed = rise = math.nan
        velocity, by_fixes = self._velocity, self._by_fixes
        if velocity is not None and stamp_ns - velocity.stamp_ns <= FRESH_NS:
            speed, rise = math.hypot(*velocity.velocity[:2]), velocity.velocity[2]
        elif by_fixes is not None and stamp_ns - by_fixes[0] <= FRESH_NS:
            _, speed, rise = by_fixes
        climb = height = math.nan
        if self._baro and stamp_ns - self._baro[-1][0] <= FRESH_NS:
            newest = math.fsum(h for _, h in self._baro) / len(self._baro)
            first, last = self._baro[0], self._baro[-1]
            if last[0] - first[0] >= NANOSECONDS:
                climb = (last[1] - first[1]) * NANOSECONDS / (last[0] - first[0])
            if self._ground is None:
                self._ground = newest
            height = last[1] - self._ground
        return _Motion(
            gyro, force, z / weight if weight else 1.0, weight, speed, rise, climb, height
        )

    def _decide(self, stamp_ns: int, m: _Motion) -> tuple[Phase, str] | None:
        """The phase and why; None to stay."""
        if m.gyro > max(1.5 * self._rest[0], DISTURBED):
            self._disturbed_ns = stamp_ns
        heavy = abs(m.weight - GRAVITY) < 0.2 * GRAVITY
        slow = not m.speed > SLOW
        off_axis = heavy and slow and m.upright < (LYING if self._phase.airborne else LEAN)
        lies = self._held["off"].ns(stamp_ns, off_axis) >= NANOSECONDS
        if lies:
            self._off_ns = stamp_ns
        rests = self._held["rest"].ns(stamp_ns, self._at_rest(m)) >= CONFIRM_NS
        angle = math.degrees(math.acos(max(-1.0, min(1.0, m.upright))))
        if self._phase.airborne:
            self._moved |= m.speed > SLOW
            bump = m.force > TOUCH * self._flight[1]
            self._touched = m.height < LOW_M and (self._touched or bump)
            if lies:
                reason = f"specific force {angle:.0f}° off the body's z axis"
                return (Phase.CRASHED if self._moved else Phase.HANDLED), reason
            if rests:
                return Phase.STANDING, f"IMU at rest ({m.gyro:.3f} rad/s, {m.force:.2f} m/s²)"
            return self._airborne(stamp_ns, m)
        took_off = self._took_off(stamp_ns, m)
        if took_off:
            return Phase.FLYING, took_off
        if rests:
            return Phase.STANDING, f"IMU at rest ({m.gyro:.3f} rad/s, {m.force:.2f} m/s²)"
        turns = self._held["turning"].ns(stamp_ns, m.gyro > 5.0 * DISTURBED and slow)
        if (lies or turns >= HANDLED_NS) and self._phase is not Phase.CRASHED:
            return Phase.HANDLED, f"turned at {m.gyro:.2f} rad/s, tilted by {angle:.0f}°"
        return None

    def _airborne(self, stamp_ns: int, m: _Motion) -> tuple[Phase, str]:
        sinks = not m.speed > 2.0 and m.climb < SINKING and m.height < LOW_M
        if self._held["sinking"].ns(stamp_ns, sinks) >= NANOSECONDS:
            return Phase.LANDING, f"sinking at {-m.climb:.1f} m/s, {m.height:.1f} m over the ground"
        if self._phase is Phase.LANDING and not (m.climb > -SINKING or m.speed > 2.0):
            return Phase.LANDING, self._reason
        if self._phase is Phase.FLYING:
            return Phase.FLYING, self._reason
        return Phase.FLYING, "the landing was broken off"

    def _took_off(self, stamp_ns: int, m: _Motion) -> str:
        """Evidence of flight, empty if there is none."""
        p = self._p
        in_hand = self._off_ns is not None and stamp_ns - self._off_ns < HAND_NS
        times = 2.0 if in_hand else 1.0
        recently = self._disturbed_ns
        disturbed = recently is not None and stamp_ns - recently <= 3 * NANOSECONDS
        upright = m.upright > LEAN
        up = self._held["up"].ns(
            stamp_ns, disturbed and upright and m.height > times * p.takeoff_height
        )
        fast = self._held["fast"].ns(stamp_ns, disturbed and m.speed > times * p.moving_speed)
        rising = self._held["rising"].ns(
            stamp_ns, disturbed and math.isnan(m.height) and m.rise > times * p.climb_rate
        )
        blind = self._phase is Phase.UNKNOWN or math.isnan(m.height)
        shaking = self._held["shaking"].ns(
            stamp_ns, blind and m.gyro > DISTURBED and m.upright > STEADY and not in_hand
        )
        if up >= times * NANOSECONDS:
            return f"{m.height:.1f} m over the ground by barometer"
        if fast * m.speed >= CONFIRM_NS * times * p.moving_speed:
            return f"{m.speed:.1f} m/s over ground"
        if rising * m.rise >= CONFIRM_NS * times * p.climb_rate:
            return f"climbs at {m.rise:.1f} m/s"
        if shaking >= ASSUME_NS:
            return f"shakes upright ({m.gyro:.2f} rad/s) for {ASSUME_NS / NANOSECONDS:.0f} s"
        return ""

    def _at_rest(self, m: _Motion) -> bool:
        """Whether the IMU is as quiet as on the ground, and nothing else contradicts."""
        self._top = max(self._top, m.height) if not math.isnan(m.height) else self._top
        if m.speed > STILL_SPEED or abs(m.climb) > STILL_CLIMB:
            return False
        if self._touched and m.gyro < STOPPED * self._flight[0]:
            return True
        if m.gyro > DISTURBED:
            return False
        now = (m.gyro, m.force)
        if not self._phase.airborne:
            return m.force < max(1.5 * self._rest[1], RESTLESS)
        if m.height > max(LANDED_M, LANDED_SHARE * self._top):
            return False
        shares = [
            math.log(max(value, 1e-6) / rest) / math.log(flight / rest)
            for value, rest, flight in zip(now, self._rest, self._flight, strict=True)
            if flight > APART * rest
        ]
        return bool(shares) and max(shares) < SHARE

    def _learn(self, m: _Motion, seconds: float) -> None:
        """Usual deviations at rest and in flight, and the height of the ground."""
        now = (m.gyro, m.force)
        if self._phase is Phase.STANDING:
            self._rest = _followed(self._rest, now, seconds / REST_S)
        elif self._phase.airborne:
            self._flight = _followed(self._flight, now, seconds / FLIGHT_S)
        on_ground = self._phase in (Phase.STANDING, Phase.UNKNOWN)
        if on_ground and self._ground is not None and not math.isnan(m.height):
            self._ground += min(1.0, seconds / REFERENCE_S) * m.height


def _followed(
    usual: tuple[float, float], now: tuple[float, float], share: float
) -> tuple[float, float]:
    """Geometric running mean: deviations are of any size."""
    first, second = (
        before * (max(value, 1e-6) / before) ** min(1.0, share) if before > 0.0 else value
        for before, value in zip(usual, now, strict=True)
    )
    return first, second


def _deviation(vectors: list[Vector3]) -> tuple[float, Vector3]:
    """Root of the summed variances of three axes, and the mean of each."""
    (x, along_x), (y, along_y), (z, along_z) = map(moments, zip(*vectors, strict=True))
    return math.sqrt(along_x + along_y + along_z), (x, y, z)
