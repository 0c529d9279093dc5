# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Reading of mcap bags."""

from __future__ import annotations

import heapq
from collections import Counter, deque
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import count
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, cast

from rosbags.typesys import Stores, get_typestore

from hijack_detect.bags.container import Block, Container
from hijack_detect.bags.errors import BagError
from hijack_detect.bags.files import mcap_files
from hijack_detect.bags.topics import NEEDED, PRESETS, TYPES, TopicMap, topic_map
from hijack_detect.streams.samples import NANOSECONDS

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

URL = "://"


def place(text: str) -> Path:
    """A path, or what behaves like one for a URL: s3://bucket/flights, zip://a/b::https://...

    Raises:
        BagError: The file system of a URL is not known, or what reads it is not installed.
    """
    if URL not in text:
        return Path(text)
    try:
        from upath import UPath  # noqa: PLC0415  an extra, for URLs only

        found = UPath(text)
        found.fs  # noqa: B018  finds out now whether there is such a file system
        return cast(Path, found)
    except ImportError as error:
        raise BagError(
            f"{text}: needs more to be installed, see the extra 'corpora': {error}"
        ) from error
    except (OSError, ValueError) as error:
        raise BagError(f"{text}: cannot be used: {error}") from error


MAX_HELD_BYTES = 2**30
"""Most message bytes that may wait for their turn where chunks overlap in time. Chosen, not
swept."""


@dataclass(frozen=True, slots=True)
class RawMessage:
    """One message of a bag, not yet deserialised.

    `log_ns` is the recorder's time in nanoseconds, `data` the CDR bytes.
    """

    topic: str
    msgtype: str
    log_ns: int
    data: bytes


@lru_cache(maxsize=1)
def typestore() -> Typestore:
    """Return the message definitions of ROS 2 Jazzy, loaded once."""
    return get_typestore(Stores.ROS2_JAZZY)


