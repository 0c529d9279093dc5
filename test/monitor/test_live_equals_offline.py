# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The same bag gives the same verdicts offline and live, at any rate, to the bit."""

from __future__ import annotations

import math
import signal
import time
from collections.abc import Sequence
from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from live import (
    SCENARIO,
    SECOND,
    Live,
    assert_same,
    expected,
    offline,
    replay,
    stamp_ns,
    start_monitor,
    values_of,
)
from ros import ROOT, Graph

from hijack_detect.nodes import COMPOSED, MONITOR

FLIGHTS = ROOT / ".." / "shared" / "flights"
OWN = ROOT / "bags/curved_8"
SIMULATED = FLIGHTS / "sitl/dev_008_curved"
REAL = FLIGHTS / "bags/inertialnav__quad106"
"""A real flight without magnetometer."""
SPIN_S = 180.0
LATE_S = 30.0
"""A monitor that has not said everything so long after the last message has lost some."""
LAST_S = 5.0
"""The end of a part of a bag for which verdicts may still be held back."""


def said(live: Live, name: str) -> list[DiagnosticArray]:
    """Verdicts, without the words of the fusion about silence once nothing comes any more."""
    return [one for one in live.verdicts[name].messages if "silent_s" not in values_of(one)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bag", "policy", "rate", "duration_s", "programs"),
    [
        pytest.param(OWN, "default", 4.0, 0.0, MONITOR, id="own-default-4x"),
        pytest.param(REAL, "paper", 5.0, 75.0, MONITOR, id="real-paper-5x"),
        pytest.param(OWN, "paper", 6.0, 0.0, [COMPOSED], id="own-paper-6x-composed"),
        pytest.param(
            SIMULATED, "default", 6.0, 90.0, [COMPOSED], id="simulated-default-6x-composed"
        ),
    ],
)
def test_every_verdict_of_a_spoofed_flight_is_the_same(
    graph: Graph, bag: Path, policy: str, rate: float, duration_s: float, programs: Sequence[str]
) -> None:
    if not bag.is_dir():
        pytest.skip("the recorded flights (../shared/flights) are not here")
    run = offline(bag, policy, SCENARIO, duration_s + LAST_S if duration_s else math.inf)
    live = start_monitor(graph, policy, programs)
    nodes = ("fusion", "monitor") if programs == [COMPOSED] else programs
    replay(graph, bag, SPIN_S, nodes, rate=rate, scenario=SCENARIO, duration_s=duration_s)
    end_ns = run.start_ns + round((duration_s - LAST_S) * SECOND)
    latest_s = time.monotonic() + LATE_S
    for name, wanted in expected(run).items():
        last_ns = end_ns if duration_s else stamp_ns(wanted[-1])
        if not duration_s and programs != [COMPOSED]:
            last_ns -= SECOND  # nodes by themselves do not know that nothing more will come

        def complete(name: str = name, last_ns: int = last_ns) -> bool:
            heard = said(live, name)
            if time.monotonic() > latest_s:  # what is missing is told below
                return True
            return bool(heard) and stamp_ns(heard[-1]) >= last_ns

        graph.spin_until(complete, f"the end of {name}")
    printed = "".join(node.output for node in live.nodes.values())
    late = [line for line in printed.splitlines() if "left out" in line]

    for name, wanted in expected(run).items():
        heard = said(live, name)
        assert heard, printed
        if duration_s:
            assert stamp_ns(heard[-1]) > end_ns
        elif programs == [COMPOSED]:
            assert len(heard) == len(wanted)
        else:
            assert stamp_ns(heard[-1]) > stamp_ns(wanted[-1]) - SECOND
        wanted = wanted[: len(heard)]  # noqa: PLW2901
        assert_same(name, heard, wanted, late)
    assert late == []

    first_alert = next(result.stamp_ns for result in run.results if result.alert)
    alerts = [one for one in live.verdicts["fusion"].messages if values_of(one)["alert"] == "true"]
    assert stamp_ns(alerts[0]) == first_alert
    assert {values_of(one)["alert_since_ns"] for one in alerts} == {str(first_alert)}
    graph.spin_until(lambda: live.alert.messages[-1].data, "hijack_alert")
    for node in live.nodes.values():
        node.signal(signal.SIGINT)
    assert [node.interrupted() for node in live.nodes.values()] == [0] * len(live.nodes)
