# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Verdict of each method on one flight, and whether it was right.

The methods are the detectors by name, the naive comparison `ins_position`, `both` (alarm once
correlation and DATE have both alarmed, Feng 2018, §5) and `fusion`, the monitor's own alert. A
detector that the monitor gains is a method without further ado.
"""

from __future__ import annotations

import dataclasses
import enum
import heapq
import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hijack_detect.detectors.fusion import Fusion, FusionResult
from hijack_detect.detectors.ins_position import InsPosition
from hijack_detect.detectors.kld import KldDetector
from hijack_detect.detectors.likelihood import FusionParameters
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.evaluation.scores.model import Model
from hijack_detect.evaluation.trials.cases import CaseRun
from hijack_detect.monitor.parts import DETECTORS, PUBLISHED, WEIGHTS, own_part
from hijack_detect.monitor.policies import MonitorParameters, policy_parameters
from hijack_detect.replay.offline import OfflineRun
from hijack_detect.replay.truth import Attack, alert_is_right
from hijack_detect.streams.samples import NANOSECONDS

BASELINE = own_part(InsPosition)
"""A method to compare with that no node runs."""
PUBLISHED_KLD = dataclasses.replace(own_part(KldDetector), name="kld_faithful")
"""The published KLD beside the hardened one, for Basan's experiment."""
PAPER = FusionParameters(policy="paper")
"""Parameters of the method `both`."""


class Judgement(enum.Enum):
    """Judgement of a method on one flight."""

    QUIET = "quiet"
    """Clean flight, no alarm: correct."""
    FALSE_ALARM = "false alarm"
    """Clean flight, alarm."""
    DETECTED = "detected"
    """Hijacked flight, first alarm in the attack: correct."""
    EARLY = "early"
    """Hijacked flight, first alarm before the onset: the drone has landed by then (§5)."""
    LATE = "late"
    """Hijacked flight, first alarm after the attack."""
    MISSED = "missed"
    """Hijacked flight, no alarm."""

    @property
    def correct(self) -> bool:
        """Whether the flight counts as correct."""
        return self in (Judgement.QUIET, Judgement.DETECTED)


class MethodOutcome(Model):
    """Outcome of one method on one flight; times in seconds from the flight's first message.

    Attributes:
        judgement: What it achieved.
        first_alarm_s: First alarm, None if there was none.
        alarms: First and last alarming verdict of every episode of alarms.
        false_alarms: Episodes that began in clean time.
        time_to_detect_s: From onset to first alarm, if detected.
        deviation_m: Distance between true and reported position at the first alarm, if detected
            and if the true position is known.
        score: For the ROC: the largest margin of the clean flight, or within the attack.
        found_s: From onset to the first alarm that began inside the attack, as if a pilot had
            taken back every alarm before. It shows what a method sees of an attack on a flight
            on which it had been wrong already; None for nothing.
        claimed: Share of the verdicts within the attack whose score is above the threshold, kept
            alarms apart: how long a method goes on seeing an attack. None without an attack, and
            for `both` and `fusion`.
    """

    judgement: Judgement
    first_alarm_s: float | None
    alarms: tuple[tuple[float, float], ...]
    false_alarms: int
    time_to_detect_s: float | None
    deviation_m: float | None
    score: float
    found_s: float | None = None
    claimed: float | None = None


@dataclass(frozen=True)
class Trace:
    """All verdicts of a method on a flight.

    Attributes:
        stamps_ns: Stamps in order, nanoseconds.
        alarms: Whether it alarmed.
        margins: Score over threshold, or another number that grows with suspicion.
        thresholded: Whether margins above 1 are claims.
    """

    stamps_ns: npt.NDArray[np.int64]
    alarms: npt.NDArray[np.bool_]
    margins: npt.NDArray[np.float64]
    thresholded: bool


def judge_case(
    case: CaseRun, parameters: FusionParameters | None = None
) -> dict[str, MethodOutcome]:
    """Judge every method on a flight, see `judge` and `traces`.

    The score of `both` is the smaller one of its two methods' scores: at a common threshold of
    their margins, both alarm exactly below it.

    Args:
        case: The flight.
        parameters: Those of the fusion that ran.
    """
    outcomes = {name: judge(case, trace) for name, trace in traces(case.run).items()}
    found = _found_after_reset(case, parameters or FusionParameters())
    found["both"]["score"] = min(outcomes[name].score for name in PUBLISHED)
    return {
        name: outcome.model_copy(update=found.get(name, {})) for name, outcome in outcomes.items()
    }


def _found_after_reset(
    case: CaseRun, parameters: FusionParameters
) -> dict[str, dict[str, float | None]]:
    """`found_s` of the methods that keep their alarm: the same fusions, started at the onset."""
    found: dict[str, dict[str, float | None]] = {"both": {}, "fusion": {}}
    attack = case.attack
    if attack is not None:
        later = {name: _since(one, attack.onset_ns) for name, one in case.run.verdicts.items()}
        for name, results in (
            ("both", fused(later, PAPER, PUBLISHED)),
            ("fusion", fused(later, parameters, DETECTORS)),
        ):
            found[name]["found_s"] = _found_s(_alert_trace(results), attack)
    return found


def _since(verdicts: Sequence[Verdict], onset_ns: int) -> list[Verdict]:
    """Verdicts from the onset on, without those of an alarm that was on already."""
    later = [verdict for verdict in verdicts if verdict.stamp_ns >= onset_ns]
    return list(itertools.dropwhile(lambda verdict: verdict.state is State.ALARM, later))


