# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Consistency of a receiver stream with itself: jumps, freezes, impossible motion, stamps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hijack_detect.detectors.flight_gate import FlightGate
from hijack_detect.detectors.gnss_checks.lasting_step import LastingStep
from hijack_detect.detectors.gnss_checks.latency import LatencySeen, later_words
from hijack_detect.detectors.gnss_checks.motion import (
    AccelerationCheck,
    JumpCheck,
    JumpLimits,
    SpeedCheck,
)
from hijack_detect.detectors.gnss_checks.step import RANK, Check, Finding, Step, Track
from hijack_detect.detectors.gnss_checks.stream import (
    CovarianceCheck,
    FreezeCheck,
    PublishersCheck,
    SatellitesCheck,
    StampsCheck,
)
from hijack_detect.detectors.gnss_checks.velocity_mismatch import (
    MismatchLimits,
    VelocityMismatchCheck,
)
from hijack_detect.detectors.input_watch import InputWatch, SetBack, patience
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.estimation.clock_rate import ClockRateCheck, clock_words
from hijack_detect.estimation.receiver_health import (
    POOR,
    ReceiverHealth,
    ReceiverLimits,
    poor_words,
)
from hijack_detect.parameters import Parameters, param
from hijack_detect.streams.samples import (
    NANOSECONDS,
    FixSample,
    GpsSample,
    PhaseSample,
    VelocitySample,
)
from hijack_detect.streams.silence import sensor_patience


