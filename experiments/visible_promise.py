# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Does `coast` see what it claims to see? Injected drifts around `smallest_visible`.

    python -m experiments.visible_promise docs/figures/visible_promise.png FLIGHT... [--every 10]

On each flight (a bag, or a log of any format of `analyze`) a drift begins about every ten seconds
in which `coast` judges and is not in alarm. It has a constant acceleration in a fixed random
direction: a multiple of `smallest_visible` of the verdict before it. It is found if `coast` alarms
before the drift is REACH_M long; a drift that the flight's end cuts off before does not count, and
one during which `coast` stops judging is missed. Only the phase of flight and `coast` run, on a
copy from the onset on.

Prints for each vehicle the share found of each multiple, and the gain (`coast.VISIBLE_GAIN`) that
the other vehicles would choose, vehicles weighing the same, with what it promises on the vehicle
left out; draws the curves.
"""

from __future__ import annotations

import copy
import math
import zlib
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import click
import matplotlib.pyplot as plt
import numpy as np

from experiments.carried_off import Samples, drift, samples_of
from experiments.vehicles import vehicle_of
from hijack_detect.detectors.coast import VISIBLE_GAIN, CoastDetector
from hijack_detect.detectors.coast_parameters import CoastParameters
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.estimation.flight_phase import FlightPhaseEstimator, FlightPhaseParameters
from hijack_detect.evaluation.scores.evaluation_tables import TextTable
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.samples import Sample
from tools.documents import markdown

REACH_M = 60.0
"""Length of a drift before which it has to be found. Chosen, not swept."""
MULTIPLES = (0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.35, 1.5, 1.75, 2.0)
SEEN, UNSEEN = 1.2, 0.8
"""Of drifts of this multiple nine tenths are to be found, and at most half: the promise of
`smallest_visible`."""
FEWEST = 5
"""A vehicle with fewer onsets has no own curve. Chosen, not swept."""
SIMULATED = ("simulator", "sitl_copter")


class Chain:
    """Phase of flight and `coast`, fed in order of stamp."""

    def __init__(self) -> None:
        """Start without samples."""
        self._phase = FlightPhaseEstimator(FlightPhaseParameters())
        self._coast = CoastDetector(CoastParameters())

    def push(self, name: str, sample: Sample) -> Verdict | None:
        """Take the next sample; return the verdict of `coast`."""
        phase = self._phase.update(name, sample) if name in self._phase.inputs else None
        verdict = self._coast.update(name, sample) if name in self._coast.inputs else None  # type: ignore[arg-type]
        if phase is not None:
            self._coast.update("phase", phase)
        return verdict


@dataclass
class Onset:
    """Where a drift may begin: the chain before the fix at `index`, and what was claimed there."""

    index: int
    stamp_ns: int
    visible: float
    bearing_deg: float
    chain: Chain
    before: dict[str, Sample]


def onsets(samples: Samples, every_s: float, name: str) -> list[Onset]:
    """Onsets about every `every_s` while `coast` judges; the name seeds their drawing."""
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    chain, found, next_ns = Chain(), list[Onset](), 0.0
    verdict: Verdict | None = None
    before: dict[str, Sample] = {}
    for index, (source, sample) in enumerate(samples):
        judging = verdict is not None and verdict.state in (State.NORMAL, State.SUSPICIOUS)
        if source == "fix" and judging and sample.stamp_ns >= next_ns:
            assert verdict is not None
            visible, bearing = verdict.values["smallest_visible"], float(rng.uniform(0.0, 360.0))
            found.append(
                Onset(index, sample.stamp_ns, visible, bearing, copy.deepcopy(chain), dict(before))
            )
            next_ns = sample.stamp_ns + 1e9 * every_s * float(rng.uniform(0.8, 1.2))
        verdict = chain.push(source, sample) or verdict
        before[source] = sample
    return found


def seen(samples: Samples, start_ns: int, onset: Onset, acceleration: float) -> bool | None:
    """Whether a drift is found before REACH_M; None if the flight ends before."""
    reach_s = math.sqrt(2.0 * REACH_M / acceleration)
    onset_s = (onset.stamp_ns - start_ns) / 1e9
    scenario = drift(acceleration, 1.1 * acceleration * reach_s, onset.bearing_deg, onset_s)
    spoofer = Spoofer(scenario, start_ns)
    chain = copy.deepcopy(onset.chain)

    for sample in sorted(onset.before.values(), key=lambda one: one.stamp_ns):
        spoofer.report(sample)
    for name, sample in samples[onset.index :]:
        if sample.stamp_ns - onset.stamp_ns > 1e9 * reach_s:
            return False
        verdict = chain.push(name, spoofer.report(sample))
        if verdict is not None and verdict.state is State.ALARM:
            return True
    return None


def curve(samples: Samples, start_ns: int, places: Sequence[Onset]) -> list[list[bool]]:
    """For each onset whether each of MULTIPLES was found, without those that were cut off."""
    rows = [[seen(samples, start_ns, one, k * one.visible) for k in MULTIPLES] for one in places]
    return [[bool(found) for found in row] for row in rows if None not in row]


def share(curves: Sequence[Sequence[float]], multiple: float) -> float:
    """Share found at a multiple between those measured; vehicles weigh the same."""
    mean = np.mean(np.array(curves), axis=0)
    return float(np.interp(math.log(multiple), np.log(MULTIPLES), mean))


def chosen(curves: Sequence[Sequence[float]]) -> float:
    """The gain in the middle of those that keep the promise: the promise has two sides."""
    grid = np.exp(np.linspace(math.log(MULTIPLES[0]), math.log(MULTIPLES[-1]), 400)).tolist()
    nine = min((k for k in grid if share(curves, k) >= 0.9), default=grid[-1])
    half = max((k for k in grid if share(curves, k) <= 0.5), default=grid[0])
    return VISIBLE_GAIN * math.sqrt(nine / SEEN * half / UNSEEN)


def report(found: Mapping[str, Sequence[Sequence[bool]]]) -> dict[str, list[float]]:
    """Print the tables; return the curves."""
    curves = {name: np.mean(found[name], axis=0).tolist() for name in sorted(found)}
    real = [row for name in found if name not in SIMULATED for row in found[name]]
    rows = {name: (len(found[name]), curves[name]) for name in curves}
    rows["real flights"] = (len(real), np.mean(real, axis=0).tolist())
    rows["vehicles alike"] = (len(curves), np.mean(list(curves.values()), axis=0).tolist())
    drifts = [
        (name, str(count), *(f"{100.0 * one:.0f}" for one in shares))
        for name, (count, shares) in rows.items()
    ]
    columns = ("vehicle", "drifts", *(f"{k:g}" for k in MULTIPLES))
    click.echo(markdown(TextTable("", columns, tuple(drifts))))
    kept = []
    for name, own in curves.items():
        gain = chosen([one for other, one in curves.items() if other != name])
        low, high = (share([own], k * gain / VISIBLE_GAIN) for k in (UNSEEN, SEEN))
        kept.append((name, f"{gain:.2f}", f"{100.0 * low:.0f} %", f"{100.0 * high:.0f} %"))
    kept.append(("none", f"{chosen(list(curves.values())):.2f}", "", ""))
    columns = ("vehicle left out", "gain", f"found of {UNSEEN:g}", f"found of {SEEN:g}")
    click.echo(markdown(TextTable("", columns, tuple(kept))))
    return curves


@click.command()
@click.argument("figure", type=click.Path(path_type=Path))
@click.argument("flights", nargs=-1, type=click.Path(exists=True, path_type=Path))
@click.option("--every", default=10.0, help="Time between two onsets, s.")
def main(figure: Path, flights: Sequence[Path], every: float) -> None:
    """Measure the promise on FLIGHTS and draw FIGURE."""
    found: dict[str, list[list[bool]]] = defaultdict(list)
    for path in flights:
        start_ns, samples = samples_of(path)
        rows = curve(samples, start_ns, onsets(samples, every, path.name))
        found[vehicle_of(path)] += rows
    found = {name: rows for name, rows in found.items() if len(rows) >= FEWEST}
    curves = report(found)
    axes = plt.figure(figsize=(6, 4), layout="constrained").add_subplot()
    for name, shares in curves.items():
        axes.plot(MULTIPLES, shares, ".-", linewidth=1, label=f"{name} ({len(found[name])})")
    axes.plot([SEEN, UNSEEN], [0.9, 0.5], "kx", markersize=10, label="promised: above, below")
    axes.set(xlabel="acceleration / smallest_visible", ylabel="found before 60 m")
    axes.legend(fontsize=8)
    figure.parent.mkdir(parents=True, exist_ok=True)
    axes.figure.savefig(figure, dpi=110)


if __name__ == "__main__":
    main()
