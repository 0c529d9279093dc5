# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Alerts an hour at risk: of one flight, of a class, of a vehicle."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from scipy.stats import chi2

from hijack_detect.analysis.account import Account
from hijack_detect.analysis.alarms import AlertSpan, Times
from hijack_detect.analysis.analysis import Visible
from hijack_detect.analysis.worth import lasting, not_judged, visible
from hijack_detect.evaluation.scores.model import Model

LEVEL = 0.95
"""Confidence of intervals: the convention of the field."""


class RateInterval(Model):
    """Events per hour with the exact (Poisson) two-sided 95 % interval (Garwood 1936)."""

    events: int
    hours: float
    per_hour: float | None
    low: float | None
    high: float | None

    @classmethod
    def of(cls, events: int, hours: float) -> RateInterval:
        """Make one; without any time there is no rate."""
        if hours <= 0.0:
            return cls(events=events, hours=0.0, per_hour=None, low=None, high=None)
        tail = (1.0 - LEVEL) / 2.0
        low = float(chi2.ppf(tail, 2 * events)) / 2.0 / hours if events else 0.0
        high = float(chi2.ppf(1.0 - tail, 2 * (events + 1))) / 2.0 / hours
        return cls(events=events, hours=hours, per_hour=events / hours, low=low, high=high)


class TimedCause(Model):
    """An alert: seconds from the flight's first message, and its cause in words."""

    at_s: float
    cause: str


class FlightWatch(Model):
    """Coverage of a flight while it was clean: all of it, or until an attack or a fault.

    Attributes:
        counted: Whether an alert would be false; not if the time from which it is right is unknown.
        in_air_s: Time in the air.
        at_risk_s: The part of it in which an alert was possible, until the first one.
        open_s: The part of it in which an alert was possible and none stood, with the alert taken
            back each time: what the rate of all alarms is of.
        told_s: The part of `at_risk_s` in which each detector could tell.
        carry_off_s: The part of it in which one could tell that could see a carry-off.
        first: The first alert.
        alarms: Every alert of a fusion that is taken back once its causes are quiet.
        not_judged: Why nothing could have seen a carry-off in the whole flight, None if something
            could.
        visible: The pull that would have been seen, see `worth.visible`.
        poor_receiver: In what the receiver was poor by its own claim, empty if it was good.
        late_gps: By how much the GPS lagged at least, empty if it was no later than receivers are.
    """

    counted: bool
    in_air_s: float
    at_risk_s: float
    open_s: float
    told_s: dict[str, float]
    carry_off_s: float
    first: TimedCause | None
    alarms: tuple[TimedCause, ...]
    not_judged: str | None
    visible: Visible | None
    poor_receiver: str = ""
    late_gps: str = ""


def watch(
    account: Account, start_ns: int, end_ns: int, clean_until_ns: int | None, *, counted: bool
) -> FlightWatch:
    """Sum up how a flight was watched.

    Args:
        account: What listened to its run.
        start_ns: Where it starts, nanoseconds.
        end_ns: Where it ends, nanoseconds.
        clean_until_ns: From here on an alert is right; None for never.
        counted: See FlightWatch.
    """
    spans, watched = account.finish(end_ns)

    def clean(times: Times) -> Times:
        return times if clean_until_ns is None else times.before(clean_until_ns)

    def false(alerts: Sequence[AlertSpan]) -> list[AlertSpan]:
        found = [one for one in alerts if clean_until_ns is None or one.start_ns < clean_until_ns]
        return sorted(found, key=lambda one: one.start_ns)

    def causes(alerts: Sequence[AlertSpan]) -> tuple[TimedCause, ...]:
        return tuple(
            TimedCause(at_s=(one.start_ns - start_ns) / 1e9, cause=one.cause) for one in alerts
        )

    alerts, alarms = false(account.alerts(end_ns)), false(account.alarms(end_ns))
    possible = clean(watched.in_air & watched.alertable)
    risk = possible.before(alerts[0].start_ns) if alerts else possible
    standing = Times((one.start_ns, one.end_ns) for one in alarms)
    return FlightWatch(
        counted=counted,
        in_air_s=clean(watched.in_air).seconds,
        at_risk_s=risk.seconds,
        open_s=(possible - standing).seconds,
        told_s={name: (risk & times).seconds for name, times in watched.judged.items()},
        carry_off_s=(risk & watched.carry_off).seconds,
        first=next(iter(causes(alerts)), None),
        alarms=causes(alarms),
        not_judged=not_judged(account, watched, spans),
        visible=visible(watched),
        poor_receiver=lasting(account.poor),
        late_gps=lasting(account.late),
    )


class GroupWatch(Model):
    """Coverage of the flights of a class or of a vehicle.

    Attributes:
        flights: How many there are.
        not_judged: Those of them in which nothing could have seen a carry-off.
        first: Flights with a false alert, per hour at risk. One that comes on the ground counts
            too, though the time there does not.
        alarms: All false alerts, each taken back, per hour in the air in which one was possible.
        told: Share of the time at risk in which each detector could tell; empty without any.
        carry_off: Share of it in which one could tell that could see a carry-off.
    """

    flights: int
    not_judged: int
    first: RateInterval
    alarms: RateInterval
    told: dict[str, float]
    carry_off: float | None

    @classmethod
    def of(cls, watches: Sequence[FlightWatch]) -> GroupWatch:
        """Sum up flights."""
        counted = [one for one in watches if one.counted]

        def total(value: Callable[[FlightWatch], float]) -> float:
            return sum(value(one) for one in counted)

        at_risk_s = total(lambda one: one.at_risk_s)
        names = dict.fromkeys(name for one in counted for name in one.told_s)
        return cls(
            flights=len(watches),
            not_judged=sum(one.not_judged is not None for one in watches),
            first=RateInterval.of(
                sum(one.first is not None for one in counted), at_risk_s / 3600.0
            ),
            alarms=RateInterval.of(
                sum(len(one.alarms) for one in counted), total(lambda one: one.open_s) / 3600.0
            ),
            told={
                name: sum(one.told_s.get(name, 0.0) for one in counted) / at_risk_s
                for name in names
                if at_risk_s > 0.0
            },
            carry_off=(total(lambda one: one.carry_off_s) / at_risk_s if at_risk_s > 0.0 else None),
        )
