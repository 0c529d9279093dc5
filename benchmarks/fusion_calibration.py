# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Likelihood ratios of the fusion: fitted on half of the flights, shown on the other half.

    python benchmarks/fusion_calibration.py build/limits docs/figures/calibration.png

Takes the records of benchmarks/detection_limits.py (recorded and sitl flights). A margin counts as
the largest of 10 s: of each 10 s of clean time, and of the 10 s after each onset. For each detector
ln LR is a straight line in the logarithm of the margin, from 0 at the margin that one clean block
in two hundred exceeds, to the ratio of the exceedances of margin 1. Where no clean block exceeds
it, half a block counts: a rarer alarm cannot be claimed from so many flights. Families count
equally.

Prints what the table `detectors.likelihood.RATIOS` would be, then the Brier score and the
reliability at even prior odds of the table as it is, and draws the diagram.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path

import click
import matplotlib.pyplot as plt
import numpy as np
from limits_runs import by_half, load

from hijack_detect.detectors.likelihood import RATIOS, LikelihoodRatio, probability, together
from hijack_detect.evaluation.scores.limit_records import BLOCK_S, WINDOWS_S, FlightRecord
from hijack_detect.evaluation.trials.families import CLEAN

WINDOW = WINDOWS_S.index(10.0)
RARE = 99.5
"""Percentile of the clean margins that says nothing."""
LARGEST_NEUTRAL = 0.9
LEAST = -0.1
"""A quiet detector never says more for the GPS than this: most are blind to most attacks."""
FAULT_S = {"inertialnav__f450_glitch": 110.0}
"""Recorded flights with a fault of the receiver, and when it begins: not clean from there on."""
MOST = {"drag": 2.7}
"""The most that a detector may say whose alarm is soft and not rare: a gust front."""
BINS = (0.0, 0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.98, 1.0)

Margins = Mapping[str, float]
Weighted = list[tuple[Margins, float]]


def clean_margins(records: Sequence[FlightRecord], names: Sequence[str]) -> list[Margins]:
    """Largest margins of each clean block."""
    found = []
    for record in records:
        count = min((len(record.blocks[name]) for name in names), default=0)
        if record.name in FAULT_S:
            count = min(count, int(FAULT_S[record.name] // BLOCK_S))
        found += [{name: record.blocks[name][k] for name in names} for k in range(count)]
    return found


def attacked_margins(records: Sequence[FlightRecord], names: Sequence[str]) -> Weighted:
    """Largest margins after each onset with a weight; the weights of a family sum to 1."""
    families: dict[str, list[Margins]] = defaultdict(list)
    for record in records:
        for attack in record.attacks:
            if attack.family != CLEAN:
                families[attack.family].append(
                    {name: attack.methods[name].margins[WINDOW] for name in names}
                )
    return [(one, 1.0 / len(all_of)) for all_of in families.values() for one in all_of]


def ratio(
    clean: Sequence[float], attacked: Sequence[tuple[float, float]], most: float
) -> LikelihoodRatio:
    """Fit one detector; attacked margins come with their weights."""
    total = sum(weight for _, weight in attacked)
    neutral = min(max(float(np.percentile(clean, RARE)), 0.05), LARGEST_NEUTRAL)
    wrong = max(sum(margin >= 1.0 for margin in clean), 0.5) / len(clean)
    right = max(sum(weight for margin, weight in attacked if margin >= 1.0) / total, 1e-3)
    high = min(max(math.log(right / wrong), 0.0), most)
    quiet = sum(weight for margin, weight in attacked if margin < neutral) / total
    low = min(max(math.log(max(quiet, 1e-3) / (RARE / 100.0)), LEAST), 0.0)
    return LikelihoodRatio(
        round(high / -math.log(neutral), 2), round(neutral, 2), round(low, 2), round(high, 2)
    )


def reliability(
    ratios: Mapping[str, LikelihoodRatio], clean: Sequence[Margins], attacked: Weighted
) -> tuple[float, list[tuple[float, float, float]]]:
    """Brier score, and mean probability, share of attacks and weight of each bin; even odds."""

    def claimed(margins: Margins) -> float:
        return probability(together({name: one(margins[name]) for name, one in ratios.items()}))

    total = sum(weight for _, weight in attacked)
    rows = [(claimed(one), 0.0, 0.5 / len(clean)) for one in clean]
    rows += [(claimed(one), 1.0, 0.5 * weight / total) for one, weight in attacked]
    table = np.array(rows)
    brier = float(np.sum(table[:, 2] * (table[:, 0] - table[:, 1]) ** 2))
    place = np.clip(np.searchsorted(BINS, table[:, 0], side="right") - 1, 0, len(BINS) - 2)
    bins = []
    for index in range(len(BINS) - 1):
        own = table[place == index]
        weight = float(np.sum(own[:, 2]))
        if weight:
            mean, share = np.average(own[:, :2], axis=0, weights=own[:, 2]).tolist()
            bins.append((mean, share, weight))
    return brier, bins


@click.command()
@click.argument("results", type=click.Path(exists=True, path_type=Path))
@click.argument("figure", type=click.Path(path_type=Path))
def main(results: Path, figure: Path) -> None:
    """Fit on half A of the records in RESULTS, show on half B, draw FIGURE."""
    parts = [by_half(load(results, part)) for part in "ab"]
    halves = {half: [one for part in parts for one in part[half]] for half in "AB"}
    names = [name for name in halves["A"][0].blocks if name != "fusion"]
    clean = {half: clean_margins(records, names) for half, records in halves.items()}
    attacked = {half: attacked_margins(records, names) for half, records in halves.items()}
    ratios = {
        name: ratio(
            [one[name] for one in clean["A"]],
            [(one[name], w) for one, w in attacked["A"]],
            MOST.get(name, math.inf),
        )
        for name in names
    }
    for name, one in ratios.items():
        figures = f"{one.slope}, {one.neutral}, {one.low}, {one.high}"
        click.echo(f'    "{name}": LikelihoodRatio({figures}),')
    axes = plt.figure(figsize=(5, 5), layout="constrained").add_subplot()
    axes.plot([0, 1], [0, 1], color="0.7")
    for half in "AB":
        brier, bins = reliability(RATIOS, clean[half], attacked[half])
        counts = f"{len(clean[half])} clean blocks, {len(attacked[half])} attacks"
        click.echo(f"half {half}: {counts}, Brier score {brier:.3f} (0.25: no idea)")
        for mean, share, weight in bins:
            click.echo(f"  claimed {mean:.3f}, attacked {share:.3f} (weight {weight:.3f})")
        points = [(mean, share) for mean, share, _ in bins]
        label = f"half {half}"
        axes.plot(*zip(*points, strict=True), "o-", label=label)
    axes.set(xlabel="claimed probability, even prior odds", ylabel="share of attacks")
    axes.legend()
    figure.parent.mkdir(parents=True, exist_ok=True)
    axes.figure.savefig(figure, dpi=110)


if __name__ == "__main__":
    main()
