# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""How a bridge is doing, for /diagnostics."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass

from hijack_detect.contract import Level
from hijack_detect.mavlink.bridge import Bridge
from hijack_detect.mavlink.codec import Codec
from hijack_detect.streams.samples import NANOSECONDS

INPUTS = ("imu", "fix", "velocity", "satellites", "mag", "pressure")
MILLISECOND = 1_000_000


@dataclass(frozen=True)
class Report:
    """Level, one sentence, and values."""

    level: Level
    text: str
    values: dict[str, str]


class Reporter:
    """Makes reports; rates are those since the one before."""

    def __init__(self, bridge: Bridge, codec: Codec) -> None:
        """Report on a bridge and its codec."""
        self._bridge, self._codec = bridge, codec
        self._before: Counter[str] = Counter()
        self._before_ns = 0

    def report(self, now_ns: int, link: str) -> Report:
        """How it is now.

        Args:
            now_ns: Now, by the steady clock.
            link: Why there is no link; empty if there is one.
        """
        bridge = self._bridge
        alarm = bridge.alarm
        level: Level = "info"
        missing = link or bridge.missing(now_ns)
        text = f"{bridge.inputs.taken} is published"
        if missing:
            level, text = "error", missing
        elif bridge.commander.failed:
            level, text = "error", f"the command failed: {bridge.commander.result}"
        elif alarm.silent:
            level, text = "warning", "the monitor is silent: no message on hijack_alert"
        return Report(level, text, self._values(now_ns))

    def _values(self, now_ns: int) -> dict[str, str]:
        bridge = self._bridge
        vehicle, round_trip = bridge.vehicle, bridge.clock.round_trip_ns(now_ns)
        seconds = (now_ns - self._before_ns) / NANOSECONDS if self._before_ns else math.inf
        counts = Counter(bridge.inputs.published)
        rates = {name: (counts[name] - self._before[name]) / seconds for name in INPUTS}
        self._before, self._before_ns = counts, now_ns
        return {
            "autopilot": "" if vehicle is None else "{}.{}".format(*vehicle.address),
            "imu from": bridge.inputs.taken,
            **{f"{name} Hz": f"{rate:.1f}" for name, rate in rates.items()},
            "round trip ms": "" if round_trip is None else f"{round_trip / MILLISECOND:.3f}",
            "system clock minus stamps s": f"{bridge.system_off_ns / NANOSECONDS:.3f}",
            "clock began afresh": str(bridge.clock.epoch),
            "messages missing": "" if vehicle is None else str(vehicle.lost),
            **_counts("bad", self._codec.bad),
            **_counts("left out", bridge.inputs.dropped),
            **_counts("ignored", bridge.ignored),
            "alert": _alert(bridge),
            "command": bridge.commander.result,
        }


def _alert(bridge: Bridge) -> str:
    if not bridge.alarm.received:
        return "not heard yet"
    if bridge.alarm.silent:
        return "silent"
    return "true" if bridge.alarm.on else "false"


def _counts(what: str, counts: Counter[str]) -> dict[str, str]:
    return {f"{what}: {reason}": str(count) for reason, count in counts.items()}
