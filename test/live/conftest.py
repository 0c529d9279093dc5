# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Makes the helpers of test/ importable, and their fixtures known."""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))

from browser import browser  # noqa: F401
from shown import Flown

if TYPE_CHECKING:
    from hijack_detect.live.server import Server


@pytest.fixture
def server(flown: Flown) -> Iterator["Server"]:
    """Serves what is shown to the test; needs the extra live."""
    from hijack_detect.live.server import Server  # noqa: PLC0415  not installed everywhere

    made = Server(flown.picture, "127.0.0.1", 0)
    made.start()
    yield made
    made.stop()
    assert not made.alive
