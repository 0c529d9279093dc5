# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""GPS height against the barometer, and against the vertical inertial channel."""

from __future__ import annotations

from hijack_detect.detectors.altitude_parameters import AltitudeParameters
from hijack_detect.detectors.barometer_check import FREEZE_MARGIN, BarometerCheck, Finding
from hijack_detect.detectors.flight_gate import FlightGate
from hijack_detect.detectors.input_watch import InputWatch
from hijack_detect.detectors.persistence import Persistence
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.detectors.vertical_channel import VerticalChannel
from hijack_detect.estimation.rotation import up_component
from hijack_detect.streams.samples import (
    NANOSECONDS,
    AttitudeSample,
    FixSample,
    PhaseSample,
    PressureSample,
    VelocitySample,
)

SAME_NS = NANOSECONDS // 20
"""A velocity belongs to a fix if their stamps are this close. Chosen, not swept."""
RAMP_S = 10.0
"""`smallest_ramp` is the slowest that is seen within this time, s. Chosen, not swept."""
INERTIAL_ONLY = "no barometer, inertial check alone"


class AltitudeDetector:
    """Judges every fix by the barometer, if there is one, and by the accelerometer.

    The score is the larger margin of the two; each is in `values`, and so is the smallest step
    and ramp of the height that the barometer would show now. A barometer that never came is
    normal. One that stops is STALE, as is any other input that was there and stops, unless the
    check that is left alarms. On the ground, in a hand and after a crash nothing is judged; an IMU
    that cannot be used ends the inertial check alone.
    """

    NAME = "altitude"
    PARAMETERS = AltitudeParameters

    def __init__(self, parameters: AltitudeParameters) -> None:
        """Start without history."""
        self._parameters = p = parameters
        self.inputs = {
            "phase": p.patience_s,
            "attitude": p.patience_s,
            "pressure": p.sensor_patience_s,
            "velocity": p.sensor_patience_s,
            "fix": p.sensor_patience_s,
        }
        self._barometer = BarometerCheck(p)
        self._channel = VerticalChannel(p)
        self._persistence = Persistence(p.persist_s)
        self._required = InputWatch(("fix",))
        self._watches: dict[str, InputWatch] = {}
        """Of the inputs that may be absent, by name, once they are there."""
        self._velocity: VelocitySample | None = None
        self._gate, self._imu_gate = FlightGate(min_imu_hz=0.0), FlightGate()
        self._airborne = True

    def update(
        self,
        name: str,
        sample: AttitudeSample | PressureSample | VelocitySample | FixSample | PhaseSample,
    ) -> Verdict | None:
        """Take the next sample in order of stamp; every fix gives a verdict."""
        stamp = sample.stamp_ns
        if isinstance(sample, PhaseSample):
            self._gate.update(sample)
            self._imu_gate.update(sample)
            return None
        if isinstance(sample, FixSample):
            if sample.has_fix:
                self._required.see("fix", stamp)
                return self._evaluate(sample)
        elif isinstance(sample, VelocitySample):
            self._seen("velocity", stamp)
            self._velocity = sample
        elif isinstance(sample, PressureSample):
            self._seen("pressure", stamp)
            self._barometer.pressure(sample)
        else:
            self._seen("attitude", stamp)
            self._channel.attitude(sample)
            if upside_down(sample):
                self._barometer.restart()
        return self._silence(stamp) if self._required.due(stamp) else None

    def _seen(self, name: str, stamp_ns: int) -> None:
        watch = self._watches.get(name)
        if watch is None:
            watch = self._watches[name] = InputWatch((name,))
        watch.see(name, stamp_ns)

    def _silence(self, stamp_ns: int) -> Verdict:
        lost = self._required.lost(stamp_ns)
        assert lost is not None
        return self._cannot(stamp_ns, lost[0], lost[1], {})

    def _evaluate(self, fix: FixSample) -> Verdict:
        stamp = fix.stamp_ns
        if not fix.has_altitude:
            return self._cannot(stamp, State.NOT_OBSERVABLE, "no GPS height", {})
        velocity = self._velocity
        if velocity is not None and abs(velocity.stamp_ns - stamp) > SAME_NS:
            velocity = None
        blocked = self._gate.blocked(stamp)
        if blocked is None and not self._airborne:
            self._channel.forget()
        self._airborne = blocked is None
        inertial = self._channel.fix(fix, velocity)
        if self._imu_gate.blocked(stamp) is not None:
            inertial = None
        suspicious = inertial is not None and inertial.margin >= FREEZE_MARGIN
        barometric = self._barometer.fix(fix, velocity, airborne=self._airborne, frozen=suspicious)
        values = self._values(barometric, inertial)
        if blocked is not None:
            return self._cannot(stamp, *blocked, values)
        if self._barometer.settles:
            return self._cannot(stamp, State.NOT_READY, self._barometer.why, values)
        lost = self._lost(stamp)
        findings = [one for one in (barometric, inertial) if one is not None]
        margin = max((one.margin for one in findings), default=0.0)
        if lost is not None and margin < 1.0:
            return self._cannot(stamp, State.STALE, lost, values)
        if not findings:
            return self._undecided(stamp, values)
        return self._judge(stamp, barometric, inertial, values)

    def _lost(self, stamp_ns: int) -> str | None:
        """What was there and has stopped."""
        for watch in self._watches.values():
            lost = watch.lost(stamp_ns)
            if lost is not None:
                return lost[1]
        return None

    def _values(self, barometric: Finding | None, inertial: Finding | None) -> dict[str, float]:
        values: dict[str, float] = {}
        if self._barometer.difference is not None:
            values["difference"] = self._barometer.difference
        if barometric is not None:
            values["barometer_margin"] = barometric.margin
            values["barometer_limit"] = self._barometer.part
            values["height_sigma"] = self._barometer.sigma
            values["smallest_step"] = self._barometer.smallest(1.0)
            values["smallest_ramp"] = self._barometer.smallest(RAMP_S) / RAMP_S
        if inertial is not None:
            values["inertial_margin"] = inertial.margin
            values["vertical_bias"] = self._channel.bias
            values["noise_scale"] = self._channel.scale
        return values

    def _undecided(self, stamp_ns: int, values: dict[str, float]) -> Verdict:
        if "pressure" in self._watches:
            return self._cannot(stamp_ns, State.NOT_READY, self._barometer.why, values)
        imu = self._imu_gate.blocked(stamp_ns)
        why = self._channel.why if imu is None else imu[1]
        state = State.NOT_OBSERVABLE
        if imu is None and ("attitude" not in self._watches or self._channel.learning):
            state = State.NOT_READY
        return self._cannot(stamp_ns, state, f"no barometer, {why}", values)

    def _cannot(
        self, stamp_ns: int, state: State, reason: str, values: dict[str, float]
    ) -> Verdict:
        self._persistence.reset()
        return Verdict(self.NAME, stamp_ns, state, 0.0, 1.0, reason, values)

    def _judge(
        self,
        stamp_ns: int,
        barometric: Finding | None,
        inertial: Finding | None,
        values: dict[str, float],
    ) -> Verdict:
        decides = barometric
        if decides is None or (inertial is not None and inertial.margin > decides.margin):
            decides = inertial
        assert decides is not None
        state = self._persistence.state(stamp_ns, decides.margin >= 1.0)
        reason = decides.text
        if "pressure" not in self._watches:
            reason += f"; {INERTIAL_ONLY}"
        return Verdict(self.NAME, stamp_ns, state, decides.margin, 1.0, reason, values)


def upside_down(sample: AttitudeSample) -> bool:
    """Whether the antenna looks down, by the attitude and by the specific force alone.

    The attitude may be wrong after an attack, and a vibrating accelerometer for a sample.
    """
    q = sample.orientation
    return q is not None and up_component(q) < 0.0 and sample.specific_force[2] < 0.0
