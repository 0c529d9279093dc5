# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What an analysis keeps of all that is published about a flight, however long that is."""

from __future__ import annotations

import re
import sys
from array import array
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass
from typing import Any

from hijack_detect.analysis.alarms import AlertSpan, AlertSpans, Span, StateSpans
from hijack_detect.analysis.inputs import Inputs
from hijack_detect.analysis.log_clock import LogClock
from hijack_detect.analysis.times import Times
from hijack_detect.detectors.coast import CoastDetector
from hijack_detect.detectors.flight_gate import imu_trouble
from hijack_detect.detectors.fusion import Fusion, FusionResult
from hijack_detect.detectors.fusion_parameters import FusionParameters
from hijack_detect.detectors.gnss_sanity import CLOCK_RATE, GnssSanityDetector
from hijack_detect.detectors.verdict import JUDGED, RAISED, Verdict
from hijack_detect.estimation.gps_lag import LATE_FIGURES, late_words
from hijack_detect.estimation.receiver_health import POOR_FIGURES, SATELLITES, poor_words
from hijack_detect.monitor.parts import weights
from hijack_detect.monitor.stage import Stage
from hijack_detect.streams.samples import NANOSECONDS, PhaseSample, Sample

MONITOR = "monitor"
"""Name of the fusion's spans."""
FUSION = "fusion"
PHASE = "phase"
VISIBLE = "smallest_visible"
FIGURES = re.compile(r"[\d.]+")


class TakenBack:
    """The fusion, with its alert taken back once the causes have been quiet.

    It publishes what a vehicle would receive whose pilot calls `fusion/reset` when no cause of the
    alert has been SUSPICIOUS or in ALARM for `together_s`, as long as a margin speaks for an
    alert. So each of its alerts is one event.
    """

    def __init__(self, parameters: FusionParameters) -> None:
        """Start without an alert."""
        self._weights = weights(parameters)
        self._fusion = Fusion(parameters, self._weights)
        self._quiet_ns = round(parameters.together_s * NANOSECONDS)
        self._raised_ns = 0

    @property
    def inputs(self) -> Mapping[str, float]:
        """See Component."""
        return self._fusion.inputs

    def update(self, name: str, sample: Any) -> FusionResult:
        """Take what the fusion takes, in order of stamp."""
        result: FusionResult = self._fusion.update(name, sample)
        if not result.alert:
            return result
        started = result.alert_since_ns == result.stamp_ns
        raised = any(
            one.state in RAISED
            for name, one in result.detectors.items()
            if name in result.causes and not self._weights[name].keeps_alarm
        )
        if started or raised:
            self._raised_ns = result.stamp_ns
        elif result.stamp_ns - self._raised_ns >= self._quiet_ns:
            self._fusion.reset()
        return result


class Complaint:
    """How long verdicts had figures beyond their limits, and the worst of them meanwhile.

    Attributes:
        lasted_ns: Nanoseconds for which they had.
    """

    def __init__(
        self, figures: frozenset[str], words: Callable[[Mapping[str, float]], str], stale_ns: int
    ) -> None:
        """Start without a verdict.

        Args:
            figures: Names of the values, of which a verdict has those beyond their limits.
            words: Says them.
            stale_ns: For how long a verdict holds at most, nanoseconds.
        """
        self._figures, self._words, self._stale_ns = figures, words, stale_ns
        self._since_ns: int | None = None
        self._worst: dict[str, float] = {}
        self.lasted_ns = 0

    def add(self, verdict: Verdict) -> None:
        """Take the next verdict of the detector that has them."""
        self.finish(verdict.stamp_ns)
        found = {name: verdict.values[name] for name in self._figures & verdict.values.keys()}
        for name, value in found.items():
            worse = min if name == SATELLITES else max
            self._worst[name] = worse(value, self._worst.get(name, value))
        self._since_ns = verdict.stamp_ns if found else None

    def finish(self, end_ns: int) -> None:
        """Count until a stamp."""
        if self._since_ns is not None:
            self.lasted_ns += max(0, min(end_ns - self._since_ns, self._stale_ns))
        self._since_ns = None

    @property
    def words(self) -> str:
        """The worst figures, empty if there were none."""
        return self._words(self._worst)


