# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Bags of simulated flights, with or without an attack that steers the vehicle."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any

from hijack_detect.bags.encoding import (
    encode_bool,
    encode_count,
    encode_orientation,
    encode_pressure,
    encode_sample,
)
from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import RawMessage
from hijack_detect.bags.topics import OPTIONAL_INPUTS, PRESETS
from hijack_detect.bags.writer import BagWriter
from hijack_detect.replay.truth import LABEL, MEASURED_FIX, SPOOF_ACTIVE, TRUTH_FIX, flight_label
from hijack_detect.simulation.flight import Flight, generate_flight
from hijack_detect.simulation.plan import FlightPlan
from hijack_detect.spoofing.scenario import Scenario
from hijack_detect.spoofing.spoofer import Spoofer

TRUTH_ATTITUDE = "/truth/attitude"


def make_bag(
    out: Path,
    plan: FlightPlan,
    seed: int,
    *,
    scenario: Scenario | None = None,
    without: Collection[str] = (),
) -> dict[str, Any]:
    """Simulate a flight and write it as a rosbag2 directory, with the topics of the nodes.

    Beside the bag lies `label.json`: flight and attack.

    Args:
        out: The directory to make; it must not exist.
        plan: What to fly.
        seed: The same seed, plan and scenario make the same bag.
        scenario: Attacks on the GPS that the autopilot flies by, in seconds from the first
            message.
        without: Inputs to leave out of the bag: `velocity`, `mag`, `pressure`, `satellites`.

    Returns:
        The label, see `flight_label`.

    Raises:
        BagError: The directory exists or cannot be written, or the flight cannot be made.
        ScenarioError: A segment lies outside the flight.
    """
    unknown = sorted(set(without) - set(OPTIONAL_INPUTS))
    if unknown:
        raise BagError(f"cannot leave out {unknown[0]!r}; choose from {', '.join(OPTIONAL_INPUTS)}")
    if scenario is not None:
        scenario.check_within(plan.duration_s)
    left_out = {topic for name, topic in PRESETS["default"].items() if name in without}
    with BagWriter(out) as writer:
        spoofer = None if scenario is None else Spoofer(scenario, plan.start_ns)
        try:
            flight = generate_flight(plan, seed, spoofer)
        except ValueError as error:
            raise BagError(f"{out}: {error}") from error
        messages = [*flight_messages(flight), *_attack_messages(flight, spoofer)]
        for message in sorted(messages, key=lambda message: message.log_ns):
            if message.topic not in left_out:
                writer.write_raw(message.topic, message.msgtype, message.log_ns, message.data)
        label = flight_label(out.name, flight, scenario)
        text = json.dumps(label, indent=1, ensure_ascii=False)
        (out / LABEL).write_text(text + "\n", encoding="utf-8")
    return label


def flight_messages(flight: Flight) -> Iterator[RawMessage]:
    """Yield the sensors and the truth of a flight, topic by topic, logged at their stamps."""
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
    for number in flight.satellites:
        yield _message(topics.satellites, number.stamp_ns, encode_count(number.count))
    for fix, attitude in zip(flight.truth_fixes, flight.truth_attitudes, strict=True):
        message = encode_orientation(fix.stamp_ns, attitude)
        yield _message(TRUTH_ATTITUDE, fix.stamp_ns, message)


def _attack_messages(flight: Flight, spoofer: Spoofer | None) -> Iterator[RawMessage]:
    """Yield with each fix whether it is spoofed, and in an attacked flight what it was before."""
    for fix in flight.measured_fixes:
        active = spoofer is not None and spoofer.active(fix.stamp_ns)
        yield _message(SPOOF_ACTIVE, fix.stamp_ns, encode_bool(active))
        if spoofer is not None:
            yield _message(MEASURED_FIX, fix.stamp_ns, encode_sample(fix))


def _message(topic: str | None, log_ns: int, message: tuple[str, bytes]) -> RawMessage:
    assert topic is not None, "the default preset has a topic for every input"
    return RawMessage(topic, message[0], log_ns, message[1])
