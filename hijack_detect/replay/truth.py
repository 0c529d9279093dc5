# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The ground truth of a bag: a scenario, topics, or a label."""

from __future__ import annotations

import bisect
import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.topics import TYPES
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.estimation.geodesy import TangentPlane, separation_m
from hijack_detect.simulation.flight import Flight
from hijack_detect.simulation.plan import GROUND_S
from hijack_detect.spoofing import schema
from hijack_detect.spoofing.onset import fix_between
from hijack_detect.spoofing.scenario import Scenario
from hijack_detect.spoofing.schema import Forge
from hijack_detect.streams.messages import BadMessage, fix_sample
from hijack_detect.streams.samples import NANOSECONDS, FixSample


@dataclass(frozen=True)
class Attack:
    """An attack's stamps: onset (first spoofed stamp) and end, nanoseconds."""

    onset_ns: int
    end_ns: int | None


@dataclass(frozen=True)
class DetectorOutcome:
    """What one detector did, stamps in nanoseconds."""

    false_alarms: int
    """Times it went into ALARM before the onset (or at all, without an attack)."""
    first_alarm_ns: int | None
    """First ALARM verdict at or after the onset."""


def detector_outcome(verdicts: Iterable[Verdict], attack: Attack | None) -> DetectorOutcome:
    """Judge one detector's verdicts against the attack."""
    false_alarms, first, before = 0, None, State.NOT_READY
    for verdict in verdicts:
        alarm = verdict.state is State.ALARM
        if attack is None or verdict.stamp_ns < attack.onset_ns:
            false_alarms += alarm and before is not State.ALARM
        elif alarm and first is None:
            first = verdict.stamp_ns
        before = verdict.state
    return DetectorOutcome(false_alarms, first)


def alert_is_right(alert_ns: int | None, attack: Attack | None) -> bool:
    """True if the alert came inside the attack, or stayed away where there was none."""
    if attack is None or alert_ns is None:
        return attack is None and alert_ns is None
    return alert_ns >= attack.onset_ns and (attack.end_ns is None or alert_ns < attack.end_ns)


def changes(verdicts: Sequence[Verdict]) -> list[tuple[int, State]]:
    """Stamp and new state of every change of state, the first verdict included."""
    found: list[tuple[int, State]] = []
    for verdict in verdicts:
        if not found or found[-1][1] is not verdict.state:
            found.append((verdict.stamp_ns, verdict.state))
    return found


DEVIATED_M = 4.0
"""Metres from its target at which a vehicle has left its route. Measured: its own control and the
noise of an honest GPS take it up to 3.5 m away."""


def flight_label(name: str, flight: Flight, scenario: Scenario | None) -> dict[str, Any]:
    """Describe a flight; times are seconds from its first message.

    Args:
        name: Name of the bag.
        flight: The flight.
        scenario: The attacks that it was flown under.

    Returns:
        Plain data: id, kind (`straight`, `curved`, `hardneg` for what tempts a detector without
        an attack, `hijack`), route, yaw (`path` or `fixed`), speed, wind (m/s; direction it
        comes from, degrees clockwise from North; deviation of the gusts), GPS errors, times, and
        the attack or None.
    """
    conditions = flight.conditions
    blows_to = math.degrees(conditions.wind_direction)
    route = flight.plan.route
    kind = route if route in ("straight", "curved") else "hardneg"
    return {
        "id": name,
        "kind": kind if scenario is None else "hijack",
        "route": route,
        "yaw": "fixed" if route in ("hover", "fixed_yaw") else "path",
        "speed_m_s": 0.0 if route == "hover" else round(conditions.speed, 2),
        "wind": {
            "spd": round(conditions.wind_m_s, 2),
            "dir": round((270.0 - blows_to) % 360.0, 1),
            "turb": round(conditions.gust_m_s, 2),
        },
        "gps_noise": {
            "sig_h": round(conditions.fix_noise_m, 2),
            "tau": round(conditions.fix_noise_s, 1),
            "white": round(conditions.fix_white_m, 3),
            "verr": round(conditions.velocity_noise_m_s, 3),
            "lag_ms": round(1e3 * conditions.gps_lag_s),
        },
        "t_takeoff": GROUND_S,
        "t_forward_start": flight.forward_start_s,
        "t_forward_end": flight.forward_end_s,
        "duration": flight.plan.duration_s,
        "attack": None if scenario is None else _attack(flight, scenario),
    }


