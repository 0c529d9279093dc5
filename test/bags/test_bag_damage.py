# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Damaged, truncated and hostile files end in a BagError, quickly and in little memory."""

import struct
import sys
import tracemalloc
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.samples import read_samples
from hijack_detect.bags.topics import detect
from hijack_detect.bags.writer import BagWriter
from hijack_detect.streams.samples import NANOSECONDS, FixSample, ImuSample, Sample

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

MAGIC = b"\x89MCAP0\r\n"
START_NS = 1_700_000_000 * NANOSECONDS


def read_all(path: Path) -> list[tuple[str, Sample]]:
    with BagReader(path) as bag:
        return list(read_samples(bag, detect(bag.topics), on_rejected=lambda _: None))


def record(opcode: int, content: bytes) -> bytes:
    return struct.pack("<BQ", opcode, len(content)) + content


def chunk(size: int, data: bytes, compression: bytes = b"zstd") -> bytes:
    head = struct.pack("<QQQI", 0, 2**63, size, 0)
    return record(
        6,
        head
        + struct.pack("<I", len(compression))
        + compression
        + struct.pack("<Q", len(data))
        + data,
    )


def finished(*records: bytes) -> bytes:
    return MAGIC + b"".join(records) + record(2, bytes(20)) + MAGIC


def test_missing(tmp_path: Path) -> None:
    with pytest.raises(BagError, match=r"nothing\.mcap: does not exist"):
        BagReader(tmp_path / "nothing.mcap")


def test_empty_file(tmp_path: Path) -> None:
    (tmp_path / "zero.mcap").touch()
    with pytest.raises(BagError, match=r"zero\.mcap: is empty \(0 bytes\)"):
        BagReader(tmp_path / "zero.mcap")


@pytest.mark.parametrize("content", [b"#ROSBAG V2.0\n", b"x", bytes(10_000)])
def test_not_mcap(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "odd.mcap").write_bytes(content)
    with pytest.raises(BagError, match="is not an MCAP file"):
        BagReader(tmp_path / "odd.mcap")


def test_no_messages(tmp_path: Path) -> None:
    (tmp_path / "none.mcap").write_bytes(finished())
    with pytest.raises(BagError, match="no messages"):
        BagReader(tmp_path / "none.mcap")


def test_directory_without_metadata_and_with_two_files(tmp_path: Path, small_mcap: bytes) -> None:
    for name in ("a.mcap", "b.mcap"):
        (tmp_path / name).write_bytes(small_mcap)
    with pytest.raises(BagError, match=r"no metadata\.yaml and 2 \.mcap files"):
        BagReader(tmp_path)


def test_empty_directory(tmp_path: Path) -> None:
    with pytest.raises(BagError, match=r"no metadata\.yaml and 0 \.mcap files"):
        BagReader(tmp_path)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "is not the metadata"),
        ("{", "cannot be read"),
        ("[" * 2_000, "cannot be read"),
        ("rosbag2_bagfile_information: 7", "is not the metadata"),
        ("rosbag2_bagfile_information: {storage_identifier: sqlite3}", "only mcap is read"),
        ("rosbag2_bagfile_information: {storage_identifier: mcap}", "lists no files"),
        (
            "rosbag2_bagfile_information: {storage_identifier: mcap, compression_mode: FILE}",
            "compression mode 'file'",
        ),
        (
            "rosbag2_bagfile_information: "
            "{storage_identifier: mcap, relative_file_paths: [../../etc/passwd]}",
            "passwd: is missing",
        ),
    ],
)
def test_metadata(tmp_path: Path, text: str, reason: str) -> None:
    (tmp_path / "metadata.yaml").write_text(text)
    with pytest.raises(BagError, match=reason):
        BagReader(tmp_path)


def test_truncated_at_many_places(tmp_path: Path, small_mcap: bytes) -> None:
    """The file is the same at every cut but the last byte kept; none is read as if whole."""
    file = tmp_path / "cut.mcap"
    readable = set()
    for size in [*range(1, len(small_mcap), 997), *range(len(small_mcap) - 60, len(small_mcap))]:
        file.write_bytes(small_mcap[:size])
        with pytest.raises(BagError, match=r"cut\.mcap") as caught:
            read_all(file)
        if size > len(MAGIC):
            assert "mcap recover" in str(caught.value)
            readable.add(int(str(caught.value).split(" messages before")[0].rsplit(" ", 1)[1]))
    assert readable >= {0, 4600}
    assert len(readable) > 2, "a cut between chunks leaves some messages"


