# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The record of one recorded flight under every family of attacks."""

from __future__ import annotations

from collections.abc import Callable

from hijack_detect.evaluation.scores.limit_records import (
    AttackRecord,
    CleanLog,
    FlightRecord,
    method_records,
)
from hijack_detect.evaluation.trials.cases import BagCase
from hijack_detect.evaluation.trials.families import Placed, attacks_on
from hijack_detect.evaluation.trials.forked import HORIZON_S, run_forked
from hijack_detect.evaluation.trials.onsets import forward_flight
from hijack_detect.monitor.graph import MonitorParameters
from hijack_detect.streams.samples import NANOSECONDS


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