def attack_label(scenario: Scenario, end_s: float) -> dict[str, Any]:
    """The label of an attack before it is flown: kind, parameters, and times in seconds."""
    segments = scenario.segments
    return {
        "kind": "+".join(dict.fromkeys(segment.model.type for segment in segments)),
        "params": {"segments": [one.model_dump(mode="json", by_alias=True) for one in segments]},
        "t_start": segments[0].start_s,
        "t_end": end_s,
    }


def _attack(flight: Flight, scenario: Scenario) -> dict[str, Any]:
    """Describe the attacks, and how far they took reports and vehicle apart."""
    segments = scenario.segments
    horizontal, vertical = _separations(flight)
    start_s = segments[0].start_s
    end_s = flight.plan.duration_s if segments[-1].end_s is None else segments[-1].end_s
    motion = flight.motion
    time = motion.offsets_ns / 1e9
    attacked = (time >= start_s) & (time < end_s)
    away = np.linalg.norm(motion.position - motion.target, axis=1)[attacked]
    return {
        **attack_label(scenario, end_s),
        "t_ramp_end": min(_ramp_end_s(segments[-1]), end_s),
        "max_separation_h_m": round(horizontal, 1),
        "max_separation_v_m": round(vertical, 1),
        "max_deviation_m": round(float(away.max()), 1),
        "real_drone_deviated": bool(away.max() > DEVIATED_M),
    }


def _separations(flight: Flight) -> tuple[float, float]:
    """Largest horizontal and vertical distance of a measured and its reported fix, metres."""
    apart = [
        TangentPlane(measured).enu(reported)
        for measured, reported in zip(flight.measured_fixes, flight.fixes, strict=True)
    ]
    return max(math.hypot(x, y) for x, y, _ in apart), max(abs(z) for _, _, z in apart)


def _ramp_end_s(segment: schema.Segment) -> float:
    """When the offset between truth and report stops to grow; infinite if it never does."""
    model = segment.model
    still = isinstance(model, schema.Jump | schema.Jitter)
    if still or (isinstance(model, schema.Altitude) and model.rate_m_s == 0.0):
        return segment.start_s
    if isinstance(model, Forge) and model.drift_speed_m_s == 0.0:
        return segment.start_s
    return math.inf


TRUTH_FIX = "/truth/fix"
"""Where the vehicle was, `sensor_msgs/NavSatFix`, stamped when it was there."""
MEASURED_FIX = "/truth/measured_fix"
"""What the receiver would have reported without the attack, stamped as the reported fix."""
SPOOF_ACTIVE = "/spoof_active"
"""Whether the fixes are spoofed, `std_msgs/Bool`, logged with each fix."""
LABEL = "label.json"
GPS_LAG_S = 0.15
"""Lag of a fix behind its position, s. Simulation: the middle of the 0.1 to 0.2 s of
docs/simulator.md."""


Source: TypeAlias = Literal["scenario", "ground_truth", "label"]


class Known(NamedTuple):
    """A known attack: its times, None for none, and their source.

    Without a `source` nothing is known, not even that there was none.
    """

    attack: Attack | None
    source: Source | None


class TruthTrack:
    """True positions in order of stamp, to be compared with reported ones."""

    def __init__(self, fixes: Sequence[FixSample], lag_s: float) -> None:
        """Keep the true positions.

        Args:
            fixes: In order of stamp, at least one.
            lag_s: How much earlier than its stamp a reported fix was measured, on their clock.
        """
        self.fixes = fixes
        self._stamps = [fix.stamp_ns for fix in fixes]
        self._lag_ns = round(lag_s * NANOSECONDS)

    def at(self, stamp_ns: int) -> FixSample:
        """The true position at a time, linear between the two around it."""
        after = bisect.bisect_right(self._stamps, stamp_ns)
        if after in (0, len(self.fixes)):
            return self.fixes[max(after - 1, 0)]
        first, last = self.fixes[after - 1], self.fixes[after]
        part = (stamp_ns - first.stamp_ns) / (last.stamp_ns - first.stamp_ns)
        return fix_between(first, last, part)

    def separation_m(self, reported: FixSample) -> float:
        """Metres between a reported fix and where the vehicle was when it was measured."""
        return separation_m(self.at(reported.stamp_ns - self._lag_ns), reported)