def judge(case: CaseRun, trace: Trace) -> MethodOutcome:
    """Judge one method on a flight.

    A clean flight is correct without any alarm; a hijacked one if the first alarm of the whole
    flight lies inside the attack. Whatever comes after the onset is no false alarm.
    """
    run, attack = case.run, case.attack
    episodes = _episodes(trace)
    clean_until = case.end_ns + 1 if attack is None else attack.onset_ns
    first = episodes[0][0] if episodes else None
    judgement = _judgement(first, attack)
    found = first if judgement is Judgement.DETECTED else None

    def seconds(stamp_ns: int) -> float:
        return (stamp_ns - run.start_ns) / NANOSECONDS

    return MethodOutcome(
        judgement=judgement,
        first_alarm_s=None if first is None else seconds(first),
        alarms=tuple((seconds(begin), seconds(end)) for begin, end in episodes),
        false_alarms=sum(begin < clean_until for begin, _ in episodes),
        time_to_detect_s=None if found is None else _since_onset_s(found, attack),
        deviation_m=None if found is None or not run.separations else run.separation_at(found),
        score=_score(trace, attack),
        found_s=None if attack is None else _found_s(trace, attack),
        claimed=_claimed(trace, attack),
    )


def with_baselines(parameters: MonitorParameters, *, published_kld: bool) -> MonitorParameters:
    """Parameters of a monitor that runs the methods to compare with too."""
    if not published_kld:
        return parameters.adding([BASELINE])
    paper = policy_parameters("paper")[KldDetector.NAME]
    return parameters.adding([BASELINE, PUBLISHED_KLD], {PUBLISHED_KLD.name: paper})


def traces(run: OfflineRun) -> dict[str, Trace]:
    """Verdicts of every method, by its name, the simplest first."""
    found = {name: _verdict_trace(verdicts) for name, verdicts in run.verdicts.items()}
    baselines = [name for name in found if name in {BASELINE.name, PUBLISHED_KLD.name}]
    order = dict.fromkeys((*baselines, *PUBLISHED, "both", *found, "fusion"))
    found["both"] = _alert_trace(fused(run.verdicts, PAPER, PUBLISHED))
    found["fusion"] = _alert_trace(run.results)
    return {name: found[name] for name in order}


def fused(
    verdicts: Mapping[str, Sequence[Verdict]], parameters: FusionParameters, names: Sequence[str]
) -> list[FusionResult]:
    """Results of a fusion of the verdicts of the named detectors."""
    fusion = Fusion(parameters, {name: WEIGHTS[name] for name in names})
    streams = ([(name, verdict) for verdict in verdicts[name]] for name in names)
    merged = heapq.merge(*streams, key=lambda entry: entry[1].stamp_ns)
    return [fusion.update(name, verdict) for name, verdict in merged]


def _verdict_trace(verdicts: Sequence[Verdict]) -> Trace:
    rows = ((v.stamp_ns, v.state is State.ALARM, v.margin) for v in verdicts)
    return _trace(rows, thresholded=True)


def _alert_trace(results: Sequence[FusionResult]) -> Trace:
    """Confidence counts up to the alert only: it is latched, and means nothing afterwards."""
    rows = (
        (r.stamp_ns, r.alert, r.confidence if r.alert_since_ns in (None, r.stamp_ns) else 0.0)
        for r in results
    )
    return _trace(rows, thresholded=False)


def _trace(claims: Iterable[tuple[int, bool, float]], *, thresholded: bool) -> Trace:
    rows = list(claims)
    stamps, alarms, margins = zip(*rows, strict=True) if rows else ((), (), ())
    return Trace(
        np.array(stamps, dtype=np.int64),
        np.array(alarms, dtype=np.bool_),
        np.array(margins, dtype=np.float64),
        thresholded,
    )


def _episodes(trace: Trace) -> list[tuple[int, int]]:
    """Stamps of the first and last of each row of alarming verdicts, nanoseconds."""
    edges = np.diff(np.concatenate([[0], trace.alarms.astype(np.int8), [0]]))
    begins, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
    stamps = trace.stamps_ns
    return list(zip(stamps[begins].tolist(), stamps[ends].tolist(), strict=True))


def _judgement(first_ns: int | None, attack: Attack | None) -> Judgement:
    right = alert_is_right(first_ns, attack)
    if attack is None:
        return Judgement.QUIET if right else Judgement.FALSE_ALARM
    if right:
        return Judgement.DETECTED
    if first_ns is None:
        return Judgement.MISSED
    return Judgement.EARLY if first_ns < attack.onset_ns else Judgement.LATE


def _since_onset_s(stamp_ns: int, attack: Attack | None) -> float:
    assert attack is not None
    return (stamp_ns - attack.onset_ns) / NANOSECONDS


def _found_s(trace: Trace, attack: Attack) -> float | None:
    """Seconds from the onset to the first alarm that began inside the attack."""
    begun = [begin for begin, _ in _episodes(trace) if alert_is_right(begin, attack)]
    return _since_onset_s(begun[0], attack) if begun else None


def _claimed(trace: Trace, attack: Attack | None) -> float | None:
    """Share of the verdicts within the attack that claim it by themselves."""
    if attack is None or not trace.thresholded:
        return None
    within = _within(trace, attack)
    return float(np.mean(trace.margins[within] > 1.0)) if within.any() else None


def _score(trace: Trace, attack: Attack | None) -> float:
    """Largest margin of a clean flight, or within the attack; 0 where nothing was judged."""
    return float(np.max(trace.margins, where=_within(trace, attack), initial=0.0))


def _within(trace: Trace, attack: Attack | None) -> npt.NDArray[np.bool_]:
    """Mask of the stamps within the attack; all of them without one."""
    wanted = np.ones(len(trace.stamps_ns), dtype=np.bool_)
    if attack is not None:
        wanted = trace.stamps_ns >= attack.onset_ns
        if attack.end_ns is not None:
            wanted &= trace.stamps_ns < attack.end_ns
    return wanted
