# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The content of the page, in bounded memory."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any, Generic, TypeVar

from hijack_detect.contract import SILENT_S
from hijack_detect.detectors.verdict import JUDGED, RAISED, State, Verdict
from hijack_detect.estimation.geodesy import LocalFrame
from hijack_detect.monitor.verdict_messages import FusionStatus
from hijack_detect.streams.samples import NANOSECONDS, FixSample


@dataclass(frozen=True, slots=True)
class Latest:
    """The newest inputs of the banner.

    `silent_s` is the time since hijack_alert on a steady clock, None before the first; `stale` is
    the text of the fusion on /diagnostics while it has no verdict.
    """

    silent_s: float | None
    alert: bool
    fused: FusionStatus | None
    stale: str
    verdicts: Mapping[str, Verdict]


def word(latest: Latest) -> str:
    """One of silent, alarm, suspicious, degraded, not_observable, not_ready, normal."""
    if latest.silent_s is None or latest.silent_s > SILENT_S:
        return "silent"
    return last_state(latest)


def last_state(latest: Latest) -> str:
    """The last state of the monitor, whether it is silent since then or not."""
    fused = latest.fused
    if latest.alert or (fused is not None and fused.alert):
        return State.ALARM.value
    if latest.stale:
        return "degraded"
    if fused is None:
        return State.NOT_READY.value
    if fused.state in RAISED:
        return State.SUSPICIOUS.value
    if fused.degraded or fused.state is State.STALE:
        return "degraded"
    return str(fused.state.value)


def sentence(latest: Latest) -> str:
    """The reason of that state, in words."""
    what, fused = last_state(latest), latest.fused
    if what == "degraded" and latest.stale:
        return latest.stale
    if fused is None:
        return "no fusion/verdict was heard yet"
    if what == State.ALARM.value:
        return fused.reason if fused.alert else "hijack_alert is true"
    if what == State.SUSPICIOUS.value:
        raised = [one for one in latest.verdicts.values() if one.state in RAISED]
        return "; ".join(f"{one.detector}: {one.reason}" for one in raised) or fused.reason
    if what == "degraded":
        if not fused.degraded:
            return fused.reason
        return f"without {', '.join(fused.degraded)}: stopped, or never ready"
    if what == State.NOT_OBSERVABLE.value:
        return "no detector can tell in this phase of flight; the table has the reasons"
    if what == State.NOT_READY.value:
        return "the detectors are getting ready; the table has the reasons"
    return _closest(latest.verdicts)


def _closest(verdicts: Mapping[str, Verdict]) -> str:
    judging = {name: one.margin for name, one in verdicts.items() if one.state in JUDGED}
    if not judging:
        return ""
    name = max(judging, key=judging.__getitem__)
    return f"nearest to its limit is {name}, at {judging[name]:.2f} of it"


T = TypeVar("T")


class Series(Generic[T]):
    """The newest entries, each with a number that it keeps.

    Attributes:
        count: Number of entries that ever came; the number of the next one.
    """

    def __init__(self, most: int) -> None:
        """Keep `most` entries."""
        self.count = 0
        self._entries: deque[T] = deque(maxlen=most)

    def append(self, entry: T) -> None:
        """Add an entry; the oldest one goes if there are too many."""
        self._entries.append(entry)
        self.count += 1

    @property
    def last(self) -> T | None:
        """The newest entry."""
        return self._entries[-1] if self._entries else None

    def since(self, number: int) -> list[T]:
        """The entries from this number on that are kept."""
        oldest = self.count - len(self._entries)
        return list(islice(self._entries, max(0, number - oldest), None))


