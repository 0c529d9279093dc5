# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Decoding of the records of an MCAP file, with every length checked.

The format: https://mcap.dev/spec. All integers are little endian.
"""

from __future__ import annotations

import struct
import sys
from zlib import crc32

from lz4.frame import LZ4FrameDecompressor

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

MAX_CHUNK_BYTES = 512 * 2**20
"""Largest decompressed chunk that is accepted; recorders write about 1 MiB."""

CHUNK_HEADER = struct.Struct("<QQQI")
"""First and last log time, decompressed size, checksum."""


class Damaged(Exception):
    """Says what is wrong at which byte; the container makes it a BagError naming the file."""


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
