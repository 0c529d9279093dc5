# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Bounded summary of all outputs of the monitor over a flight."""

from __future__ import annotations

import math
import re
import sys
from array import array
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field
from typing import Any

from hijack_detect.analysis.alarms import AlertSpan, AlertSpans, Span, StateSpans, Times
from hijack_detect.analysis.log_clock import LogClock
from hijack_detect.detectors.coast import CoastDetector
from hijack_detect.detectors.flight_gate import imu_trouble
from hijack_detect.detectors.fusion import Fusion, FusionResult
from hijack_detect.detectors.gnss_sanity import CLOCK_RATE, GnssSanityDetector
from hijack_detect.detectors.likelihood import FusionParameters
from hijack_detect.detectors.verdict import JUDGED, RAISED, Verdict
from hijack_detect.estimation.lag_ekf import LATE_FIGURES, late_words
from hijack_detect.estimation.receiver_health import POOR_FIGURES, SATELLITES, poor_words
from hijack_detect.monitor.graph import Stage
from hijack_detect.monitor.parts import weights
from hijack_detect.streams.samples import (
    NANOSECONDS,
    FixSample,
    ImuSample,
    MagneticSample,
    PhaseSample,
    PressureSample,
    Sample,
    SatelliteSample,
    VelocitySample,
)
from hijack_detect.streams.silence import SILENCE_S

NAMES: dict[type, str] = {
    ImuSample: "imu",
    FixSample: "fix",
    VelocitySample: "velocity",
    SatelliteSample: "satellites",
    MagneticSample: "mag",
    PressureSample: "pressure",
}
NEEDED = frozenset({"imu", "fix"})
"""Inputs without which nothing can be judged."""
STUCK = 0.9
"""Share of stamps that repeat the one before from which on an input has no usable stamps. Chosen,
not swept."""
JUMP_NS = round(SILENCE_S * NANOSECONDS)
"""A step of the stamps that the order of inputs takes for an outage or a clock that was set."""
LIGHT, HEAVY = 6.9, 29.4
"""m/s²: mean magnitudes of the specific force of no flight. Accelerations cancel out, so gravity
remains (0.7 of it: no flight falls for long), and vibration adds to it: 3 g is 16 m/s² an axis."""


@dataclass
class Stamps:
    """Notes on the stamps of one input, nanoseconds.

    `set_back` is the largest step back, `ahead` the sum of all steps of more than JUMP_NS.
    """

    count: int = 0
    first: int = 0
    last: int = 0
    repeated: int = 0
    set_back: int = 0
    ahead: int = 0

    def add(self, stamp_ns: int) -> None:
        """Take the next stamp."""
        if self.count:
            step = stamp_ns - self.last
            if step == 0:
                self.repeated += 1
            elif step > JUMP_NS:
                self.ahead += step
            elif -step > self.set_back:
                self.set_back = -step
        else:
            self.first = stamp_ns
        self.count += 1
        self.last = stamp_ns

    @property
    def stuck(self) -> bool:
        """Whether the stamps do not advance."""
        return self.count > 1 and self.repeated >= STUCK * (self.count - 1)


