# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Targets of random bytes: each takes them or refuses them, and does nothing else."""

from __future__ import annotations

import os
import shutil
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader, RawMessage
from hijack_detect.bags.samples import CONVERT, read_samples
from hijack_detect.bags.topics import TYPES
from hijack_detect.cli.parameter_files import load_parameters
from hijack_detect.detectors.fusion import Latched
from hijack_detect.logs.csv_map import load_map
from hijack_detect.logs.formats import convert
from hijack_detect.monitor.verdict_messages import verdict_from
from hijack_detect.nodes.messages import message_class
from hijack_detect.nodes.state_file import Survivor
from hijack_detect.parameters import ParameterError
from hijack_detect.recording.journal_keeper import JournalKeeper
from hijack_detect.recording.journal_reader import Query, open_journal
from hijack_detect.recording.problems import JournalError
from hijack_detect.recording.rows import Row
from hijack_detect.recording.schema import FILE, TABLES
from hijack_detect.replay.truth import LABEL, label_attack, read_label
from hijack_detect.spoofing.scenario import ScenarioError, load_scenario
from hijack_detect.streams.cdr import FROM_BYTES
from hijack_detect.streams.messages import BadMessage
from stress.fuzz import small_logs
from stress.fuzz.flight import Flown, message_seeds, monitor_seeds
from stress.fuzz.seeds import (
    SESSION,
    START_NS,
    bag_seeds,
    journal_seeds,
    metadata_of,
    small_bag,
)

ROOT = Path(__file__).parents[2]
Attempt = Callable[[bytes], bool]
"""Whether the bytes were accepted; what it raises is a defect."""
KINDS = {
    **TYPES,
    "attitude": TYPES["imu"],
    "course": "geometry_msgs/msg/QuaternionStamped",
    "phase": "diagnostic_msgs/msg/DiagnosticArray",
}
VERDICT = "diagnostic_msgs/msg/DiagnosticArray"


COUNTS = struct.Struct("<QQ")
"""Inputs tried and accepted, in a file: libFuzzer ends the process as it likes."""


@dataclass(frozen=True)
class Target:
    """A parser.

    Attributes:
        words: What it reads, for the table.
        make: Makes what is given the bytes; it may write into the folder.
        seeds: Good input to begin with.
        longest: Bytes of an input, at most.
    """

    words: str
    make: Callable[[Path], Attempt]
    seeds: Callable[[Path], list[bytes]]
    longest: int = 16384


def _reads(
    name: str, read: Callable[[Path], object], refusal: type[Exception]
) -> Callable[[Path], Attempt]:
    """A parser of a file of that name, which may refuse it in one way only."""

    def make(folder: Path) -> Attempt:
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)

        def attempt(data: bytes) -> bool:
            file.write_bytes(data)
            try:
                read(file)
            except refusal:
                return False
            return True

        return attempt

    return make


def _read_bag(file: Path) -> None:
    with BagReader(file) as reader:
        for _ in read_samples(reader, reader.inputs(), on_rejected=lambda _: None):
            pass


def _read_metadata(file: Path) -> None:
    if not file.with_name("bag.mcap").is_file():
        bag = next(small_bag(file.parent.with_name("beside") / "bag").glob("*.mcap"))
        shutil.copy(bag, file.with_name("bag.mcap"))
    BagReader(file.parent).close()


def _read_label(file: Path) -> None:
    label = read_label(file.parent)
    assert label is not None
    label_attack(label, 0)


def _read_journal(file: Path) -> None:
    for beside in file.parent.glob(f"{file.name}-*"):
        beside.unlink()
    with open_journal(file) as journal:
        for table in TABLES:
            journal.summary(table)
            for _ in journal.rows(Query(table)):
                pass


def _convert(file: Path) -> None:
    """A bag in sqlite3 is a folder with its metadata."""
    log = file
    if file.suffix == ".db3":
        log = file.parent
        if not (log / "metadata.yaml").is_file():
            made = small_logs.sqlite(log.with_name("beside") / log.name)
            shutil.copy(made / "metadata.yaml", log)
    out = file.with_name("out")
    shutil.rmtree(out, ignore_errors=True)
    convert(log, out)


def _convert_table(file: Path) -> None:
    """A table with a good map, or a map with a good table."""
    folder = file.with_name("beside")
    folder.mkdir(exist_ok=True)
    table, columns = file, file
    if file.suffix == ".csv":
        columns = folder / "map.yaml"
        columns.write_text(small_logs.COLUMNS)
    else:
        table = folder / "flight.csv"
        if not table.is_file():
            small_logs.table(table)
    out = file.with_name("out")
    shutil.rmtree(out, ignore_errors=True)
    convert(table, out, None, load_map(columns))


def _table_seeds(folder: Path) -> list[bytes]:
    return [small_logs.table(folder / "seed.csv").read_bytes()]


def _offline_message(folder: Path) -> Attempt:
    """The first byte chooses the input; an Imu is read in two ways, which must agree."""
    with BagReader(small_bag(folder / "tried" / "bag")) as reader:
        pass  # only its types are needed
    names = list(CONVERT)

    def attempt(data: bytes) -> bool:
        name, body = names[data[0] % len(names) if data else 0], data[1:]
        try:
            message = reader.deserialize(RawMessage(f"/{name}", KINDS[name], 0, body))
            sample = CONVERT[name](message)
        except (BagError, BadMessage):
            return False
        quick = FROM_BYTES[name](body) if name in FROM_BYTES else None
        if quick is not None and repr(quick) != repr(sample):
            raise AssertionError(f"{quick} is not {sample}")
        return True

    return attempt


