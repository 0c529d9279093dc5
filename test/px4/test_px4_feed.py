# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Messages of px4_msgs become samples with their own time; impossible ones are refused."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from hijack_detect.logs.px4 import INPUTS, readings, stamp_us
from hijack_detect.px4.clock import Px4Clock
from hijack_detect.px4.feed import Feed, OtherVersion
from hijack_detect.px4.topics import Px4BridgeParameters, Px4Topic, px4_topics
from hijack_detect.streams.messages import BadMessage, check
from hijack_detect.streams.samples import ImuSample, SatelliteSample
from stress.fuzz.small_logs import PX4

US = 1_750_000_000_000_000


def imu(**fields: Any) -> Any:
    given = {
        "timestamp": US + 2500,
        "timestamp_sample": US,
        "delta_angle": (0.002, 0.004, -0.006),
        "delta_angle_dt": 4000,
        "delta_velocity": (0.01, 0.02, -0.04),
        "delta_velocity_dt": 5000,
    }
    return SimpleNamespace(**{**given, **fields})


def test_every_type_that_is_read_is_defined_with_its_times() -> None:
    assert set(PX4) == set(INPUTS)
    store = get_typestore(Stores.ROS2_JAZZY)
    for kind, text in PX4.items():
        store.register(get_types_from_msg(text, kind))
        names = [name for name, _ in store.fielddefs[kind][1]]
        assert names[0] == "timestamp"
        assert ("timestamp_sample" in names) == (kind != "px4_msgs/msg/SensorCombined")


def test_increments_of_a_vehicle_imu_are_divided_by_their_time() -> None:
    (one,) = readings("imu", imu(), stamp_us("imu", imu()) * 1000)
    assert isinstance(one.value, ImuSample)
    assert one.value.stamp_ns == US * 1000
    assert one.value.angular_velocity == pytest.approx((0.5, -1.0, 1.5))
    assert one.value.specific_force == pytest.approx((2.0, -4.0, 8.0))
    with pytest.raises(BadMessage, match="delta_velocity_dt is 0"):
        list(readings("imu", imu(delta_velocity_dt=0), US * 1000))


def test_the_time_of_the_sample_is_taken_where_it_makes_sense() -> None:
    at = SimpleNamespace
    assert stamp_us("imu", at(timestamp=US)) == US
    assert stamp_us("mag", at(timestamp=US + 3, timestamp_sample=US)) == US
    offset_us = US - 40_000_000
    unset = at(timestamp=US, timestamp_sample=offset_us)
    assert stamp_us("pressure", unset) == US, "0 that the agent has moved to UTC"
    assert stamp_us("fix", at(timestamp=US + 3, timestamp_sample=US)) == US + 3
    with pytest.raises(BadMessage, match="timestamp is 0"):
        stamp_us("imu", at(timestamp=0))
    with pytest.raises(BadMessage, match="after 2038"):
        stamp_us("imu", at(timestamp=2**63))


def test_a_sample_is_held_to_the_limits_of_messages() -> None:
    check(SatelliteSample(0, 14))
    for bad, said in (
        (SatelliteSample(0, 255), "satellites is 255"),
        (ImuSample(0, (0.0, math.nan, 0.0), (0.0, 0.0, 9.8)), "angular_velocity.y is nan"),
    ):
        with pytest.raises(BadMessage, match=said):
            check(bad)


def test_a_message_of_another_size_is_of_another_version() -> None:
    feed = Feed(Px4Topic("imu", "fmu/out/sensor_combined", "px4_msgs/msg/SensorCombined"), 52)
    for size in (49, 52, 55):
        feed.check_size(bytes(size))
    for size in (4, 48, 56):
        with pytest.raises(OtherVersion, match=f"it has {size} bytes, .* here has 52"):
            feed.check_size(bytes(size))


def test_a_report_says_what_to_do() -> None:
    combined, _, mag, _ = px4_topics(Px4BridgeParameters())
    silent: list[str] = []
    clock = Px4Clock(silent.append, silent.append)
    feed = Feed(combined, 52)
    assert feed.report(1.0, 0)[:2] == (
        False,
        "nobody publishes it: is the agent running, and in this ROS_DOMAIN_ID? Nothing works "
        "without it",
    )
    assert feed.report(1.0, 1)[:2] == (True, "0.0 Hz")
    assert feed.report(1.0, 1)[:2] == (False, "there is a publisher, and nothing comes")
    message = SimpleNamespace(timestamp=US, gyro_rad=(0, 0, 0), accelerometer_m_s2=(0, 0, -9.8))
    for _ in range(100):
        feed.received += 1
        assert len(list(feed.take(message, clock, US * 1000))) == 1
    well, text, values = feed.report(0.5, 1)
    assert (well, text) == (True, "200.0 Hz")
    assert (values["rate Hz"], values["last stamp"]) == ("200.0", "1750000000.000000")
    assert Feed(mag, 40).report(1.0, 0)[0], "what is not needed is no fault"


def test_topics_follow_the_parameters_and_are_found_in_their_versions() -> None:
    given = Px4BridgeParameters(prefix="/x/", imu="vehicle_imu", gps="sensor_gps", mag="")
    found = {one.name: (one.topic, one.msgtype.rpartition("/")[2]) for one in px4_topics(given)}
    assert found == {
        "imu": ("/x/vehicle_imu", "VehicleImu"),
        "fix": ("/x/sensor_gps", "SensorGps"),
        "pressure": ("/x/vehicle_air_data", "VehicleAirData"),
    }
    (first, *_) = px4_topics(Px4BridgeParameters())
    names = ["/a", "/a_v1", "/a_v12", "/a_vx", "/a_v1/b", "/b/a_v1"]
    assert first.versions("/a", names) == ["/a_v1", "/a_v12"]
    with pytest.raises(ValueError, match="parameter 'gps' is empty"):
        px4_topics(Px4BridgeParameters(gps=""))
