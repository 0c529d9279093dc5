# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Hard but clean flights through the whole monitor on the default policy: no alert in any."""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.evaluation.trials.protocols import hard_case
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.replay.offline import OfflineRun
from hijack_detect.simulation.plan import FlightPlan
from hijack_detect.streams.samples import NANOSECONDS, AttitudeSample


@dataclass
class Said:
    """What the monitor said of a flight, with times in seconds from its start."""

    plan: FlightPlan
    run: OfflineRun
    attitudes: list[AttitudeSample] = field(default_factory=list)

    def seconds(self, stamp_ns: int) -> float:
        return (stamp_ns - self.run.start_ns) / NANOSECONDS

    def during(self, detector: str, start_s: float, end_s: float) -> list[Verdict]:
        found = self.run.verdicts[detector]
        return [v for v in found if start_s <= self.seconds(v.stamp_ns) < end_s]

    def fused(self, start_s: float, end_s: float) -> set[State]:
        return {r.state for r in self.run.results if start_s <= self.seconds(r.stamp_ns) < end_s}

    @property
    def alerted(self) -> str:
        """The cause of the alert; empty without one."""
        return next((r.reason for r in self.run.results if r.alert), "")

    def worst(self, detector: str) -> float:
        return max(v.margin for v in self.run.verdicts[detector])


@lru_cache(maxsize=2)
def flown(name: str, number: int = 0) -> Said:
    case = hard_case(name, number)
    outputs: dict[str, list[Any]] = defaultdict(list)
    done = case.run(
        MonitorParameters(), on_output=lambda part, output: outputs[part].append(output)
    )
    said = Said(case.plan, done.run, outputs["attitude"])
    assert len(said.run.results) > 1000
    return said


def settled(said: Said, detector: str) -> set[State]:
    """States of a detector in forward flight."""
    return {v.state for v in said.during(detector, 45.0, 95.0)}


def test_strong_wind_with_turbulence_is_at_most_suspicious() -> None:
    said = flown("strong_wind")
    assert not said.alerted
    assert said.fused(45.0, 95.0) <= {State.NORMAL, State.SUSPICIOUS}
    assert settled(said, "date") == settled(said, "kld") == {State.NORMAL}


def test_gusts_of_8_m_s_are_normal() -> None:
    said = flown("gusts")
    assert not said.alerted
    assert settled(said, "date") == settled(said, "kld") == {State.NORMAL}
    assert said.worst("date") < 0.5


def test_a_gust_front_of_8_m_s_is_normal() -> None:
    said = flown("gust_front")
    assert not said.alerted
    assert settled(said, "date") == settled(said, "kld") == {State.NORMAL}
    assert said.worst("date") < 0.5


def test_hard_braking_is_normal() -> None:
    said = flown("hard_braking")
    assert not said.alerted
    assert settled(said, "date") == settled(said, "kld") == {State.NORMAL}
    assert said.worst("date") < 0.5


def test_spins_in_hover_leave_no_course_and_date_normal() -> None:
    said = flown("spin_in_hover")
    assert not said.alerted
    assert settled(said, "correlation") <= {State.NOT_OBSERVABLE, State.NOT_READY}
    assert settled(said, "kld") == {State.NORMAL}
    assert settled(said, "date") <= {State.NORMAL, State.NOT_READY}


def test_a_spin_in_flight_alarms_the_correlation_which_alone_never_alerts() -> None:
    """The nose turns and the course does not, which is what the correlation looks for."""
    said = flown("spin_in_flight")
    assert not said.alerted
    assert State.ALARM in settled(said, "correlation")
    assert settled(said, "date") == settled(said, "kld") == {State.NORMAL}
    assert said.fused(45.0, 95.0) <= {State.NORMAL, State.SUSPICIOUS, State.NOT_OBSERVABLE}


def test_a_compass_anomaly_bends_the_heading_and_raises_no_alert() -> None:
    said = flown("compass_anomaly")
    (anomaly,) = said.plan.disturbances.anomalies
    begin = anomaly.pulse.start_s
    assert not said.alerted
    assert settled(said, "kld") == {State.NORMAL}
    variances = [
        a.heading_variance
        for a in said.attitudes
        if begin <= said.seconds(a.stamp_ns) < begin + 20.0
    ]
    assert len(variances) > 1900, "imu/data goes on with an orientation"
    assert max(variances) < math.radians(30.0) ** 2


def test_an_outage_is_said_to_be_stale_and_its_return_is_normal() -> None:
    said = flown("gps_outage")
    (outage,) = said.plan.disturbances.outages
    lost, back = outage.start_s, outage.start_s + outage.duration_s
    assert not said.alerted
    # A silent input is waited for 3 s on the stamps of the others, and noticed after 1.5 s.
    during = said.during("date", lost + 5.0, back)
    assert during
    assert {v.state for v in during} == {State.STALE}
    assert all("GPS velocity" in v.reason for v in during)
    assert State.STALE in said.fused(lost + 5.0, back)
    assert State.NORMAL not in said.fused(lost + 6.0, back)
    # Left out for 1 s after its return, then DATE fills its window of 2 s.
    for name in ("date", "kld"):
        assert {v.state for v in said.during(name, back + 6.0, 95.0)} == {State.NORMAL}
        assert not {State.SUSPICIOUS, State.ALARM} & {v.state for v in said.run.verdicts[name]}


def test_a_receiver_jump_of_2_m_is_normal() -> None:
    said = flown("receiver_jump")
    assert not said.alerted
    assert settled(said, "date") == settled(said, "kld") == {State.NORMAL}


def test_strong_vibration_is_normal_off_the_sampling_rate() -> None:
    said = flown("vibration")
    vibration = said.plan.disturbances.vibration
    assert vibration is not None
    assert 3.0 <= vibration.force_rms <= 5.0
    assert abs(vibration.rotor_hz - 100.0) > 5.0
    assert not said.alerted
    assert settled(said, "date") == settled(said, "kld") == {State.NORMAL}
