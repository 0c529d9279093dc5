# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Small bags for the tests of the replay: a straight flight with noise, a few seconds long."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
import pytest

from hijack_detect.bags.container import Container
from hijack_detect.bags.encoding import encode_bool, encode_count, encode_sample
from hijack_detect.bags.reader import RawMessage
from hijack_detect.bags.topics import PRESETS, TopicMap
from hijack_detect.bags.writer import BagWriter
from hijack_detect.streams.samples import FixSample, ImuSample, Sample, VelocitySample

_HEADED = (
    "sensor_msgs/msg/Imu",
    "sensor_msgs/msg/NavSatFix",
    "sensor_msgs/msg/MagneticField",
    "geometry_msgs/msg/TwistStamped",
    "mavros_msgs/msg/GPSRAW",
)
_PLAIN = ("std_msgs/msg/UInt32", "std_msgs/msg/Bool", "diagnostic_msgs/msg/DiagnosticArray")
START_NS = 1_700_000_000_000_000_000
STEP_NS = 20_000_000
SPOOF_TEXT = """
segments:
  - {start: 1.0, end: 3.0, model: {type: jump, distance_m: 50.0, bearing_deg: 90.0}}
"""


def flight(seconds: float = 4.0, names: TopicMap = PRESETS["default"]) -> Iterator[RawMessage]:
    """Imu at 50 Hz, fix, velocity and satellites at 5 Hz, and a true fix, all on the same grid."""
    rng = np.random.default_rng(1)
    for index in range(round(seconds * 50) + 1):
        stamp = START_NS + index * STEP_NS
        noise = rng.normal(size=3).tolist()
        yield raw(names.imu, ImuSample(stamp, tuple(noise), (0.0, noise[0], 9.8)))
        if index % 10 == 0:
            fix = FixSample(stamp, 48.0 + 1e-6 * index, 11.0 + 1e-6 * noise[0], 500.0)
            yield raw(names.fix, fix)
            assert names.velocity is not None
            yield raw(names.velocity, VelocitySample(stamp, (noise[1], 5.0, 0.0)))
            yield raw("/truth/fix", fix)
            assert names.satellites is not None
            yield RawMessage(names.satellites, *_at(stamp, encode_count(9)))


def raw(topic: str, sample: Sample, log_ns: int | None = None) -> RawMessage:
    """A message of a sample, logged at its stamp unless told otherwise."""
    stamp = sample.stamp_ns if log_ns is None else log_ns
    return RawMessage(topic, *_at(stamp, encode_sample(sample)))


def flag(topic: str, log_ns: int, value: bool) -> RawMessage:
    """A message with a Bool."""
    return RawMessage(topic, *_at(log_ns, encode_bool(value)))


def write(path: Path, messages: Iterable[RawMessage]) -> Path:
    """Write a bag directory."""
    with BagWriter(path) as bag:
        for one in messages:
            bag.write_raw(one.topic, one.msgtype, one.log_ns, one.data)
    return path


def damage_last_chunk(path: Path) -> None:
    """Spoil a bag of several chunks so that it opens, and its reading fails at the last one."""
    file = next(path.glob("*.mcap"))
    with_blocks = Container(file)
    with_blocks.close()
    assert len(with_blocks.blocks) > 1
    block = with_blocks.blocks[-1]
    content = bytearray(file.read_bytes())
    middle = block.offset + block.size // 2
    content[middle : middle + 64] = bytes(64)
    file.write_bytes(content)


def stand_in(msgtype: str) -> object:
    """A message class as far as the replay looks at it, without ROS; None if not installed."""
    return _Headed if msgtype in _HEADED else _Plain if msgtype in _PLAIN else None


class _Headed:
    @staticmethod
    def get_fields_and_field_types() -> dict[str, str]:
        return {"header": "std_msgs/Header", "rest": "double"}


class _Plain:
    @staticmethod
    def get_fields_and_field_types() -> dict[str, str]:
        return {"data": "uint32"}


def _at(log_ns: int, message: tuple[str, bytes]) -> tuple[str, int, bytes]:
    return message[0], log_ns, message[1]


@pytest.fixture(scope="session")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A flight of four seconds."""
    return write(tmp_path_factory.mktemp("replay") / "flight", flight())


@pytest.fixture(scope="session")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A jump from 1 to 3 s."""
    path = tmp_path_factory.mktemp("scenario") / "jump.yaml"
    path.write_text(SPOOF_TEXT)
    return path
