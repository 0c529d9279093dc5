# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""One node of the monitor, and the test as all that it hears.

For each node its inputs, each with good messages of a straight flight to the North at 5 m/s and
with bad ones. Inputs stay together within one GPS interval, as sensors do.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import QuaternionStamped, TwistStamped
from live import SECOND, values_of
from rclpy.duration import Duration
from ros import KEEP_ALL, ROOT, Graph, Listener, RosProcess
from sensor_msgs.msg import FluidPressure, Imu, MagneticField, NavSatFix, NavSatStatus
from std_msgs.msg import UInt32

from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.monitor.parts import DETECTORS
from hijack_detect.nodes.messages import (
    course_message,
    imu_message,
    phase_message,
    time_message,
    verdict_message,
)
from hijack_detect.streams.samples import AttitudeSample, CourseSample, Phase, PhaseSample

START_NS = 1_700_000_000 * SECOND
GPS_NS = SECOND // 5
GPS_STEPS = 10
"""IMU messages for each GPS message."""
NOW = Duration(nanoseconds=0)


def imu(stamp_ns: int, **changed: float) -> Imu:
    message = Imu()
    message.header.stamp = time_message(stamp_ns)
    message.linear_acceleration.z = changed.get("force_z", 9.8)
    message.angular_velocity.x = changed.get("omega_x", 0.0)
    return message


def fix(stamp_ns: int, latitude: float | None = None, altitude: float = 500.0) -> NavSatFix:
    north_m = 5.0 * (stamp_ns - START_NS) / SECOND
    message = NavSatFix(longitude=11.0, altitude=altitude)
    message.status.status = NavSatStatus.STATUS_FIX
    message.header.stamp = time_message(stamp_ns)
    message.latitude = 48.0 + north_m / 111_000.0 if latitude is None else latitude
    return message


def velocity(stamp_ns: int, north: float = 5.0) -> TwistStamped:
    message = TwistStamped()
    message.header.stamp = time_message(stamp_ns)
    message.twist.linear.y = north
    return message


def mag(stamp_ns: int, north: float = 2e-5) -> MagneticField:
    message = MagneticField()
    message.header.stamp = time_message(stamp_ns)
    message.magnetic_field.x = north
    return message


def pressure(stamp_ns: int, pascal: float = 95_460.0) -> FluidPressure:
    message = FluidPressure(fluid_pressure=pascal)
    message.header.stamp = time_message(stamp_ns)
    return message


def attitude(stamp_ns: int, w: float | None = None) -> Imu:
    half = math.sqrt(0.5)
    sample = AttitudeSample(stamp_ns, (0.0, 0.0, half, half), 0.001, (0.0,) * 3, (0.0, 0.0, 9.8))
    message = imu_message(sample, "base_link")
    message.orientation.w = half if w is None else w
    return message


def course(stamp_ns: int, z: float | None = None) -> QuaternionStamped:
    half = math.sqrt(0.5)
    message = course_message(CourseSample(stamp_ns, half, half), "map")
    message.quaternion.z = half if z is None else z
    return message


def satellites(_: int, count: int = 12) -> UInt32:
    return UInt32(data=count)


def verdict(stamp_ns: int, detector: str = "date", score: float = 0.1) -> DiagnosticArray:
    return verdict_message(Verdict(detector, stamp_ns, State.NORMAL, score, 1.0, "calm"))


def phase(stamp_ns: int) -> DiagnosticArray:
    return phase_message(PhaseSample(stamp_ns, Phase.FLYING, stamp_ns, "flies", 100.0))


def no_status(stamp_ns: int) -> DiagnosticArray:
    message = DiagnosticArray()
    message.header.stamp = time_message(stamp_ns)
    return message


@dataclass(frozen=True)
class Input:
    """A topic of a node: how often it comes, a good message, and bad ones by what is told."""

    name: str
    topic: str
    good: Callable[[int], Any]
    bad: dict[str, Callable[[int], Any]] = field(default_factory=dict)
    per_gps: int = 1
    stamped: bool = True


RAW_IMU = Input(
    "imu",
    "imu/data_raw",
    imu,
    {
        "angular_velocity.x is nan": lambda stamp: imu(stamp, omega_x=math.nan),
        "linear_acceleration.z is inf": lambda stamp: imu(stamp, force_z=math.inf),
    },
    GPS_STEPS,
)
FIX = Input(
    "fix",
    "gps/fix",
    fix,
    {
        "latitude is 91.0, not within [-90, 90]": lambda stamp: fix(stamp, 91.0),
        "latitude is nan": lambda stamp: fix(stamp, math.nan),
        "altitude is -inf": lambda stamp: fix(stamp, altitude=-math.inf),
    },
)
VELOCITY = Input(
    "velocity",
    "gps/vel",
    velocity,
    {
        "velocity.y is nan": lambda stamp: velocity(stamp, math.nan),
        "velocity.y is inf": lambda stamp: velocity(stamp, math.inf),
    },
)
MAG = Input("mag", "mag", mag, {"magnetic_field.x is nan": lambda stamp: mag(stamp, math.nan)})
PRESSURE = Input(
    "pressure",
    "pressure",
    pressure,
    {
        "fluid_pressure is nan": lambda stamp: pressure(stamp, math.nan),
        "fluid_pressure is 954.6, not within": lambda stamp: pressure(stamp, 954.6),
    },
)
ATTITUDE = Input(
    "attitude",
    "imu/data",
    attitude,
    {
        "has norm 2.": lambda stamp: attitude(stamp, 2.0),
        "has norm nan": lambda stamp: attitude(stamp, math.nan),
    },
    GPS_STEPS,
)
COURSE = Input(
    "course",
    "gps/course",
    course,
    {
        "quaternion.z is nan": lambda stamp: course(stamp, math.nan),
        "quaternion.z is 1.5": lambda stamp: course(stamp, 1.5),
    },
)
DATE = Input(
    "date",
    "date/verdict",
    verdict,
    {
        "a verdict has one status, this has 0": no_status,
        "has score nan": lambda stamp: verdict(stamp, score=math.nan),
    },
)
PHASE = Input(
    "phase",
    "flight_phase",
    phase,
    {"a verdict has one status, this has 0": no_status},
)
VERDICTS = [
    Input(name, f"{name}/verdict", partial(verdict, detector=name))
    for name in DETECTORS
    if name != DATE.name
]
SATELLITES = Input(
    "satellites",
    "gps/satellites",
    satellites,
    {"data is 250, not within [0, 200]": lambda stamp: satellites(stamp, 250)},
    stamped=False,
)

