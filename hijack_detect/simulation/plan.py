# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What a simulated flight is asked to be."""

from __future__ import annotations

from dataclasses import dataclass, field

from hijack_detect.estimation.magnetic import field_enu
from hijack_detect.simulation.disturbances import Disturbances

ROUTES = ("straight", "curved", "hover", "fixed_yaw", "survey")
HARD_ROUTES = ("brake",)
"""Routes that are flown at the limits of the vehicle."""
MIN_DURATION_S = 60.0
MAX_DURATION_S = 3600.0
"""Bounds of a flight. Chosen: room for climb and route; memory."""


@dataclass(frozen=True)
class Place:
    """Where the flight starts (WGS-84), and the Earth's magnetic field there.

    Attributes:
        latitude_deg: Latitude, degrees.
        longitude_deg: Longitude, degrees.
        altitude_m: Height above the ellipsoid, metres.
        field_enu_t: Magnetic field, tesla in ENU. The default is the World Magnetic Model 2025
            of June 2025 at the default place: declination 12.66° East, inclination -66°.
    """

    latitude_deg: float = -35.363
    longitude_deg: float = 149.165
    altitude_m: float = 584.0
    field_enu_t: tuple[float, float, float] = (5.1693e-6, 23.0145e-6, 53.0911e-6)

    @classmethod
    def at(cls, latitude_deg: float, longitude_deg: float, altitude_m: float) -> Place:
        """A place with the field that the World Magnetic Model has there."""
        field = field_enu(latitude_deg, longitude_deg, altitude_m)
        return cls(latitude_deg, longitude_deg, altitude_m, field)


@dataclass(frozen=True)
class FlightPlan:
    """A multirotor flight: stand, take off, hover, fly a route, hover.

    The seed decides everything that is not asked for: the first course, the turns, wind and
    gusts, the vehicle, its sensors and all noise.

    Attributes:
        route: `straight`, one leg; `curved`, turns of 50° to 110°, mostly with two in quick
            succession; `survey`, parallel legs joined by sharp turns; `fixed_yaw`, as `curved`
            with a heading that stays; `hover`, no motion; `brake`, as fast as it can to its
            speed and to a stop, again and again. But for `fixed_yaw` and `hover` the nose follows
            the course.
        duration_s: Length of the recording, 60 to 3600 seconds.
        speed: Ground speed on the route, 2 to 15 m/s; None draws 6 to 9 m/s from the seed.
        height_m: Height of the flight above the ground, 5 to 120 metres.
        wind_m_s: Mean wind, 0 to 12 m/s; None draws 0 to 5 m/s from the seed.
        place: Where it starts.
        start_ns: Stamp of the first sample, nanoseconds.
        disturbances: What makes the flight hard; by default nothing.
    """

    route: str = "straight"
    duration_s: float = 110.0
    speed: float | None = None
    height_m: float = 20.0
    wind_m_s: float | None = None
    place: Place = Place()
    start_ns: int = 1_750_000_000_000_000_000
    disturbances: Disturbances = field(default_factory=Disturbances)

    def __post_init__(self) -> None:
        """Check the plan.

        Raises:
            ValueError: A value is outside what is allowed; the text names it.
        """
        routes = ROUTES + HARD_ROUTES
        if self.route not in routes:
            raise ValueError(f"route is {self.route!r}, not one of {', '.join(routes)}")
        for name, value, low, high in (
            ("duration", self.duration_s, MIN_DURATION_S, MAX_DURATION_S),
            ("speed", self.speed, 2.0, 15.0),
            ("height", self.height_m, 5.0, 120.0),
            ("wind", self.wind_m_s, 0.0, 12.0),
        ):
            if value is not None and not low <= value <= high:
                raise ValueError(f"{name} is {value!r}, not within [{low:g}, {high:g}]")
        if self.start_ns < 0:
            raise ValueError(f"start is {self.start_ns} ns, it must not be negative")
        if forward_end_s(self) - forward_start_s(self) < 20.0:
            raise ValueError(
                f"duration of {self.duration_s:g} s leaves less than 20 s for the route; fly "
                "longer or lower"
            )


GROUND_S = 6.0
"""Times and rates of a mission are chosen: long enough for every detector to be ready."""
HOVER_S = 8.0
CLIMB_RATE = 2.5
"""m/s"""
RAMP_S = 1.0
"""Seconds over which the climb rate is reached."""
END_S = 14.0
"""Seconds from the start of braking to the end of the recording."""


def climb_end_s(plan: FlightPlan) -> float:
    """Seconds from the start to the command that ends the climb."""
    return GROUND_S + plan.height_m / CLIMB_RATE + RAMP_S


def forward_start_s(plan: FlightPlan) -> float:
    """Seconds from the start to the command to fly forward."""
    return climb_end_s(plan) + HOVER_S


def forward_end_s(plan: FlightPlan) -> float:
    """Seconds from the start to the command to brake."""
    return plan.duration_s - END_S
