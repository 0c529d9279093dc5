# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Consistency of a receiver stream with itself: jumps, freezes, impossible motion, stamps."""

from __future__ import annotations

from collections.abc import Mapping

from hijack_detect.detectors.flight_gate import FlightGate
from hijack_detect.detectors.gnss_checks.acceleration import AccelerationCheck
from hijack_detect.detectors.gnss_checks.freeze import FreezeCheck
from hijack_detect.detectors.gnss_checks.jump import JumpCheck, JumpLimits
from hijack_detect.detectors.gnss_checks.lasting_step import LastingStep
from hijack_detect.detectors.gnss_checks.latency import LatencySeen, later_words
from hijack_detect.detectors.gnss_checks.publishers import PublishersCheck
from hijack_detect.detectors.gnss_checks.speed import SpeedCheck
from hijack_detect.detectors.gnss_checks.stamps import StampsCheck
from hijack_detect.detectors.gnss_checks.step import RANK, Check, Finding, Step
from hijack_detect.detectors.gnss_checks.track import Track
from hijack_detect.detectors.gnss_checks.variation import CovarianceCheck, SatellitesCheck
from hijack_detect.detectors.gnss_checks.velocity_mismatch import (
    MismatchLimits,
    VelocityMismatchCheck,
)
from hijack_detect.detectors.gnss_sanity_parameters import GnssSanityParameters
from hijack_detect.detectors.input_watch import InputWatch
from hijack_detect.detectors.set_back import SetBack
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.estimation.clock_rate import ClockRateCheck, clock_words
from hijack_detect.estimation.receiver_health import (
    POOR,
    ReceiverHealth,
    ReceiverLimits,
    poor_words,
)
from hijack_detect.streams.samples import (
    NANOSECONDS,
    FixSample,
    GpsSample,
    PhaseSample,
    VelocitySample,
)

CLOCK_RATE = "clock_rate"
"""Value: true seconds in one of the stamps' clock, where that is not 1."""
LATER = "later_s"
"""Value: growth of the GPS's latency, where position and velocity would contradict without it."""
BELOW_ALARM = 0.99
"""Largest margin outside of flight."""


class GnssSanityDetector:
    """Runs every check at every fix; the verdict is that of the one that claims most.

    The score is its margin. What a check claims is kept for `hold_s` after its last evidence.
    Before a take-off and after a crash it is SUSPICIOUS at most: a receiver that settles jumps as
    well. A receiver that is poor by its own word is named in the reason, and its figures beyond
    their limits are among the values (`ReceiverHealth`), and so is the rate of a clock that runs
    wrong (`ClockRateCheck`), and a latency that grew (`LatencySeen`) where it explains what would
    be an alarm; no state follows from any of them.
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
        """What is said once a second while no fix comes."""
        lost = self._watch.lost(stamp_ns)
        if lost is None or not self._watch.due(stamp_ns):
            return None
        return self._verdict(stamp_ns, *lost)

    def refused(
        self, name: str, sample: GpsSample, last: GpsSample, before: GpsSample | None
    ) -> None:
        """Note a sample refused for its stamp, see `Stage`; said with the next fix."""
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
