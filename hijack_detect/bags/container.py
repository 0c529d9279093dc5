# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The structure of an MCAP file, read with every length checked.

Bags come from crashed recorders, broken disks and strangers. The libraries at hand trust the
lengths in a file: a damaged one makes them allocate gigabytes or fail deep inside a
decompressor. So the container is walked here, bounded by the size of the file, and rosbags does
what it does well: message definitions, CDR and writing.

The format: https://mcap.dev/spec. All integers are little endian; times are nanoseconds.
"""

from __future__ import annotations

import struct
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO, NamedTuple
from zlib import crc32

from lz4.frame import LZ4FrameDecompressor

from hijack_detect.bags.errors import BagError

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

MAX_CHUNK_BYTES = 512 * 2**20
"""Largest decompressed chunk that is accepted. Chosen: recorders write about 1 MiB."""

CHUNK_HEADER = struct.Struct("<QQQI")
"""First and last log time, decompressed size, checksum."""


class Damaged(Exception):
    """Damage at a byte; the container makes it a BagError with the name of the file."""


def decompressed(content: bytes, offset: int) -> bytes:
    """Return the records of a chunk, checked against its declared size and checksum.

    Args:
        content: Content of the chunk record.
        offset: Where it lies in the file, for the message of the error.

    Raises:
        Damaged: Sizes, compression or checksum do not fit.
    """
    where = f"the chunk at byte {offset}"
    _, _, size, checksum = unpack(CHUNK_HEADER, content, 0, offset)
    compression, position = string(content, CHUNK_HEADER.size, offset)
    stored = int.from_bytes(content[position : position + 8], "little")
    data = content[position + 8 :]
    if stored > len(data):
        raise Damaged(f"{where} overruns its record")
    if size > MAX_CHUNK_BYTES:
        raise Damaged(f"{where} claims {size} bytes, more than the {MAX_CHUNK_BYTES} allowed")
    data = data[:stored]
    try:
        if compression == "zstd":
            data = zstd.ZstdDecompressor().decompress(data, size + 1) if size else b""
        elif compression == "lz4":
            data = LZ4FrameDecompressor().decompress(data, size + 1) if size else b""
        elif compression:
            raise Damaged(f"{where} is compressed with {compression!r}, not zstd or lz4")
    except (zstd.ZstdError, RuntimeError, EOFError, MemoryError) as error:
        raise Damaged(f"{where} cannot be decompressed ({error})") from error
    if len(data) != size:
        raise Damaged(f"{where} does not have the size it declares")
    if checksum and crc32(data) != checksum:
        raise Damaged(f"{where} does not match its checksum")
    return data


def unpack(
    layout: struct.Struct, content: bytes | memoryview, position: int, offset: int
) -> tuple[int, ...]:
    """Return the numbers at `position` of a record.

    Raises:
        Damaged: The record is too short.
    """
    if len(content) - position < layout.size:
        raise Damaged(f"the record at byte {offset} is too short")
    return layout.unpack_from(content, position)


def string(content: bytes, position: int, offset: int) -> tuple[str, int]:
    """Return the string at `position` of a record and the position after it.

    Raises:
        Damaged: The string is longer than the record, or not UTF-8.
    """
    size = int.from_bytes(content[position : position + 4], "little")
    end = position + 4 + size
    if position + 4 > len(content) or end > len(content):
        raise Damaged(f"a string overruns the record at byte {offset}")
    try:
        return content[position + 4 : end].decode(), end
    except UnicodeDecodeError as error:
        raise Damaged(f"text of the record at byte {offset} is not UTF-8") from error


MAGIC = b"\x89MCAP0\r\n"
_FOOTER, _SCHEMA, _CHANNEL, _MESSAGE, _CHUNK, _STATISTICS = 0x02, 0x03, 0x04, 0x05, 0x06, 0x0B
_PREFIX = struct.Struct("<BQ")
_MESSAGE_HEADER = struct.Struct("<HIQQ")
_STATISTICS_HEADER = struct.Struct("<QHIIIIQQI")
_FOOTER_CONTENT = struct.Struct("<QQI")
"""Start of the summary, start of its offsets, checksum of the summary up to there."""


class Channel(NamedTuple):
    """One channel of the file: a topic, the id of its type and how its messages are encoded."""

    topic: str
    schema_id: int
    encoding: str


class Record(NamedTuple):
    """One message as it lies in the file: channel id, log time in nanoseconds, CDR bytes."""

    channel_id: int
    log_ns: int
    data: bytes


class Block(NamedTuple):
    """A part of the file that holds messages: one chunk, or one message outside any chunk.

    `start_ns` and `end_ns` are the first and last log time in it, `offset` and `size` the place
    of the record's content in bytes.
    """

    opcode: int
    offset: int
    size: int
    start_ns: int
    end_ns: int


class Container:
    """One open MCAP file.

    Attributes:
        path: The file.
        channels: Channels by id.
        blocks: Where the messages are, in file order.
        counts: Number of messages by channel id.
        start_ns: Log time of the first message, nanoseconds.
        end_ns: Log time of the last message, nanoseconds.
    """

    def __init__(self, path: Path) -> None:
        """Open the file and read its structure.

        Raises:
            BagError: It is missing, empty, not MCAP, truncated or damaged.
        """
        self.path = path
        self.channels: dict[int, Channel] = {}
        self.blocks: list[Block] = []
        self.counts: Counter[int] = Counter()
        self.start_ns = 2**64
        self.end_ns = -1
        self._schemas: dict[int, tuple[str, bytes]] = {}
        self._indexed = False
        self._read_blocks: set[int] = set()
        """Offsets of the blocks of which all messages were read,"""
        self._read_counts: Counter[int] = Counter()
        """and how many those were, by channel id."""
        try:
            self._file: BinaryIO = path.open("rb")
        except OSError as error:
            raise BagError(f"{path}: cannot be opened: {error.strerror}; check the path") from error
        try:
            self._open()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def msgtype(self, channel: Channel) -> str:
        """Return the ROS type of a channel, empty if the file has none."""
        return self._schemas.get(channel.schema_id, ("", b""))[0]

    def definition(self, channel: Channel) -> str:
        """Return the definition of a channel's type as in a .msg file, empty if there is none.

        Raises:
            BagError: The definition is damaged.
        """
        _, content = self._schemas.get(channel.schema_id, ("", b""))
        try:
            encoding, position = string(content, 0, 0) if content else ("", 0)
            return string(content, position, 0)[0] if encoding == "ros2msg" else ""
        except Damaged as error:
            name = self.msgtype(channel)
            raise BagError(f"{self.path}: the definition of {name}: {error}") from error

    def records(self, block: Block) -> Iterator[Record]:
        """Yield the messages of one block in file order.

        Raises:
            BagError: The block is damaged, or it was the last one and the file has other messages
                than it states.
        """
        counts: Counter[int] = Counter()
        try:
            for record in self._records(block):
                counts[record.channel_id] += 1
                yield record
            if block.offset not in self._read_blocks:
                self._read_blocks.add(block.offset)
                self._read_counts += counts
                self._check_counts()
        except Damaged as error:
            raise self._damaged_error(str(error)) from error

    def _check_counts(self) -> None:
        """Compare the counts of messages with those in the file, once all were read."""
        if len(self._read_blocks) < len(self.blocks) or self._read_counts == self.counts:
            return
        for number, channel in self.channels.items():
            stated, found = self.counts[number], self._read_counts[number]
            if stated != found:
                raise Damaged(f"says that it has {stated} messages of {channel.topic}, has {found}")

    def _open(self) -> None:
        self._size = self._file.seek(0, 2)
        if self._size == 0:
            raise BagError(
                f"{self.path}: is empty (0 bytes); the recorder never wrote to it, or the copy "
                "failed: copy or record it again"
            )
        if self._read(0, min(self._size, len(MAGIC))) != MAGIC:
            raise BagError(
                f"{self.path}: is not an MCAP file; convert ROS 1 and sqlite3 bags with "
                "`rosbags-convert`"
            )
        try:
            complete = self._walk()
            if complete and not self._indexed:
                self._count()
        except Damaged as error:
            raise self._damaged_error(str(error)) from error
        if not complete:
            raise self._damaged_error("truncated or damaged, its end mark was not reached")

    def _walk(self) -> bool:
        """Go over all records outside chunks; return whether the file is complete."""
        position = len(MAGIC)
        while position + _PREFIX.size <= self._size:
            opcode, size = _PREFIX.unpack(self._read(position, _PREFIX.size))
            position += _PREFIX.size
            if size > self._size - position:
                return False
            if opcode == _FOOTER:
                self._check_summary(self._read(position, size), position)
                return self._read(position + size, len(MAGIC)) == MAGIC
            if opcode in (_CHUNK, _MESSAGE):
                self._add_block(opcode, position, size)
            elif opcode in (_SCHEMA, _CHANNEL):
                self._declare(opcode, self._read(position, size), position)
            elif opcode == _STATISTICS:
                self._read_statistics(self._read(position, size), position)
            position += size
        return False

    def _check_summary(self, footer: bytes, offset: int) -> None:
        """Compare the summary with its checksum, if it has one."""
        start, _, checksum = unpack(_FOOTER_CONTENT, footer, 0, offset)
        end = offset + _FOOTER_CONTENT.size - 4  # all of the footer but the checksum
        if checksum and start and crc32(self._read(start, max(0, end - start))) != checksum:
            raise Damaged("its summary does not match its checksum")

    def _add_block(self, opcode: int, offset: int, size: int) -> None:
        header: struct.Struct = CHUNK_HEADER if opcode == _CHUNK else _MESSAGE_HEADER
        values = unpack(header, self._read(offset, min(size, header.size)), 0, offset)
        start, end = values[:2] if opcode == _CHUNK else (values[2], values[2])
        self.blocks.append(Block(opcode, offset, size, start, end))

    def _declare(self, opcode: int, content: bytes | memoryview, offset: int) -> None:
        """Take over a schema or a channel record."""
        content = bytes(content)
        number = int.from_bytes(content[:2], "little")
        if opcode == _SCHEMA:
            name, position = string(content, 2, offset)
            schema = (name, content[position:])
            if self._schemas.setdefault(number, schema) != schema:
                raise Damaged(f"declares type {number} again as {name} at byte {offset}")
            return
        topic, position = string(content, 4, offset)
        encoding, _ = string(content, position, offset)
        channel = Channel(topic, int.from_bytes(content[2:4], "little"), encoding)
        if self.channels.setdefault(number, channel) != channel:
            raise Damaged(f"declares channel {number} again as {topic} at byte {offset}")

    def _read_statistics(self, content: bytes, offset: int) -> None:
        """Take over counts and times, if every counted channel is known."""
        values = unpack(_STATISTICS_HEADER, content, 0, offset)
        chunks = sum(block.opcode == _CHUNK for block in self.blocks)
        if values[5] != chunks:
            raise Damaged(f"says that it has {values[5]} chunks, has {chunks}")
        pairs = content[_STATISTICS_HEADER.size :]
        if len(pairs) != values[8] or len(pairs) % 10:
            return
        counts = +Counter(dict(struct.iter_unpack("<HQ", pairs)))  # + drops counts of zero
        if counts and sum(counts.values()) == values[0] and set(counts) <= set(self.channels):
            self.counts, self.start_ns, self.end_ns = counts, values[6], values[7]
            self._indexed = True

    def _count(self) -> None:
        """Count all messages by reading them; for files without statistics."""
        self.counts = Counter()
        for block in self.blocks:
            for record in self._records(block):
                self.counts[record.channel_id] += 1
                self.start_ns = min(self.start_ns, record.log_ns)
                self.end_ns = max(self.end_ns, record.log_ns)

    def _damaged_error(self, what: str) -> BagError:
        with suppress(Damaged):
            self._count()
        found = sum(self.counts.values())
        return BagError(
            f"{self.path}: {what}; {found} messages before that can be read. "
            f"Recover them with `mcap recover {self.path.name} -o recovered.mcap`, then use "
            "recovered.mcap"
        )

    def _records(self, block: Block) -> Iterator[Record]:
        content = self._read(block.offset, block.size)
        if block.opcode == _MESSAGE:
            yield self._message(memoryview(content), block)
            return
        chunk = memoryview(decompressed(content, block.offset))
        position = 0
        while position < len(chunk):
            opcode, size = unpack(_PREFIX, chunk, position, block.offset)
            position += _PREFIX.size
            if size > len(chunk) - position:
                raise Damaged(f"a record overruns the chunk at byte {block.offset}")
            if opcode == _MESSAGE:
                yield self._message(chunk[position : position + size], block)
            elif opcode in (_SCHEMA, _CHANNEL):
                self._declare(opcode, chunk[position : position + size], block.offset)
            position += size

    def _message(self, content: memoryview, block: Block) -> Record:
        channel, _, log_ns, _ = unpack(_MESSAGE_HEADER, content, 0, block.offset)
        if channel not in self.channels:
            raise Damaged(f"a message of unknown channel {channel} at byte {block.offset}")
        if not block.start_ns <= log_ns <= block.end_ns:
            raise Damaged(f"a message outside its chunk's times at byte {block.offset}")
        return Record(channel, log_ns, bytes(content[_MESSAGE_HEADER.size :]))

    def _read(self, offset: int, size: int) -> bytes:
        """Read `size` bytes at `offset`, never more than the file holds."""
        if size > self._size - offset:
            raise Damaged(f"truncated at byte {self._size}")
        try:
            self._file.seek(offset)
            content = self._file.read(size)
        except OSError as error:
            raise Damaged(f"cannot be read at byte {offset} ({error.strerror})") from error
        if len(content) != size:
            raise Damaged(f"truncated at byte {offset + len(content)}, while it was read")
        return content