def _live_message(folder: Path) -> Attempt:
    """As rclpy reads it; whatever it raises on the bytes, a node counts and goes on."""
    from rclpy.serialization import deserialize_message  # noqa: PLC0415 - not for offline use

    kinds = {name: message_class(KINDS.get(name, VERDICT)) for name in (*CONVERT, "verdict")}
    names = list(kinds)

    def attempt(data: bytes) -> bool:
        name, body = names[data[0] % len(names) if data else 0], data[1:]
        try:
            message = deserialize_message(body, kinds[name])
        except Exception:
            return False
        try:
            verdict_from(message) if name == "verdict" else CONVERT[name](message)
        except BadMessage:
            return False
        return True

    return attempt


def _importer(words: str, name: str, make: Callable[[Path], Path], longest: int) -> Target:
    """The importer of a log of that name; `make` makes a good one, or a folder with one."""

    def seeds(folder: Path) -> list[bytes]:
        seed = folder / "seed"
        log = seed / name.split("/", maxsplit=1)[0]
        if not log.exists():
            seed.mkdir(parents=True, exist_ok=True)
            make(log)
        return [(seed / name).read_bytes()]

    return Target(words, _reads(name, _convert, BagError), seeds, longest)


def _recorder(folder: Path) -> Attempt:
    """The recorder takes up what it finds, or moves it aside; nothing may be raised or lost."""
    place = folder / "recorder"
    place.mkdir(exist_ok=True)

    def attempt(data: bytes) -> bool:
        for left in place.iterdir():
            left.unlink()
        (place / FILE).write_bytes(data)
        keeper = JournalKeeper(place / FILE, 2**20, 0, SESSION)
        keeper.add(Row("satellites", (START_NS, START_NS, 12)), 0.0)
        written = keeper.commit(0.0, START_NS) or keeper.commit(9.0, START_NS)
        keeper.close(9.0, START_NS)
        if not written:
            raise AssertionError(keeper.problem)
        return not keeper.notes

    return attempt


def _survivor(folder: Path) -> Attempt:
    os.environ["ROS_HOME"] = str(folder)
    survivor = Survivor("/fusion", 1e9)
    survivor.path.parent.mkdir(parents=True, exist_ok=True)

    def attempt(data: bytes) -> bool:
        survivor.path.write_bytes(data)
        return survivor.read() is not None

    return attempt


def _survivor_seeds(folder: Path) -> list[bytes]:
    _survivor(folder)
    survivor = Survivor("/fusion", 1e9)
    survivor.write(Latched(10**18, "gnss", ("gnss", "coast"), 0.99))
    return [survivor.path.read_bytes()]


def _files(*names: str) -> Callable[[Path], list[bytes]]:
    return lambda _: [
        path.read_bytes() for name in names for path in sorted((ROOT / "config").glob(name))
    ]


def _label_seeds(_: Path) -> list[bytes]:
    attack = '{"t_start": 60.0, "t_end": 90.5, "kind": "drift"}'
    return [f'{{"kind": "{kind}", "attack": {attack}}}'.encode() for kind in ("hijacked", "x")]


TARGETS: Mapping[str, Target] = {
    "bag": Target("mcap file", _reads("any.mcap", _read_bag, BagError), bag_seeds),
    "metadata": Target(
        "`metadata.yaml` of a bag",
        _reads("bag/metadata.yaml", _read_metadata, BagError),
        metadata_of,
    ),
    "message": Target("CDR of every input, from a bag", _offline_message, message_seeds),
    "live": Target("CDR of every input and a verdict, by rclpy", _live_message, message_seeds),
    "monitor": Target("values of messages, to all detectors", Flown, monitor_seeds, 48),
    "scenario": Target(
        "scenario",
        _reads("any.yaml", load_scenario, ScenarioError),
        _files("scenarios/*.yaml"),
    ),
    "parameters": Target(
        "parameter file",
        _reads("any.yaml", load_parameters, ParameterError),
        _files("default.yaml", "paper.yaml"),
    ),
    "label": Target("`label.json` of a flight", _reads(LABEL, _read_label, BagError), _label_seeds),
    "ulog": _importer("PX4 ULog", "any.ulg", small_logs.ulog, 2**16),
    "dataflash": _importer("ArduPilot DataFlash", "any.log", small_logs.dataflash, 2**16),
    "tlog": _importer("MAVLink telemetry", "any.tlog", small_logs.tlog, 2**16),
    "ros1": _importer("ROS 1 bag", "any.bag", small_logs.ros1, 2**18),
    "sqlite": _importer("ROS 2 bag in sqlite3", "any/any.db3", small_logs.sqlite, 2**18),
    "csv": Target("CSV", _reads("any.csv", _convert_table, BagError), _table_seeds, 2**16),
    "columns": Target(
        "column map of a CSV",
        _reads("any.yaml", _convert_table, BagError),
        lambda _: [small_logs.COLUMNS.encode()],
    ),
    "journal": Target(
        "journal (SQLite)",
        _reads("any.sqlite3", _read_journal, JournalError),
        journal_seeds,
        65536,
    ),
    "recorder": Target("journal, taken up by the recorder", _recorder, journal_seeds, 65536),
    "alert": Target("alert kept by the fusion", _survivor, _survivor_seeds),
}
