# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Messages that no sensor can mean, and a clock that is set back: told, and the node goes on."""

from __future__ import annotations

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from feed import NODES, Fed
from live import SECOND, values_of
from ros import Graph


@pytest.mark.parametrize("node", NODES)
def test_bad_messages_are_counted_and_a_clock_set_back_starts_afresh(
    graph: Graph, node: str
) -> None:
    fed = Fed(graph, node)
    fed.until_more_output()

    at_ns = fed.stamp_ns + 1
    wanted = {}
    for one in fed.inputs:
        for make in one.bad.values():
            fed.send(one, make(at_ns))
        if one.stamped:
            for back_ns in (0, SECOND // 20):
                fed.send(one, one.good(fed.stamp_ns - back_ns))
            wanted[f"{one.name}: stamp does not increase"] = 2
        if one.bad:
            wanted[f"{one.name}: bad message"] = len(one.bad)
    fed.until_left_out(wanted)
    warned = [one for one in fed.reports() if one.level == DiagnosticStatus.WARN]
    assert all(any(f"{reason} (" in one.message for one in warned) for reason in wanted)
    log = fed.process.output
    seconds = f"{at_ns // SECOND}.{at_ns % SECOND:09d}"
    for one in fed.inputs:
        stamped = f" stamped {seconds}" if one.stamped else ""
        line = f"/{one.topic}: message{stamped} left out: "
        assert not one.bad or (line in log and any(told in log for told in one.bad)), log
    assert all(f"left out: {reason}" in log for reason in wanted)

    fed.until_more_output()
    graph.spin_until(lambda: fed.reports()[-1].level == DiagnosticStatus.OK, "OK again")
    assert fed.left_out() == wanted
    assert values_of(fed.reports()[-1])["restarts"] == "0"

    fed.stamp_ns -= 100 * SECOND
    fed.good(2)
    fed.until_more_output()
    graph.spin_until(lambda: values_of(fed.reports()[-1])["restarts"] == "1", "a restart")
    further = {reason: count for reason, count in fed.left_out().items() if reason not in wanted}
    assert fed.left_out() == {**further, **wanted}
    assert f"{fed.inputs[0].name}: stamp jumps" in further
    assert all(reason.endswith(": stamp jumps") for reason in further)
    assert set(further.values()) == {1}
    assert fed.process.interrupt() == 0
    assert "Traceback" not in fed.process.output
    assert "internal error" not in fed.process.output


@pytest.mark.parametrize("node", ["coast_detector", "date_detector"])
def test_bytes_that_are_no_message_are_counted_and_the_node_goes_on(
    graph: Graph, node: str
) -> None:
    fed = Fed(graph, node)
    fed.until_more_output()
    one = next(one for one in fed.inputs if one.name in ("imu", "attitude"))
    fed.publishers[one.name].publish(b"\x00\x01\x00\x00 cut off")
    fed.until_left_out({f"{one.name}: bad message": 1})
    assert f"/{one.topic}: message left out: internal error" in fed.process.output
    fed.until_more_output()
    assert fed.process.interrupt() == 0
    assert "Traceback" not in fed.process.output