@dataclass(frozen=True)
class Watched:
    """When what could be judged.

    Attributes:
        in_air: The vehicle was in the air.
        told: Each detector could tell, in the air or not.
        alertable: A detector could tell whose alarm makes an alert.
        carry_off: One could tell that could see a carry-off and is asked by the policy.
        visible: Start, end (ns) and smallest visible acceleration (m/s²) of each verdict of
            `coast` that could tell.
    """

    in_air: Times
    told: dict[str, Times]
    alertable: Times
    carry_off: Times
    visible: list[tuple[int, int, float]]

    def within(self, start_ns: int, end_ns: int) -> Watched:
        """The part of it from one stamp to another, nanoseconds."""
        whole = Times([(start_ns, end_ns)])
        return Watched(
            self.in_air & whole,
            {name: times & whole for name, times in self.told.items()},
            self.alertable & whole,
            self.carry_off & whole,
            self.visible,
        )

    def seen(self, acceleration: float) -> Times:
        """When `coast` claimed to see an offset acceleration (m/s²), in the air."""
        return self.in_air & Times((a, b) for a, b, least in self.visible if least <= acceleration)


class Account:
    """Listens to a monitor and keeps states, alerts, phases and the largest margins.

    Attributes:
        weights: What the fusion makes of each detector that it subscribes to.
        inputs: What was noted of the samples.
        peaks: The verdict with the largest margin of each detector that could ever tell.
        newest_ns: Stamp of the fusion's last result, nanoseconds; 0 before the first.
        phases: Nanoseconds in each phase, by phase and reason.
        imu_faults: First words and nanoseconds of each fault of the IMU, by its words without
            figures.
        clock_rate: True seconds in one of the stamps' clock, None unless it is known to be wrong.
        poor: For how long the receiver was poor by its own word, and how much so.
        late: The same of a GPS that is late.
    """

    def __init__(
        self,
        detectors: Sequence[str],
        fusion: FusionParameters,
        start_ns: int,
        clock: LogClock | None = None,
    ) -> None:
        """Begin a flight.

        Args:
            detectors: Names of the parts that give verdicts.
            fusion: Parameters of the fusion.
            start_ns: Where the flight begins, nanoseconds.
            clock: Where stamps belong, None if they are as they should be.
        """
        self._clock = clock
        self._fusion, self.weights = fusion, weights(fusion)
        self._stale_ns = round(fusion.stale_s * NANOSECONDS)
        self._spans = {name: StateSpans(start_ns, self._stale_ns) for name in (MONITOR, *detectors)}
        self._alerts, self._alarms = AlertSpans(), AlertSpans()
        self._again = Stage(lambda: TakenBack(fusion))
        self._air: list[tuple[int, int]] = []
        self._phase: PhaseSample | None = None
        self._visible_ns, self._visible = array("q"), array("d")
        self.inputs = Inputs()
        self.peaks: dict[str, Verdict] = {}
        self.newest_ns = 0
        self.phases: dict[tuple[str, str], int] = defaultdict(int)
        self.imu_faults: dict[str, tuple[str, int]] = {}
        self.poor = Complaint(POOR_FIGURES, poor_words, self._stale_ns)
        self.late = Complaint(LATE_FIGURES, late_words, self._stale_ns)
        self.clock_rate: float | None = None

    def take(self, sample: Sample) -> None:
        """Take a sample that the monitor is given."""
        self.inputs.add(sample)

    def hear(self, part: str, output: Any) -> None:
        """Take what a part of the monitor puts out."""
        own, output = output, self._placed(output)
        if part == FUSION:
            self._spans[MONITOR].add(output)
            self._alerts.add(output)
            self.newest_ns = output.stamp_ns
            return
        if part in self._again.component.inputs:
            for result in self._again.push_all(part, [own]):
                self._alarms.add(self._placed(result))
        if part == PHASE:
            self._close_phase(output.stamp_ns)
            self._phase = output
        elif part in self._spans:
            self._spans[part].add(output)
            if part == GnssSanityDetector.NAME:
                self.poor.add(output)
                self.clock_rate = output.values.get(CLOCK_RATE, self.clock_rate)
            peak = self.peaks.get(part)
            if output.state in JUDGED and (peak is None or output.margin > peak.margin):
                self.peaks[part] = output
            if part == CoastDetector.NAME:
                self.late.add(output)
                told = output.state in JUDGED and VISIBLE in output.values
                self._visible_ns.append(output.stamp_ns)
                self._visible.append(output.values[VISIBLE] if told else float("inf"))

    def _placed(self, output: Any) -> Any:
        return output if self._clock is None else self._clock.placed(output)

    def _close_phase(self, stamp_ns: int) -> None:
        """Account the phase that holds until a stamp, or until it is stale."""
        last = self._phase
        if last is None:
            return
        end_ns = min(stamp_ns, last.stamp_ns + self._stale_ns)
        lasted = max(end_ns - last.stamp_ns, 0)
        if last.phase.airborne:
            self._air.append((last.stamp_ns, end_ns))
        self.phases[last.phase.value, last.reason] += lasted
        trouble = imu_trouble(last) if last.imu_rate_hz else last.imu_fault
        if trouble:
            kind = FIGURES.sub("", trouble)
            words, before = self.imu_faults.get(kind, (trouble, 0))
            self.imu_faults[kind] = words, before + lasted

    def finish(self, end_ns: int) -> tuple[dict[str, list[Span]], Watched]:
        """States of the fusion (under `MONITOR`) and of each detector, and when what could tell.

        Args:
            end_ns: Where the flight ends, nanoseconds.
        """
        self._close_phase(end_ns)
        self._phase = None
        self.poor.finish(end_ns)
        self.late.finish(end_ns)
        spans = {name: one.finish(end_ns) for name, one in self._spans.items()}
        told = {
            name: Times((one.start_ns, one.end_ns) for one in own if one.state in JUDGED)
            for name, own in spans.items()
            if name != MONITOR
        }
        asked = {
            name: weight
            for name, weight in self.weights.items()
            if weight.published or self._fusion.policy != "paper"
        }
        return spans, Watched(
            in_air=Times(self._air),
            told=told,
            alertable=union(told, {name for name, one in asked.items() if one.may_alert}),
            carry_off=union(told, {name for name, one in asked.items() if one.sees_carry_off}),
            visible=list(self._visible_spans(end_ns)) if CoastDetector.NAME in asked else [],
        )

    def _visible_spans(self, end_ns: int) -> list[tuple[int, int, float]]:
        ends = [*self._visible_ns, end_ns][1:]
        return [
            (start, min(end, start + self._stale_ns), least)
            for start, end, least in zip(self._visible_ns, ends, self._visible, strict=True)
            if least < sys.float_info.max
        ]

    def alerts(self, end_ns: int) -> list[AlertSpan]:
        """All alerts until a flight's end, nanoseconds. One is latched: it lasts to the end."""
        return self._alerts.finish(end_ns)

    def alarms(self, end_ns: int) -> list[AlertSpan]:
        """All alerts of a fusion whose alert is taken back, see `TakenBack`."""
        return self._alarms.finish(end_ns)


def union(told: Mapping[str, Times], names: Set[str]) -> Times:
    """The times in which at least one of the named detectors could tell."""
    return Times(one for name in sorted(names & told.keys()) for one in told[name].intervals)