NODES: dict[str, tuple[list[Input], type, str]] = {
    "attitude_estimator": ([RAW_IMU, FIX, VELOCITY, MAG], Imu, "imu/data"),
    "flight_phase": ([RAW_IMU, PRESSURE, VELOCITY, FIX], DiagnosticArray, "flight_phase"),
    "gps_angle": ([FIX], QuaternionStamped, "gps/course"),
    "correlation_detector": ([PHASE, ATTITUDE, COURSE], DiagnosticArray, "correlation/verdict"),
    "date_detector": ([PHASE, ATTITUDE, FIX, VELOCITY], DiagnosticArray, "date/verdict"),
    "kld_detector": ([PHASE, FIX, VELOCITY, SATELLITES], DiagnosticArray, "kld/verdict"),
    "coast_detector": ([PHASE, RAW_IMU, VELOCITY, MAG, FIX], DiagnosticArray, "coast/verdict"),
    "gnss_sanity": ([PHASE, FIX, VELOCITY, SATELLITES], DiagnosticArray, "gnss/verdict"),
    "altitude_detector": (
        [PHASE, ATTITUDE, PRESSURE, VELOCITY, FIX],
        DiagnosticArray,
        "altitude/verdict",
    ),
    "heading_detector": (
        [PHASE, RAW_IMU, MAG, FIX, VELOCITY, ATTITUDE],
        DiagnosticArray,
        "heading/verdict",
    ),
    "drag_detector": ([PHASE, ATTITUDE, FIX, VELOCITY], DiagnosticArray, "drag/verdict"),
    "fusion": ([DATE, *VERDICTS], DiagnosticArray, "fusion/verdict"),
}
"""Inputs of each node and its output."""


class Fed:
    """A node, and the test as all that it hears."""

    def __init__(self, graph: Graph, node: str) -> None:
        self.graph, self.name = graph, node
        self.inputs, kind, topic = NODES[node]
        self.output: Listener = graph.listen(kind, topic)
        self.diagnostics = graph.listen(DiagnosticArray, "/diagnostics")
        replay = str(ROOT / "config/replay.yaml")
        self.process: RosProcess = graph.start(node, "--params-file", replay)
        self.publishers = {
            one.name: graph.node.create_publisher(type(one.good(0)), one.topic, KEEP_ALL)
            for one in self.inputs
        }
        graph.spin_until(
            lambda: all(one.get_subscription_count() for one in self.publishers.values()),
            f"subscriptions of {node}",
        )
        graph.until_known(node)
        self.stamp_ns = START_NS

    def listen(self, kind: Any, topic: str) -> Listener:
        """Listen to a further output, from its first message on."""
        listener = self.graph.listen(kind, topic)
        self.graph.until_known(self.name)
        return listener

    def good(self, intervals: int) -> None:
        """Send good messages of all inputs, and wait until the node has had each interval."""
        for _ in range(intervals):
            self.stamp_ns += GPS_NS
            for one in self.inputs:
                for step in reversed(range(one.per_gps)):
                    back = step * GPS_NS // one.per_gps
                    self.send(one, one.good(self.stamp_ns - back))
            self.until_received()

    def send(self, one: Input, message: Any) -> None:
        self.publishers[one.name].publish(message)

    def until_received(self) -> None:
        """Wait until the node has acknowledged everything: inputs stay within one interval."""
        self.graph.spin_until(
            lambda: all(one.wait_for_all_acked(NOW) for one in self.publishers.values()),
            "acknowledgements",
        )

    def until_more_output(self) -> None:
        heard = len(self.output.messages)
        for _ in range(40):
            self.good(1)
            if len(self.output.messages) > heard:
                return
        self.graph.spin_until(lambda: len(self.output.messages) > heard, "output")

    def reports(self) -> list[DiagnosticStatus]:
        return [
            one
            for message in self.diagnostics.messages
            for one in message.status
            if one.name == f"/{self.name}: inputs"
        ]

    def left_out(self) -> dict[str, int]:
        """Counts of the newest report, by reason."""
        told = values_of(self.reports()[-1]) if self.reports() else {}
        prefix = "left out, "
        return {
            key.removeprefix(prefix): int(value)
            for key, value in told.items()
            if key.startswith(prefix)
        }

    def until_left_out(self, wanted: Mapping[str, int]) -> None:
        self.graph.spin_until(lambda: self.left_out() == wanted, f"{wanted} in /diagnostics")
