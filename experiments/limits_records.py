# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Record of every detector and the fusion around an attack, small enough to keep for thousands.

From these records come maps of detection and time to detect, ROC curves, and the calibration of
the fusion: for an attack each method's largest margin within the first 1 to 60 s, for clean time
its largest margin in every ten seconds. The fusion's margin is its confidence, which counts up to
the alert only, as that is latched.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

from experiments.forked import HORIZON_S, run_forked
from hijack_detect.detectors.fusion import FusionResult
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.evaluation.scores.model import Model
from hijack_detect.evaluation.trials.cases import BagCase, Case, class_of
from hijack_detect.evaluation.trials.families import Placed, attacks_on
from hijack_detect.evaluation.trials.onsets import forward_flight
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.replay.offline import OfflineRun
from hijack_detect.streams.samples import NANOSECONDS

FUSION = "fusion"
WINDOWS_S = (1.0, 2.0, 5.0, 10.0, 20.0, 60.0)
"""Seconds after the onset within which the largest margins are kept. Chosen, not swept."""
BLOCK_S = 10.0
"""Length of the pieces of clean time whose largest margins are kept, seconds."""


class MethodRecord(Model):
    """Record of one method and one attack; seconds from the onset.

    Attributes:
        suspicious_s: First verdict that was SUSPICIOUS or worse, None without.
        alarm_s: First ALARM, None without.
        separation_m: Metres between true and reported position then, None where not known.
        margins: Largest margin within each of WINDOWS_S.
        before_s: How long before the onset the method alarmed last, None if never. It had been
            wrong by then, or even kept its alarm, and no later verdict is a detection.
    """

    suspicious_s: float | None
    alarm_s: float | None
    separation_m: float | None
    margins: tuple[float, ...]
    before_s: float | None


class AttackRecord(Model):
    """One attack.

    Attributes:
        family: Its family or class.
        size: Its size in words.
        figures: Its size as numbers by name.
        onset_s: Onset, seconds after the flight's first message.
        watched_s: How long it was followed, seconds.
        methods: Record of each method.
    """

    family: str
    size: str
    figures: dict[str, float]
    onset_s: float
    watched_s: float
    methods: dict[str, MethodRecord]


class FlightRecord(Model):
    """One flight: its clean time, and attacks on it.

    Attributes:
        name: The flight's name.
        kind: Its class.
        clean_s: Length of its clean time, from the first message, seconds.
        blocks: By method, the largest margin in every BLOCK_S of the clean time.
        alarms: By method, begin and end of each episode of alarms that began in the clean time,
            seconds.
        attacks: The attacks.
    """

    name: str
    kind: str
    clean_s: float
    blocks: dict[str, list[float]]
    alarms: dict[str, list[tuple[float, float]]]
    attacks: list[AttackRecord]


class Claim(NamedTuple):
    """One output of a method in the terms of these records."""

    stamp_ns: int
    suspicious: bool
    alarm: bool
    margin: float


def claim(output: Any) -> Claim | None:
    """What an output of the monitor claims, None if it is not a verdict of any method."""
    if isinstance(output, Verdict):
        alarm = output.state is State.ALARM
        suspicious = alarm or output.state is State.SUSPICIOUS
        return Claim(output.stamp_ns, suspicious, alarm, output.margin)
    if isinstance(output, FusionResult):
        suspicious = output.alert or output.state in (State.SUSPICIOUS, State.ALARM)
        counts = output.alert_since_ns in (None, output.stamp_ns)
        confidence = output.confidence if counts else 0.0
        return Claim(output.stamp_ns, suspicious, output.alert, confidence)
    return None


