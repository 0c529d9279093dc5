# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The messages of a flight, and what can be wrong with them."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from benchmarks.load import load_bag
from hijack_detect.bags.reader import BagReader
from hijack_detect.replay.injection import inject
from hijack_detect.simulation.plan import Place
from hijack_detect.spoofing.scenario import parse_scenario
from hijack_detect.streams.cdr import stamp_from_bytes, with_stamp
from hijack_detect.streams.samples import NANOSECONDS

BEGIN_S, END_S, FLIGHT_S = 45.0, 55.0, 95.0
"""A fault lasts from BEGIN_S to END_S, or to the end, and the flight this long."""
IMU_HZ = 200
HEADERLESS = ("/gps/satellites",)


@dataclass(frozen=True)
class Sent:
    """A message to publish, seconds after the first."""

    at_s: float
    topic: str
    kind: str
    data: bytes

    @property
    def stamp_ns(self) -> int | None:
        """Header stamp, nanoseconds; None if it has no header."""
        if self.topic in HEADERLESS:
            return None
        return stamp_from_bytes(self.data)

    def restamped(self, change: Callable[[int], int]) -> Sent:
        """The same message with another header stamp, nanoseconds."""
        stamp_ns = self.stamp_ns
        if stamp_ns is None:
            return self
        return replace(self, data=with_stamp(self.data, change(stamp_ns)))


Fault = Callable[[Sequence[Sent]], list[Sent]]
"""Changes of the messages of a flight."""


def flight(folder: Path, place: Place | None = None, spoofed_s: float | None = None) -> list[Sent]:
    """The messages of a simulated flight, with every sensor; carried off from a time on."""
    bag = load_bag(folder, FLIGHT_S, IMU_HZ, place=place)
    if spoofed_s is not None:
        bag = _carried_off(bag, spoofed_s)
    with BagReader(bag) as reader:
        return [
            Sent((raw.log_ns - reader.start_ns) / NANOSECONDS, raw.topic, raw.msgtype, raw.data)
            for raw in reader.messages()
        ]


def _carried_off(bag: Path, start_s: float) -> Path:
    """A copy of a bag, made if it is not there, with a drift of 1.5 m/s² to 12 m/s."""
    spoofed = bag.with_name(f"{bag.name}_spoofed_{start_s:g}s")
    if not spoofed.is_dir():
        drift = {"type": "drift", "speed_m_s": 12.0, "bearing_deg": 80.0}
        model = {**drift, "onset_acceleration_m_s2": 1.5}
        scenario = parse_scenario({"segments": [{"start": start_s, "model": model}]})
        with BagReader(bag) as reader:
            inject(reader, spoofed, scenario)
    return spoofed


def gone(*topics: str) -> Fault:
    """Topics fall silent for a while."""
    return lambda sent: [
        one for one in sent if one.topic not in topics or not BEGIN_S <= one.at_s < END_S
    ]


def lossy(share: float) -> Fault:
    """So many of all messages are lost, to the end of the flight."""
    rng = random.Random(1)
    return lambda sent: [one for one in sent if one.at_s < BEGIN_S or rng.random() >= share]


def late(most_s: float, least_s: float = 0.0, *topics: str) -> Fault:
    """Messages come later by up to this much; those of one topic stay in order."""
    rng = random.Random(2)

    def delayed(sent: Sequence[Sent]) -> list[Sent]:
        newest: dict[str, float] = {}
        found = []
        for one in sent:
            if one.at_s >= BEGIN_S and (not topics or one.topic in topics):
                at_s = one.at_s + rng.uniform(least_s, most_s)
                newest[one.topic] = max(newest.get(one.topic, 0.0), at_s)
                found.append(replace(one, at_s=newest[one.topic]))
            else:
                found.append(one)
        return sorted(found, key=lambda one: one.at_s)

    return delayed


def reordered(share: float) -> Fault:
    """So many of all messages come after the next one of their topic."""
    rng = random.Random(3)

    def swapped(sent: Sequence[Sent]) -> list[Sent]:
        held: dict[str, Sent] = {}
        found = []
        for one in sent:
            if one.topic in held:
                found += [one, replace(held.pop(one.topic), at_s=one.at_s)]
            elif one.at_s >= BEGIN_S and rng.random() < share:
                held[one.topic] = one
            else:
                found.append(one)
        return found

    return swapped


def twice(sent: Sequence[Sent]) -> list[Sent]:
    """Every message comes twice."""
    return [one for each in sent for one in [each] * (2 if each.at_s >= BEGIN_S else 1)]


def clock(seconds: float) -> Fault:
    """The clock behind all stamps is set by this much."""
    shift_ns = round(seconds * NANOSECONDS)
    return lambda sent: [
        one.restamped(lambda ns: ns + shift_ns) if one.at_s >= BEGIN_S else one for one in sent
    ]


def from_zero(sent: Sequence[Sent]) -> list[Sent]:
    """Stamps count from the start of the flight, as those of an autopilot without a clock."""
    first_ns = min(one.stamp_ns for one in sent if one.stamp_ns is not None)
    start_ns = first_ns // NANOSECONDS * NANOSECONDS
    return [one.restamped(lambda ns: ns - start_ns) for one in sent]


def as_it_is(sent: Sequence[Sent]) -> list[Sent]:
    """No fault of the messages."""
    return list(sent)
