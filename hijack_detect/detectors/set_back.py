# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Tells a receiver whose clock was set back from one whose stamps are broken."""

from __future__ import annotations

from hijack_detect.streams.samples import GpsSample


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

        It is empty at all other stamps, and where no clock was set back. Refused samples are told
        of while samples that came before them still wait for others.
        """
        if self._last is None or stamp_ns <= self._last.stamp_ns:
            return ()
        refused, self._last, self._refused = self._refused, None, ()
        return refused if len(refused) > 1 else ()
