# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Messages to the ground station and the autopilot on an alert."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Protocol

from hijack_detect.contract import SILENT_S, START_S
from hijack_detect.mavlink.codec import TEXT_BYTES
from hijack_detect.monitor.verdict_messages import FusionStatus
from hijack_detect.streams.samples import NANOSECONDS

SILENT_NS, START_NS = round(SILENT_S * NANOSECONDS), round(START_S * NANOSECONDS)
CAUSE_NS = 3 * NANOSECONDS // 10
"""Timeout of the cause of an alert. Chosen: it follows the alert within milliseconds."""
SILENT, HEARD, OVER = "hijack monitor silent", "hijack monitor heard", "hijack alert is over"


class Severity(IntEnum):
    """Values of MAV_SEVERITY."""

    EMERGENCY = 0
    WARNING = 4
    NOTICE = 5


@dataclass(frozen=True)
class Text:
    """A STATUSTEXT."""

    severity: Severity
    text: str


@dataclass(frozen=True)
class Cause:
    """Cause of an alert, from fusion/verdict: when it began (text), why, and which detectors."""

    since: str
    words: str
    detectors: tuple[str, ...]


def cause_of(fused: FusionStatus) -> Cause | None:
    """Cause of the alert in a fusion/verdict; None without an alert."""
    if not fused.alert:
        return None
    since = "" if fused.alert_since_ns is None else str(fused.alert_since_ns)
    return Cause(since, fused.reason, fused.causes)


class Memory(Protocol):
    """The alert that was acted on, kept beyond the end of this process."""

    def read(self) -> str | None:
        """When that alert began, empty if that is not known; None without one."""

    def write(self, since: str) -> None:
        """Note it."""

    def forget(self) -> None:
        """It is over."""


class Alarm:
    """Follows one alert after the other.

    An alert is acted on once: not again while it is repeated, not after the monitor was silent,
    and not after a restart of this process in the middle of it.
    """

    def __init__(self, memory: Memory, text_period_ns: int, now_ns: int) -> None:
        """Begin; the monitor has START_NS for its first message."""
        self._memory, self._period_ns = memory, text_period_ns
        self._silent_from_ns = now_ns + START_NS
        self._on = False
        self._on_ns = self._sent_ns = now_ns
        self._acted = self._received = self._silent = False
        self._cause: Cause | None = None

    @property
    def on(self) -> bool:
        """Whether there is an alert."""
        return self._on

    @property
    def silent(self) -> bool:
        """Whether the monitor is missing."""
        return self._silent

    @property
    def received(self) -> bool:
        """Whether the monitor has ever published."""
        return self._received

    def update(self, now_ns: int, *, alert: bool) -> list[Text]:
        """Take a message of the monitor; the texts to send at once."""
        self._silent_from_ns = now_ns + SILENT_NS
        self._received = True
        texts = []
        if self._silent:
            self._silent = False
            texts.append(Text(Severity.NOTICE, HEARD))
        if alert and not self._on:
            self._on_ns, self._acted = now_ns, False
        elif not alert:
            self._memory.forget()
            self._cause = None
            if self._on and self._acted:
                texts.append(Text(Severity.NOTICE, OVER))
        self._on = alert
        return texts

    def explain(self, cause: Cause | None) -> None:
        """Take the cause of the alert; None without an alert."""
        self._cause = cause

    def due(self, now_ns: int) -> tuple[list[Text], bool]:
        """The texts that are due, and whether to command the autopilot."""
        if now_ns >= self._silent_from_ns and not self._silent:
            self._silent = True
            return [Text(Severity.WARNING, SILENT)], False
        if not self._on or self._silent:
            return [], False
        if not self._acted:
            if self._cause is None and now_ns - self._on_ns < CAUSE_NS:
                return [], False
            self._acted, self._sent_ns = True, now_ns
            return [self.text()], not self._was_acted_on()
        if now_ns - self._sent_ns >= self._period_ns:
            self._sent_ns = now_ns
            return [self.text()], False
        return [], False

    def acted(self) -> None:
        """Note that the autopilot is commanded: not again for this alert. Raises OSError."""
        self._memory.write(self._since)

    def text(self) -> Text:
        """The alert in as many words as fit."""
        words = ["GPS SPOOFED? hijack alert"]
        if self._cause is not None:
            names = ", ".join(self._cause.detectors)
            words = [f"GPS SPOOFED? {self._cause.words}", f"GPS SPOOFED? found by {names}", *words]
        fit = [one for one in words if len(one) <= TEXT_BYTES and one.rstrip() == one]
        return Text(Severity.EMERGENCY, fit[0])

    @property
    def _since(self) -> str:
        return "" if self._cause is None else self._cause.since

    def _was_acted_on(self) -> bool:
        """Whether the process before this one has acted on this very alert."""
        before = self._memory.read()
        return before is not None and (not before or not self._since or before == self._since)
