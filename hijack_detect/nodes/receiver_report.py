# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What a detector says of the receiver beside its verdict, on /diagnostics and in the log."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.impl.rcutils_logger import RcutilsLogger

from hijack_detect.detectors.verdict import Verdict
from hijack_detect.nodes.diagnostics import Diagnostics
from hijack_detect.streams.samples import NANOSECONDS


@dataclass(frozen=True)
class Subject:
    """Something that can be wrong with a receiver.

    Attributes:
        name: Its name on /diagnostics, after the node's.
        figures: Values that a verdict has only while something is wrong.
        words: Says them; empty without any.
        good: What is said without any.
        over: What is logged once there are none any more.
        title: What stands before the words, if they need it.
        digits: Decimals of the values on /diagnostics.
    """

    name: str
    figures: frozenset[str]
    words: Callable[[Mapping[str, float]], str]
    good: str
    over: str
    title: str = ""
    digits: int = 1


class ReceiverReport:
    """A status once a second of the verdicts' stamps, and at once where something begins or ends.

    A WARN while something is wrong; its begin and end go to the log, too.
    """

    def __init__(self, diagnostics: Diagnostics, log: RcutilsLogger, subject: Subject) -> None:
        """Report as the node whose diagnostics and logger these are."""
        self._diagnostics, self._log, self._subject = diagnostics, log, subject
        self._wrong, self._second = False, 0

    def add(self, verdict: Verdict) -> None:
        """Take the next verdict."""
        subject, values = self._subject, verdict.values
        words = subject.words(values)
        wrong = f"{subject.title}: {words}" if words and subject.title else words
        news, self._wrong = bool(wrong) is not self._wrong, bool(wrong)
        second = verdict.stamp_ns // NANOSECONDS
        if news or second != self._second:
            self._second = second
            level = DiagnosticStatus.WARN if wrong else DiagnosticStatus.OK
            figures = {
                name: f"{values[name]:.{subject.digits}f}"
                for name in sorted(subject.figures & values.keys())
            }
            self._diagnostics.tell(subject.name, level, wrong or subject.good, figures)
        if news:
            self._log.info(wrong or subject.over)
