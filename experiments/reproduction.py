# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The tables of docs/reproduction.md: runs the evaluations and writes their figures into the text.

    python -m experiments.reproduction docs/reproduction.md --results build/reproduction

A line `<!-- table RUN KIND -->` of the text is followed by a table, which is replaced. RUN is a
name in RUNS, KIND one in KINDS. The results of a run are kept as JSON in the folder of results,
and made only if they are not there.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import click

from hijack_detect.evaluation.scores.basan_tables import (
    attack_table,
    false_alarm_table,
    forged_table,
    forging_table,
)
from hijack_detect.evaluation.scores.evaluate import Evaluation
from hijack_detect.evaluation.scores.evaluation_tables import (
    TextTable,
    correct_table,
    detection_table,
    error_table,
    flight_table,
    outcome_text,
    proportion,
    spread,
)
from hijack_detect.evaluation.scores.metrics import FlightOutcome, Proportion, Spread
from hijack_detect.evaluation.trials.fake_tracks import TRACKS
from tools.documents import fill

FLIGHTS = "../shared/flights"
FENG = ("--protocol", "feng2018", "--scale", "4")
ONSETS = ("--scenario", "turn_away_track", "--onsets", "5")
PAPER = ("--policy", "paper")
RUNS = {
    "feng2018_paper": (*FENG, *PAPER),
    "noisy_paper": ("--protocol", "feng2018_noisy", "--scale", "4", *PAPER),
    "sitl_paper": (f"{FLIGHTS}/sitl", *PAPER),
    "recorded_paper": (f"{FLIGHTS}/bags", *ONSETS, *PAPER),
    "basan2022": ("--protocol", "basan2022", "--scale", "4"),
    "basan2022_sitl": (f"{FLIGHTS}/sitl", "--protocol", "basan2022", "--onsets", "2"),
}
"""Arguments of `hijack-detect evaluate`."""

TABLE_1 = {
    "correlation": {"straight": "92 %", "curved": "100 %", "hijacked": "100 %"},
    "date": {"straight": "100 %", "curved": "84 %", "hijacked": "100 %"},
    "both": {"straight": "100 %", "curved": "100 %", "hijacked": "100 %"},
}
"""Table 1 of the paper: correctness of each method on 25, 25 and 50 flights."""
METHODS = ("correlation", "date", "both", "kld", "fusion")
PUBLISHED = ("ins_position", "kld_faithful", *METHODS)
"""Methods in the tables of the published policy; the other detectors are no part of the papers."""


def table_1(evaluation: Evaluation) -> TextTable:
    """Table 1: the paper's number, and ours with its interval."""
    kinds = ("straight", "curved", "hijacked")
    rows = [
        (
            name,
            *(
                f"{TABLE_1.get(name, {}).get(kind, '–')} · {proportion(summary.correct[kind])}"
                for kind in kinds
            ),
        )
        for name, summary in evaluation.methods.items()
    ]
    columns = ("method", *(f"{kind}: paper · ours" for kind in kinds))
    return TextTable("Table 1", columns, tuple(rows))


def misses(evaluation: Evaluation) -> TextTable:
    """The flights on which `both` or `fusion` was wrong."""
    rows = [
        (flight.name, *(outcome_text(flight.methods[name]) for name in METHODS))
        for flight in evaluation.flights
        if not all(flight.methods[name].judgement.correct for name in ("both", "fusion"))
    ]
    return TextTable("Wrong", ("flight", *METHODS), tuple(rows))


def by_flight(evaluation: Evaluation) -> TextTable:
    """For each recorded flight its false alarms, and how many attacks on it were found."""
    rows = []
    for clean in evaluation.flights:
        attacks = [one for one in evaluation.flights if one.name.startswith(f"{clean.name}@")]
        if clean.onset_s is None:
            rows.append(
                (
                    clean.name,
                    *(str(clean.methods[name].false_alarms) for name in METHODS),
                    str(len(attacks)),
                    *(
                        str(sum(found(one, name) is not None for one in attacks))
                        for name in METHODS
                    ),
                )
            )
    columns = (
        "flight",
        *(f"false alarms: {name}" for name in METHODS),
        "attacks",
        *(f"found: {name}" for name in METHODS),
    )
    return TextTable("By flight", columns, tuple(rows))