def test_every_cut_and_every_changed_byte_of_a_small_bag(tmp_path: Path) -> None:
    """No cut is read as if whole; a changed byte is seen, or changes nothing that is read."""
    with BagWriter(tmp_path / "bag") as bag:
        bag.write("/imu/data_raw", ImuSample(START_NS, (0.1, 0.2, 0.3), (0.0, 0.0, 9.8)))
        bag.write("/gps/fix", FixSample(START_NS, 48.0, 11.0, 500.0))
    content = (tmp_path / "bag" / "bag.mcap").read_bytes()
    file = tmp_path / "small.mcap"
    for size in range(len(content)):
        file.write_bytes(content[:size])
        with pytest.raises(BagError, match=r"small\.mcap"):
            read_all(file)
    file.write_bytes(content)
    whole = read_all(file)
    refused = 0
    for place in range(len(content)):
        changed = bytearray(content)
        changed[place] ^= (0x01, 0x80, 0xFF)[place % 3]
        file.write_bytes(changed)
        try:
            found = read_all(file)
        except BagError:
            refused += 1
        else:
            assert found == whole
    assert refused > len(content) / 3


def test_truncated_file_says_how_many_messages_are_left(tmp_path: Path, small_mcap: bytes) -> None:
    (tmp_path / "cut.mcap").write_bytes(small_mcap[:-1])
    with pytest.raises(BagError, match=r"truncated.* 4600 messages .* `mcap recover cut\.mcap"):
        BagReader(tmp_path / "cut.mcap")


def test_file_cut_while_it_is_read(tmp_path: Path, write_small_bag: Callable[..., Path]) -> None:
    bag = write_small_bag(tmp_path / "bag")
    with BagReader(bag) as reader:
        messages = reader.messages()
        next(messages)
        with (bag / "bag.mcap").open("r+b") as file:
            file.truncate(1000)
        with pytest.raises(BagError, match=r"bag\.mcap: truncated"):
            list(messages)


@settings(
    max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(data=st.data())
def test_changed_bytes(tmp_path: Path, tiny_mcap: bytes, data: st.DataObject) -> None:
    """Any few changed bytes are read as something, or refused."""
    content = bytearray(tiny_mcap)
    edges = st.integers(0, 300) | st.integers(len(content) - 3000, len(content) - 1)
    for _ in range(data.draw(st.integers(1, 4))):
        position = data.draw(edges | st.integers(0, len(content) - 1))
        content[position] = data.draw(st.integers(0, 255))
    file = tmp_path / "changed.mcap"
    file.write_bytes(content)
    with suppress(BagError):
        read_all(file)


@settings(max_examples=200, deadline=None)
@given(content=st.binary(max_size=300))
def test_any_records(tmp_path_factory: pytest.TempPathFactory, content: bytes) -> None:
    file = tmp_path_factory.getbasetemp() / "any.mcap"
    for whole in (MAGIC + content, finished(content), finished(chunk(len(content), content, b""))):
        file.write_bytes(whole)
        with pytest.raises(BagError):
            read_all(file)


HOSTILE = {
    "record of 2^60 bytes": MAGIC + struct.pack("<BQ", 6, 2**60) + bytes(100),
    "chunk of 2^40 bytes": finished(chunk(2**40, zstd.compress(b"x"))),
    "string of 2^32 bytes": finished(record(3, struct.pack("<HI", 1, 2**32 - 1) + b"x")),
    "chunk that expands more than it says": finished(chunk(100, zstd.compress(bytes(2**28)))),
    "chunk in an unknown compression": finished(chunk(1, b"x", b"rar")),
    "chunk that is no zstd": finished(chunk(100, b"not zstd")),
    "chunk that is no lz4": finished(chunk(100, b"not lz4", b"lz4")),
    "chunk that is shorter than it says": finished(chunk(100, zstd.compress(b"x"))),
    "message of an unknown channel": finished(record(5, struct.pack("<HIQQ", 9, 0, 0, 0))),
    "statistics of unknown channels": finished(
        record(11, struct.pack("<QHIIIIQQIHQ", 5, 0, 0, 0, 0, 0, 0, 0, 10, 3, 5))
    ),
    "statistics cut short": finished(record(11, bytes(3))),
}


@pytest.mark.parametrize("content", HOSTILE.values(), ids=HOSTILE.keys())
def test_hostile_lengths_do_not_take_memory(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "hostile.mcap"
    file.write_bytes(content)
    tracemalloc.start()
    try:
        with pytest.raises(BagError, match=r"hostile\.mcap"):
            read_all(file)
        assert tracemalloc.get_traced_memory()[1] < 2**22
    finally:
        tracemalloc.stop()
