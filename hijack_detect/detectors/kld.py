# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Kullback-Leibler divergence of GPS statistics: Basan et al. 2022, and a hardened variant."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from hijack_detect.detectors.flight_gate import FlightGate
from hijack_detect.detectors.input_watch import InputWatch, SetBack
from hijack_detect.detectors.kld_values import NAMES, Changes, KldParameters, Table2Values, Values
from hijack_detect.detectors.poisson import log_pmf, mixed_divergence
from hijack_detect.detectors.verdict import JUDGED, State, Verdict
from hijack_detect.streams.samples import NANOSECONDS, FixSample, GpsSample, PhaseSample


class Divergence(NamedTuple):
    """Kullback-Leibler divergences between the last window and the one before, nats.

    Attributes:
        forward: Of the last window from the one before (Eqs. 7-12), large when values fall.
        backward: Of the one before from the last (Eq. 13), large when values rise.
    """

    forward: float
    backward: float

    @property
    def total(self) -> float:
        """Their sum, which thresholds are for."""
        return self.forward + self.backward


class Series(Protocol):
    """Takes the counts of one parameter, one by one."""

    def add(self, count: float) -> Divergence | None:
        """Take the next count; None while there are too few."""
        ...


class RowSeries:
    """Eqs. 1-13 of Basan 2022: sums over the probabilities of the values, not normalised.

    P of each value is that of a Poisson distribution whose mean is that of the last n values.
    `forward = Σ P ln(P / P')` over the last n, with P' of the value n before; `backward = Σ P'
    ln(P' / P)`. As the probabilities of a window do not add up to 1, both can be negative (§2.1).
    """

    def __init__(self, length: int) -> None:
        """Start empty; n is `length`."""
        self._length = length
        self._values: deque[float] = deque(maxlen=length)
        self._logs: deque[float] = deque(maxlen=2 * length)

    def add(self, count: float) -> Divergence | None:
        """See Series."""
        self._values.append(count)
        if len(self._values) < self._length:
            return None
        self._logs.append(log_pmf(count, math.fsum(self._values) / self._length))
        if len(self._logs) < 2 * self._length:
            return None
        logs = list(self._logs)
        pairs = list(zip(logs[: self._length], logs[self._length :], strict=True))
        forward = math.fsum(math.exp(now) * (now - before) for before, now in pairs)
        backward = math.fsum(math.exp(before) * (before - now) for before, now in pairs)
        return Divergence(forward, backward)


class DistributionSeries:
    """Divergences of the whole distributions that the means of two windows stand for.

    They are true Kullback-Leibler divergences: never negative, 0 only for equal means. They ask by
    what factor a mean has changed and how much that weighs, so the noise of a bad receiver is
    normal as long as it stays. The distributions are negative binomial: sizes of noise scatter as
    widely as they are large, and under Poisson's law those of a noisy receiver would be changes.
    """

    def __init__(self, length: int, floor: float, shape: float) -> None:
        """Start empty.

        Args:
            length: Counts in a window.
            floor: What is added to every mean.
            shape: k of the negative binomial distributions.
        """
        self._length, self._floor, self._shape = length, floor, shape
        self._values: deque[float] = deque(maxlen=2 * length)

    def add(self, count: float) -> Divergence | None:
        """See Series."""
        self._values.append(count)
        if len(self._values) < 2 * self._length:
            return None
        values = list(self._values)
        before = self._floor + math.fsum(values[: self._length]) / self._length
        now = self._floor + math.fsum(values[self._length :]) / self._length
        return Divergence(
            mixed_divergence(now, before, self._shape), mixed_divergence(before, now, self._shape)
        )


ATTACK, NO_ATTACK = 111, 110
"""The codes of the paper's analyser (§3.3)."""
CODES = {
    State.NORMAL: NO_ATTACK,
    State.SUSPICIOUS: NO_ATTACK,
    State.ALARM: ATTACK,
}
"""Code of each state that judges the GPS; the others have none."""


@dataclass
class _Watched:
    """One parameter of the GPS since its last gap."""

    series: Series
    last_ns: int
    divergence: Divergence | None = None


