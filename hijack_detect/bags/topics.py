# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Which topic of a bag is which input."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields

from hijack_detect.bags.errors import BagError

TYPES = {
    "imu": "sensor_msgs/msg/Imu",
    "fix": "sensor_msgs/msg/NavSatFix",
    "velocity": "geometry_msgs/msg/TwistStamped",
    "mag": "sensor_msgs/msg/MagneticField",
    "pressure": "sensor_msgs/msg/FluidPressure",
    "satellites": "std_msgs/msg/UInt32",
}
"""Message type of each input."""

NEEDED = ("imu", "fix")
"""Inputs without which nothing can be judged; the others may be absent."""

OWN_TOPICS = {
    "imu": "imu/data_raw",
    "fix": "gps/fix",
    "velocity": "gps/vel",
    "mag": "mag",
    "pressure": "pressure",
    "satellites": "gps/satellites",
}
"""The relative topic that the nodes of this package subscribe for each input."""

OPTIONAL_INPUTS = tuple(name for name in TYPES if name not in NEEDED)
"""Inputs that may be absent: a detector works without them, if less well, or not at all."""


@dataclass(frozen=True)
class TopicMap:
    """The absolute topic of each input in a bag; None where the bag has no such input.

    Attributes:
        imu: Raw `sensor_msgs/Imu`, FLU (REP-103).
        fix: `sensor_msgs/NavSatFix`.
        velocity: GPS velocity, `geometry_msgs/TwistStamped` in ENU.
        mag: `sensor_msgs/MagneticField`, FLU.
        pressure: Static pressure, `sensor_msgs/FluidPressure`.
        satellites: Number of satellites, `std_msgs/UInt32`.
    """

    imu: str
    fix: str
    velocity: str | None = None
    mag: str | None = None
    pressure: str | None = None
    satellites: str | None = None

    def items(self) -> Iterator[tuple[str, str]]:
        """Yield input name and topic, of the inputs that have a topic."""
        for field in fields(self):
            topic = getattr(self, field.name)
            if topic is not None:
                yield field.name, topic


PRESETS = {
    "default": TopicMap(**{name: f"/{topic}" for name, topic in OWN_TOPICS.items()}),
    "mavros": TopicMap(
        imu="/mavros/imu/data_raw",
        fix="/mavros/global_position/raw/fix",
        velocity="/mavros/global_position/raw/gps_vel",
        mag="/mavros/imu/mag",
        pressure="/mavros/imu/static_pressure",
        satellites="/mavros/global_position/raw/satellites",
    ),
}
"""Topic maps by name: the topics of this package, and those of mavros."""


def remaps(topic_map: TopicMap) -> dict[str, str]:
    """Return, for each topic of a bag, the relative topic that the nodes subscribe."""
    return {topic: OWN_TOPICS[name] for name, topic in topic_map.items()}


def topic_map(name: str, topics: Mapping[str, str]) -> TopicMap:
    """Return a preset by name, or for `auto` the map that fits a bag.

    Args:
        name: `auto` or the name of a preset.
        topics: Type by topic, as in `BagReader.topics`.

    Raises:
        BagError: There is no such preset, or no map fits.
    """
    if name == "auto":
        return detect(topics)
    if name not in PRESETS:
        raise BagError(f"there is no preset {name!r}; use auto or one of {', '.join(PRESETS)}")
    return PRESETS[name]


def detect(topics: Mapping[str, str]) -> TopicMap:
    """Choose the topic map for a bag.

    The first preset for which the bag has Imu and NavSatFix under its names; then the same in a
    namespace (`/drone1/imu/data_raw`); then by type, where there is only one topic of the type.
    Topics under `/truth/` are references, never inputs.

    Args:
        topics: Type by topic, as in `BagReader.topics`.

    Raises:
        BagError: The bag has no Imu or no NavSatFix, or several between which only a person
            can choose.
    """
    inputs = {topic: kind for topic, kind in topics.items() if not topic.startswith("/truth/")}
    for preset in PRESETS.values():
        found = _in_namespace(preset, "", inputs)
        if found:
            return found
    spaces = [
        _in_namespace(preset, topic.removesuffix(preset.imu), inputs)
        for preset in PRESETS.values()
        for topic in sorted(inputs)
        if topic.endswith(preset.imu)
    ]
    complete = [found for found in spaces if found]
    if len(complete) == 1:
        return complete[0]
    return _by_type(inputs)


def _in_namespace(preset: TopicMap, namespace: str, topics: Mapping[str, str]) -> TopicMap | None:
    """Return the part of a preset that the bag has, None without Imu and NavSatFix."""
    found = {
        name: namespace + topic
        for name, topic in preset.items()
        if topics.get(namespace + topic) == TYPES[name]
    }
    return TopicMap(**found) if "imu" in found and "fix" in found else None


def _by_type(topics: Mapping[str, str]) -> TopicMap:
    only: dict[str, str] = {}
    for name, kind in TYPES.items():
        found = sorted(topic for topic in topics if topics[topic] == kind)
        if len(found) == 1 and name != "satellites":  # a UInt32 can be anything
            only[name] = found[0]
        elif name in NEEDED:
            what = f"several {kind} topics ({', '.join(found)})" if found else f"no {kind} topic"
            listed = ", ".join(f"{topic} ({topics[topic]})" for topic in sorted(topics)) or "none"
            raise BagError(
                f"the bag has {what}; its topics: {listed}. Of several vehicles, choose one with "
                "`hijack-detect analyze BAG --namespace /uav1` (also convert, which makes a bag of "
                f"it); known are the names of {', '.join(PRESETS)}"
            )
    return TopicMap(**only)
