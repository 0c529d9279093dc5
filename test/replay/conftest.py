# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Makes the helpers of test/ importable, and opens small bags for the tests of the replay."""

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))

from small_bags import bag, scenario, stand_in  # noqa: F401

from hijack_detect.replay.playback import Playback, ReplayParameters


@pytest.fixture
def playback() -> Iterator[Callable[..., Playback]]:
    """Opens bags, and closes them with the test."""
    made: list[Playback] = []

    def opened(path: Path, **parameters: object) -> Playback:
        made.append(Playback(ReplayParameters(bag=str(path), **parameters), stand_in))
        return made[-1]

    yield opened
    for one in made:
        one.close()
