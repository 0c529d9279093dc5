# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Seeded onsets in forward flight, for attacks on recorded flights."""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.samples import Rejected, read_samples
from hijack_detect.estimation.course import CourseEstimator, CourseParameters
from hijack_detect.evaluation.trials.cases import BagCase
from hijack_detect.spoofing.scenario import Scenario
from hijack_detect.streams.samples import NANOSECONDS, FixSample, VelocitySample

FORWARD_SPEED = 3.0
"""m/s; a vehicle that is faster is in forward flight. Chosen, not swept."""
PAUSE_S = 2.0
"""A pause shorter than this does not end forward flight. Chosen, not swept."""
SHORTEST_S = 5.0
"""Least forward flight left after an onset. Chosen, not swept."""

Span = tuple[float, float]


def forward_flight(reader: BagReader) -> list[Span]:
    """Begin and end of each piece of forward flight, seconds from the first message.

    The speed is that of the GPS velocity, or comes from the fixes where there is none.

    Raises:
        BagError: The bag cannot be read.
    """
    topics = reader.inputs()
    course = CourseEstimator(CourseParameters())
    spans: list[Span] = []
    for _, sample in read_samples(reader, topics, on_rejected=Rejected().add):
        if isinstance(sample, VelocitySample):
            speed = math.hypot(*sample.velocity[:2])
        elif isinstance(sample, FixSample) and topics.velocity is None:
            course.update("fix", sample)
            speed = course.speed
        else:
            continue
        if speed > FORWARD_SPEED:
            t = (sample.stamp_ns - reader.start_ns) / NANOSECONDS
            begin = spans.pop()[0] if spans and t - spans[-1][1] <= PAUSE_S else t
            spans.append((begin, t))
    return spans


def seeded_onsets(spans: Sequence[Span], latest_s: float, count: int, name: str) -> list[float]:
    """Onsets in forward flight, in order: one by chance in each of `count` equal parts of it.

    Args:
        spans: Begin and end of each piece of forward flight, seconds.
        latest_s: The latest onset, seconds.
        count: How many.
        name: Seeds the choice, so that every flight has its own onsets.

    Returns:
        Seconds, to a tenth; none where there is no forward flight of SHORTEST_S.
    """
    places = [(begin, min(end - SHORTEST_S, latest_s)) for begin, end in spans]
    places = [(begin, end) for begin, end in places if end > begin]
    if not places:
        return []
    lengths = np.array([end - begin for begin, end in places])
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    along = (np.arange(count) + rng.uniform(size=count)) / count * lengths.sum()
    starts = np.concatenate([[0.0], np.cumsum(lengths)[:-1]])
    index = np.searchsorted(starts, along, side="right") - 1
    onsets = np.array([begin for begin, _ in places])[index] + along - starts[index]
    return sorted(round(onset, 1) for onset in onsets.tolist())


def attacked(case: BagCase, scenario: Scenario, count: int) -> list[BagCase]:
    """A recorded flight with an attack at each of `count` onsets in its forward flight.

    Attacks that the flight's end would cut off are not made.

    Raises:
        BagError: The bag cannot be read.
    """
    first, last = scenario.segments[0], scenario.segments[-1]
    lasts_s = SHORTEST_S if last.end_s is None else last.end_s - first.start_s
    with case.opened() as reader:
        spans, latest_s = forward_flight(reader), reader.duration_s - lasts_s
    return [
        replace(
            case,
            name=f"{case.name}@{onset:g}s",
            kind="hijacked",
            scenario=scenario.moved_to(onset),
        )
        for onset in seeded_onsets(spans, latest_s, count, case.name)
    ]
