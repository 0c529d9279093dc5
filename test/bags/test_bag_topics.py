# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Which topic is which input."""

import pytest

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.topics import (
    OPTIONAL_INPUTS,
    OWN_TOPICS,
    PRESETS,
    TYPES,
    TopicMap,
    detect,
    remaps,
    topic_map,
)


def types_of(preset: TopicMap) -> dict[str, str]:
    return {topic: TYPES[name] for name, topic in preset.items()}


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_is_found(name: str) -> None:
    assert topic_map("auto", types_of(PRESETS[name])) == PRESETS[name]
    assert topic_map(name, {}) == PRESETS[name]


def test_mavros_names() -> None:
    mavros = PRESETS["mavros"]
    assert mavros.imu == "/mavros/imu/data_raw"
    assert mavros.fix == "/mavros/global_position/raw/fix"
    assert mavros.velocity == "/mavros/global_position/raw/gps_vel"


def test_an_input_that_the_bag_lacks_is_none() -> None:
    topics = types_of(PRESETS["default"])
    del topics["/gps/vel"]
    topics["/mag"] = "std_msgs/msg/String"
    found = detect(topics)
    assert found.velocity is None
    assert found.mag is None
    assert found.pressure == "/pressure"


def test_a_namespace_is_found() -> None:
    found = detect({f"/d7{topic}": kind for topic, kind in types_of(PRESETS["mavros"]).items()})
    assert found.fix == "/d7/mavros/global_position/raw/fix"


def test_single_topics_are_found_by_type() -> None:
    found = detect(
        {
            "/a": TYPES["imu"],
            "/b": TYPES["fix"],
            "/truth/fix": TYPES["fix"],
            "/c": TYPES["velocity"],
            "/counter": TYPES["satellites"],
        }
    )
    assert found == TopicMap(imu="/a", fix="/b", velocity="/c")


def test_two_of_a_type_need_a_person() -> None:
    with pytest.raises(BagError, match=r"several sensor_msgs/msg/Imu topics \(/a, /b\)"):
        detect({"/a": TYPES["imu"], "/b": TYPES["imu"], "/c": TYPES["fix"]})


def test_none_lists_topics_and_presets() -> None:
    with pytest.raises(BagError, match=r"no sensor_msgs/msg/NavSatFix.*/a .*default, mavros"):
        detect({"/a": TYPES["imu"], "/truth/fix": TYPES["fix"]})


def test_unknown_preset() -> None:
    with pytest.raises(BagError, match="no preset 'px4'; use auto or one of default, mavros"):
        topic_map("px4", {})


def test_remaps() -> None:
    assert remaps(TopicMap(imu="/a/imu", fix="/b")) == {"/a/imu": "imu/data_raw", "/b": "gps/fix"}


def test_all_but_imu_and_fix_may_be_absent() -> None:
    assert set(OPTIONAL_INPUTS) == set(OWN_TOPICS) - {"imu", "fix"}