class Curve:
    """One value over time, thinned to its largest in each period so that no peak is lost."""

    def __init__(self, most: int, period_s: float) -> None:
        """Keep `most` points, one for each period."""
        self.points: Series[tuple[float, float | None]] = Series(most)
        self._period_s = period_s
        self._peak: tuple[float, float] | None = None

    def add(self, time_s: float, value: float | None) -> None:
        """Take the next value; None is a gap."""
        peak = self._peak
        if peak is not None and (value is None or self._period(time_s) != self._period(peak[0])):
            self.points.append(peak)
            self._peak = peak = None
        if value is not None:
            if peak is None or value >= peak[1]:
                self._peak = time_s, value
        elif self.points.last is not None and self.points.last[1] is not None:
            self.points.append((time_s, None))

    def _period(self, time_s: float) -> int:
        return int(time_s // self._period_s)


KEPT_S = 600.0
"""Flight time that is kept. Chosen, not swept: 2400 points a curve."""
PERIOD_S = 0.25
"""Flight time between two points of a curve or of the track. Chosen: a fix of 5 Hz a point."""
MOST = round(KEPT_S / PERIOD_S)
MOST_CHANGES = 500
"""Most changes of the state that are kept. Chosen, not swept."""
BACK_S = 1.0
"""Stamps that run back by more than this begin another flight. Chosen, not swept."""
OLD_S = 5.0
"""Silence after which a detector or a complaint is over. Chosen: five periods of /diagnostics."""
STAMP_S = 1.0
"""Timeout of the verdict with the stamp of a change of hijack_alert. Chosen, not swept; it follows
at once."""
LONGEST = 600
"""Most characters of a text. Chosen, not swept."""
Frame = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Cursor:
    """The position of a reader: its flight, and its number of entries of each history."""

    flight: int
    counts: tuple[int, ...]


class Picture:
    """The state of the page; one thread adds messages, another reads it.

    Times are seconds of header stamps since the first one. Silence is measured on a steady clock,
    since a dead node sends no stamps.

    Attributes:
        detectors: Names of the detectors that it expects.
    """

    def __init__(
        self, detectors: Sequence[str], clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Expect these detectors; `clock` gives seconds."""
        self.detectors = tuple(detectors)
        self._clock = clock
        self._lock = threading.Lock()
        self._flight = 0
        self._alert, self._alert_s, self._changed_s = False, -math.inf, -math.inf
        self._confidence = math.nan
        self._complaints: dict[str, tuple[str, float]] = {}
        self._begin()

    def _begin(self) -> None:
        """Forget a flight."""
        self._flight += 1
        self._stamps: dict[str, int] = {}
        self._start_ns: int | None = None
        self._newest_ns = 0
        self._frame: LocalFrame | None = None
        self._position: Frame | None = None
        self._fused: FusionStatus | None = None
        self._stale = ""
        self._verdicts: dict[str, Verdict] = {}
        self._received_s: dict[str, float] = {}
        self._track: Series[tuple[float, ...]] = Series(MOST)
        self._states: Series[tuple[float, str]] = Series(MOST_CHANGES)
        self._curves = {name: Curve(MOST, PERIOD_S) for name in self.detectors}

    def receive_fix(self, fix: FixSample) -> None:
        """Take the next position; one without a fix is a gap in the track."""
        with self._lock:
            time_s = self._time(fix.stamp_ns, "fix")
            self._note_state(time_s)
            last = self._track.last
            if not fix.has_fix:
                self._position = None
                if last is not None and len(last) > 1:
                    self._track.append((time_s,))
                return
            if self._frame is None:
                self._frame = LocalFrame(fix)
            east, north, _ = self._frame.enu(fix)
            self._position = {
                "east": round(east, 2),
                "north": round(north, 2),
                "latitude": fix.latitude_deg,
                "longitude": fix.longitude_deg,
                "altitude": _finite(fix.altitude_m, 1),
            }
            if last is None or len(last) == 1 or time_s // PERIOD_S != last[0] // PERIOD_S:
                self._track.append((time_s, round(east, 2), round(north, 2)))

    def receive_verdict(self, name: str, verdict: Verdict) -> None:
        """Take the next verdict of a detector that is expected."""
        with self._lock:
            time_s = self._time(verdict.stamp_ns, name)
            self._verdicts[name], self._received_s[name] = verdict, self._clock()
            judging = verdict.state in JUDGED and math.isfinite(verdict.margin)
            self._curves[name].add(time_s, round(verdict.margin, 3) if judging else None)

    def receive_fused(self, fused: FusionStatus) -> None:
        """Take a fusion/verdict."""
        with self._lock:
            time_s = self._time(fused.stamp_ns, "fusion")
            self._fused = fused
            if fused.state is not State.STALE:
                self._stale = ""
            self._note_state(time_s)

    def receive_alert(self, alert: bool) -> None:
        """Take hijack_alert."""
        with self._lock:
            now = self._clock()
            if alert != self._alert:
                self._changed_s = now
            self._alert, self._alert_s = alert, now

    def receive_confidence(self, confidence: float) -> None:
        """Take hijack_confidence; NaN without one."""
        with self._lock:
            self._confidence = confidence

    def receive_stale(self, text: str) -> None:
        """Take the text of a fusion without a verdict; empty with one."""
        with self._lock:
            self._stale = text

    def receive_complaint(self, name: str, text: str) -> None:
        """Take a complaint of a node; an empty text takes it back."""
        with self._lock:
            self._complaints[name[:LONGEST]] = text[:LONGEST], self._clock()
            now = self._clock()
            self._complaints = {
                name: (text, received_s)
                for name, (text, received_s) in self._complaints.items()
                if text and now - received_s <= OLD_S
            }

    def _time(self, stamp_ns: int, stream: str) -> float:
        """Seconds since the first stamp."""
        if stamp_ns < self._stamps.get(stream, stamp_ns) - BACK_S * NANOSECONDS:
            self._begin()
        self._stamps[stream] = stamp_ns
        if self._start_ns is None:
            self._start_ns = self._newest_ns = stamp_ns
        self._newest_ns = max(self._newest_ns, stamp_ns)
        return self._seconds(stamp_ns)

    def _seconds(self, stamp_ns: int) -> float:
        return round((stamp_ns - (self._start_ns or 0)) / NANOSECONDS, 3)

    def _latest(self) -> Latest:
        silent_s = self._clock() - self._alert_s
        return Latest(
            silent_s if math.isfinite(silent_s) else None,
            self._alert,
            self._fused,
            self._stale,
            self._verdicts,
        )

    def _note_state(self, time_s: float) -> None:
        """Keep when the state changed; never before the change that was kept last."""
        now, last = word(self._latest()), self._states.last
        waited_s = self._clock() - self._changed_s
        if now == "alarm" and waited_s < STAMP_S and not (self._fused and self._fused.alert):
            return  # fusion/verdict, which has the stamp of the alarm, is on its way
        if last is None:
            self._states.append((time_s, now))
        elif last[1] != now:
            self._states.append((max(time_s, last[0]), now))

    def frame(self, cursor: Cursor | None) -> tuple[Frame, Cursor]:
        """What a reader does not have yet, and its next cursor.

        With a cursor of another flight, or none, `reset` is true and the whole history is there.
        """
        with self._lock:
            return self._read(cursor)

    def _read(self, cursor: Cursor | None) -> tuple[Frame, Cursor]:
        if self._start_ns is not None:
            self._note_state(self._seconds(self._newest_ns))
        histories: list[Series[Any]] = [self._track, self._states]
        histories += [curve.points for curve in self._curves.values()]
        reset = cursor is None or cursor.flight != self._flight
        had = (0,) * len(histories) if cursor is None or reset else cursor.counts
        track, states, *curves = (
            history.since(number) for history, number in zip(histories, had, strict=True)
        )
        margins = dict(zip(self._curves, curves, strict=True))
        frame = {
            "reset": reset,
            **self._banner(),
            "position": self._position,
            "detectors": [self._row(name) for name in self.detectors],
            "complaints": [
                f"{name}: {text}"
                for name, (text, received_s) in sorted(self._complaints.items())
                if text and self._clock() - received_s <= OLD_S
            ],
            "track": track,
            "states": states,
            "margins": {name: points for name, points in margins.items() if points},
        }
        return frame, Cursor(self._flight, tuple(history.count for history in histories))

    def _banner(self) -> Frame:
        latest, fused = self._latest(), self._fused
        since = self._states.last[0] if self._states.last else None
        if fused is not None and fused.alert_since_ns is not None and word(latest) == "alarm":
            since = self._seconds(fused.alert_since_ns)
        known = self._start_ns is not None
        return {
            "time": self._seconds(self._newest_ns) if known else None,
            "stamp": self._newest_ns / NANOSECONDS if known else None,
            "state": word(latest),
            "said": None if latest.silent_s is None else last_state(latest),
            "why": sentence(latest)[:LONGEST],
            "since": since,
            "silent": None if latest.silent_s is None else round(latest.silent_s, 1),
            "probability": None if word(latest) == "silent" else _finite(self._confidence),
        }

    def _row(self, name: str) -> Frame:
        verdict = self._verdicts.get(name)
        if verdict is None:
            return {"name": name, "state": "silent", "margin": None, "why": "no verdict yet"}
        quiet_s = self._clock() - self._received_s[name]
        if quiet_s > OLD_S:
            why = f"no verdict for {quiet_s:.0f} s"
            return {"name": name, "state": "silent", "margin": None, "why": why}
        return {
            "name": name,
            "state": verdict.state.value,
            "margin": _finite(verdict.margin) if verdict.state in JUDGED else None,
            "time": self._seconds(verdict.stamp_ns),
            "why": verdict.reason[:LONGEST],
        }


def _finite(value: float, digits: int = 3) -> float | None:
    return round(value, digits) if math.isfinite(value) else None
