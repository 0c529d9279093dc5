# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Tables 4 and 5 of Basan et al. 2022, the paper's figures beside ours."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hijack_detect.detectors.kld_values import NAMES
from hijack_detect.evaluation.scores.evaluate import Evaluation
from hijack_detect.evaluation.scores.evaluation_tables import NONE, TextTable, proportion, spread
from hijack_detect.evaluation.scores.forged import UNITS
from hijack_detect.evaluation.scores.metrics import FlightOutcome, Proportion, Spread
from hijack_detect.evaluation.trials.basan2022 import MODES

METHODS = ("kld_faithful", "kld", "fusion")
PAPER_TABLE_4: Mapping[str, tuple[str, str]] = {
    "clean": ("0", "0.560"),
    "soft": ("0.060", "4.214"),
    "hard_1": ("0.640", "5.519"),
    "hard_2": ("-0.061", "8.343"),
}
"""Likelihood function and standard deviation of the altitude, simulation, by class."""
PAPER_TABLE_5 = {"soft": ("0.01", "0.99"), "hard_1": ("0.05", "0.94"), "hard_2": ("0.09", "0.90")}
"""Type II error and probability of detection by class."""
PAPER_DELAY = "5 to 30"


def attack_table(evaluation: Evaluation) -> TextTable:
    """Table 5: Type II, detection and the delay of the notification, for every mode and method.

    `claimed` is the share of the attack in which the method's figures alone were above the
    threshold.
    """
    rows = [
        _detection(mode, method, [one for one in evaluation.flights if one.kind == mode])
        for mode in MODES
        for method in METHODS
        if method in evaluation.methods
    ]
    columns = (
        "attack",
        "method",
        "Type II",
        "paper",
        "detection",
        "paper",
        f"notification, s\n(paper {PAPER_DELAY})",
        "early",
        "claimed",
    )
    return TextTable(
        "Table 5: detection [95 % interval]; notification: median / p95 / maximum",
        columns,
        tuple(rows),
    )


def false_alarm_table(evaluation: Evaluation) -> TextTable:
    """Type I: clean flights with an alarm; the paper saw none."""
    rows = [
        (name, proportion(evaluation.methods[name].type_1))
        for name in METHODS
        if name in evaluation.methods
    ]
    return TextTable(
        "Type I error (paper: none)", ("method", "clean flights with an alarm"), (*rows,)
    )


def forged_table(evaluation: Evaluation) -> TextTable:
    """Table 4: likelihood function and standard deviation of each parameter, and their spread."""
    rows = []
    for kind in ("clean", *MODES):
        flights = [one for one in evaluation.flights if one.kind == kind and one.forged]
        for name in NAMES:
            found = [one.forged[name] for one in flights if one.forged and name in one.forged]
            if not found:
                continue
            published = (
                PAPER_TABLE_4.get(kind, (NONE, NONE)) if name == "altitude" else (NONE, NONE)
            )
            unit = UNITS[name][1]
            rows.append(
                (
                    kind,
                    f"{name}, {unit}" if unit else name,
                    _quantiles([one.likelihood for one in found]),
                    published[0],
                    _quantiles([one.sigma for one in found]),
                    published[1],
                    _quantiles([one.normal_sigma for one in found if one.normal_sigma is not None]),
                )
            )
    columns = (
        "attack",
        "parameter",
        "likelihood",
        "paper",
        "standard deviation",
        "paper",
        "before the attack",
    )
    return TextTable("Table 4: quality of forged data, median [5 %, 95 %]", columns, tuple(rows))


def forging_table(evaluation: Evaluation) -> TextTable:
    """The time that forging the values of one update takes."""
    rows = [(one.parameters, f"{one.microseconds:.0f}") for one in evaluation.forging or ()]
    return TextTable("Time spent on forging", ("forged", "µs per update"), tuple(rows))


def basan_tables(evaluation: Evaluation) -> list[TextTable]:
    """All of them."""
    return [
        attack_table(evaluation),
        false_alarm_table(evaluation),
        forged_table(evaluation),
        forging_table(evaluation),
    ]


def _detection(mode: str, method: str, flights: Sequence[FlightOutcome]) -> tuple[str, ...]:
    missed, found = PAPER_TABLE_5.get(mode, (NONE, NONE))
    outcomes = [flight.methods[method] for flight in flights]
    detected = sum(outcome.judgement.correct for outcome in outcomes)
    early = sum(outcome.judgement.value == "early" for outcome in outcomes)
    delays = [one.time_to_detect_s for one in outcomes if one.time_to_detect_s is not None]
    claimed = [one.claimed for one in outcomes if one.claimed is not None]
    return (
        mode,
        method,
        f"{1.0 - detected / len(outcomes):.3f}" if outcomes else NONE,
        missed,
        proportion(Proportion.of(detected, len(outcomes))),
        found,
        spread(Spread.of(delays)),
        str(early),
        f"{100.0 * sum(claimed) / len(claimed):.0f} %" if claimed else NONE,
    )


def _quantiles(values: Sequence[float]) -> str:
    if not values:
        return NONE
    low, median, high = np.percentile(values, [5.0, 50.0, 95.0]).tolist()
    return f"{median:.3g}\n[{low:.3g}, {high:.3g}]"
