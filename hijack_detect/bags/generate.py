"""Bags of simulated flights."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path

from hijack_detect.bags.encoding import (
    encode_count,
    encode_orientation,
    encode_pressure,
    encode_sample,
)
from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import RawMessage
from hijack_detect.bags.topics import PRESETS
from hijack_detect.bags.writer import BagWriter
from hijack_detect.simulation.flight import Flight, generate_flight
from hijack_detect.simulation.plan import FlightPlan

OPTIONAL_INPUTS = ("velocity", "mag", "pressure", "satellites")
TRUTH_FIX = "/truth/fix"
TRUTH_ATTITUDE = "/truth/attitude"


def make_bag(
    out: Path, route: str, seed: int, duration_s: float, *, without: Collection[str] = ()
) -> None:
    """Simulate a flight and write it as a rosbag2 directory, with the topics of the nodes.

    Args:
        out: The directory to make; it must not exist.
        route: `straight` or `curved`.
        seed: The same seed, route and duration make the same bag.
        duration_s: Length of the recording, seconds.
        without: Inputs to leave out: `velocity`, `mag`, `pressure`, `satellites`.

    Raises:
        BagError: The directory exists or cannot be written, or the flight cannot be made.
    """
    unknown = sorted(set(without) - set(OPTIONAL_INPUTS))
    if unknown:
        raise BagError(f"cannot leave out {unknown[0]!r}; choose from {', '.join(OPTIONAL_INPUTS)}")
    left_out = {topic for name, topic in PRESETS["default"].items() if name in without}
    with BagWriter(out) as writer:
        try:
            flight = generate_flight(FlightPlan(route=route, duration_s=duration_s), seed)
        except ValueError as error:
            raise BagError(f"{out}: {error}") from error
        for message in sorted(flight_messages(flight), key=lambda message: message.log_ns):
            if message.topic not in left_out:
                writer.write_raw(message.topic, message.msgtype, message.log_ns, message.data)


def flight_messages(flight: Flight) -> Iterator[RawMessage]:
    """Yield all messages of a simulated flight, topic by topic, logged at their stamps."""
    topics = PRESETS["default"]
    for topic, samples in (
        (topics.imu, flight.imu),
        (topics.fix, flight.fixes),
        (topics.velocity, flight.velocities),
        (topics.mag, flight.magnetics),
        (TRUTH_FIX, flight.truth_fixes),
    ):
        for sample in samples:
            yield _message(topic, sample.stamp_ns, encode_sample(sample))
    for stamp, pascal in flight.pressures:
        yield _message(topics.pressure, stamp, encode_pressure(stamp, pascal))
    for stamp, number in flight.satellites:
        yield _message(topics.satellites, stamp, encode_count(int(number)))
    for fix, attitude in zip(flight.truth_fixes, flight.truth_attitudes, strict=True):
        message = encode_orientation(fix.stamp_ns, attitude)
        yield _message(TRUTH_ATTITUDE, fix.stamp_ns, message)


def _message(topic: str | None, log_ns: int, message: tuple[str, bytes]) -> RawMessage:
    assert topic is not None, "the default preset has a topic for every input"
    return RawMessage(topic, message[0], log_ns, message[1])