class KldDetector:
    """Divergence of successive windows of the GPS values: some change their statistics at once.

    Every parameter has a series of counts (`kld_values`), whose last n are compared with the n
    before (`DistributionSeries`). It claims a change when forward and backward divergence together
    exceed its threshold; `quorum` claims at once are an alarm. The score is the margin of the
    parameter that completes the quorum, or, with `together`, what more parameters reach with a
    share each.

    A parameter whose topic is absent is left out, and one that has a gap starts over. It is
    evaluated at every fix.
    """

    NAME = "kld"
    PARAMETERS = KldParameters

    def __init__(self, parameters: KldParameters) -> None:
        """Start with empty windows."""
        self._parameters = p = parameters
        sensors = dict.fromkeys(("velocity", "satellites", "fix"), p.patience_s)
        self.inputs = {"phase": p.phase_patience_s, **sensors}
        self._gate = FlightGate(min_imu_hz=0.0)
        self._set_back = SetBack()
        self._begin()
        self._max_gap_ns = round(p.max_gap_s * NANOSECONDS)
        self._watch = InputWatch(("fix",))
        self._latched: tuple[int, str] | None = None

    def _begin(self) -> None:
        p = self._parameters
        self._values: Values = Changes(p) if p.mode == "hardened" else Table2Values()
        self._watched: dict[str, _Watched] = {}

    def reset(self) -> None:
        """Take a kept alarm back (service `~/reset`)."""
        self._latched = None

    def inherit(self, before: KldDetector) -> None:
        """Keep the alarm of the detector before: a clock that is set back takes none back."""
        self._latched = before._latched

    def update(self, name: str, sample: GpsSample | PhaseSample) -> Verdict | None:
        """Take the next sample in order of stamp; every fix gives a verdict."""
        if isinstance(sample, PhaseSample):
            if self._parameters.mode == "hardened":
                self._gate.update(sample)
            return None
        if isinstance(sample, FixSample) and self._set_back.caught_up(sample.stamp_ns):
            self._begin()
        if isinstance(sample, FixSample) and not sample.has_fix:
            return self._verdict(sample.stamp_ns, State.NOT_OBSERVABLE, "the receiver has no fix")
        self._watch.see(name, sample.stamp_ns)
        for parameter, count in self._values(sample).items():
            self._add(parameter, sample.stamp_ns, count)
        if isinstance(sample, FixSample):
            return self._evaluate(sample.stamp_ns)
        lost = self._watch.lost(sample.stamp_ns)
        if lost is None or not self._watch.due(sample.stamp_ns):
            return None
        return self._verdict(sample.stamp_ns, *lost)

    def refused(
        self, name: str, sample: GpsSample, last: GpsSample, before: GpsSample | None
    ) -> None:
        """Note a sample refused for its stamp, see `Stage`; windows end where a clock is set."""
        if name == "fix":
            self._set_back.goes_on(sample, last)

    def _add(self, parameter: str, stamp_ns: int, count: float | None) -> None:
        """Let a count into its series, which starts over after a gap."""
        watched = self._watched.get(parameter)
        if watched is not None and stamp_ns - watched.last_ns > self._max_gap_ns:
            watched = None
        if count is None:
            self._watched.pop(parameter, None)
            return
        if watched is None:
            watched = self._watched[parameter] = _Watched(self._new_series(), stamp_ns)
        watched.last_ns = stamp_ns
        watched.divergence = watched.series.add(count)

    def _new_series(self) -> Series:
        p = self._parameters
        if p.mode == "hardened":
            return DistributionSeries(p.window, p.floor, p.dispersion)
        return RowSeries(p.window)

    def _evaluate(self, stamp_ns: int) -> Verdict:
        p = self._parameters
        current = {
            name: watched.divergence
            for name in NAMES
            if (watched := self._watched.get(name)) is not None
            and watched.divergence is not None
            and stamp_ns - watched.last_ns <= self._max_gap_ns
        }
        if len(current) < p.quorum:
            reason = f"{len(current)} parameters with full windows, {p.quorum} are needed"
            return self._verdict(stamp_ns, State.NOT_READY, reason)
        margins = {name: found.total / p.threshold(name) for name, found in current.items()}
        ranked = sorted(margins, key=lambda name: -margins[name])
        shared = {
            count: margins[ranked[count - 1]] * count / p.quorum
            for count in range(p.quorum, min(p.quorum * p.together, len(ranked)) + 1)
        }
        count = max(shared, key=lambda number: shared[number])
        score = max(shared[count], 0.0)
        claims = [name for name in ranked if margins[name] > 1.0]
        alarm = score > 1.0
        decisive = ", ".join(
            f"{name} by {current[name].total:.3g} nat (limit {p.threshold(name):g})"
            for name in (ranked[:count] if alarm else claims or ranked[:1])
        )
        what = (
            "The GPS values have changed their statistics" if alarm or claims else "largest change"
        )
        reason = f"{what}: {decisive}"
        state = State.ALARM if alarm else State.NORMAL
        if claims and not alarm:
            state, reason = State.SUSPICIOUS, f"{reason}; {p.quorum} parameters are needed"
        values = {"divergence": current[ranked[count - 1]].total, "claims": float(len(claims))}
        for name, found in current.items():
            values[f"{name}.forward"], values[f"{name}.backward"] = found
        return self._verdict(stamp_ns, state, reason, score, values)

    def _verdict(
        self,
        stamp_ns: int,
        state: State,
        reason: str,
        score: float = 0.0,
        values: dict[str, float] | None = None,
    ) -> Verdict:
        """A verdict, or the alarm that is kept; on the ground a receiver may settle."""
        blocked = self._gate.blocked(stamp_ns) if state in JUDGED else None
        if blocked is not None:
            (state, reason), score = blocked, 0.0
        if state is State.ALARM and self._latched is None and self._parameters.latched:
            self._latched = (stamp_ns, reason)
        if self._latched is not None and state is not State.ALARM:
            since_ns, first = self._latched
            reason = f"kept for {(stamp_ns - since_ns) / NANOSECONDS:.1f} s: {first}"
            state = State.ALARM
        return Verdict(self.NAME, stamp_ns, state, score, 1.0, reason, values or {})
