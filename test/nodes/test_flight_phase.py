# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The phase of the flight on its topic, there and back."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.nodes.messages import phase_message
from hijack_detect.streams.messages import BadMessage, phase_sample
from hijack_detect.streams.samples import Phase, PhaseSample


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