@dataclass
class Inputs:
    """Notes of all samples; `forces` is the sum of the magnitudes of the specific force, m/s²."""

    stamps: dict[str, Stamps] = field(default_factory=dict)
    fixes: int = 0
    forces: float = 0.0

    def add(self, sample: Sample) -> None:
        """Take the next sample."""
        name = NAMES.get(type(sample))
        if name is None:
            return
        stamps = self.stamps.get(name)
        if stamps is None:
            stamps = self.stamps[name] = Stamps()
        stamps.add(sample.stamp_ns)
        if isinstance(sample, ImuSample):
            self.forces += math.hypot(*sample.specific_force)
        elif isinstance(sample, FixSample):
            self.fixes += sample.has_fix

    def count(self, name: str) -> int:
        """Number of samples of an input."""
        return self.stamps[name].count if name in self.stamps else 0

    def unusable(self) -> str:
        """Reason why nothing can be judged with these inputs; empty if that is not known."""
        stuck = [name for name, one in self.stamps.items() if one.stuck]
        if NEEDED & {*stuck}:
            zero = "" if any(self.stamps[name].last for name in stuck) else ": all are 0"
            return f"the header stamps of {_list(sorted(stuck))} do not advance{zero}"
        if not self.count("fix"):
            return "there is no position of the GPS"
        if not self.fixes:
            return f"no usable fix in {self.count('fix')} messages of the receiver"
        if not self.count("imu"):
            return "there is no IMU"
        mean = self.forces / self.count("imu")
        if not LIGHT < mean < HEAVY:
            return (
                f"the accelerometer reads {mean:.3g} m/s² on average, where a vehicle feels "
                "9.8 m/s²: wrong unit or scale"
            )
        return ""

    def notes(self, duration_s: float) -> Iterator[str]:
        """Notes on the stamps, a sentence each.

        Args:
            duration_s: From the first to the last message by log time: a clock that was set
                forward looks like an outage, but that its stamps span more than the log does.
        """
        back = {name: one.set_back / 1e9 for name, one in self.stamps.items() if not one.stuck}
        set_back = sorted(name for name, seconds in back.items() if seconds > SILENCE_S)
        if set_back:
            most = max(back[name] for name in set_back)
            yield f"The header stamps of {_list(set_back)} were set back by {most:.1f} s."
        longer = {
            name: (one.last - one.first) / NANOSECONDS - duration_s
            for name, one in self.stamps.items()
            if one.ahead
        }
        ahead = sorted(name for name, seconds in longer.items() if seconds > SILENCE_S)
        if ahead:
            most = max(longer[name] for name in ahead)
            yield f"The header stamps of {_list(ahead)} jumped ahead by {most:.1f} s."
        stuck = sorted(name for name, one in self.stamps.items() if one.stuck)
        if stuck and not NEEDED & {*stuck}:  # else it is why nothing could be judged
            yield f"The header stamps of {_list(stuck)} do not advance."


def _list(names: list[str]) -> str:
    """Names in words."""
    return " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))


MONITOR = "monitor"
"""Name of the fusion's spans."""
FUSION = "fusion"
PHASE = "phase"
VISIBLE = "smallest_visible"
FIGURES = re.compile(r"[\d.]+")


class TakenBack:
    """The fusion, with its alert taken back once the causes have been quiet.

    It publishes what a vehicle receives whose pilot calls `fusion/reset` when no cause of the
    alert has been SUSPICIOUS or in ALARM for `together_s`, while a margin supports an
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
    """Time in which verdicts had figures beyond their limits, and the worst of them.

    Attributes:
        lasted_ns: Nanoseconds for which they had.
    """

    def __init__(
        self, figures: frozenset[str], words: Callable[[Mapping[str, float]], str], stale_ns: int
    ) -> None:
        """Start without a verdict.

        Args:
            figures: Names of the values, of which a verdict has those beyond their limits.
            words: Text of them.
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
    """Times in which each thing could be judged.

    Attributes:
        in_air: The vehicle was in the air.
        told: Each detector could tell, in the air or not.
        alertable: A detector could tell whose alarm makes an alert.
        carry_off: One could tell that could see a carry-off and is asked by the policy.
        visible: Start, end (ns) and smallest visible acceleration (m/s²) of each verdict of
            `coast` that could tell.
    """

    in_air: Times
    judged: dict[str, Times]
    alertable: Times
    carry_off: Times
    visible: list[tuple[int, int, float]]

    def within(self, start_ns: int, end_ns: int) -> Watched:
        """The part of it from one stamp to another, nanoseconds."""
        whole = Times([(start_ns, end_ns)])
        return Watched(
            self.in_air & whole,
            {name: times & whole for name, times in self.judged.items()},
            self.alertable & whole,
            self.carry_off & whole,
            self.visible,
        )

    def seen(self, acceleration: float) -> Times:
        """Times in which `coast` claimed to see an offset acceleration (m/s²), in the air."""
        return self.in_air & Times((a, b) for a, b, least in self.visible if least <= acceleration)


class Account:
    """Account of a monitor's states, alerts, phases and largest margins.

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

    def take_output(self, part: str, output: Any) -> None:
        """Take an output of a part of the monitor."""
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
                judged = output.state in JUDGED and VISIBLE in output.values
                self._visible_ns.append(output.stamp_ns)
                self._visible.append(output.values[VISIBLE] if judged else float("inf"))

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
        judged = {
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
            judged=judged,
            alertable=union(judged, {name for name, one in asked.items() if one.may_alert}),
            carry_off=union(judged, {name for name, one in asked.items() if one.sees_carry_off}),
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


def union(judged: Mapping[str, Times], names: Set[str]) -> Times:
    """The times in which at least one of the named detectors could tell."""
    return Times(one for name in sorted(names & judged.keys()) for one in judged[name].intervals)
