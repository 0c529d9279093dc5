# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Writing of rosbag2 mcap bags."""

from __future__ import annotations

import contextlib
import shutil
import sys
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Literal

from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.rosbag2.errors import WriterError
from rosbags.rosbag2.storage_mcap import McapWriter
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from hijack_detect.bags import encoding
from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import typestore
from hijack_detect.streams.samples import Quaternion, Sample

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

if TYPE_CHECKING:
    from rosbags.interfaces import Connection

METADATA_VERSION: Literal[9] = 9
"""Version of metadata.yaml, as written by ROS 2 Jazzy."""


class BagWriter:
    """Writes a rosbag2 directory: one mcap with zstd chunks, and metadata.yaml.

    A context manager. The same calls write the same bytes (with the same versions of rosbags
    and zstd). If the block is left by an exception, or nothing was written, the directory is
    removed: an unfinished bag cannot be read.

    Stamps and log times are integer nanoseconds.
    """

    def __init__(self, path: str | Path) -> None:
        """Prepare to write the bag directory `path`, which must not exist.

        Raises:
            BagError: The path exists.
        """
        self.path = Path(path)
        self._connections: dict[str, Connection] = {}
        self._types = typestore()
        if self.path.exists():
            raise BagError(f"{self.path}: exists; remove it or choose another name")
        self._writer = Writer(
            self.path, version=METADATA_VERSION, storage_plugin=StoragePlugin.MCAP
        )
        self._writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)

    def __enter__(self) -> BagWriter:
        """Make the directory.

        Raises:
            BagError: It cannot be made.
        """
        try:
            self._writer.open()
        except (OSError, WriterError) as error:
            raise BagError(f"{self.path}: cannot be made ({error}); choose another name") from error
        assert isinstance(self._writer.storage, McapWriter)
        self._writer.storage.compressor = _with_checksum
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Finish the bag, or remove it.

        Raises:
            BagError: Nothing was written, or the disk is full.
        """
        if error is not None or not self._connections:
            self._writer.abort()
            shutil.rmtree(self.path, ignore_errors=True)
            if error is None:
                raise BagError(f"{self.path}: no message to write, so no bag was made")
            return
        try:
            self._writer.close()
        except OSError as failure:
            with contextlib.suppress(OSError):  # or the file stays open, and its room is taken
                self._writer.abort()
            shutil.rmtree(self.path, ignore_errors=True)
            raise BagError(
                f"{self.path}: cannot be finished ({failure}); make room and write it again"
            ) from failure

    def define(self, msgtype: str, definition: str) -> None:
        """Make a type known that is not one of ROS 2 Jazzy's.

        Args:
            msgtype: Its name, as `mavros_msgs/msg/State`.
            definition: Its definition and those of the types in it, as a bag holds them.

        Raises:
            BagError: The definition cannot be used.
        """
        if msgtype in self._types.fielddefs:
            return
        if not definition:
            raise BagError(f"{self.path}: {msgtype} has no definition")
        if self._types is typestore():
            self._types = get_typestore(Stores.ROS2_JAZZY)
        try:
            found = get_types_from_msg(definition, msgtype)
            known = self._types.fielddefs
            self._types.register({name: of for name, of in found.items() if name not in known})
            self._types.hash_rihs01(msgtype)
        except Exception as error:  # rosbags raises anything
            raise BagError(f"{self.path}: the definition of {msgtype} is not known") from error

    def write_raw(self, topic: str, msgtype: str, log_ns: int, data: bytes) -> None:
        """Write one message that is already CDR.

        Raises:
            BagError: The type is neither one of ROS 2 Jazzy's nor defined, the topic was written
                with another type, or the disk is full.
        """
        connection = self._connections.get(topic) or self._add(topic, msgtype)
        if connection.msgtype != msgtype:
            raise BagError(
                f"{self.path}: topic {topic} at {log_ns} ns has type {msgtype}, before it had "
                f"{connection.msgtype}; write it to another topic"
            )
        try:
            self._writer.write(connection, log_ns, data)
        except (OSError, OverflowError) as error:
            raise BagError(
                f"{self.path}: topic {topic} at {log_ns} ns cannot be written ({error})"
            ) from error

    def write(self, topic: str, sample: Sample, log_ns: int | None = None) -> None:
        """Write one sample as its message; logged at its stamp unless `log_ns` is given.

        Raises:
            BagError: As `write_raw`.
        """
        time = sample.stamp_ns if log_ns is None else log_ns
        self.write_raw(topic, *_at(time, encoding.encode_sample(sample)))

    def write_orientation(self, topic: str, stamp_ns: int, quaternion: Quaternion) -> None:
        """Write `geometry_msgs/QuaternionStamped`: rotation from FLU to ENU as (x, y, z, w)."""
        self.write_raw(topic, *_at(stamp_ns, encoding.encode_orientation(stamp_ns, quaternion)))

    def write_pressure(self, topic: str, stamp_ns: int, pascal: float) -> None:
        """Write `sensor_msgs/FluidPressure` in pascal."""
        self.write_raw(topic, *_at(stamp_ns, encoding.encode_pressure(stamp_ns, pascal)))

    def write_count(self, topic: str, log_ns: int, value: int) -> None:
        """Write `std_msgs/UInt32`."""
        self.write_raw(topic, *_at(log_ns, encoding.encode_count(value)))

    def write_bool(self, topic: str, log_ns: int, value: bool) -> None:
        """Write `std_msgs/Bool`."""
        self.write_raw(topic, *_at(log_ns, encoding.encode_bool(value)))

    def _add(self, topic: str, msgtype: str) -> Connection:
        if msgtype not in self._types.fielddefs:
            raise BagError(f"{self.path}: topic {topic} has type {msgtype!r}, which is not known")
        connection = self._writer.add_connection(topic, msgtype, typestore=self._types)
        self._connections[topic] = connection
        return connection


def _with_checksum(data: bytes) -> bytes:
    """Compress a chunk; rosbags gives it no checksum of its own."""
    return zstd.compress(data, options={zstd.CompressionParameter.checksum_flag: 1})


def _at(log_ns: int, message: tuple[str, bytes]) -> tuple[str, int, bytes]:
    return message[0], log_ns, message[1]