class BagReader:
    """A bag: a rosbag2 directory, split or not, or a bare mcap file. A context manager.

    The bag is checked when it is made: it is complete, and it has messages. Reads chunks
    compressed with zstd or lz4. A truncated file is refused: what a recorder lost may be what
    matters, so recovering it is the analyst's decision.

    Attributes:
        path: The path that was opened.
        start_ns: Log time of the first message, nanoseconds.
        end_ns: Log time of the last message, nanoseconds.
        topics: Type by topic, of the topics that have messages.
        message_counts: Number of messages by topic.
        at_ns: Log time of the message that was read last, nanoseconds; that of the first message
            before.
    """

    def __init__(self, path: str | Path, *, made_from: Path | None = None) -> None:
        """Open a bag and read its topics.

        Args:
            path: A rosbag2 directory, a directory with exactly one mcap file, or an mcap file; a
                text may be a URL, see `place`.
            made_from: The log that the bag was made from, to be named in its place.

        Raises:
            BagError: It is missing, empty, truncated, damaged, no mcap, or has no messages.
        """
        self.path = place(path) if isinstance(path, str) else path
        self.topics: dict[str, str] = {}
        self.message_counts: dict[str, int] = {}
        self._files: list[Container] = []
        try:
            for file in mcap_files(self.path):
                self._files.append(Container(file))
            self._summarise()
            self.path = made_from or self.path
        except BaseException:
            self.close()
            raise

    @property
    def duration_s(self) -> float:
        """Seconds from the first to the last message, in log time."""
        return (self.end_ns - self.start_ns) / NANOSECONDS

    def close(self) -> None:
        """Close the files."""
        for file in self._files:
            file.close()

    def __enter__(self) -> BagReader:
        """Return the reader, open since it was made."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the files."""
        self.close()

    def messages(
        self,
        topics: Collection[str] | None = None,
        start_ns: int | None = None,
        end_ns: int | None = None,
    ) -> Iterator[RawMessage]:
        """Yield messages in order of log time; equal times keep the order of the file.

        Args:
            topics: Topics to read, all if None.
            start_ns: Only messages logged at this time or later, nanoseconds.
            end_ns: Only messages logged before this time, nanoseconds.

        Raises:
            BagError: The file is damaged.
        """
        first = 0 if start_ns is None else start_ns
        last = 2**64 if end_ns is None else end_ns
        pending: deque[tuple[Block, Container]] = deque(
            sorted(
                (
                    (block, file)
                    for file in self._files
                    for block in file.blocks
                    if block.end_ns >= first and block.start_ns < last
                ),
                key=lambda pair: pair[0].start_ns,
            )
        )
        waiting: list[tuple[int, int, RawMessage]] = []
        order = count()
        held = 0
        while pending or waiting:
            while pending and (not waiting or pending[0][0].start_ns <= waiting[0][0]):
                block, file = pending.popleft()
                for message in self._block_messages(file, block, topics):
                    if first <= message.log_ns < last:
                        heapq.heappush(waiting, (message.log_ns, next(order), message))
                        held += len(message.data)
                if held > MAX_HELD_BYTES:
                    raise BagError(
                        f"{file.path}: more than {MAX_HELD_BYTES} bytes of messages overlap in "
                        "time; sort the file with `mcap sort`"
                    )
            if waiting:
                message = heapq.heappop(waiting)[2]
                held -= len(message.data)
                self.at_ns = message.log_ns
                yield message

    def deserialize(self, raw: RawMessage) -> Any:
        """Return the message, with the attribute names of ROS.

        Raises:
            BagError: The type is not one of ROS 2 Jazzy's, or the bytes do not fit the type.
        """
        try:
            return typestore().deserialize_cdr(raw.data, raw.msgtype)
        except Exception as error:  # rosbags raises anything
            known = raw.msgtype in typestore().fielddefs
            what = (
                f"malformed {raw.msgtype} of {len(raw.data)} bytes ({error!r}); the file is damaged"
                if known
                else f"type {raw.msgtype!r} is not known; leave this topic out"
            )
            raise BagError(
                f"{self.path}: topic {raw.topic} at log time {raw.log_ns} ns: {what}"
            ) from error

    def definition(self, topic: str) -> str:
        """Return the definition of a topic's type as in a .msg file, empty if the bag has none.

        Raises:
            BagError: The definition is damaged.
        """
        for file in self._files:
            for channel in file.channels.values():
                if channel.topic == topic and (found := file.definition(channel)):
                    return found
        return ""

    def inputs(self, preset: str = "auto") -> TopicMap:
        """Which topic of this bag is which input.

        Args:
            preset: Name of a preset, or `auto` for the one that fits.

        Raises:
            BagError: There is no such preset, or the bag has no Imu or no NavSatFix.
        """
        try:
            found = topic_map(preset, self.topics)
        except BagError as error:
            raise BagError(f"{self.path}: {error}") from error
        self.require(found)
        return found

    def require(self, preset: TopicMap) -> None:
        """Check that the bag has the inputs without which nothing can be analysed.

        Raises:
            BagError: There is no Imu or no NavSatFix on the topics of the map.
        """
        for name in NEEDED:
            topic = getattr(preset, name)
            if self.topics.get(topic) != TYPES[name]:
                presets = "; ".join(
                    f"{key}: {known.imu}, {known.fix}" for key, known in PRESETS.items()
                )
                raise BagError(
                    f"{self.path}: no {TYPES[name]} on topic {topic}. The bag has "
                    f"{self.describe_topics()}. Choose the preset that fits ({presets}) or name "
                    "the topics"
                )

    def describe_topics(self) -> str:
        """Return all topics with type and number of messages, for messages to people."""
        return ", ".join(
            f"{topic} ({kind}, {self.message_counts[topic]})"
            for topic, kind in sorted(self.topics.items())
        )

    def _summarise(self) -> None:
        counts: Counter[str] = Counter()
        encodings: set[str] = set()
        for file in self._files:
            for number, channel in file.channels.items():
                if not file.counts[number]:
                    continue
                encodings.add(channel.encoding)
                if channel.encoding == "cdr":
                    counts[channel.topic] += file.counts[number]
                    self.topics.setdefault(channel.topic, file.msgtype(channel))
        if not counts:
            other = ", ".join(sorted(encodings))
            reason = f"only messages encoded as {other}, not cdr" if other else "no messages"
            raise BagError(
                f"{self.path}: has {reason}; check that the topics were published while it was "
                "recorded by ROS 2"
            )
        self.message_counts = dict(counts)
        self.start_ns = self.at_ns = min(file.start_ns for file in self._files if file.counts)
        self.end_ns = max(file.end_ns for file in self._files if file.counts)

    @staticmethod
    def _block_messages(
        file: Container, block: Block, topics: Collection[str] | None
    ) -> Iterator[RawMessage]:
        for record in file.records(block):
            channel = file.channels[record.channel_id]
            if channel.encoding == "cdr" and (topics is None or channel.topic in topics):
                yield RawMessage(channel.topic, file.msgtype(channel), record.log_ns, record.data)