@dataclass(frozen=True)
class GnssSanityParameters(Parameters):
    """Limits of each check."""

    jump_suspicious_m: float = param(
        3.0,
        "A horizontal step that differs by more from the reported motion is SUSPICIOUS (over 1 s: "
        "4/3 of it). Clean: 1.1 in one step, 2.6 over 1 s. Raise for a receiver that jumps by "
        "itself.",
        source="measured on clean recorded flights",
        basic=True,
        unit="m",
        low=0.1,
        high=1000.0,
    )
    jump_alarm_m: float = param(
        15.0,
        "Such a step is an ALARM at once. Reflections move receivers by a few metres, a step of "
        "15 m under a good view of the sky is several times what they claim; smaller ones are an "
        "ALARM when there are three within 5 s, or when they last (jump_lasting_m). Lower it where "
        "an alarm costs little.",
        source="chosen: five times jump_suspicious_m",
        unit="m",
        low=0.5,
        high=10_000.0,
    )
    jump_lasting_m: float = param(
        5.0,
        "With reported velocities, such a step within 1 s is an ALARM if it is not taken back: "
        "1.4 times as large after 1 s, else after 6 s. Up to twice this on a receiver that claims "
        "or has shown worse. Clean: 2.4. Raise it where buildings reflect.",
        source="measured: 1.25 times the step of two antennas 4 m apart that are switched "
        "(docs/detectors.md, what gnss allows)",
        unit="m",
        low=0.5,
        high=10_000.0,
    )
    vertical_suspicious_m: float = param(
        6.0,
        "As jump_suspicious_m, for height. Clean: 1.7 in one step, 3.0 over 1 s.",
        source="measured: twice the largest on clean recorded flights",
        unit="m",
        low=0.1,
        high=1000.0,
    )
    vertical_alarm_m: float = param(
        25.0,
        "As jump_alarm_m, for height.",
        source="chosen, not swept: about four times vertical_suspicious_m",
        unit="m",
        low=0.5,
        high=10_000.0,
    )
    manoeuvre_m_s2: float = param(
        15.0,
        "Acceleration the vehicle may have between two samples. It allows a step a·dt²/4 with "
        "velocities, a·dt² from fixes alone: little at 5 Hz, kilometres after 20 s.",
        source="chosen, not swept: 1.5 g",
        unit="m/s²",
        low=0.1,
        high=500.0,
    )
    accuracy_gain: float = param(
        3.0,
        "A step within this many times the claimed standard deviation is not SUSPICIOUS.",
        source="physics: three standard deviations",
        low=0.0,
        high=20.0,
    )
    accuracy_cap_m: float = param(
        2.0,
        "A claimed accuracy beyond this does not count: what claims it may be the attacker.",
        source="chosen, not swept",
        unit="m",
        low=0.0,
        high=100.0,
    )
    mismatch_base_m: float = param(
        5.0,
        "Horizontal change of position against integrated velocity over T seconds may differ by "
        "base + rate·T + fraction·path on a poor receiver. Clean quadrotors: 3.3 in 2 s, 5.6 in "
        "10 s, 7.8 in 20 s.",
        source="measured: 1.7 times the largest of clean recorded quadrotors",
        unit="m",
        low=0.1,
        high=1000.0,
    )
    mismatch_rate_m_s: float = param(
        0.45,
        "See mismatch_base_m.",
        source="measured with mismatch_base_m",
        unit="m/s",
        low=0.0,
        high=100.0,
    )
    mismatch_path_fraction: float = param(
        0.03,
        "See mismatch_base_m: errors of fast vehicles grow with the way. Clean fixed wing: 19 m in "
        "600 m.",
        source="measured: a recorded fixed wing",
        low=0.0,
        high=1.0,
    )
    mismatch_vertical_base_m: float = param(
        5.5,
        "As mismatch_base_m, for height. Clean quadrotors: 4 m in 2 s, 10 m in 10 s, 16 m in 20 s.",
        source="measured: 1.6 to 1.9 times the largest of clean recorded quadrotors",
        unit="m",
        low=0.1,
        high=1000.0,
    )
    mismatch_vertical_rate_m_s: float = param(
        1.1,
        "As mismatch_rate_m_s, for height.",
        source="measured with mismatch_vertical_base_m",
        unit="m/s",
        low=0.0,
        high=100.0,
    )
    mismatch_persist_s: float = param(
        1.0,
        "It must last for this long to be an ALARM.",
        source="chosen, not swept",
        unit="s",
        low=0.0,
        high=60.0,
    )
    mismatch_floor: float = param(
        0.25,
        "A receiver whose own past is good has these limits times a part, down to this one. "
        "1 switches learning off.",
        source="chosen, not swept",
        low=0.05,
        high=1.0,
    )
    mismatch_gain: float = param(
        2.5,
        "The part is this times the largest level of the receiver's past flight. Raise it if "
        "velocity_mismatch alarms on clean flights.",
        source="measured: clean recorded flights",
        low=1.0,
        high=100.0,
    )
    freeze_s: float = param(
        1.2,
        "A position that repeats for this long while the vehicle moves is an ALARM. Clean: 0.2. "
        "Raise for a receiver slower than 1 Hz whose fixes are repeated by its driver.",
        source="chosen: six fixes of 5 Hz",
        unit="s",
        low=0.1,
        high=60.0,
    )
    max_speed_m_s: float = param(
        48.0,
        "A speed in three dimensions that the vehicle cannot fly: ALARM, SUSPICIOUS from 80 %. "
        "Clean: 32. Set it to 1.5 times the vehicle's own largest.",
        source="measured: 1.5 times the fastest recorded vehicle",
        basic=True,
        unit="m/s",
        low=1.0,
        high=1000.0,
    )
    max_acceleration_m_s2: float = param(
        55.0,
        "A change of velocity over 1 s that it cannot fly: ALARM, SUSPICIOUS from 80 %. Clean: "
        "36 (launch of a fixed wing), 11 on quadrotors. Set it to 1.5 times the vehicle's own.",
        source="measured: 1.5 times the largest recorded",
        basic=True,
        unit="m/s²",
        low=1.0,
        high=1000.0,
    )
    satellites_at_once: float = param(
        8.0,
        "One change of the number of satellites that is SUSPICIOUS. Clean: 5.",
        source="measured: 1.6 times the largest recorded",
        low=1.0,
        high=200.0,
    )
    satellites_in_5_s: float = param(
        20.0,
        "Sum of its changes over 5 s that is SUSPICIOUS. Clean: 12, in banked turns.",
        source="measured: 1.7 times the largest recorded",
        low=1.0,
        high=1000.0,
    )
    covariance_in_5_s: float = param(
        3.0,
        "Sum of the changes of ln(claimed accuracy) over 5 s, each at most 1, that is SUSPICIOUS.",
        source="chosen, not swept",
        low=0.1,
        high=100.0,
    )
    stamps_alarm: int = param(
        5,
        "This many stamps of fixes and velocities that repeat, run back or jump within stamps_in_s "
        "are an ALARM, unless they are copies of the sample before (SUSPICIOUS).",
        source="chosen, not swept",
        low=2,
        high=60,
    )
    stamps_in_s: float = param(
        3.0, "See stamps_alarm.", source="chosen, not swept", unit="s", low=0.1, high=60.0
    )
    receiver_no_fix_s: float = param(
        3.0,
        "The receiver is poor by its own word if it has no fix, or sends nothing, for this long of "
        "the last minute. That changes no state: it is named in the reason and on /diagnostics. "
        "Receivers under an open sky lose none (measured); one loss takes them 5 s.",
        source="measured: recorded receivers",
        unit="s",
        low=0.1,
        high=60.0,
    )
    receiver_accuracy_m: float = param(
        5.0,
        "It is poor if it claims a horizontal standard deviation above this in most fixes of 10 s "
        "(ArduPilot aligns no EKF above, nor with an HDOP above 2.5, which is the same).",
        source="ArduPilot, EKF alignment",
        unit="m",
        low=0.1,
        high=1000.0,
    )
    receiver_vertical_accuracy_m: float = param(
        7.5,
        "The same for its height (ArduPilot's limit).",
        source="ArduPilot, EKF alignment",
        unit="m",
        low=0.1,
        high=1000.0,
    )
    receiver_satellites: int = param(
        6,
        "It is poor with fewer satellites in most fixes of 10 s (the limit of ArduPilot and of "
        "PX4, EKF2_REQ_NSATS).",
        source="PX4, EKF2_REQ_NSATS",
        low=0,
        high=200,
    )
    hold_s: float = param(
        2.0,
        "SUSPICIOUS and ALARM are kept for this long after their last evidence, for the fusion.",
        source="chosen, not swept",
        unit="s",
        low=0.0,
        high=600.0,
    )
    patience_s: float = patience()
    sensor_patience_s: float = sensor_patience()


