# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What is recorded."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

FUSION = "fusion"
"""Name of the source that says whether there is an alert."""


@dataclass(frozen=True)
class Source:
    """A topic that is recorded.

    Attributes:
        name: Name of the input, or of the detector.
        topic: Absolute topic.
        msgtype: Type as `std_msgs/msg/Bool`.
        stamped: Whether its messages begin with a header.
        decode: Makes the message from its CDR bytes, for what the journal keeps.
    """

    name: str
    topic: str
    msgtype: str
    stamped: bool = True
    decode: Callable[[bytes], Any] | None = None
