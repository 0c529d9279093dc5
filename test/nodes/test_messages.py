# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Samples and verdicts survive their trip through ROS messages to the bit."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import QuaternionStamped
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import Imu

from hijack_detect.detectors.fusion import FusionResult
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.mavlink.alarm import Cause, cause_of
from hijack_detect.monitor.verdict_messages import FusionStatus, fusion_from, verdict_from
from hijack_detect.nodes.messages import (
    LEVELS,
    course_message,
    fusion_message,
    imu_message,
    time_message,
    verdict_message,
)
from hijack_detect.streams.messages import BadMessage, attitude_sample, course_sample
from hijack_detect.streams.samples import AttitudeSample, CourseSample

SECOND = 1_000_000_000
STAMPS = st.integers(0, 2**31 * SECOND - 1)
FINITE = st.floats(allow_nan=False, allow_infinity=False)
NUMBERS = st.floats(allow_nan=False)
TEXTS = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=30)
OWN_KEYS = {"state", "score", "threshold", "margin"}
VERDICTS = st.builds(
    Verdict,
    TEXTS,
    STAMPS,
    st.sampled_from(State),
    FINITE,
    st.floats(1e-300, 1e300),
    TEXTS,
    st.dictionaries(TEXTS.filter(lambda key: key not in OWN_KEYS), NUMBERS, max_size=4),
)


def vectors(limit: float) -> st.SearchStrategy[tuple[float, float, float]]:
    return st.tuples(*[st.floats(-limit, limit)] * 3)


def over_the_wire(message: Any) -> Any:
    return deserialize_message(serialize_message(message), type(message))


def heading_quaternion(angle: float) -> tuple[float, float, float, float]:
    return (0.0, 0.0, math.sin(angle / 2), math.cos(angle / 2))


@given(VERDICTS)
def test_a_verdict_comes_back_to_the_bit(verdict: Verdict) -> None:
    back = verdict_from(over_the_wire(verdict_message(verdict)))
    assert back == verdict
    assert repr(back) == repr(verdict)  # tells -0.0 from 0.0


@pytest.mark.parametrize("state", State)
def test_every_state_has_the_level_that_a_diagnostics_tool_shows(state: State) -> None:
    told = verdict_message(Verdict("date", 5, state, 3.0, 1.5, "because", {"delta_ax": 0.1}))
    status = told.status[0]
    assert status.level == LEVELS[state]
    assert (status.name, status.message) == ("date", "because")
    assert {pair.key: pair.value for pair in status.values} == {
        "state": state.value, "score": "3.0", "threshold": "1.5", "margin": "2.0", "delta_ax": "0.1"
    }  # fmt: skip


@given(STAMPS)
def test_stamps_keep_every_nanosecond(stamp_ns: int) -> None:
    stamp = time_message(stamp_ns)
    assert stamp.sec * SECOND + stamp.nanosec == stamp_ns


@given(
    STAMPS,
    st.floats(-math.pi, math.pi),
    st.floats(0.0, allow_nan=False),
    vectors(100.0),
    vectors(1000.0),
)
def test_an_attitude_comes_back_to_the_bit(
    stamp_ns: int, angle: float, variance: float, omega: Any, force: Any
) -> None:
    sample = AttitudeSample(stamp_ns, heading_quaternion(angle), variance, omega, force)
    message = over_the_wire(imu_message(sample, "base_link"))
    assert attitude_sample(message) == sample
    assert message.header.frame_id == "base_link"
    assert message.orientation_covariance[0] > 0.0


@given(STAMPS, vectors(100.0), vectors(1000.0))
def test_without_orientation_the_covariance_is_minus_one(
    stamp_ns: int, omega: Any, force: Any
) -> None:
    sample = AttitudeSample(stamp_ns, None, math.inf, omega, force)
    message = over_the_wire(imu_message(sample, "base_link"))
    assert message.orientation_covariance[0] == -1.0
    assert attitude_sample(message) == sample


@given(STAMPS, st.floats(-math.pi, math.pi))
def test_a_course_comes_back_to_the_bit(stamp_ns: int, angle: float) -> None:
    sample = CourseSample(stamp_ns, math.sin(angle / 2), math.cos(angle / 2))
    message = over_the_wire(course_message(sample, "map"))
    assert course_sample(message) == sample
    assert message.quaternion.x == message.quaternion.y == 0.0


def test_no_course_is_all_zeros() -> None:
    message = over_the_wire(course_message(CourseSample(7, 0.0, 0.0), "map"))
    assert message.quaternion == QuaternionStamped(quaternion=message.quaternion).quaternion
    assert (message.quaternion.z, message.quaternion.w) == (0.0, 0.0)
    assert not course_sample(message).observable


def array(*pairs: tuple[str, str], statuses: int = 1) -> DiagnosticArray:
    values = [KeyValue(key=key, value=value) for key, value in pairs]
    status = DiagnosticStatus(name="date", values=values)
    return DiagnosticArray(status=[status] * statuses)


