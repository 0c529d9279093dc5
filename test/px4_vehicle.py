# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A PX4 as ROS sees it: px4_msgs of a recorded flight, in its units, frames and times.

What it sends is made here by hand, in single precision where PX4 has no more, and so is what the
monitor has to hear of it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from geometry_msgs.msg import TwistStamped
from live import values_of
from ros import Graph, Listener
from sensor_msgs.msg import FluidPressure, Imu, MagneticField, NavSatFix
from std_msgs.msg import UInt32

from hijack_detect.nodes.qos import SENSOR
from hijack_detect.streams.samples import (
    FixSample,
    ImuSample,
    MagneticSample,
    PressureSample,
    Sample,
    SatelliteSample,
    VelocitySample,
)

TOPICS = {
    "imu": ("sensor_combined", "SensorCombined"),
    "fix": ("vehicle_gps_position", "SensorGps"),
    "mag": ("vehicle_magnetometer", "VehicleMagnetometer"),
    "pressure": ("vehicle_air_data", "VehicleAirData"),
}
OUTPUTS = {
    "imu": (Imu, "imu/data_raw"),
    "fix": (NavSatFix, "gps/fix"),
    "velocity": (TwistStamped, "gps/vel"),
    "satellites": (UInt32, "gps/satellites"),
    "mag": (MagneticField, "mag"),
    "pressure": (FluidPressure, "pressure"),
}
EVERY_TOPIC = dict.fromkeys(TOPICS, "")
"""No version behind the name of any."""
LATE_US = 3000
"""PX4 publishes a message so long after the sample was taken."""
Timed = tuple[str, int, Any]
"""Input, time of the sample in microseconds of PX4, and message."""


def kind(name: str) -> Any:
    """The class of the message of an input; see workspace()."""
    import px4_msgs.msg  # noqa: PLC0415  built by the test

    return getattr(px4_msgs.msg, TOPICS[name][1])


def single(value: float) -> float:
    """What is left of a value in a float32."""
    return float(np.float32(value))


def imu(time_us: int, rate: Sequence[float], force: Sequence[float]) -> Any:
    """SensorCombined of vectors in FLU."""
    message = kind("imu")(timestamp=time_us)
    for field, (x, y, z) in ((message.gyro_rad, rate), (message.accelerometer_m_s2, force)):
        field[:] = (x, -y, -z)
    return message


def mag(time_us: int, tesla: Sequence[float]) -> Any:
    """VehicleMagnetometer of a field in FLU."""
    x, y, z = (one * 1e4 for one in tesla)
    message = kind("mag")(timestamp=time_us + LATE_US, timestamp_sample=time_us)
    message.magnetometer_ga[:] = (x, -y, -z)
    return message


def pressure(time_us: int, pascal: float) -> Any:
    """VehicleAirData."""
    late_us = time_us + LATE_US
    return kind("pressure")(timestamp=late_us, timestamp_sample=time_us, baro_pressure_pa=pascal)


def gps(time_us: int, fix: FixSample, velocity: Sequence[float], count: int) -> Any:
    """SensorGps of a velocity in ENU."""
    east, north, up = velocity
    return kind("fix")(
        timestamp=time_us,
        timestamp_sample=0,  # as many drivers leave it
        latitude_deg=fix.latitude_deg,
        longitude_deg=fix.longitude_deg,
        altitude_ellipsoid_m=fix.altitude_m,
        altitude_msl_m=fix.altitude_m - 20.0,
        fix_type=3 if fix.has_fix else 1,
        eph=fix.accuracy_m or 0.0,
        vel_n_m_s=north,
        vel_e_m_s=east,
        vel_d_m_s=-up,
        vel_ned_valid=True,
        satellites_used=count,
    )


def messages(samples: Sequence[tuple[str, Sample]], from_ns: int) -> list[Timed]:
    """The messages of a flight, whose times count microseconds from a stamp."""
    counts = {one.stamp_ns: one.count for _, one in samples if isinstance(one, SatelliteSample)}
    velocities = {
        one.stamp_ns: one.velocity for _, one in samples if isinstance(one, VelocitySample)
    }
    sent: list[Timed] = []
    for name, one in samples:
        us = (one.stamp_ns - from_ns) // 1000
        if isinstance(one, ImuSample):
            sent.append((name, us, imu(us, one.angular_velocity, one.specific_force)))
        elif isinstance(one, FixSample):
            count = counts.get(one.stamp_ns, 12)
            sent.append((name, us, gps(us, one, velocities[one.stamp_ns], count)))
        elif isinstance(one, MagneticSample):
            sent.append((name, us, mag(us, one.field)))
        elif isinstance(one, PressureSample):
            sent.append((name, us, pressure(us, one.pressure_pa)))
    return sent


def heard(samples: Sequence[tuple[str, Sample]], shift_ns: int) -> list[tuple[str, Sample]]:
    """What the monitor has to get of a flight: in single precision, with its stamps moved."""
    found: list[tuple[str, Sample]] = []
    for name, one in samples:
        stamp_ns = one.stamp_ns + shift_ns
        if isinstance(one, ImuSample):
            rate = tuple(map(single, one.angular_velocity))
            force = tuple(map(single, one.specific_force))
            found.append((name, ImuSample(stamp_ns, rate, force)))
        elif isinstance(one, VelocitySample):
            found.append((name, VelocitySample(stamp_ns, tuple(map(single, one.velocity)))))
        elif isinstance(one, MagneticSample):
            field = tuple(single(value * 1e4) * 1e-4 for value in one.field)
            found.append((name, MagneticSample(stamp_ns, field)))
        elif isinstance(one, PressureSample):
            found.append((name, PressureSample(stamp_ns, single(one.pressure_pa))))
        else:
            found.append((name, replace(one, stamp_ns=stamp_ns)))
    return found


def said(told: Listener, space: str, topic: str) -> tuple[str, dict[str, str]]:
    """The newest that a bridge says of a topic on /diagnostics: sentence and values."""
    name = f"{space}/px4_bridge: {space}/fmu/out/{topic}"
    found = [one for array in told.messages for one in array.status if one.name == name]
    return (found[-1].message, values_of(found[-1])) if found else ("", {})


def subscribers(told: Listener, space: str) -> dict[str, int]:
    """How many subscribers a bridge has found for each of its outputs, by topic."""
    name = f"{space}/px4_bridge: outputs"
    found = [one for array in told.messages for one in array.status if one.name == name]
    return {topic: int(count) for topic, count in values_of(found[-1]).items()} if found else {}


class Vehicle:
    """The publishers of one PX4: best effort and volatile, as its client makes them."""

    def __init__(
        self, graph: Graph, space: str = "", versions: Mapping[str, str] = EVERY_TOPIC
    ) -> None:
        self.outputs = {
            name: graph.node.create_publisher(
                kind(name), f"{space}/fmu/out/{TOPICS[name][0]}{version}", SENSOR
            )
            for name, version in versions.items()
        }

    def heard(self, told: Listener, space: str = "") -> bool:
        """Whether a bridge hears each topic; if not, knocks with what it has to leave out.

        That a subscription is known here does not say yet that it knows this publisher.
        """
        topics = {name: TOPICS[name][0] for name in self.outputs}
        deaf = [
            name
            for name, topic in topics.items()
            if said(told, space, topic)[1].get("left out, bad message", "0") == "0"
        ]
        for name in deaf:
            self.send(name, kind(name)())
        return not deaf

    def send(self, name: str, message: Any) -> None:
        """Publish a message, or bytes as one."""
        self.outputs[name].publish(message)
