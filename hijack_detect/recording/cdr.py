# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The header stamp of a message that is still CDR bytes."""

from __future__ import annotations

import struct

from hijack_detect.streams.samples import NANOSECONDS

_LITTLE = struct.Struct("<iI")
_BIG = struct.Struct(">iI")
_ENCAPSULATION_BYTES = 4
"""Two bytes say how the rest is encoded, two are options (DDS-XTypes 7.6.2)."""


def header_stamp_ns(data: bytes) -> int | None:
    """Stamp of a message that begins with `std_msgs/Header`, nanoseconds; None if too short."""
    if len(data) < _ENCAPSULATION_BYTES + _LITTLE.size:
        return None
    layout = _LITTLE if data[1] & 1 else _BIG
    seconds, nanoseconds = layout.unpack_from(data, _ENCAPSULATION_BYTES)
    return int(seconds) * NANOSECONDS + int(nanoseconds)
