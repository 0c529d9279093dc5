# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Puts the stamps of a receiver on the clock of the IMU, whatever the receiver takes for the time.

A driver that stamps fixes and velocities with the receiver's own time hands on every step of it:
a leap second, GPS time for UTC, a week, a spoofer with the wrong date. On stamps alone that is a
gap, or a clock that was set back, and the merges would lose the receiver or the IMU. Here it is
distinguished by the stamps of the IMU that arrive meanwhile, which the receiver cannot move.

What is assumed: on the way, messages of one input stay in order, and those of the receiver are
early or late against the IMU's by less than half a step of up to 3 s, by less than 1.5 s at a
larger one, and by less than 2 s at the start. Then whether there was a step is the same in every
delivery. How large it was follows from the receiver's own stamps.
"""

from __future__ import annotations

import dataclasses
import statistics
from collections import Counter, deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from hijack_detect.streams.samples import NANOSECONDS

REFERENCE = "imu"
"""The input whose stamps are the time: autopilot or companion make them, not the receiver."""
STAMPED = ("fix", "velocity")
"""What a receiver stamps; both are put right by the same offset where both step by as much."""
SATELLITES = "satellites"
"""Has the stamp of a fix, and follows it."""

LATE_NS = 3 * NANOSECONDS // 2
"""Much more than transport is late by (measured with a busy computer: below 1 s)."""
SMALLEST_NS = 350_000_000
"""A stamp this far from where it is due is looked at: two fixes at 5 Hz, lost or to spare."""
AT_START_NS = 2 * NANOSECONDS
"""As LATE_NS for the first samples, when subscriptions come about one after the other."""
WATCHED_NS = 9 * NANOSECONDS // 10
"""How long a new level must last. With one interval more, a merge still waits for the receiver."""
WATCHED_AT_START_NS = 3 * NANOSECONDS // 2
"""The same at the start. Chosen, not swept."""
GIVEN_UP_NS = 5 * NANOSECONDS // 2
"""What is not clear by then is left as it is: the merges wait for 3 s."""
STEADY_NS = 600_000_000
"""The ages of stamps on one level differ by less; those of a backlog that is worked off do not.
Chosen, not swept."""
MOST_HELD = 200
"""With this many samples held a new level is decided as it stands. Chosen, not swept."""
GAP_NS = 3 * NANOSECONDS // 4
"""After a gap this long no merge waits for what is held here: it is left out."""
KEPT = 15
ENOUGH = 3
"""Intervals between stamps of an input from which its usual one is known. Chosen, not swept."""
WHOLE_NS = 50_000_000
"""A step this close to whole seconds is one, as leap seconds, time zones and weeks are; of uneven
stamps one within twice their deviation."""
FAR = 50
"""Intervals beyond which their errors add up to more than arrival shows. Chosen, not swept."""
AGREE_NS = SMALLEST_NS
LEAP_NS = 300_000_000
"""A reference that leaps by this had a hole, or was set itself. Chosen, not swept."""

Passed: TypeAlias = tuple[str, Any]
"""Input and sample."""


@dataclass
class _Trial:
    """A level of stamps that may be new."""

    before_ns: int | None
    """Stamp before it; None where the input begins."""
    opened_ns: int | None
    """Time of the IMU's clock when it was opened."""
    seen: list[tuple[int, int | None]] = field(default_factory=list)
    """Stamps, and how old each was when it arrived, on the offset so far."""

    @property
    def enough_ns(self) -> int:
        """Time for which it must be watched."""
        return WATCHED_AT_START_NS if self.before_ns is None else WATCHED_NS

    def ages(self) -> list[int]:
        """Ages of the newest stamps, of the last time on their own clock."""
        if not self.seen:
            return []
        since_ns = self.seen[-1][0] - self.enough_ns
        return [age for one_ns, age in self.seen if age is not None and one_ns >= since_ns]

    def is_clear(self) -> bool:
        """Whether the level was watched for long enough, and was steady."""
        known = [one_ns for one_ns, age in self.seen if age is not None]
        if not known or known[-1] - known[0] < self.enough_ns:
            return False
        ages = self.ages()
        return max(ages) - min(ages) <= STEADY_NS


