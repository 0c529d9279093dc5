# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A recorder without ROS, and a flight for it: messages as CDR, decoded by rosbags."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hijack_detect.bags.encoding import encode_bool, encode_count, encode_sample
from hijack_detect.bags.reader import typestore
from hijack_detect.bags.topics import OWN_TOPICS, TYPES
from hijack_detect.detectors.verdict import Verdict
from hijack_detect.monitor.verdict_messages import verdict_from
from hijack_detect.recording.black_box import FUSION, Source
from hijack_detect.recording.parameters import RecorderParameters
from hijack_detect.recording.recorder import Recorder
from hijack_detect.streams.samples import FixSample, ImuSample, VelocitySample

SECOND = 1_000_000_000
START_NS = 1_764_000_000 * SECOND
ARRAY = "diagnostic_msgs/msg/DiagnosticArray"
DEADLINE_S = 20.0


def decoder(msgtype: str) -> Callable[[bytes], Any]:
    return lambda data: typestore().deserialize_cdr(data, msgtype)


def _verdict(data: bytes) -> Verdict:
    return verdict_from(decoder(ARRAY)(data))


SOURCES = {
    **{
        name: Source(
            name,
            f"/{topic}",
            TYPES[name],
            name != "satellites",
            decoder(TYPES[name]) if name in ("fix", "velocity", "satellites") else None,
        )
        for name, topic in OWN_TOPICS.items()
    },
    "date": Source("date", "/date/verdict", ARRAY, True, _verdict),
    FUSION: Source(FUSION, "/fusion/verdict", ARRAY, True, decoder(ARRAY)),
    "hijack_alert": Source("hijack_alert", "/hijack_alert", "std_msgs/msg/Bool", False),
}


def imu(stamp_ns: int) -> bytes:
    turn = stamp_ns % 997 / 997
    return encode_sample(ImuSample(stamp_ns, (turn, -turn, 0.0), (turn, 0.0, 9.8)))[1]


def fix(stamp_ns: int, latitude_deg: float = 48.0) -> bytes:
    return encode_sample(FixSample(stamp_ns, latitude_deg, 11.0, 500.0))[1]


def velocity(stamp_ns: int) -> bytes:
    return encode_sample(VelocitySample(stamp_ns, (0.0, 5.0, 0.0)))[1]


def satellites(count: int) -> bytes:
    return encode_count(count)[1]


def flag(value: bool) -> bytes:
    return encode_bool(value)[1]


def array(stamp_ns: int, name: str, text: str, values: dict[str, str]) -> bytes:
    """A diagnostic_msgs/DiagnosticArray with one status."""
    types = typestore().types
    header = types["std_msgs/msg/Header"](
        types["builtin_interfaces/msg/Time"](*divmod(stamp_ns, SECOND)), ""
    )
    pairs = [types["diagnostic_msgs/msg/KeyValue"](key, value) for key, value in values.items()]
    status = types["diagnostic_msgs/msg/DiagnosticStatus"](0, name, text, "", pairs)
    return bytes(typestore().serialize_cdr(types[ARRAY](header, [status]), ARRAY))


def verdict(stamp_ns: int, state: str = "normal", score: float = 0.25) -> bytes:
    values = {"state": state, "score": repr(score), "threshold": "1.0", "delta_ax": "0.5"}
    return array(stamp_ns, "date", "date says so", values)


def fusion(stamp_ns: int, *, alert: bool, state: str | None = None) -> bytes:
    values = {
        "state": state or ("alarm" if alert else "normal"),
        "alert": str(alert).lower(),
        "alert_since_ns": str(stamp_ns) if alert else "",
        "confidence": "0.75",
        "lost": "",
        "degraded": "",
        "causes": "date" if alert else "",
    }
    return array(stamp_ns, FUSION, "date alarm" if alert else "calm", values)


class Flown:
    """A recorder and what flies past it: Imu at `imu_hz`, everything of the GPS at 5 Hz."""

    def __init__(self, folder: Path, imu_hz: int = 50, **parameters: Any) -> None:
        self.parameters = RecorderParameters(folder=str(folder), **parameters)
        self.told: list[tuple[str, str]] = []
        self.announced: list[Path] = []
        self.on_announced: Callable[[Path], object] = lambda _: None
        self.recorder = Recorder(
            self.parameters,
            "/recorder",
            "1.2.3",
            lambda level, text: self.told.append((level, text)),
            self._announce,
        )
        self.stamp_ns = START_NS
        self._step_ns = SECOND // imu_hz
        self._gps_ns = SECOND // 5

    def _announce(self, path: Path) -> None:
        self.announced.append(path)
        self.on_announced(path)

    def receive(self, name: str, data: bytes) -> None:
        self.recorder.receive(SOURCES[name], data)

    def fly(self, seconds: float, *, alert: bool = False) -> None:
        """Let messages arrive, as fast as they are taken."""
        until_ns = self.stamp_ns + round(seconds * SECOND)
        while self.stamp_ns < until_ns:
            self.stamp_ns += self._step_ns
            self.receive("imu", imu(self.stamp_ns))
            if self.stamp_ns % self._gps_ns < self._step_ns:
                self.receive("fix", fix(self.stamp_ns))
                self.receive("velocity", velocity(self.stamp_ns))
                self.receive("satellites", satellites(9))
                self.receive("date", verdict(self.stamp_ns))
                self.receive(FUSION, fusion(self.stamp_ns, alert=alert))
                self.receive("hijack_alert", flag(alert))

    def tick_until(self, condition: Callable[[], object]) -> None:
        """Tick until something is so."""
        deadline = time.monotonic() + DEADLINE_S
        while not condition():
            assert time.monotonic() < deadline, f"too late; told was {self.told}"
            self.recorder.tick()
            time.sleep(0.005)
