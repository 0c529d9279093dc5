# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Every parser takes or refuses what is random; `make fuzz` goes on for longer, led by coverage."""

from __future__ import annotations

import gc
import random
import warnings
from pathlib import Path

import pytest

pytest.importorskip("mcap", reason="mcap is not installed")

from stress.fuzz.targets import TARGETS

TRIES = {
    "monitor": 12,
    "parameters": 200,
    "recorder": 60,
    "ulog": 40,
    "dataflash": 40,
    "tlog": 40,
    "ros1": 40,
    "sqlite": 20,
    "csv": 40,
    "columns": 100,
}
MOST_TRIES = 400


def changed(seed: bytes, rng: random.Random) -> bytes:
    """A few bytes set, taken out, put in twice, or the end cut off."""
    data = bytearray(seed)
    for _ in range(rng.randint(1, 4)):
        at = rng.randrange(len(data) + 1)
        end = min(len(data), at + rng.choice((1, 1, 4, 30)))
        what = rng.randrange(5)
        if what == 0:
            del data[at:]
        elif what == 1:
            del data[at:end]
        elif what == 2:
            data[at:at] = data[at:end]
        else:
            data[at:end] = rng.randbytes(end - at) if what == 3 else b"\xff" * (end - at)
    return bytes(data)


@pytest.mark.parametrize("name", TARGETS)
def test_random_bytes_are_taken_or_refused(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_HOME", str(tmp_path))  # the alert's target sets it
    target = TARGETS[name]
    seeds = target.seeds(tmp_path)
    attempt = target.make(tmp_path)
    if name != "monitor":
        assert all(map(attempt, seeds))
    rng = random.Random(7)
    tries = TRIES.get(name, MOST_TRIES)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)  # pymavlink leaves a file open
        accepted = [attempt(changed(rng.choice(seeds), rng)) for _ in range(tries)]
        gc.collect()
    assert not all(accepted)
