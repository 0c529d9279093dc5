# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""From the messages of a bag to samples."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader, RawMessage
from hijack_detect.bags.topics import TYPES, TopicMap
from hijack_detect.streams.cdr import FROM_BYTES
from hijack_detect.streams.messages import (
    CONVERTERS,
    Absence,
    BadMessage,
    header_stamp_ns,
    satellite_count,
)
from hijack_detect.streams.samples import Sample
from hijack_detect.streams.satellites import SATELLITES, SatelliteStamps

CONVERT = {**CONVERTERS, SATELLITES: satellite_count}
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Rejection:
    """One refused message.

    Attributes:
        path: The bag.
        topic: Topic of the message.
        log_ns: Log time of the message, nanoseconds.
        stamp_ns: Header stamp of the message, nanoseconds; the log time where it has no header.
        reason: The refused field and its value.
    """

    path: Path
    topic: str
    log_ns: int
    stamp_ns: int
    reason: str

    def __str__(self) -> str:
        """Return all of it in one line."""
        return f"{self.path}: topic {self.topic}, stamp {self.stamp_ns} ns: {self.reason}"


@dataclass
class Rejected:
    """Counts refused messages by topic and field, and keeps the first of each.

    Pass its `add` to `read_samples` as `on_rejected`.

    Attributes:
        counts: Number of refused messages by (topic, field).
        first: The first refused message of each.
    """

    counts: Counter[tuple[str, str]] = field(default_factory=Counter)
    first: dict[tuple[str, str], Rejection] = field(default_factory=dict)

    def add(self, rejection: Rejection) -> None:
        """Count one refused message."""
        key = (rejection.topic, rejection.reason.split(" ", 1)[0])
        self.counts[key] += 1
        self.first.setdefault(key, rejection)

    @property
    def total(self) -> int:
        """Number of refused messages."""
        return sum(self.counts.values())

    def lines(self) -> list[str]:
        """Return one line for each reason: how many, and the first of them."""
        return [f"{self.counts[key]} refused, first {self.first[key]}" for key in self.counts]


def read_samples(
    reader: BagReader,
    topic_map: TopicMap,
    *,
    on_rejected: Callable[[Rejection], None] | None = None,
    absence: Absence | None = None,
) -> Iterator[tuple[str, Sample]]:
    """Yield input name and sample of every valid message, in order of log time.

    A message with a value that no sensor can mean is refused and the next one is read. A number
    of satellites gets the stamp of its fix from `SatelliteStamps`, so it follows after the next
    fix. Components without a measurement are marked, see `Absence`.

    Args:
        reader: The bag.
        topic_map: Which topic is which input.
        on_rejected: Called for every refused message. None logs a summary as a warning when
            the bag has been read.
        absence: What marks the components that were not measured, to ask it afterwards; None
            takes one of its own.

    Raises:
        BagError: The bag is damaged, or a topic does not have the type of its input.
    """
    names = {topic: name for name, topic in topic_map.items() if name in CONVERT}
    stamps, absence = SatelliteStamps(), absence or Absence()
    summary = Rejected()
    reject = on_rejected or summary.add
    for place, raw in enumerate(reader.messages(names.keys())):
        name = names[raw.topic]
        if raw.msgtype != TYPES[name]:
            raise BagError(
                f"{reader.path}: topic {raw.topic} at log time {raw.log_ns} ns has type "
                f"{raw.msgtype}, the input '{name}' needs {TYPES[name]}; name another topic"
            )
        try:
            converted = _converted(reader, name, raw)
        except BadMessage as error:
            stamp_ns = raw.log_ns
            if name != SATELLITES:
                stamp_ns = header_stamp_ns(reader.deserialize(raw))
            reject(Rejection(reader.path, raw.topic, raw.log_ns, stamp_ns, str(error)))
            continue
        if (marked := absence(converted)) is not None:
            yield from stamps.samples(name, place, marked)
    for line in summary.lines():
        _log.warning("%s", line)


def _converted(reader: BagReader, name: str, raw: RawMessage) -> Any:
    """The sample of a message of an input, or its number. Raises BadMessage, BagError."""
    quick = FROM_BYTES.get(name)
    sample = None if quick is None else quick(raw.data)
    return CONVERT[name](reader.deserialize(raw)) if sample is None else sample
