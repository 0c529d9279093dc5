# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Finds which input of a detector has stopped, so that silence is never taken for normal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from hijack_detect.detectors.verdict import State
from hijack_detect.parameters import param
from hijack_detect.streams.samples import NANOSECONDS, GpsSample


class SetBack:
    """Follows the refused samples of one input.

    After a clock was set back, samples are refused until their stamps have caught up, but among
    themselves they go on in order. Single stamps that repeat or run back, and those of a second
    publisher, stand between samples that are in order.
    """

    def __init__(self) -> None:
        """Start without samples."""
        self._last: GpsSample | None = None
        self._refused: tuple[GpsSample, ...] = ()
        """The newest ones since the last that was in order, while they go on: two at most."""

    def goes_on(self, sample: GpsSample, last: GpsSample) -> bool:
        """Whether a refused sample follows on another one since the last that was in order."""
        newest = self._refused[-1:] if last is self._last else ()
        goes_on = bool(newest) and sample.stamp_ns > newest[0].stamp_ns
        self._last, self._refused = last, (*newest, sample) if goes_on else (sample,)
        return goes_on

    def caught_up(self, stamp_ns: int) -> tuple[GpsSample, ...]:
        """The newest two that were refused, once a stamp is the first above those before them.

        It is empty at all other stamps, and where no clock was set back. Refused samples are
        reported while samples that came before them still wait for others.
        """
        if self._last is None or stamp_ns <= self._last.stamp_ns:
            return ()
        refused, self._last, self._refused = self._refused, None, ()
        return refused if len(refused) > 1 else ()


SILENT_NS = 3 * NANOSECONDS // 2
"""An input without a sample for this long has stopped; receivers give at least one fix a second."""
REPEAT_NS = NANOSECONDS
"""A detector that cannot evaluate reports it this often."""


def patience() -> Any:
    """Declare how long a detector waits for the estimators' nodes."""
    return param(
        10.0,
        "How long to wait for another node of the monitor that has gone silent, on the stamps of "
        "the other inputs. It must be longer than the estimator waits for a sensor (3 s). Costs "
        "time only when a node has died. For replays faster than real time far larger.",
        source="chosen, not swept: a node that launch starts again is back within 10 s",
        unit="s",
        low=4.0,
        high=3600.0,
    )


class InputWatch:
    """Keeps the newest stamp of each input of a detector."""

    def __init__(self, names: Sequence[str]) -> None:
        """Watch the named inputs."""
        self._last: dict[str, int | None] = dict.fromkeys(names)
        self._reported_ns: int | None = None

    def see(self, name: str, stamp_ns: int) -> None:
        """Note a sample of an input."""
        self._last[name] = stamp_ns

    def lost(self, stamp_ns: int) -> tuple[State, str] | None:
        """State and reason if an input has stopped or never begun; None if all are alive."""
        for name, last_ns in self._last.items():
            if last_ns is None:
                return State.NOT_READY, f"no {name} yet"
            if stamp_ns - last_ns > SILENT_NS:
                seconds = (stamp_ns - last_ns) / NANOSECONDS
                return State.STALE, f"no {name} for {seconds:.1f} s"
        return None

    def due(self, stamp_ns: int) -> bool:
        """Whether it is time to report again, outside the usual evaluations, what is lost."""
        if self._reported_ns is None:
            self._reported_ns = stamp_ns
        if stamp_ns - self._reported_ns < REPEAT_NS or self.lost(stamp_ns) is None:
            return False
        self._reported_ns = stamp_ns
        return True
