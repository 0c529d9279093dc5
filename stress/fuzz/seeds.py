# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Good files to begin with."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

from mcap.writer import CompressionType, Writer

from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.writer import BagWriter
from hijack_detect.recording.journal import Journal, Session
from hijack_detect.streams.samples import NANOSECONDS, FixSample, ImuSample, VelocitySample

START_NS = 1_700_000_000 * NANOSECONDS
SESSION = Session(START_NS, "/recorder", "0")


def small_bag(path: Path) -> Path:
    """A bag of four messages; made if it is not there."""
    if path.is_dir():
        return path
    path.parent.mkdir(parents=True, exist_ok=True)
    with BagWriter(path) as bag:
        bag.write("/imu/data_raw", ImuSample(START_NS, (0.1, 0.2, 0.3), (0.0, 0.0, 9.8)))
        bag.write("/gps/fix", FixSample(START_NS, 48.0, 11.0, 500.0, accuracy_m=1.0))
        bag.write("/gps/vel", VelocitySample(START_NS, (1.0, 2.0, 3.0)))
        bag.write_count("/gps/satellites", START_NS, 12)
    return path


def bag_seeds(folder: Path) -> list[bytes]:
    """The same messages as we write them, and as mcap does without chunks or checksums.

    Behind a checksum random bytes come nowhere.
    """
    bag = small_bag(folder / "seed" / "bag")
    found = [next(bag.glob("*.mcap")).read_bytes()]
    for chunked in (True, False):
        file = BytesIO()
        writer = Writer(
            file,
            compression=CompressionType.NONE,
            use_chunking=chunked,
            enable_crcs=False,
        )
        writer.start("ros2")
        with BagReader(bag) as reader:
            for raw in reader.messages():
                schema = writer.register_schema(
                    raw.msgtype, "ros2msg", reader.definition(raw.topic).encode()
                )
                channel = writer.register_channel(raw.topic, "cdr", schema)
                writer.add_message(channel, raw.log_ns, raw.data, raw.log_ns)
        writer.finish()
        found.append(file.getvalue())
    return found


def metadata_of(folder: Path) -> list[bytes]:
    """The metadata of that bag."""
    return [(small_bag(folder / "seed" / "bag") / "metadata.yaml").read_bytes()]


def journal_seeds(folder: Path) -> list[bytes]:
    """An empty journal."""
    path = folder / "seed.sqlite3"
    if not path.is_file():
        Journal(path, 2**20, SESSION).close()
    return [path.read_bytes()]
