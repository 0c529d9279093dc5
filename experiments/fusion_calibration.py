# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Likelihood ratios of the fusion, fitted with one vehicle left out and shown on that vehicle.

    python -m experiments.fusion_calibration docs/detection-limits.md docs/figures/calibration.png \
        --records build/ratios

The recorded flights, as native logs with barometer and compass where there are such, are attacked
at seeded onsets (ATTACKS); on labelled flights the attack that is there counts. Each flight's
record is a file, and a flight whose file is there is not run again: begin with an empty folder
after a change of any detector.

A margin counts as the largest of 10 s in which the detector could tell: of each 10 s of clean time,
and of the 10 s after each onset. For each detector ln LR is a straight line in the logarithm of the
margin, from 0 at the margin that one clean block in two hundred exceeds, to the ratio of the
exceedances of margin 1. Where no clean block exceeds it, half a block counts: a rarer alarm cannot
be claimed from this number of flights. Families count equally.

Prints what the ratios of `monitor.parts` would be, fills in the tables `ratios fitted`
and `ratios shown` of the document, and draws the reliability at even prior odds.
"""

from __future__ import annotations

import json
import math
import sys
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import click
import matplotlib.pyplot as plt
import numpy as np

from experiments.limits_records import (
    BLOCK_S,
    WINDOWS_S,
    FlightRecord,
    MethodRecord,
    record_forked,
)
from experiments.limits_runs import Work, credited, record_of
from experiments.vehicles import Flight, corpus
from hijack_detect.bags.errors import BagError
from hijack_detect.detectors.likelihood import (
    FusionParameters,
    LikelihoodRatio,
    odds,
    probability,
    together,
)
from hijack_detect.evaluation.scores.evaluation_tables import NONE, TextTable
from hijack_detect.evaluation.trials.cases import HIJACKED
from hijack_detect.evaluation.trials.families import CLEAN, Placed
from hijack_detect.monitor.parts import WEIGHTS
from hijack_detect.monitor.policies import MonitorParameters, policy_parameters
from tools.documents import fill, write

RATIOS: Ratios = {name: one.ratio for name, one in WEIGHTS.items() if one.ratio is not None}
ALERTING = {name for name, one in WEIGHTS.items() if one.may_alert}
WINDOW = WINDOWS_S.index(BLOCK_S)
HORIZON_S = 12.0
"""Time after an onset that counts: the window, and what comes late in it. Chosen, not swept."""
ATTACKS: Mapping[str, frozenset[str]] = {
    CLEAN: frozenset({"in motion", "any phase"}),
    "jump": frozenset({"10 m", "20 m"}),
    "drift": frozenset({"0.5 m/s² to 4 m/s", "1 m/s² to 4 m/s", "2 m/s² to 4 m/s"}),
    "drift_position_only": frozenset({"0.4 m/s² to 2 m/s"}),
    "turn_away": frozenset({"60° at 15°/s"}),
    "fake_track": frozenset({"turn"}),
    "freeze": frozenset({"velocity frozen", "velocity true"}),
    "altitude_ramp": frozenset({"1 m/s", "2 m/s"}),
    "altitude_step": frozenset({"10 m"}),
    "replay": frozenset({"30 s before"}),
    "jump_any_phase": frozenset({"20 m"}),
    "drift_any_phase": frozenset({"1 m/s² to 4 m/s"}),
}
"""Families and sizes that are injected, see `families.attacks_on`."""
MOVING, ANY_PHASE = 4, 2
"""Onsets on each flight."""
ATTACKED = frozenset({"flight", "unlabelled"})
"""Classes of clean flights that are attacked."""
UNUSED = frozenset({"ground", "low_imu_rate", "sitl", "import"})
"""Classes in which no detector could see a carry-off: their clean time proves nothing."""
NATIVE = frozenset(
    {
        "dronekit_la__log171",
        "erlerobot__10-11-2014_103",
        "erlerobot__5-12-2014_218",
        "joeydouglas__2014-10-18_20-04-24",
    }
)
"""Bags of flights of which there is the native log: only that counts."""

RARE = 99.5
"""Percentile of the clean margins that has weight 0. Chosen, not swept."""
LARGEST_NEUTRAL = 0.9
LEAST = -0.1
"""Least weight, of a quiet detector: most are blind to most attacks. Chosen, not swept."""
MOST = {"drag": 2.7}
"""Largest weight of a detector whose alarm is soft and not rare: a gust front. Chosen, not
swept."""
BINS = (0.0, 0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.98, 1.0)
FUSION = FusionParameters()

Margins = Mapping[str, float]
Ratios = Mapping[str, LikelihoodRatio]


@dataclass(frozen=True)
class Piece:
    """A block of clean time, or the time after an onset.

    Attributes:
        family: Family of the attack; CLEAN for none.
        margins: Largest margin of each detector that could tell.
        alarmed: Whether one alarmed whose alarm makes an alert.
    """

    family: str
    margins: Margins
    alarmed: bool

    def log_odds(self, ratios: Ratios, prior: float) -> float:
        """Logarithm of the odds of an attack, nats."""
        values = {name: ratios[name](margin) for name, margin in self.margins.items()}
        return odds(prior) + together(values, WEIGHTS)

    def alerts(self, ratios: Ratios) -> bool:
        """Whether the fusion alerts."""
        return self.alarmed and self.claim(ratios) >= FUSION.alarm_probability

    def warns(self, ratios: Ratios) -> bool:
        """Whether the probability alone makes the monitor SUSPICIOUS."""
        return not self.alerts(ratios) and self.claim(ratios) >= FUSION.warn_probability

    def claim(self, ratios: Ratios) -> float:
        """The value of `hijack_confidence`."""
        return probability(self.log_odds(ratios, FUSION.prior))


def pieces(one: FlightRecord, fails_s: float | None) -> Iterator[Piece]:
    """Evidence of a flight, until its receiver really failed."""
    blocks = {name: one.blocks[name] for name in RATIOS if name in one.blocks}
    count = max(map(len, blocks.values()), default=0)
    if fails_s is not None:
        count = min(count, int(fails_s // BLOCK_S))
    spans = [span for name in ALERTING for span in one.alarms.get(name, ())]
    for k in range(count):
        begin, end = k * BLOCK_S, (k + 1) * BLOCK_S
        values = {name: own[k] for name, own in blocks.items() if k < len(own)}
        yield Piece(CLEAN, _judging(values), any(a < end and b >= begin for a, b in spans))
    for attack in one.attacks:
        if attack.family != CLEAN:
            methods = {name: attack.methods[name] for name in RATIOS if name in attack.methods}
            yield Piece(
                attack.family,
                _judging({name: one.margins[WINDOW] for name, one in methods.items()}),
                any(_alarmed(one) for name, one in methods.items() if name in ALERTING),
            )


def _judging(margins: Margins) -> Margins:
    """Without the detectors that could not tell."""
    return {name: margin for name, margin in margins.items() if margin > 0.0}


def _alarmed(method: MethodRecord) -> bool:
    return method.alarm_s is not None and method.alarm_s <= BLOCK_S


def weighted(found: Sequence[Piece]) -> list[tuple[Piece, float]]:
    """The attacks, each with a weight; the weights of a family sum to 1."""
    families: dict[str, list[Piece]] = defaultdict(list)
    for one in found:
        if one.family != CLEAN:
            families[one.family].append(one)
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


def fitted(found: Sequence[Piece]) -> Ratios:
    """Fit all detectors."""
    attacked = weighted(found)
    return {
        name: ratio(
            [one.margins[name] for one in found if one.family == CLEAN and name in one.margins],
            [(one.margins[name], weight) for one, weight in attacked if name in one.margins],
            MOST.get(name, math.inf),
        )
        for name in RATIOS
    }


def reliability(
    found: Sequence[tuple[Piece, Ratios]],
) -> tuple[float, list[tuple[float, float, float]]]:
    """Brier score, and mean claim, share of attacks and weight of each bin, at even prior odds.

    Args:
        found: Pieces with the ratios by which each is judged. Clean and attacked ones weigh a half.
    """
    counts = Counter(one.family for one, _ in found)
    attacked = len(counts.keys() - {CLEAN})
    table = np.array(
        [
            (
                probability(one.log_odds(ratios, 0.5)),
                one.family != CLEAN,
                0.5 / counts[one.family] / (1 if one.family == CLEAN else attacked),
            )
            for one, ratios in found
        ]
    )
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


def fitted_table(found: Mapping[str, Sequence[Piece]], without: Mapping[str, Ratios]) -> TextTable:
    """Neutral margin and largest word of each ratio: in force, fitted on all, without each."""
    everything = [one for own in found.values() for one in own]
    rows = {"none: in force": RATIOS, "none: fitted": fitted(everything), **without}
    cells = [
        (vehicle, *(f"{one.neutral:.2f}, {one.high:.1f}" for one in ratios.values()))
        for vehicle, ratios in rows.items()
    ]
    return TextTable("Ratios", ("vehicle left out", *RATIOS), tuple(cells))


def shown_table(found: Mapping[str, Sequence[Piece]], without: Mapping[str, Ratios]) -> TextTable:
    """What the fusion makes of each vehicle: with the ratios in force, and with those without."""
    rows = []
    for vehicle, own in found.items():
        clean = [one for one in own if one.family == CLEAN]
        attacked = [one for one in own if one.family != CLEAN]
        shown = [_shown(clean, attacked, ratios) for ratios in (RATIOS, without[vehicle])]
        both = [", ".join(pair) for pair in zip(*shown, strict=True)]
        rows.append((vehicle, str(len(clean)), *both[:3], str(len(attacked)), *both[3:]))
    return TextTable(
        "Fusion",
        (
            "vehicle",
            "clean blocks",
            "alerts",
            "only suspicious",
            "largest probability without an alarm",
            "attacks",
            "found",
            "only suspicious",
            "Brier score",
        ),
        tuple(rows),
    )


def _shown(clean: Sequence[Piece], attacked: Sequence[Piece], ratios: Ratios) -> tuple[str, ...]:
    """Alerts, warnings and largest probability of clean blocks; alerts, warnings, Brier score."""
    quiet = [one.claim(ratios) for one in clean if not one.alarmed]
    score = NONE
    if clean and attacked:
        score = f"{reliability([(one, ratios) for one in (*clean, *attacked)])[0]:.3f}"
    return (
        str(sum(one.alerts(ratios) for one in clean)),
        str(sum(one.warns(ratios) for one in clean)),
        f"{max(quiet, default=0.0):.2f}",
        str(sum(one.alerts(ratios) for one in attacked)),
        str(sum(one.warns(ratios) for one in attacked)),
        score,
    )


def least_high(ratios: Ratios) -> float:
    """Weight that a detector needs at its limit for an alert beside quiet others, nats."""
    quiet = sum(-one.low for one in ratios.values())
    return odds(FUSION.alarm_probability) - odds(FUSION.prior) + quiet


def fly(parameters: MonitorParameters, flight: Flight) -> FlightRecord:
    """Run a flight, clean and attacked.

    Raises:
        BagError: It cannot be read.
    """
    case = flight.case
    if case.kind == HIJACKED:
        return record_of(Work(case.name, "b", (case,)), case, parameters, 0, 0)
    attacked = case.kind in ATTACKED and flight.fails_s is None

    def wanted(one: Placed) -> bool:
        return one.size in ATTACKS.get(one.family, ())

    return record_forked(
        parameters,
        case,
        moving=MOVING if attacked else 0,
        any_phase=ANY_PHASE if attacked else 0,
        chosen=wanted,
        horizon_s=HORIZON_S,
    )


def flown(flights: Path, records: Path) -> dict[str, list[Piece]]:
    """Evidence of each vehicle; runs flights without a record."""
    parameters, found = policy_parameters("default"), defaultdict[str, list[Piece]](list)
    for flight in corpus(flights):
        if flight.case.kind in UNUSED or flight.case.name in NATIVE:
            continue
        path = records / f"{flight.case.name}.json"
        if not path.is_file():
            try:
                made = fly(parameters, flight)
            except BagError as error:
                print(f"{flight.case.name}: left out: {error}", file=sys.stderr)
                continue
            write(path, made.model_dump_json() + "\n")
            print(f"{flight.case.name}: {len(made.attacks)} attacks", file=sys.stderr)
        kept = credited(FlightRecord.model_validate(json.loads(path.read_text("utf-8"))))
        found[flight.vehicle] += pieces(kept, flight.fails_s)
    return dict(sorted(found.items()))


@click.command()
@click.argument("document", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.argument("figure", type=click.Path(path_type=Path))
@click.option("--records", type=click.Path(path_type=Path), required=True, help="Folder of them.")
@click.option(
    "--flights",
    type=click.Path(path_type=Path),
    default=Path("../shared/flights"),
    show_default=True,
)
def main(document: Path, figure: Path, records: Path, flights: Path) -> None:
    """Fit with each vehicle left out, fill in the tables of DOCUMENT and draw FIGURE."""
    found = flown(flights, records)
    everything = [one for own in found.values() for one in own]
    without = {
        vehicle: fitted([one for other, own in found.items() if other != vehicle for one in own])
        for vehicle in found
    }
    for name, one in fitted(everything).items():
        figures = f"{one.slope}, {one.neutral}, {one.low}, {one.high}"
        click.echo(f'    "{name}": LikelihoodRatio({figures}),')
    click.echo(f"an alarm alone alerts from {least_high(RATIOS):.2f} nats on")

    tables: Mapping[str, Callable[[], TextTable]] = {
        "fitted": lambda: fitted_table(found, without),
        "shown": lambda: shown_table(found, without),
    }
    fill(document, lambda part, *words: tables[words[0]]() if part == "ratios" else None)

    judged = {
        "in force": [(one, RATIOS) for one in everything],
        "vehicle left out": [(one, without[name]) for name, own in found.items() for one in own],
    }
    axes = plt.figure(figsize=(5, 5), layout="constrained").add_subplot()
    axes.plot([0, 1], [0, 1], color="0.7")
    for label, pairs in judged.items():
        brier, bins = reliability(pairs)
        click.echo(f"{label}: Brier score {brier:.3f} (0.25: no idea)")
        for mean, share, weight in bins:
            click.echo(f"  claimed {mean:.3f}, attacked {share:.3f} (weight {weight:.3f})")
        axes.plot(*zip(*((mean, share) for mean, share, _ in bins), strict=True), "o-", label=label)
    axes.set(xlabel="claimed probability, even prior odds", ylabel="share of attacks")
    axes.legend()
    figure.parent.mkdir(parents=True, exist_ok=True)
    axes.figure.savefig(figure, dpi=110)


if __name__ == "__main__":
    main()
