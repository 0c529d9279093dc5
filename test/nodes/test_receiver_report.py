# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What is said of a receiver on /diagnostics: once a second, and at once where it changes."""

from __future__ import annotations

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from live import SECOND, values_of
from ros import Graph

from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.nodes.detector_node import (
    CLOCK,
    GROWTH,
    LATENCY,
    RECEIVER,
    ReceiverReport,
    Subject,
)
from hijack_detect.nodes.diagnostics import Diagnostics


@pytest.mark.parametrize(
    ("subject", "values", "words"),
    [
        (LATENCY, {"late_gps": 0.38}, "the GPS is late: lags by 0.38 s or more"),
        (RECEIVER, {"poor_satellites": 4.0}, "the receiver is poor by its own word: 4 satellites"),
        (
            GROWTH,
            {"later_s": 0.8},
            "the GPS has become later by 0.8 s, which explains its position",
        ),
        (CLOCK, {"clock_rate": 1.0833}, "the clock of the stamps runs 7.7 % slow"),
    ],
)
def test_a_fault_is_a_warning_while_it_lasts(
    graph: Graph, subject: Subject, values: dict[str, float], words: str
) -> None:
    heard = graph.listen(DiagnosticArray, "/diagnostics")
    report = ReceiverReport(Diagnostics(graph.node), graph.node.get_logger(), subject)
    for at_s in (1.0, 1.2, 1.4, 1.6, 2.0, 2.2):
        wrong = 1.3 < at_s < 2.1
        own = {"score": 1.0, **(values if wrong else {})}
        report.add(Verdict("any", round(at_s * SECOND), State.NORMAL, 0.0, 1.0, "", own))

    def told() -> list[DiagnosticStatus]:
        own = f"{graph.node.get_fully_qualified_name()}: {subject.name}"
        return [one for each in heard.messages for one in each.status if one.name == own]

    graph.spin_until(lambda: len(told()) >= 4, "four statuses")
    good, warning = (DiagnosticStatus.OK, subject.good), (DiagnosticStatus.WARN, words)
    assert [(one.level, one.message) for one in told()] == [good, warning, warning, good]
    shown = {name: f"{value:.{subject.digits}f}" for name, value in values.items()}
    assert [values_of(one) for one in told()] == [{}, shown, shown, {}]
