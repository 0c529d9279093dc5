# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Effect of a slower IMU on each detector: the same flights with fewer samples.

    python -m experiments.imu_rate FLIGHT...

The IMU of each flight (a bag, or a log of any format of `analyze`) is brought to each rate, once by
picking samples and once by averaging them, and runs through the default monitor without the limit
on the IMU's rate. At four onsets in motion a copy is carried off with 1 m/s² up to 4 m/s for 22 s.

Prints a table for each flight: largest clean margin, share of verdicts that judge, and carry-offs
alarmed for, by rate and detector.
"""

from __future__ import annotations

import copy
import math
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import click
import numpy as np

from experiments.carried_off import Samples, drift, samples_of
from hijack_detect.detectors.verdict import JUDGED, State
from hijack_detect.estimation.flight_phase import FlightPhaseEstimator, FlightPhaseParameters
from hijack_detect.evaluation.scores.evaluation_tables import TextTable
from hijack_detect.monitor.graph import Monitor
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.replay.offline import runs_of
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.samples import (
    ImuSample,
    PhaseSample,
    Sample,
    Vector3,
    VelocitySample,
)
from tools.documents import markdown

RATES = (100.0, 50.0, 25.0, 20.0, 15.0, 10.0, 5.0, 2.0)
DETECTORS = ("coast", "date", "drag", "correlation", "heading", "altitude")
"""Those that use the IMU or the attitude."""
ONSETS, WATCHED_S, LONGEST_S = 4, 22.0, 330.0
"""Chosen, not swept."""
MOVING = 1.5
"""m/s: onsets lie between the first and the last time that the vehicle is faster. Chosen, not
swept."""
SETTLED_S = 45.0
"""Chosen, not swept."""


class AnyRate(FlightPhaseEstimator):
    """Phase of flight that takes every IMU for fast enough."""

    def update(self, name: str, sample: Sample) -> PhaseSample | None:
        """Take the next sample."""
        output = super().update(name, sample)
        return None if output is None else replace(output, imu_rate_hz=math.inf)


@dataclass
class Seen:
    """Outputs of one detector: largest margin, verdicts, verdicts that judge, and first alarm."""

    margin: float = 0.0
    verdicts: int = 0
    judged: int = 0
    alarm_ns: int | None = None


def at_rate(samples: Samples, rate: float, *, average: bool) -> Samples:
    """The samples with at most `rate` of the IMU: every nth, or the mean of what is left out."""
    found: list[tuple[str, Sample]] = []
    step_ns, next_ns = 1e9 / rate, 0.0
    waiting: list[ImuSample] = []
    for name, sample in samples:
        if not isinstance(sample, ImuSample):
            found.append((name, sample))
            continue
        waiting.append(sample)
        if sample.stamp_ns < next_ns - 1e6:
            continue
        next_ns = max(next_ns + step_ns, sample.stamp_ns + 0.5 * step_ns)
        if average:
            force = _mean([one.specific_force for one in waiting])
            rates = _mean([one.angular_velocity for one in waiting])
            sample = replace(sample, specific_force=force, angular_velocity=rates)  # noqa: PLW2901
        found.append((name, sample))
        waiting.clear()
    return found


def _mean(vectors: Sequence[Vector3]) -> Vector3:
    x, y, z = np.mean(vectors, axis=0).tolist()
    return x, y, z


def listen(samples: Samples, monitor: Monitor, spoofer: Spoofer | None = None) -> dict[str, Seen]:
    """Outputs of the detectors for samples, as the spoofer reports them."""
    seen = {name: Seen() for name in DETECTORS}
    for source, some in runs_of(samples):
        given = some if spoofer is None else [spoofer.report(one) for one in some]
        for part, output in monitor.push(source, given):
            if part not in seen:
                continue
            one = seen[part]
            one.verdicts += 1
            if output.state in JUDGED:
                one.judged += 1
                one.margin = max(one.margin, output.margin)
            if output.state is State.ALARM and one.alarm_ns is None:
                one.alarm_ns = output.stamp_ns
    return seen


def drawn(samples: Samples, start_ns: int, name: str) -> list[tuple[int, float]]:
    """Stamp and bearing of the carry-offs, the same at every rate."""
    moving = [
        one.stamp_ns
        for _, one in samples
        if isinstance(one, VelocitySample) and math.hypot(*one.velocity[:2]) > MOVING
    ]
    first = max(moving[0] + 25e9, start_ns + 1e9 * SETTLED_S)
    length = (moving[-1] - 20e9 - first) / ONSETS
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    return [
        (round(first + length * (k + rng.uniform(0.2, 0.8))), float(rng.uniform(0.0, 360.0)))
        for k in range(ONSETS)
    ]


def flown(samples: Samples, start_ns: int, name: str) -> tuple[dict[str, Seen], dict[str, int]]:
    """Outputs on the clean flight, and how many carry-offs each detector alarmed for."""
    monitor = Monitor(MonitorParameters())
    monitor.stages["phase"].component = AnyRate(FlightPhaseParameters())
    clean = {one: Seen() for one in DETECTORS}
    found = dict.fromkeys(DETECTORS, 0)
    at = 0
    for onset_ns, bearing in drawn(samples, start_ns, name):
        until = next(k for k, one in enumerate(samples) if one[1].stamp_ns >= onset_ns)
        _add(clean, listen(samples[at:until], monitor))
        at = until
        onset_s = (onset_ns - start_ns) / 1e9
        spoofer = Spoofer(drift(1.0, 4.0, bearing, onset_s), start_ns)
        for _, sample in samples[max(0, until - 300) : until]:
            spoofer.report(sample)
        watched = [one for one in samples[until:] if one[1].stamp_ns < onset_ns + 1e9 * WATCHED_S]
        for detector, seen in listen(watched, copy.deepcopy(monitor), spoofer).items():
            found[detector] += seen.alarm_ns is not None and seen.alarm_ns >= onset_ns
    _add(clean, listen(samples[at:], monitor))
    return clean, found


def _add(total: dict[str, Seen], more: dict[str, Seen]) -> None:
    for name, one in more.items():
        total[name].margin = max(total[name].margin, one.margin)
        total[name].verdicts += one.verdicts
        total[name].judged += one.judged


@click.command()
@click.argument("flights", nargs=-1, type=click.Path(exists=True, path_type=Path))
def main(flights: Sequence[Path]) -> None:
    """Measure what rates of the IMU do on FLIGHTS."""
    for path in flights:
        start_ns, whole = samples_of(path)
        whole = [one for one in whole if one[1].stamp_ns - start_ns < 1e9 * LONGEST_S]
        stamps = [one.stamp_ns for _, one in whole if isinstance(one, ImuSample)]
        native = 1e9 / float(np.median(np.diff(stamps)))
        click.echo(f"\n{path.name}, {native:.0f} Hz: margin, share judged, found\n")
        rows = []
        for rate in (one for one in RATES if one < 1.1 * native):
            slower = rate < 0.9 * native
            for average in (False, True) if slower else (False,):
                samples = at_rate(whole, rate, average=average) if slower else whole
                clean, found = flown(samples, start_ns, path.name)
                cells = [
                    f"{one.margin:.2f}, {100.0 * one.judged / max(1, one.verdicts):.0f} %, "
                    f"{found[name]}/{ONSETS}"
                    for name, one in clean.items()
                ]
                way = "" if not slower else " averaged" if average else " picked"
                rows.append((f"{rate:g} Hz{way}", *cells))
        click.echo(markdown(TextTable("", ("IMU", *DETECTORS), tuple(rows))))


if __name__ == "__main__":
    main()
