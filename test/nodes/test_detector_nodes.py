"""What a detector's node says beside its verdict: a Bool for managers, Float64 for plots."""

from __future__ import annotations

import math

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from feed import GPS_NS, VELOCITY, Fed, velocity
from live import SECOND, values_of
from ros import Graph
from std_msgs.msg import Bool, Float64

FIGURES = {
    "correlation": ("coefficient", "mean_difference"),
    "date": ("delta_ax", "delta_ay"),
}


@pytest.mark.parametrize("detector", FIGURES)
def test_every_verdict_has_its_flag_and_figures(graph: Graph, detector: str) -> None:
    fed = Fed(graph, f"{detector}_detector")
    hijacked = graph.listen(Bool, f"{detector}/hijacked")
    figures = {name: graph.listen(Float64, f"{detector}/{name}") for name in FIGURES[detector]}
    topics = [f"/{detector}/{name}" for name in ("hijacked", *figures)]
    graph.spin_until(lambda: all(map(graph.node.count_publishers, topics)), "the topics")
    fed.good(30)
    graph.spin_until(lambda: len(fed.output.messages) >= 28, "verdicts")
    verdicts = fed.output.messages
    for listener in (hijacked, *figures.values()):
        graph.spin_until(lambda heard=listener: len(heard.messages) == len(verdicts), "figures")
    assert not any(one.data for one in hijacked.messages)
    for name, listener in figures.items():
        told = [float(values_of(one).get(name, math.nan)) for one in verdicts]
        heard = [one.data for one in listener.messages]
        assert [repr(one) for one in heard] == [repr(one) for one in told]
        assert math.isnan(heard[0])
    assert values_of(verdicts[0])["state"] == "not_ready"
    assert fed.process.interrupt() == 0


def test_hijacked_is_true_while_date_alarms(graph: Graph) -> None:
    fed = Fed(graph, "date_detector")
    hijacked = graph.listen(Bool, "date/hijacked")
    graph.spin_until(lambda: graph.node.count_publishers("/date/hijacked"), "date/hijacked")
    fed.good(15)
    fed.inputs = [one for one in fed.inputs if one is not VELOCITY]
    began_ns = fed.stamp_ns
    for _ in range(15):  # the reported velocity gains 4 m/s each second, the vehicle does not
        stamp_ns = fed.stamp_ns + GPS_NS
        fed.send(VELOCITY, velocity(stamp_ns, 5.0 + 4.0 * (stamp_ns - began_ns) / SECOND))
        fed.good(1)
    graph.spin_until(lambda: any(one.data for one in hijacked.messages), "date/hijacked")
    alarms = [one for one in fed.output.messages if values_of(one)["state"] == "alarm"]
    assert alarms[0].status[0].level == DiagnosticStatus.ERROR
    assert fed.process.interrupt() == 0
    lines = [line for line in fed.process.output.splitlines() if "[date_detector]" in line]
    states = [line.split("]: ")[1].split()[0] for line in lines if " margin " in line]
    assert states == ["not_ready", "normal", "suspicious", "alarm"]