def unfound(evaluation: Evaluation) -> TextTable:
    """The attacks on recorded flights that the fusion did not find, and the margins reached."""
    rows = [
        (flight.name, *(f"{flight.methods[name].score:.2f}" for name in ("correlation", "date")))
        for flight in evaluation.flights
        if flight.injected and found(flight, "fusion") is None
    ]
    return TextTable("Not found", ("attack", "correlation margin", "DATE margin"), tuple(rows))


def found_of_all(evaluation: Evaluation) -> TextTable:
    """How many attacks on recorded flights each method found, and how soon."""
    injected = [flight for flight in evaluation.flights if flight.injected]
    rows = []
    for name in METHODS:
        times = [t for flight in injected if (t := found(flight, name)) is not None]
        rows.append(
            (name, proportion(Proportion.of(len(times), len(injected))), spread(Spread.of(times)))
        )
    columns = ("method", "found [95 % interval]", "after, s: median / p95 / max")
    return TextTable("Found", columns, tuple(rows))


def found(flight: FlightOutcome, method: str) -> float | None:
    """Seconds from the onset to the first alarm that began in the attack, see `found_s`."""
    return flight.methods[method].found_s


def by_track(evaluation: Evaluation) -> TextTable:
    """Hijacked flights of a protocol judged correctly, by real route and fake track."""
    flights = [flight for flight in evaluation.flights if flight.onset_s is not None]
    groups = {
        (route, track): [one for one in flights if one.name.endswith(f"_{route}_{track}")]
        for route in ("straight", "curved")
        for track in TRACKS
    }
    turning = [one for (_, track), group in groups.items() if track != "straight" for one in group]
    rows = [
        (*names, *(proportion(right(group, name)) for name in METHODS))
        for names, group in [*groups.items(), (("any", "any that turns"), turning)]
    ]
    return TextTable("By track", ("real route", "fake track", *METHODS), tuple(rows))


def right(flights: Sequence[FlightOutcome], method: str) -> Proportion:
    """Flights that a method judged correctly."""
    count = sum(flight.methods[method].judgement.correct for flight in flights)
    return Proportion.of(count, len(flights))


KINDS: Mapping[str, Callable[[Evaluation], TextTable]] = {
    "table1": table_1,
    "correct": correct_table,
    "errors": error_table,
    "detection": detection_table,
    "flights": flight_table,
    "misses": misses,
    "by_flight": by_flight,
    "unfound": unfound,
    "found": found_of_all,
    "by_track": by_track,
    "attacks": attack_table,
    "false_alarms": false_alarm_table,
    "forged": forged_table,
    "forging": forging_table,
}


def result(run: str, folder: Path) -> Evaluation:
    """The result of a run, made if it is not there."""
    path = folder / f"{run}.json"
    if not path.is_file():
        folder.mkdir(parents=True, exist_ok=True)
        program = Path(sys.executable).with_name("hijack-detect")
        command = [str(program), "evaluate", *RUNS[run], "--json", str(path)]
        print(" ".join(["hijack-detect", *command[1:]]), file=sys.stderr)
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    evaluation = Evaluation.model_validate_json(path.read_text(encoding="utf-8"))
    # Without the published policy the fusion is the default one.
    shown = PUBLISHED if run.endswith("_paper") else set(PUBLISHED) - {"fusion"}
    methods = {name: one for name, one in evaluation.methods.items() if name in shown}
    return evaluation.model_copy(update={"methods": methods})


@click.command()
@click.argument("document", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--results", type=click.Path(path_type=Path), required=True)
def main(document: Path, results: Path) -> None:
    """Write the tables into DOCUMENT."""
    fill(document, lambda run, kind: KINDS[kind](result(run, results)))


if __name__ == "__main__":
    main()
