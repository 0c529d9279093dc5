# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A small bag with every input, and its parts."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hijack_detect.bags.writer import BagWriter
from hijack_detect.streams.samples import FixSample, ImuSample, MagneticSample, VelocitySample

START_NS = 1_700_000_000_000_000_000


def _write(path: Path, seconds: float = 40.0, topics: tuple[str, ...] = ()) -> Path:
    """Write noise on all inputs (or only `topics`): chunks enough to lose one."""
    rng = np.random.default_rng(1)
    with BagWriter(path) as bag:
        for index in range(round(seconds * 100)):
            stamp = START_NS + index * 10_000_000
            a, b, c = rng.normal(size=3).tolist()
            samples = {"/imu/data_raw": ImuSample(stamp, (a, b, c), (b, c, 9.8 + a))}
            if index % 20 == 0:
                samples["/gps/fix"] = FixSample(stamp, 48.0 + a * 1e-5, 11.0, 500.0 + b)
                samples["/gps/vel"] = VelocitySample(stamp, (a, b, c))
                samples["/mag"] = MagneticSample(stamp, (a * 1e-5, b * 1e-5, c * 1e-5))
            for topic, sample in samples.items():
                if not topics or topic in topics:
                    bag.write(topic, sample)
    return path


@pytest.fixture(scope="session")
def write_small_bag() -> Callable[..., Path]:
    return _write


@pytest.fixture(scope="session")
def small_bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return _write(tmp_path_factory.mktemp("bags") / "small")


@pytest.fixture(scope="session")
def small_mcap(small_bag: Path) -> bytes:
    return (small_bag / "small.mcap").read_bytes()


@pytest.fixture(scope="session")
def tiny_mcap(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    bag = _write(tmp_path_factory.mktemp("bags") / "tiny", 2.0)
    return (bag / "tiny.mcap").read_bytes()


@pytest.fixture(scope="session")
def faulty_bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bag with one NaN, three latitudes of 91° and one good message on each topic."""
    path = tmp_path_factory.mktemp("bags") / "faulty"
    with BagWriter(path) as bag:
        bag.write("/imu/data_raw", ImuSample(START_NS, (0.0, 0.0, 0.0), (0.0, 0.0, 9.8)))
        bag.write("/gps/fix", FixSample(START_NS, 48.0, 11.0, 500.0))
        bag.write("/imu/data_raw", ImuSample(START_NS + 7, (0.0, math.nan, 0.0), (0.0, 0.0, 9.8)))
        for index in range(3):
            bag.write("/gps/fix", FixSample(START_NS + 8 + index, 91.0 + index, 11.0, 500.0))
    return path