GOOD = (("state", "alarm"), ("score", "3.0"), ("threshold", "1.5"))


def with_pair(key: str, value: str) -> DiagnosticArray:
    return array(*(pair for pair in GOOD if pair[0] != key), (key, value))


def test_margin_and_figures_may_be_missing() -> None:
    assert verdict_from(array(*GOOD)) == Verdict("date", 0, State.ALARM, 3.0, 1.5, "")


@pytest.mark.parametrize(
    ("message", "told"),
    [
        (array(statuses=0), "has 0"),
        (array(*GOOD, statuses=2), "has 2"),
        (array(*GOOD[1:]), "no 'state'"),
        (array(GOOD[0], GOOD[2]), "no 'score'"),
        (array(*GOOD[:2]), "no 'threshold'"),
        (with_pair("state", "hijacked"), "'hijacked' is not a valid State"),
        (with_pair("score", "high"), "'high'"),
        (with_pair("score", "nan"), "score nan"),
        (with_pair("score", "inf"), "score inf"),
        (with_pair("threshold", "0.0"), "over 0.0"),
        (with_pair("threshold", "-1.5"), "over -1.5"),
        (with_pair("threshold", "nan"), "over nan"),
        (with_pair("delta_ax", ""), "could not convert"),
    ],
)
def test_a_broken_verdict_is_refused_and_the_text_says_why(
    message: DiagnosticArray, told: str
) -> None:
    with pytest.raises(BadMessage, match="verdict") as refused:
        verdict_from(message)
    assert told in str(refused.value)


def test_a_result_of_the_fusion_as_message() -> None:
    alarm = Verdict("date", 4, State.ALARM, 3.0, 1.5, "why")
    result = FusionResult(
        5, State.ALARM, True, 4, 1.0, "cause", {"date": alarm}, ("correlation",), ("date",)
    )
    status = fusion_message(result).status[0]
    assert (status.name, status.level, status.message) == (
        "fusion", DiagnosticStatus.ERROR, "cause"
    )  # fmt: skip
    assert {pair.key: pair.value for pair in status.values} == {
        "state": "alarm",
        "alert": "true",
        "alert_since_ns": "4",
        "confidence": "1.0",
        "lost": "correlation",
        "degraded": "correlation",
        "causes": "date",
        "date.state": "alarm",
        "date.margin": "2.0",
    }
    assert cause_of(fusion_from(fusion_message(result))) == Cause("4", "cause", ("date",))
    assert fusion_from(over_the_wire(fusion_message(result))) == FusionStatus(
        5, State.ALARM, True, 4, 1.0, ("correlation",), ("correlation",), ("date",), "cause"
    )
    quiet = dataclasses.replace(result, alert=False, alert_since_ns=None)
    assert cause_of(fusion_from(fusion_message(quiet))) is None
    for wrong in (verdict_message(alarm), DiagnosticArray()):
        with pytest.raises(BadMessage):
            fusion_from(wrong)


CALM = (
    ("state", "normal"),
    ("alert", "false"),
    ("alert_since_ns", ""),
    ("confidence", "nan"),
    ("lost", ""),
    ("degraded", "coast  drag"),
    ("causes", ""),
)


def test_a_message_of_the_fusion_is_read() -> None:
    status = fusion_from(array(*CALM))
    assert (status.state, status.alert, status.alert_since_ns) == (State.NORMAL, False, None)
    assert math.isnan(status.confidence)
    assert (status.lost, status.degraded, status.causes) == ((), ("coast", "drag"), ())


@pytest.mark.parametrize("missing", [key for key, _ in CALM])
def test_a_message_of_the_fusion_without_a_value_is_refused(missing: str) -> None:
    with pytest.raises(BadMessage, match=f"of the fusion has no '{missing}'"):
        fusion_from(array(*(pair for pair in CALM if pair[0] != missing)))


@pytest.mark.parametrize(
    ("key", "value", "told"),
    [
        ("state", "hijacked", "not a valid State"),
        ("alert", "maybe", "alert is 'maybe'"),
        ("alert_since_ns", "-1", "alert_since_ns is -1"),
        ("alert_since_ns", str(2**63), "alert_since_ns is 9223372036854775808"),
        ("alert_since_ns", "soon", "'soon'"),
        ("confidence", "high", "'high'"),
    ],
)
def test_a_broken_message_of_the_fusion_is_refused(key: str, value: str, told: str) -> None:
    with pytest.raises(BadMessage, match=f"verdict of the fusion: .*{told}"):
        fusion_from(array(*(pair for pair in CALM if pair[0] != key), (key, value)))


def test_an_imu_message_says_which_sensor_readings_it_carries() -> None:
    sample = AttitudeSample(1, None, math.inf, (0.1, 0.2, 0.3), (1.0, 2.0, 9.8))
    message = imu_message(sample, "imu_link")
    assert isinstance(message, Imu)
    assert (message.angular_velocity.z, message.linear_acceleration.z) == (0.3, 9.8)
