# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The tables of alerts an hour at risk, for the terminal and the page alike."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from hijack_detect.evaluation.scores.evaluate import Evaluation
from hijack_detect.evaluation.scores.evaluation_tables import NONE, TextTable
from hijack_detect.evaluation.scores.metrics import FlightOutcome
from hijack_detect.evaluation.scores.watch import FlightWatch, GroupWatch, RateInterval
from hijack_detect.monitor.parts import DETECTORS, WEIGHTS

EXPLAINED = {
    "Alerts/h at risk": "Flights with a false alert, per hour in the air in which an alert was "
    "possible (a detector could tell whose alarm makes one), until that alert. Clean flights "
    "count whole, hijacked ones until the attack, a receiver that fails until it does. An alert on "
    "the ground counts, the time there does not. Exact two-sided 95 % interval of a Poisson rate.",
    "All alarms/h": "The same of all alerts, if each is taken back once no cause of it has been "
    "suspicious or in alarm for `together_s`.",
    "Could tell": "Share of the time at risk. “Carry-off”: at least one of "
    f"{', '.join(name for name, one in WEIGHTS.items() if one.sees_carry_off)}.",
    "Not judged": "Flights in which none of them could tell in the air.",
}
"""Meaning of the columns."""


def watch_tables(evaluation: Evaluation) -> Iterator[TextTable]:
    """Rates and shares by class and by vehicle, and every alert with its cause."""
    for name, groups in (("class", evaluation.by_class), ("vehicle", evaluation.by_vehicle)):
        if groups:
            yield _rates(name, groups)
            yield _shares(name, groups)
    rows = tuple(
        row
        for flight in evaluation.flights
        if flight.watch is not None
        for row in _alerts(flight, flight.watch)
    )
    if rows:
        columns: tuple[str, ...] = ("flight", "class", "vehicle", "at", "cause")
        yield TextTable("False alerts, each taken back once its causes are quiet", columns, rows)
    unjudged = tuple(
        (flight.name, flight.kind, flight.vehicle or NONE, flight.watch.not_judged)
        for flight in evaluation.flights
        if flight.watch is not None and flight.watch.not_judged is not None
    )
    if unjudged:
        columns = ("flight", "class", "vehicle", "cause")
        yield TextTable("Flights that could not be judged", columns, unjudged)


def _rates(name: str, groups: Mapping[str, GroupWatch]) -> TextTable:
    columns = (name, "flights", "not judged", "with alert", "h at risk", "alerts/h at risk",
               "alarms", "all alarms/h")  # fmt: skip
    rows = tuple(
        (
            group,
            str(one.flights),
            str(one.not_judged),
            str(one.first.events),
            f"{one.first.hours:.3f}",
            interval(one.first),
            str(one.alarms.events),
            interval(one.alarms),
        )
        for group, one in groups.items()
    )
    return TextTable(f"Alerts an hour at risk by {name} [95 % interval]", columns, rows)


def _shares(name: str, groups: Mapping[str, GroupWatch]) -> TextTable:
    rows = tuple(
        (
            group,
            NONE if one.carry_off is None else f"{100.0 * one.carry_off:.0f} %",
            *(f"{100.0 * one.told[key]:.0f} %" if key in one.told else NONE for key in DETECTORS),
        )
        for group, one in groups.items()
    )
    columns = (name, "carry-off", *DETECTORS)
    return TextTable(f"Could tell, share of the time at risk, by {name}", columns, rows)


def _alerts(flight: FlightOutcome, one: FlightWatch) -> Iterator[tuple[str, ...]]:
    note = "" if one.counted else " (not counted)"
    for alarm in one.alarms:
        yield (
            flight.name,
            f"{flight.kind}{note}",
            flight.vehicle or NONE,
            f"{alarm.at_s:.1f} s",
            alarm.cause,
        )


def interval(rate: RateInterval) -> str:
    """Events per hour and their interval."""
    if rate.per_hour is None or rate.low is None or rate.high is None:
        return NONE
    return f"{rate.per_hour:.1f} [{rate.low:.1f}, {rate.high:.1f}]"