class CleanLog:
    """Summary of the verdicts in clean time."""

    def __init__(self, start_ns: int) -> None:
        """Count from the stamp of the flight's first message."""
        self._start_ns = start_ns
        self._blocks: dict[str, list[float]] = {}
        self._alarms: dict[str, list[tuple[int, int]]] = {}
        self._alarming: set[str] = set()

    def add(self, method: str, output: Any) -> None:
        """Take an output of any part of the monitor."""
        one = claim(output)
        if one is None:
            return
        blocks = self._blocks.setdefault(method, [])
        episodes = self._alarms.setdefault(method, [])
        index = int((one.stamp_ns - self._start_ns) / NANOSECONDS // BLOCK_S)
        if index >= 0:
            blocks += [0.0] * (index + 1 - len(blocks))
            blocks[index] = max(blocks[index], _short(one.margin))
        if not one.alarm:
            self._alarming.discard(method)
        elif method in self._alarming:
            episodes[-1] = (episodes[-1][0], one.stamp_ns)
        else:
            self._alarming.add(method)
            episodes.append((one.stamp_ns, one.stamp_ns))

    def before_s(self, method: str, onset_ns: int) -> float | None:
        """Seconds from the last alarm before a stamp to it, None without one."""
        begun = [episode for episode in self._alarms.get(method, ()) if episode[0] < onset_ns]
        return max(0.0, (onset_ns - begun[-1][1]) / NANOSECONDS) if begun else None

    def record(
        self, name: str, kind: str, clean_s: float, attacks: list[AttackRecord]
    ) -> FlightRecord:
        """The record of the flight."""
        alarms = {
            method: [(self._seconds(begin), self._seconds(end)) for begin, end in episodes]
            for method, episodes in self._alarms.items()
        }
        return FlightRecord(
            name=name,
            kind=kind,
            clean_s=clean_s,
            blocks=self._blocks,
            alarms=alarms,
            attacks=attacks,
        )

    def _seconds(self, stamp_ns: int) -> float:
        return round((stamp_ns - self._start_ns) / NANOSECONDS, 3)


def method_record(
    outputs: Iterable[Any], onset_ns: int, run: OfflineRun, watched_s: float, before_s: float | None
) -> MethodRecord:
    """Record of a method for an attack.

    Args:
        outputs: Verdicts, or results of the fusion, in order of stamp.
        onset_ns: Stamp of the onset.
        run: Knows the separations.
        watched_s: How long after the onset the attack is followed, seconds.
        before_s: See MethodRecord.
    """
    first: dict[str, int] = {}
    margins = [0.0] * len(WINDOWS_S)
    for one in filter(None, map(claim, outputs)):
        after_s = (one.stamp_ns - onset_ns) / NANOSECONDS
        if after_s < 0.0:
            if one.alarm:
                before_s = -after_s if before_s is None else min(before_s, -after_s)
            continue
        if after_s > watched_s:
            break
        if one.suspicious:
            first.setdefault("suspicious", one.stamp_ns)
        if one.alarm:
            first.setdefault("alarm", one.stamp_ns)
        for index, window_s in enumerate(WINDOWS_S):
            if after_s <= window_s:
                margins[index] = max(margins[index], one.margin)
    times = {what: round((ns - onset_ns) / NANOSECONDS, 3) for what, ns in first.items()}
    known = "alarm" in first and bool(run.separations)
    return MethodRecord(
        suspicious_s=times.get("suspicious"),
        alarm_s=times.get("alarm"),
        separation_m=_short(run.separation_at(first["alarm"])) if known else None,
        margins=tuple(map(_short, margins)),
        before_s=None if before_s is None else round(before_s, 3),
    )


def method_records(
    run: OfflineRun, onset_ns: int, watched_s: float, log: CleanLog
) -> dict[str, MethodRecord]:
    """Record of each detector and the fusion for an attack, see `method_record`."""
    return {
        method: method_record(outputs, onset_ns, run, watched_s, log.before_s(method, onset_ns))
        for method, outputs in _outputs(run)
    }


def _outputs(run: OfflineRun) -> Iterator[tuple[str, Iterable[Any]]]:
    return itertools.chain(run.verdicts.items(), [(FUSION, run.results)])


def record_case(
    parameters: MonitorParameters, case: Case, *, size: str = "", horizon_s: float = WINDOWS_S[-1]
) -> FlightRecord:
    """Run a whole flight, clean or attacked, and record the outputs.

    Args:
        parameters: Parameters of every part of the monitor.
        case: The flight; an attack on it is of the family that its class is called.
        size: Size of the attack in words.
        horizon_s: How long after its onset an attack is followed, seconds.

    Raises:
        ValueError: The flight cannot be read or made; the text names it.
    """
    done = case.run(parameters)
    run, attack = done.run, done.attack
    kind = class_of(case, attack)
    clean_ns = done.end_ns if attack is None else attack.onset_ns
    log = CleanLog(run.start_ns)
    for method, outputs in _outputs(run):
        for output in outputs:
            if output.stamp_ns >= clean_ns and attack is not None:
                break
            log.add(method, output)
    attacks = []
    if attack is not None:
        end_ns = done.end_ns if attack.end_ns is None else min(attack.end_ns, done.end_ns)
        watched_s = min(horizon_s, (end_ns - attack.onset_ns) / NANOSECONDS)
        attacks.append(
            AttackRecord(
                family=kind,
                size=size,
                figures={},
                onset_s=round((attack.onset_ns - run.start_ns) / NANOSECONDS, 3),
                watched_s=watched_s,
                methods=method_records(run, attack.onset_ns, watched_s, log),
            )
        )
    return log.record(case.name, kind, (clean_ns - run.start_ns) / NANOSECONDS, attacks)


def _short(value: float) -> float:
    """A number in four digits."""
    return float(f"{value:.4g}")


def record_forked(
    parameters: MonitorParameters,
    case: BagCase,
    *,
    moving: int = 10,
    any_phase: int = 5,
    horizon_s: float = HORIZON_S,
    chosen: Callable[[Placed], bool] = lambda _: True,
    on_done: Callable[[int, int], None] | None = None,
) -> FlightRecord:
    """Attack a clean flight with every family, see `attacks_on` and `run_forked`.

    Args:
        parameters: Parameters of every part of the monitor.
        case: The flight; its own scenario is not looked at.
        moving: Onsets in forward flight.
        any_phase: Onsets at any phase of flight.
        horizon_s: How long after its onset an attack is followed, seconds.
        chosen: Which attacks to run.
        on_done: Called after each attack with how many of how many are done.

    Raises:
        BagError: The bag cannot be read, or has no Imu or NavSatFix.
    """
    with case.opened() as reader:
        placed = attacks_on(
            case.name,
            forward_flight(reader),
            reader.duration_s,
            moving=moving,
            any_phase=any_phase,
        )
        wanted = [one for one in placed if chosen(one)]
        log = CleanLog(reader.start_ns)
        attacks: list[AttackRecord] = []
        for one, run in run_forked(
            reader, wanted, parameters, horizon_s=horizon_s, on_clean=log.add
        ):
            onset_ns = reader.start_ns + round(one.onset_s * NANOSECONDS)
            watched_s = min(horizon_s, (reader.end_ns - onset_ns) / NANOSECONDS)
            attacks.append(
                AttackRecord(
                    family=one.family,
                    size=one.size,
                    figures=dict(one.figures),
                    onset_s=one.onset_s,
                    watched_s=round(watched_s, 3),
                    methods=method_records(run, onset_ns, watched_s, log),
                )
            )
            if on_done is not None:
                on_done(len(attacks), len(wanted))
        return log.record(case.name, case.kind, reader.duration_s, attacks)
