# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What does an attacker gain by jamming the receiver before a carry-off?

    python -m experiments.jamming build/jamming FLIGHT... [--acceleration 1.0] [--most 4]

On each flight (a bag, or a log of any format of `analyze`) carry-offs in a random direction begin
at fixes at which `coast` judges, and the receiver is jammed for 0 to 60 s before. The same
carry-offs follow on every jamming, so that they differ in nothing else:

* `back`: the fix is lost, and comes back where the vehicle is; no carry-off.
* `carried`: the fix is lost, and the carry-off begins with the first one after.
* `displaced`: the same, and the first fix is DISPLACED_M off at once.
* `degraded`: the fix stays, with the noise of a poor receiver, few satellites and a claimed
  accuracy POORER times as large. With the carry-off the noise fades; the claims stay. Only of
  receivers that claim an accuracy.

The whole default monitor runs, on a copy from the begin of each jamming on. Prints for each kind
and length how many runs alert during the jamming (which is no hijack), how many of the others
alert before the separation is REACH_M, after how long and how far off, what the same carry-offs
gain against no jamming, and the states of the detectors. Outcomes are kept in the folder, one
file for each flight and acceleration, and not run again.
"""

from __future__ import annotations

import copy
import json
import statistics
import zlib
from collections import defaultdict, deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import click
import numpy as np

from experiments.carried_off import ORDER, Samples, samples_of
from experiments.jammed_receiver import Carried, CarryOff, Change, Degraded, lost, untouched
from hijack_detect.detectors.fusion import FusionResult
from hijack_detect.detectors.verdict import JUDGED, Verdict
from hijack_detect.evaluation.scores.evaluation_tables import TextTable
from hijack_detect.evaluation.scores.metrics import Proportion
from hijack_detect.monitor.graph import Monitor
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.replay.offline import outputs_of
from hijack_detect.spoofing.spoofer import RECENT
from hijack_detect.streams.samples import (
    NANOSECONDS,
    FixSample,
    GpsSample,
    Sample,
    VelocitySample,
)
from tools.documents import markdown

LENGTHS_S = (0, 5, 15, 30, 60)
"""Lengths of the jamming. Chosen, not swept."""
INPUTS = (*ORDER[:-1], "satellites", "fix")
DISPLACED_M = 10.0
"""A jump within what a receiver may be off that has just found its fix."""
KINDS = ("back", "carried", "displaced", "degraded")
LOST, DEGRADED = "lost", "degraded"
WATCHED = ("coast", "date", "drag", "gnss", "altitude", "fusion")
LONGEST_VERDICT_S = 1.5
"""A verdict holds until the next one, and no longer than this. Chosen, not swept."""
DELIVERED_NS = NANOSECONDS // 2
"""The output for a stamp may come this much later: runs of samples are handed over together."""


@dataclass
class Response:
    """Response of the monitor: seconds in each state by part, the first alert, and `coast`."""

    states: dict[str, dict[str, float]] = field(default_factory=dict)
    alert_ns: int | None = None
    cause: str = ""
    judged_ns: int | None = None
    """When `coast` first judged."""
    visible: float | None = None
    """`smallest_visible` then, m/s²."""
    _last: dict[str, tuple[int, str]] = field(default_factory=dict)

    def take(self, part: str, output: Verdict | FusionResult) -> None:
        """Account an output of a part."""
        stamp_ns, state = output.stamp_ns, output.state.value
        if part in self._last:
            since_ns, before = self._last[part]
            seconds = min((stamp_ns - since_ns) / NANOSECONDS, LONGEST_VERDICT_S)
            of = self.states.setdefault(part, {})
            of[before] = of.get(before, 0.0) + seconds
        self._last[part] = stamp_ns, state
        if part == "coast" and self.judged_ns is None and output.state in JUDGED:
            assert isinstance(output, Verdict)
            self.judged_ns, self.visible = stamp_ns, output.values["smallest_visible"]
        if isinstance(output, FusionResult) and output.alert and self.alert_ns is None:
            self.alert_ns, self.cause = output.alert_since_ns, output.cause


def listen(
    samples: Samples, monitor: Monitor, change: Change, from_ns: int, to_ns: int
) -> Response:
    """Feed changed samples with stamps up to a time; collect the outputs from a time on.

    It ends with an alert.
    """
    response = Response()

    def given() -> Iterator[tuple[str, Sample]]:
        for name, sample in samples:
            if sample.stamp_ns >= to_ns:
                return
            changed = change(sample)
            if changed is not None:
                yield name, changed

    for part, output in outputs_of(given(), monitor):
        if part in WATCHED and output.stamp_ns >= from_ns:
            response.take(part, output)
            if response.alert_ns is not None:
                break
    return response


@dataclass
class Place:
    """Where a carry-off begins, and copies of the monitor before each jamming by its length.

    A copy goes with the index of the first sample that it has not seen, and with the last samples
    of the receiver before.
    """

    stamp_ns: int
    bearing_deg: float
    forks: dict[int, tuple[int, Monitor, list[GpsSample]]] = field(default_factory=dict)


def places(
    samples: Samples, most: int, every_s: float, reach_s: float, name: str
) -> Iterator[Place]:
    """Places on a flight; `coast` judges when the jamming begins and when the carry-off does.

    A flight that is too short for the longest jamming has shorter ones. The name seeds their
    drawing.
    """
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    clean = _Clean()
    fixes = [one.stamp_ns for _, one in samples if isinstance(one, FixSample) and one.has_fix]
    next_ns, found = 0.0, 0
    place: Place | None = None
    lengths: tuple[int, ...] = ()
    for index, (source, sample) in enumerate(samples):
        stamp_ns = sample.stamp_ns
        if clean.alerted:
            return
        if place is None and clean.judging and source == "fix" and stamp_ns >= next_ns:
            left_s = (fixes[-1] - stamp_ns) / NANOSECONDS - reach_s - 2.0
            lengths = tuple(one for one in LENGTHS_S if one <= left_s)
            if not lengths:
                return
            wanted = stamp_ns + (lengths[-1] + 1) * NANOSECONDS
            first = next(one for one in fixes if one >= wanted)
            place = Place(first, float(rng.uniform(0.0, 360.0)))
        if place is not None:
            for length in lengths:
                if length not in place.forks and stamp_ns >= place.stamp_ns - length * NANOSECONDS:
                    place.forks[length] = index, clean.copied(), list(clean.recent)
            if 0 in place.forks:
                next_ns = place.stamp_ns + every_s * NANOSECONDS * float(rng.uniform(0.8, 1.2))
                if clean.judging:
                    yield place
                    found += 1
                    if found == most:
                        return
                place = None
        clean.take(source, sample)


class _Clean:
    """The monitor on the clean flight; runs of samples of one input are pushed together."""

    def __init__(self) -> None:
        self._monitor = Monitor(policy_parameters("default"))
        self._run: tuple[str, list[Sample]] = "", []
        self.judging = self.alerted = False
        self.recent: deque[GpsSample] = deque(maxlen=RECENT)

    def take(self, source: str, sample: Sample) -> None:
        """Take the next sample."""
        if source != self._run[0]:
            self._push()
            self._run = source, []
        self._run[1].append(sample)
        if isinstance(sample, FixSample | VelocitySample):
            self.recent.append(sample)

    def copied(self) -> Monitor:
        """A copy of the monitor that has seen all samples."""
        self._push()
        return copy.deepcopy(self._monitor)

    def _push(self) -> None:
        source, run = self._run
        if not run:
            return
        for part, output in self._monitor.push(source, run):
            if part == "coast":
                self.judging = output.state in JUDGED
            elif part == "fusion" and output.alert:
                self.alerted = True
        self._run = source, []


@dataclass(frozen=True)
class Outcome:
    """One run: times in seconds, from the begin of the jamming and of the carry-off."""

    flight: str
    kind: str
    length_s: int
    onset_s: float
    jam_alert_s: float | None = None
    alert_s: float | None = None
    separation_m: float | None = None
    cause: str = ""
    judged_s: float | None = None
    visible: float | None = None
    jam_states: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    states: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    @property
    def place(self) -> tuple[str, float]:
        """What the same carry-offs have in common."""
        return self.flight, self.onset_s


def trials(
    samples: Samples, start_ns: int, place: Place, acceleration: float, flight: str
) -> Iterator[Outcome]:
    """Run every jamming and what follows on it."""
    onset_s = (place.stamp_ns - start_ns) / NANOSECONDS
    for length, (index, before, recent) in place.forks.items():
        claims = any(one.accuracy_m is not None for one in recent if isinstance(one, FixSample))
        for jamming in (LOST, DEGRADED) if length and claims else (LOST,):
            monitor = copy.deepcopy(before)
            seed = zlib.crc32(f"{flight} {onset_s}".encode())
            change: Change = lost if jamming == LOST else Degraded(seed, place.stamp_ns)
            jammed_ns = place.stamp_ns - length * NANOSECONDS
            response = listen(samples[index:], monitor, change, jammed_ns, place.stamp_ns)
            at = next(
                k for k in range(index, len(samples)) if samples[k][1].stamp_ns >= place.stamp_ns
            )
            truth = recent + [
                one for _, one in samples[index:at] if isinstance(one, FixSample | VelocitySample)
            ]
            for kind in KINDS[:-1] if jamming == LOST else KINDS[-1:]:
                if kind == "back" and not length:
                    continue
                outcome = Outcome(flight, kind, length, onset_s, jam_states=response.states)
                if response.alert_ns is not None:
                    seconds = (response.alert_ns - jammed_ns) / NANOSECONDS
                    yield replace(outcome, jam_alert_s=seconds, cause=response.cause)
                    continue
                one = CarryOff(
                    place.stamp_ns,
                    0.0 if kind == "back" else acceleration,
                    place.bearing_deg,
                    DISPLACED_M if kind == "displaced" else 0.0,
                )
                claims = untouched if jamming == LOST else change  # its errors fade
                carried = Carried(one, start_ns, truth[-RECENT:], claims)
                yield _followed(outcome, samples[at:], copy.deepcopy(monitor), carried, one)


def _followed(
    outcome: Outcome, samples: Samples, monitor: Monitor, carried: Carried, one: CarryOff
) -> Outcome:
    """Follow a carry-off until it alerts or is REACH_M off."""
    end_ns = one.stamp_ns + round(one.reach_s * NANOSECONDS)
    separations: list[tuple[int, float]] = []

    def change(sample: Sample) -> Sample | None:
        changed = carried(sample)
        if isinstance(sample, FixSample):
            separations.append((sample.stamp_ns, carried.separation_m))
        return changed

    response = listen(samples, monitor, change, 0, end_ns + DELIVERED_NS)
    found = replace(outcome, states=response.states, cause=response.cause)
    if response.judged_ns is not None:
        seconds = max(0.0, (response.judged_ns - one.stamp_ns) / NANOSECONDS)
        found = replace(found, judged_s=seconds, visible=response.visible)
    if response.alert_ns is None or response.alert_ns > end_ns:
        return replace(found, cause="")
    seconds = (response.alert_ns - one.stamp_ns) / NANOSECONDS
    if seconds < 0.0:  # caused by the jamming, and delivered after it
        return replace(found, jam_alert_s=outcome.length_s + seconds)
    off = max((m for ns, m in separations if ns <= response.alert_ns), default=0.0)
    return replace(found, alert_s=seconds, separation_m=off)


def flown(path: Path, acceleration: float, most: int, every_s: float) -> Iterator[Outcome]:
    """All outcomes of a flight."""
    start_ns, samples = samples_of(path, INPUTS)
    reach_s = CarryOff(0, acceleration, 0.0).reach_s
    for place in places(samples, most, every_s, reach_s, path.name):
        yield from trials(samples, start_ns, place, acceleration, path.name)


def table(outcomes: Sequence[Outcome]) -> TextTable:
    """The table of all kinds and lengths."""
    columns = (
        "kind",
        "jammed",
        "alert while jammed",
        "alert before 60 m",
        "median s",
        "median m",
        "found without jamming only",
        "with only",
        "later by s",
        "further by m",
        "`coast` judges after s",
    )
    without = {one.place: one for one in outcomes if (one.kind, one.length_s) == ("carried", 0)}
    rows = []
    for kind in KINDS:
        for length in LENGTHS_S:
            own = [one for one in outcomes if (one.kind, one.length_s) == (kind, length)]
            if own:
                rows.append(_row(kind, length, own, without))
    return TextTable("", columns, tuple(rows))


def _row(
    kind: str, length: int, rows: Sequence[Outcome], without: Mapping[tuple[str, float], Outcome]
) -> tuple[str, ...]:
    quiet = [one for one in rows if one.jam_alert_s is None]
    found = [one for one in quiet if one.alert_s is not None]
    pairs = [(one, without[one.place]) for one in quiet if one.place in without]
    only_without = sum(a.alert_s is None and b.alert_s is not None for a, b in pairs)
    only_with = sum(a.alert_s is not None and b.alert_s is None for a, b in pairs)
    later = [_less(a.alert_s, b.alert_s) for a, b in pairs]
    further = [_less(a.separation_m, b.separation_m) for a, b in pairs]
    return (
        kind,
        f"{length} s",
        share(len(rows) - len(quiet), len(rows)) if length else "",
        share(len(found), len(quiet)),
        middle(one.alert_s for one in found),
        middle(one.separation_m for one in found),
        "" if kind == "back" else str(only_without),
        "" if kind == "back" else str(only_with),
        "" if kind == "back" else middle(later, sign="+"),
        "" if kind == "back" else middle(further, sign="+"),
        middle(one.judged_s for one in quiet),
    )


def _less(one: float | None, other: float | None) -> float | None:
    return None if one is None or other is None else one - other


def share(count: int, total: int) -> str:
    """A count with its exact 95 % interval."""
    one = Proportion.of(count, total)
    if one.low is None or one.high is None:
        return "0/0"
    return f"{count}/{total} [{100.0 * one.low:.0f}, {100.0 * one.high:.0f}] %"


def middle(values: Iterable[float | None], sign: str = "") -> str:
    """Median and quartiles of what is there."""
    known = sorted(one for one in values if one is not None)
    if not known:
        return "–"
    low, high = np.quantile(known, [0.25, 0.75]).tolist()
    return f"{statistics.median(known):{sign}.1f} ({low:{sign}.1f} to {high:{sign}.1f})"


def states(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """Per cent of the time in each state, of each part, while jammed and afterwards."""
    for when in ("jammed", "afterwards"):
        for kind in KINDS:
            rows = [one for one in outcomes if one.kind == kind and one.length_s]
            for part in WATCHED:
                total: dict[str, float] = defaultdict(float)
                for one in rows:
                    seconds_in = one.jam_states if when == "jammed" else one.states
                    for state, seconds in seconds_in.get(part, {}).items():
                        total[state] += seconds
                whole = sum(total.values())
                listed = ", ".join(
                    f"{state} {100.0 * total[state] / whole:.0f} %"
                    for state in sorted(total, key=lambda one: -total[one])
                )
                yield f"{when}, {kind}, {part}: {listed}"


@click.command()
@click.argument("results", type=click.Path(path_type=Path))
@click.argument("flights", nargs=-1, type=click.Path(exists=True, path_type=Path))
@click.option("--acceleration", default=1.0, help="Of the carry-off, m/s².")
@click.option("--most", default=4, help="Carry-offs on one flight.")
@click.option("--every", default=20.0, help="Time from one carry-off to the next jamming, s.")
def main(
    results: Path, flights: Sequence[Path], acceleration: float, most: int, every: float
) -> None:
    """Measure on FLIGHTS; keep outcomes in RESULTS."""
    results.mkdir(parents=True, exist_ok=True)
    found: list[Outcome] = []
    with click.progressbar(flights, label="flights", item_show_func=_name) as bar:
        for path in bar:
            kept = results / f"{path.name}_{acceleration:g}.json"
            if not kept.exists():
                done = [asdict(one) for one in flown(path, acceleration, most, every)]
                kept.write_text(json.dumps(done))
            found += [Outcome(**one) for one in json.loads(kept.read_text())]
    click.echo(markdown(table(found)))
    for line in states(found):
        click.echo(line)


def _name(path: Path | None) -> str:
    return "" if path is None else path.name


if __name__ == "__main__":
    main()