@dataclass
class _Input:
    offset_ns: int = 0
    begun: bool = False
    latest_ns: int | None = None
    """Newest stamp let through, with its offset taken off."""
    reference_ns: int | None = None
    """Time of the IMU's clock then."""
    intervals: deque[int] = field(default_factory=lambda: deque(maxlen=KEPT))
    ages: deque[int] = field(default_factory=lambda: deque(maxlen=KEPT))
    trial: _Trial | None = None


@dataclass
class _Held:
    name: str
    sample: Any
    age_ns: int | None
    reference_ns: int | None
    before_ns: int
    """Offset before the trial."""
    tried: bool = False
    dropped: bool = False


class ReceiverClock:
    """Puts the stamps of a receiver on the clock of the IMU; inputs keep their order of arrival.

    A sample of the receiver whose stamp is not where it was due, while the IMU's clock did not
    move as far, is held for about a second, with what follows of the receiver. If the new level
    lasts, it is a step: from there on `stamp_ns` is put back on the old level and
    `clock_offset_ns` is the offset subtracted. If not, all passes unchanged, as any other stamp.
    The same is done at the start with an input that is more than 2 s off the IMU: of a constant
    offset only arrival shows how large it is, so it is known to whole seconds, or else to 0.1 s.

    Attributes:
        refused: Samples left out, by reason.
        findings: Steps found, as text, until the owner removes them.
    """

    def __init__(self) -> None:
        """Start without samples."""
        self.refused: Counter[str] = Counter()
        self.findings: list[str] = []
        self._inputs = {name: _Input() for name in STAMPED}
        self._reference_ns: int | None = None
        self._intervals: deque[int] = deque([0], maxlen=KEPT)
        """Times between stamps of the IMU."""
        self._held: list[_Held] = []
        self._offsets: deque[tuple[int, int]] = deque(maxlen=4 * KEPT)
        """Stamps of the newest fixes as received, and the offsets subtracted."""

    def push(self, name: str, sample: Any) -> list[Passed]:
        """Take one sample; return the samples that pass, in order of arrival.

        Args:
            name: The input; those that are neither receiver nor IMU go through.
            sample: Has `stamp_ns`, or goes through.
        """
        if name == REFERENCE:
            return [*self._take_reference(sample.stamp_ns), (name, sample)]
        if name in self._inputs:
            return self._take(name, sample)
        if name == SATELLITES and hasattr(sample, "stamp_ns"):
            if not self._held:
                return [(name, self._follows_fix(sample))]
            self._held.append(_Held(name, sample, None, None, 0))
            return []
        return [(name, sample)]

    def push_run(self, name: str, samples: Sequence[Any]) -> Iterable[tuple[str, Sequence[Any]]]:
        """Take successive samples of one input; return the runs that pass."""
        if name == REFERENCE and not self._held and samples:
            before_ns = samples[-2].stamp_ns if len(samples) > 1 else self._reference_ns
            self._reference_ns = samples[-1].stamp_ns
            self._intervals.append(self._reference_ns - (before_ns or self._reference_ns))
            return [(name, samples)]
        if name not in (REFERENCE, SATELLITES, *self._inputs):
            return [(name, samples)]
        runs: list[tuple[str, list[Any]]] = []
        for sample in samples:
            for of, one in self.push(name, sample):
                if not runs or runs[-1][0] != of:
                    runs.append((of, []))
                runs[-1][1].append(one)
        return runs

    def note_reference(self, stamp_ns: int) -> list[Passed]:
        """Take only the stamp of an IMU sample, which itself goes another way."""
        return self._take_reference(stamp_ns)

    def _take_reference(self, stamp_ns: int) -> list[Passed]:
        before_ns, self._reference_ns = self._reference_ns, stamp_ns
        usual_ns, interval_ns = self._intervals[-1], stamp_ns - (before_ns or stamp_ns)
        self._intervals.append(interval_ns)
        if not self._held:
            return []
        if before_ns is None or abs(interval_ns) > max(LEAP_NS, 3 * abs(usual_ns) // 2):
            self._leapt()
        return self._decided()

    def _leapt(self) -> None:
        """Judge again once the IMU's clock has moved at once: a hole of all inputs has ended."""
        assert self._reference_ns is not None
        for source in self._inputs.values():
            trial = source.trial
            if trial is None or not trial.seen:
                continue
            age_ns = self._reference_ns - (trial.seen[-1][0] - source.offset_ns)
            if trial.before_ns is None:
                if abs(age_ns) <= AT_START_NS:
                    source.begun, source.trial = True, None
                elif trial.seen[-1][1] is None:  # the IMU begins
                    trial.opened_ns, trial.seen = self._reference_ns, []
            elif not self._is_step(source, *self._moved(source, trial, [age_ns])):
                source.trial = None
            else:  # the age of the stamps before is unknown
                trial.opened_ns = self._reference_ns
                trial.seen = [
                    *((one_ns, None) for one_ns, _ in trial.seen[:-1]),
                    (
                        trial.seen[-1][0],
                        age_ns,
                    ),
                ]

    def _take(self, name: str, sample: Any) -> list[Passed]:
        source, stamp_ns = self._inputs[name], sample.stamp_ns
        reference_ns, age_ns = self._reference_ns, None
        if reference_ns is not None:
            age_ns = reference_ns - (stamp_ns - source.offset_ns)
        held = _Held(name, sample, age_ns, reference_ns, source.offset_ns)
        if source.trial is not None:
            held.tried = self._goes_on(source, source.trial, name, stamp_ns, age_ns)
        elif self._is_suspect(source, stamp_ns - source.offset_ns, age_ns):
            before_ns = source.latest_ns if source.begun else None
            source.trial = _Trial(before_ns, reference_ns, [(stamp_ns, age_ns)])
            held.tried = True
        elif not self._held:
            return [self._let_through(held)]
        self._held.append(held)
        return self._decided()

    def _is_suspect(self, source: _Input, stamp_ns: int, age_ns: int | None) -> bool:
        """Whether a stamp, with the offset so far taken off, may be the first of a new level."""
        if not source.begun:
            return (age_ns is None and source.latest_ns is None) or abs(age_ns or 0) > AT_START_NS
        if age_ns is None or source.latest_ns is None or stamp_ns == source.latest_ns:
            return False
        if min(len(source.intervals), len(source.ages)) < ENOUGH:
            return False
        usual_ns = _median(source.intervals)
        off_ns = stamp_ns - source.latest_ns - usual_ns
        uneven_ns = max(abs(one_ns - usual_ns) for one_ns in source.intervals)
        shift_ns = _median(source.ages) - age_ns
        if abs(off_ns) <= max(SMALLEST_NS, 3 * uneven_ns // 2):
            return False
        return self._is_step(source, off_ns, shift_ns)

    def _goes_on(
        self, source: _Input, trial: _Trial, name: str, stamp_ns: int, age_ns: int | None
    ) -> bool:
        """Whether the next stamp belongs to the trial; it may end it."""
        if trial.before_ns is not None and trial.seen:
            longest_ns = _median(source.intervals) + SMALLEST_NS
            follows_new = 0 < stamp_ns - trial.seen[-1][0] <= longest_ns
            follows_old = 0 < stamp_ns - source.offset_ns - trial.before_ns <= longest_ns
            if follows_old and not follows_new:
                source.trial = None
                return False
            if not follows_new:  # another step: the time in between is unknown
                trial.seen.clear()
                for one in self._held:
                    one.dropped |= one.tried and one.name == name
        trial.seen.append((stamp_ns, age_ns))
        return True

    def _decided(self) -> list[Passed]:
        """Everything held, once it is clear."""
        trials = [one.trial for one in self._inputs.values() if one.trial is not None]
        if trials and len(self._held) < MOST_HELD:
            given_up = any(map(self._is_given_up, trials))
            if not given_up and not all(map(self._is_clear, trials)):
                return []
        found = {name: self._new_offset(name, source) for name, source in self._inputs.items()}
        for name, source in self._inputs.items():
            self._conclude(name, source, self._agreed(name, found))
        held, self._held = self._held, []
        return [self._let_through(one) for one in held if not one.dropped]

    def _is_given_up(self, trial: _Trial) -> bool:
        """Whether the merges can wait no longer."""
        watched_ns = trial.seen[-1][0] - trial.seen[0][0] if trial.seen else 0
        if self._reference_ns is None or trial.opened_ns is None:
            return watched_ns >= trial.enough_ns
        return max(abs(self._reference_ns - trial.opened_ns), watched_ns) >= GIVEN_UP_NS

    def _is_clear(self, trial: _Trial) -> bool:
        """Whether a new level was watched for long enough, was steady, and the IMU moved on."""
        return trial.is_clear() and not self._stands(trial)

    def _agreed(self, name: str, found: Mapping[str, int | None]) -> int | None:
        """An input's new offset; that of the other if its own stamps moved as far."""
        source = self._inputs[name]
        trial = source.trial
        if found[name] is not None or trial is None or trial.before_ns is None:
            return found[name]
        led_to_ns = source.offset_ns + self._moved(source, trial, [0])[0]
        for other_ns in found.values():
            if other_ns is not None and abs(other_ns - led_to_ns) <= AGREE_NS:
                return other_ns
        return None

    def _conclude(self, name: str, source: _Input, offset_ns: int | None) -> None:
        """End an input's trial: take on its new offset, or leave the stamps as they are."""
        trial, source.trial = source.trial, None
        mine = [one for one in self._held if one.name == name and one.tried]
        if offset_ns is None or offset_ns == source.offset_ns:
            source.begun |= trial is not None and self._reference_ns is not None
            for one in mine:
                one.tried = one.dropped = False
            return
        fix_ns = self._inputs[STAMPED[0]].offset_ns
        if name != STAMPED[0] and abs(offset_ns - fix_ns) <= AGREE_NS:
            offset_ns = fix_ns
        stepped_ns, source.offset_ns = offset_ns - source.offset_ns, offset_ns
        if source.begun:
            what = f"{name}: the receiver's time stepped by {stepped_ns / NANOSECONDS:+.1f} s"
        else:
            what = f"{name}: stamped {seconds_off(offset_ns)} of the IMU from the start"
        self.findings.append(f"{what}; taken off its stamps: {offset_ns / NANOSECONDS:.1f} s")
        source.begun = True
        self.refused[f"{name}: stamp unclear while the receiver's time stepped"] += sum(
            one.dropped for one in mine
        )

    def _new_offset(self, name: str, source: _Input) -> int | None:
        """The offset that the trial of an input leads to; None if it was none."""
        trial = source.trial
        if trial is None or not self._is_clear(trial):
            return None
        ages = trial.ages()
        if trial.before_ns is None:
            if min(map(abs, ages)) <= AT_START_NS:
                return None
            return _rounded(source.offset_ns - min(ages))
        off_ns, shift_ns = self._moved(source, trial, ages)
        if not self._is_step(source, off_ns, shift_ns):
            return None
        step_ns = _size(off_ns, shift_ns, source.intervals)
        if off_ns - step_ns >= GAP_NS:
            mine = [one for one in self._held if one.name == name and one.tried]
            for one in mine[:-1]:
                one.dropped = True
        offset_ns = source.offset_ns + step_ns
        return 0 if abs(offset_ns) < SMALLEST_NS else offset_ns

    def _stands(self, trial: _Trial) -> bool:
        """Whether the IMU's clock did not move meanwhile: then it shows nothing."""
        if self._reference_ns is None or trial.opened_ns is None:
            return True
        return abs(self._reference_ns - trial.opened_ns) < trial.enough_ns // 2

    def _is_step(self, source: _Input, off_ns: int, shift_ns: int) -> bool:
        """Whether stamps moved rather than that samples were lost or late.

        A stamp is `off_ns` from where it was due by the input's own interval, and `shift_ns` ahead
        of where it was due on the IMU's clock: 0 if samples were lost, `off_ns` if the time
        stepped. What the ages differ by anyway, or a slow IMU shows too coarsely, is no step.
        """
        if abs(shift_ns) >= LATE_NS:
            return True
        spread_ns = max(source.ages) - min(source.ages)
        least_ns = max(abs(off_ns) // 2, spread_ns, 3 * _median(self._intervals))
        return off_ns * shift_ns > 0 and abs(shift_ns) >= least_ns

    def _moved(self, source: _Input, trial: _Trial, ages: Sequence[int]) -> tuple[int, int]:
        """Distances of stamps from where they were due: by their interval, and by the IMU."""
        assert trial.before_ns is not None
        first_ns = trial.seen[0][0] - source.offset_ns
        off_ns = first_ns - trial.before_ns - _median(source.intervals)
        return off_ns, _median(source.ages) - _median(ages)

    def _let_through(self, held: _Held) -> Passed:
        if held.name == SATELLITES:
            return held.name, self._follows_fix(held.sample)
        source = self._inputs[held.name]
        offset_ns = source.offset_ns if held.tried else held.before_ns
        stamp_ns = held.sample.stamp_ns - offset_ns
        if source.latest_ns is not None and 0 < stamp_ns - source.latest_ns <= 2 * NANOSECONDS:
            source.intervals.append(stamp_ns - source.latest_ns)
        if held.reference_ns is not None and held.age_ns is not None:
            source.begun |= abs(held.age_ns) <= AT_START_NS
            if held.reference_ns != source.reference_ns:  # the IMU lives
                source.ages.append(held.reference_ns - stamp_ns)
        source.latest_ns, source.reference_ns = stamp_ns, held.reference_ns
        if held.name == STAMPED[0]:
            self._offsets.append((held.sample.stamp_ns, offset_ns))
        return held.name, _shifted(held.sample, offset_ns)

    def _follows_fix(self, sample: Any) -> Any:
        """A number of satellites with the offset of its fix."""
        for stamp_ns, offset_ns in reversed(self._offsets):
            if stamp_ns == sample.stamp_ns:
                return _shifted(sample, offset_ns)
        return _shifted(sample, self._inputs[STAMPED[0]].offset_ns)


def seconds_off(offset_ns: int) -> str:
    """An offset of stamps in words."""
    return f"{abs(offset_ns) / NANOSECONDS:.1f} s {'ahead' if offset_ns > 0 else 'behind'}"


def _size(off_ns: int, shift_ns: int, intervals: Iterable[int]) -> int:
    """Size of a step: by the stamps, less the samples lost at it, which arrival counts."""
    intervals = list(intervals)
    usual_ns = _median(intervals)
    uneven_ns = max(WHOLE_NS, 2 * _median(abs(one_ns - usual_ns) for one_ns in intervals))
    whole_ns = round(off_ns / NANOSECONDS) * NANOSECONDS
    if whole_ns and abs(off_ns - whole_ns) <= uneven_ns and abs(whole_ns - shift_ns) < LATE_NS // 3:
        return whole_ns  # nothing was lost
    whole_ns = round(shift_ns / NANOSECONDS) * NANOSECONDS
    if whole_ns and abs(shift_ns - whole_ns) <= usual_ns // 2 + uneven_ns:
        rest_ns = off_ns - whole_ns
        if abs(rest_ns - round(rest_ns / usual_ns) * usual_ns) <= uneven_ns:
            return whole_ns
    lost = round((off_ns - shift_ns) / usual_ns)
    return _rounded(shift_ns) if abs(lost) > FAR else off_ns - lost * usual_ns


def _rounded(offset_ns: int) -> int:
    """An offset known from arrival, so less what transport takes: whole seconds, or 0.1 s."""
    guess_ns = offset_ns + NANOSECONDS // 10
    whole_ns = round(guess_ns / NANOSECONDS) * NANOSECONDS
    if abs(guess_ns - whole_ns) <= 3 * NANOSECONDS // 10:
        return whole_ns
    return round(offset_ns * 10 / NANOSECONDS) * NANOSECONDS // 10


def _median(values: Iterable[int]) -> int:
    return statistics.median_low(list(values))


def _shifted(sample: Any, offset_ns: int) -> Any:
    if not offset_ns:
        return sample
    changes: dict[str, int] = {"stamp_ns": sample.stamp_ns - offset_ns}
    if hasattr(sample, "clock_offset_ns"):
        changes["clock_offset_ns"] = offset_ns
    return dataclasses.replace(sample, **changes)