def truth_track(reader: BagReader) -> TruthTrack | None:
    """The true track, if the bag has one.

    Raises:
        BagError: The bag is damaged.
    """
    for topic, lag_s in ((MEASURED_FIX, 0.0), (TRUTH_FIX, GPS_LAG_S)):
        if reader.topics.get(topic) == TYPES["fix"] and (fixes := valid_fixes(reader, topic)):
            return TruthTrack(fixes, lag_s)
    return None


def valid_fixes(reader: BagReader, topic: str) -> list[FixSample]:
    """The valid fixes of a topic whose stamps increase.

    Raises:
        BagError: The bag is damaged.
    """
    fixes: list[FixSample] = []
    for raw in reader.messages([topic]):
        try:
            fix = fix_sample(reader.deserialize(raw))
        except BadMessage:
            continue
        if fix.has_fix and (not fixes or fix.stamp_ns > fixes[-1].stamp_ns):
            fixes.append(fix)
    return fixes


def known_attack(reader: BagReader, scenario: Scenario | None = None) -> Known:
    """The attack on a flight: the scenario's, the ground truth's in the bag, or the label's.

    Raises:
        BagError: The label beside the bag cannot be used, or the bag is damaged.
        ScenarioError: A segment lies outside the flight.
    """
    if scenario is not None:
        return Known(scenario_attack(scenario, reader), "scenario")
    if reader.topics.get(SPOOF_ACTIVE) == "std_msgs/msg/Bool":
        return Known(recorded_attack(reader), "ground_truth")
    label = read_label(reader.path)
    if label is None:
        return Known(None, None)
    return Known(label_attack(label, reader.start_ns), "label")


def scenario_attack(scenario: Scenario, reader: BagReader) -> Attack:
    """From the start of the first segment to the end of the last.

    Raises:
        ScenarioError: A segment lies outside the flight.
    """
    scenario.check_within(reader.duration_s)
    return attack_times(scenario, reader.start_ns)


def attack_times(scenario: Scenario, start_ns: int) -> Attack:
    """The same for a flight whose first message is at `start_ns`, which it is to fit into."""
    first, last = scenario.segments[0], scenario.segments[-1]
    end = None if last.end_s is None else start_ns + round(last.end_s * NANOSECONDS)
    return Attack(start_ns + round(first.start_s * NANOSECONDS), end)


def read_label(bag: Path) -> dict[str, Any] | None:
    """The content of `label.json` beside a bag, None without one.

    Raises:
        BagError: The file is no label.
    """
    path = (bag if bag.is_dir() else bag.parent) / LABEL
    if not path.is_file():
        return None
    try:
        label = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(label["kind"], str):
            raise TypeError(f"kind is {label['kind']!r}, not a word")
        attack = label["attack"]
        if attack is not None and not 0.0 <= attack["t_start"] < attack["t_end"] < math.inf:
            raise ValueError("the attack begins before the flight or does not end after its start")
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise BagError(f"{path}: is no label of a flight ({error!r})") from error
    return dict(label)


def label_attack(label: dict[str, Any], start_ns: int) -> Attack | None:
    """The attack of a label, whose times are seconds from the bag's first message."""
    attack = label["attack"]
    if attack is None:
        return None
    onset, end = (start_ns + round(attack[key] * NANOSECONDS) for key in ("t_start", "t_end"))
    return Attack(onset, end)


def recorded_attack(reader: BagReader) -> Attack | None:
    """The time from the first to after the last fix that the bag's ground truth calls spoofed.

    Raises:
        BagError: The bag is damaged.
    """
    flags = [(raw.log_ns, reader.deserialize(raw).data) for raw in reader.messages([SPOOF_ACTIVE])]
    spoofed = [log_ns for log_ns, active in flags if active]
    if not spoofed:
        return None
    after = [log_ns for log_ns, _ in flags if log_ns > spoofed[-1]]
    return Attack(spoofed[0], after[0] if after else None)