CLOCK_RATE = "clock_rate"
"""Value: true seconds in one of the stamps' clock, where that is not 1."""
LATER = "later_s"
"""Value: growth of the GPS's latency, where position and velocity would contradict without it."""
BELOW_ALARM = 0.99
"""Largest margin outside of flight. Chosen, not swept."""


class GnssSanityDetector:
    """Largest margin of the checks of one receiver: its stream contradicts itself or its vehicle.

    The verdict is that of the check that claims most, and is kept for `hold_s` after the last
    evidence. Before a take-off and after a crash it is SUSPICIOUS at most: a receiver that settles
    jumps as well. A receiver that is poor by its own word is named in the reason, and its figures
    beyond their limits are among the values (`ReceiverHealth`), and so is the rate of a clock that
    runs wrong (`ClockRateCheck`), and a latency that grew (`LatencySeen`) where it explains what
    would be an alarm; no state follows from any of them.
    """

    NAME = "gnss"
    PARAMETERS = GnssSanityParameters

    def __init__(self, parameters: GnssSanityParameters) -> None:
        """Start without samples."""
        self._parameters = p = parameters
        sensors = dict.fromkeys(("velocity", "satellites", "fix"), p.sensor_patience_s)
        self.inputs: Mapping[str, float] = {"phase": p.patience_s, **sensors}
        self._gate = FlightGate(min_imu_hz=0.0)
        self._track = Track()
        self._set_back = {name: SetBack() for name in ("fix", "velocity")}
        self._watch = InputWatch(("fix",))
        self._latency = LatencySeen()
        self._mismatch = VelocityMismatchCheck(_mismatch_limits(p), self._latency)
        self._receiver = ReceiverHealth(_receiver_limits(p))
        self._rate = ClockRateCheck()
        self._stamps = StampsCheck(p.stamps_alarm, p.stamps_in_s)
        self._lasting = LastingStep(p.jump_lasting_m, p.manoeuvre_m_s2, self._latency)
        self._checks: tuple[Check, ...] = (
            self._stamps,
            PublishersCheck(),
            FreezeCheck(p.freeze_s),
            JumpCheck(
                "jump",
                _jump_limits(p, p.jump_suspicious_m, p.jump_alarm_m),
                self._latency,
                self._lasting,
                vertical=False,
            ),
            JumpCheck(
                "vertical",
                _jump_limits(p, p.vertical_suspicious_m, p.vertical_alarm_m),
                self._latency,
                vertical=True,
            ),
            SpeedCheck(p.max_speed_m_s),
            AccelerationCheck(p.max_acceleration_m_s2),
            self._mismatch,
            SatellitesCheck(p.satellites_at_once, p.satellites_in_5_s),
            CovarianceCheck(p.covariance_in_5_s),
        )
        self._held: dict[State, tuple[int, str]] = {}
        """When SUSPICIOUS and ALARM were last found, and why."""

    def update(self, name: str, sample: GpsSample | PhaseSample) -> Verdict | None:
        """Take the next sample in order of stamp; every fix gives a verdict, and its absence."""
        stamp_ns = sample.stamp_ns
        self._receiver.passes(stamp_ns)
        if isinstance(sample, PhaseSample):
            if self._gate.update(sample):
                self._mismatch.begin()
                self._lasting.take_off()
            return self._lost(stamp_ns)
        if isinstance(sample, FixSample):
            self._watch.see("fix", stamp_ns)
            self._receiver.fix(sample)
            self._rate.fix(sample)
            if not sample.has_fix:
                return self._verdict(stamp_ns, State.NOT_OBSERVABLE, "the receiver has no fix")
            if caught_up := self._set_back["fix"].caught_up(sample.stamp_ns):
                self._track = Track()
                for refused in caught_up:
                    if isinstance(refused, FixSample) and refused.has_fix:
                        self._track.fix(refused)
            step = self._track.fix(sample)
            if step is None:
                return self._verdict(stamp_ns, State.NOT_READY, "only one fix yet")
            return self._judge(step)
        if isinstance(sample, VelocitySample):
            self._track.velocity(sample)
            self._rate.velocity(sample)
        else:
            self._track.satellites(sample)
            self._receiver.satellites(sample)
        return self._lost(stamp_ns)

    def _lost(self, stamp_ns: int) -> Verdict | None:
        """The verdict once a second while no fix comes."""
        lost = self._watch.lost(stamp_ns)
        if lost is None or not self._watch.due(stamp_ns):
            return None
        return self._verdict(stamp_ns, *lost)

    def refused(
        self, name: str, sample: GpsSample, last: GpsSample, before: GpsSample | None
    ) -> None:
        """Note a sample refused for its stamp, see `Stage`; published with the next fix."""
        if name in ("fix", "velocity"):  # a number of satellites has the stamp of its fix
            late = before is not None and before.stamp_ns < sample.stamp_ns < last.stamp_ns
            set_back = self._set_back[name].goes_on(sample, last)
            if name == "fix" and sample.stamp_ns <= last.stamp_ns:
                self._receiver.unclear()
            self._stamps.note(last.stamp_ns, harmless=set_back or late or sample == last)

    def _judge(self, step: Step) -> Verdict:
        self._latency.add(step)
        findings = {check.name: check.judge(step) for check in self._checks}
        name = max(findings, key=lambda one: findings[one].claims)
        worst = findings[name]
        values = {one: finding.margin for one, finding in findings.items()}
        values["velocity_mismatch_limit"] = self._mismatch.part
        reason, later_s = _reason(name, worst), self._mismatch.later_s
        if later_s is not None:
            values[LATER] = later_s
            reason = f"{reason}; {later_words(later_s)}"
        return self._verdict(step.stamp_ns, worst.state, reason, worst.margin, values)

    def _verdict(
        self,
        stamp_ns: int,
        state: State,
        reason: str,
        score: float = 0.0,
        values: dict[str, float] | None = None,
    ) -> Verdict:
        """A verdict, or what is kept."""
        blocked = self._gate.blocked(stamp_ns)
        if blocked is not None and state is State.ALARM:
            state, score, reason = State.SUSPICIOUS, BELOW_ALARM, f"{reason}; {blocked[1]}"
        if state in (State.SUSPICIOUS, State.ALARM):
            self._held[state] = (stamp_ns, reason)
        for kept in (State.ALARM, State.SUSPICIOUS):
            since_ns, why = self._held.get(kept, (None, ""))
            if since_ns is None or _rank(state) >= _rank(kept) or state is State.STALE:
                continue
            ago_s = (stamp_ns - since_ns) / NANOSECONDS
            if ago_s <= self._parameters.hold_s:
                state, reason = kept, f"{why} ({ago_s:.1f} s ago)"
        beside = self._receiver.poor()
        if beside:
            reason = f"{reason}; {POOR}: {poor_words(beside)}"
        if self._rate.rate is not None:
            beside[CLOCK_RATE] = self._rate.rate
            reason = f"{reason}; {clock_words(self._rate.rate)}"
        return Verdict(self.NAME, stamp_ns, state, score, 1.0, reason, {**(values or {}), **beside})


