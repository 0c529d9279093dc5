# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The phase of the flight on its topic, there and back, and on /diagnostics."""

from __future__ import annotations

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from feed import START_NS, imu
from hypothesis import given
from hypothesis import strategies as st
from live import SECOND, values_of
from ros import KEEP_ALL, Graph
from sensor_msgs.msg import Imu

from hijack_detect.nodes.messages import phase_message
from hijack_detect.streams.messages import BadMessage, phase_sample
from hijack_detect.streams.samples import Phase, PhaseSample

HZ = 50


@given(
    st.integers(0, 2**60),
    st.sampled_from(Phase),
    st.integers(0, 2**60),
    st.floats(0.0, 1e4),
    st.sampled_from(["", "the accelerometer clips at 14 m/s²"]),
)
def test_a_phase_comes_back_to_the_bit(
    stamp_ns: int, phase: Phase, since_ns: int, rate_hz: float, fault: str
) -> None:
    sample = PhaseSample(stamp_ns, phase, since_ns, "why", rate_hz, fault)
    assert phase_sample(phase_message(sample)) == sample


@pytest.mark.parametrize("key", ["phase", "since_ns", "imu_rate_hz", "imu_fault"])
def test_what_is_missing_or_wrong_is_named(key: str) -> None:
    message = phase_message(PhaseSample(1, Phase.FLYING, 1, "why", 100.0))
    status = message.status[0]
    status.values = [one for one in status.values if one.key != key]
    with pytest.raises(BadMessage, match=key):
        phase_sample(message)


def test_phase_and_a_wrong_imu_are_told_on_diagnostics(graph: Graph) -> None:
    phases = graph.listen(DiagnosticArray, "flight_phase")
    diagnostics = graph.listen(DiagnosticArray, "/diagnostics")
    process = graph.start("flight_phase")
    output = graph.node.create_publisher(Imu, "imu/data_raw", KEEP_ALL)
    graph.spin_until(output.get_subscription_count, "its subscription")
    graph.until_known("flight_phase")

    def told() -> list[DiagnosticStatus]:
        found = [one for message in diagnostics.messages for one in message.status]
        return [one for one in found if one.name == "/flight_phase: phase of the flight"]

    stamp_ns = START_NS

    def flown() -> bool:
        nonlocal stamp_ns
        for _ in range(HZ // 10):
            stamp_ns += SECOND // HZ
            output.publish(imu(stamp_ns, force_z=19.6))
        return any(one.level == DiagnosticStatus.WARN for one in told())

    graph.spin_until(flown, "a word about the wrong IMU")
    values = values_of(told()[-1])
    assert values["phase"] in ("unknown", "standing")
    assert "specific force" in values["imu_fault"]
    assert float(values["imu_rate_hz"]) == pytest.approx(HZ, rel=0.1)
    assert [one.key for one in told()[-1].values] == [
        one.key for one in phases.messages[-1].status[0].values
    ]
    assert process.interrupt() == 0