def _rank(state: State) -> int:
    return RANK.index(state) if state in RANK else -1


def _reason(name: str, finding: Finding) -> str:
    if finding.state is State.NORMAL:
        return f"consistent, nearest to its limit is {name} with margin {finding.margin:.2f}"
    return finding.text if finding.innocent else f"{name}: {finding.text}"


def _jump_limits(p: GnssSanityParameters, suspicious_m: float, alarm_m: float) -> JumpLimits:
    return JumpLimits(suspicious_m, alarm_m, p.manoeuvre_m_s2, p.accuracy_gain, p.accuracy_cap_m)


def _receiver_limits(p: GnssSanityParameters) -> ReceiverLimits:
    return ReceiverLimits(
        p.receiver_no_fix_s,
        p.receiver_accuracy_m,
        p.receiver_vertical_accuracy_m,
        p.receiver_satellites,
    )


def _mismatch_limits(p: GnssSanityParameters) -> MismatchLimits:
    return MismatchLimits(
        p.mismatch_base_m,
        p.mismatch_rate_m_s,
        p.mismatch_path_fraction,
        p.mismatch_vertical_base_m,
        p.mismatch_vertical_rate_m_s,
        p.mismatch_persist_s,
        p.mismatch_floor,
        p.mismatch_gain,
    )
