# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Which topics of a bag are replayed, and under which names."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from hijack_detect.bags.topics import OWN_TOPICS, TYPES, TopicMap

TRUTH_TOPIC = "spoof_active"
TRUTH_TYPE = "std_msgs/msg/Bool"
_ANSWERS = re.compile(
    r"(.*/)?(hijack_alert|hijack_confidence|spoof_active|verdict|hijacked)"
    r"|(correlation|date|kld|coast|drag|gnss|altitude|heading)/.*"
    r"|imu/data|yaw|gps_angle|gps/course|flight_phase"
)
"""What the nodes of this package say, by the relative name."""
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)*")
_INFRASTRUCTURE = re.compile(r"clock|diagnostics(_agg)?|(.*/)?(rosout|parameter_events)")


class Route(NamedTuple):
    """Where the messages of one topic go.

    `headed` says that the message begins with a std_msgs/Header, `input_name` which input of the
    detectors it is, empty if none.
    """

    topic: str
    msgtype: str
    kind: Any
    headed: bool
    input_name: str


@dataclass(frozen=True)
class Routes:
    """The topics of a bag: `published` by bag topic, and `skipped` with the reason."""

    published: Mapping[str, Route]
    skipped: Mapping[str, str]

    def topic_of(self, input_name: str) -> str | None:
        """Return the bag's topic of an input, None if it is not replayed."""
        for topic, route in self.published.items():
            if route.input_name == input_name:
                return topic
        return None

    @property
    def has_truth(self) -> bool:
        """Whether the bag's own ground truth is replayed."""
        return any(route.topic == TRUTH_TOPIC for route in self.published.values())


def routes(
    topics: Mapping[str, str],
    topic_map: TopicMap,
    find: Callable[[str], Any],
    *,
    spoofing: bool,
) -> Routes:
    """Choose what to replay, under names relative to the node's namespace.

    The inputs get the names that the nodes of this package subscribe. What these nodes publish
    is left out, or a recorded alert would be taken for a new one; a recorded ground truth stays,
    unless attacks are injected.

    Args:
        topics: Type by topic, as in `BagReader.topics`.
        topic_map: The inputs.
        find: Gives the message class of a type, None if it is not installed.
        spoofing: Whether attacks are injected.
    """
    names = {topic: name for name, topic in topic_map.items()}
    published: dict[str, Route] = {}
    skipped: dict[str, str] = {}
    taken: dict[str, str] = {}
    for topic in sorted(topics, key=lambda topic: (topic not in names, topic)):
        name, msgtype = names.get(topic, ""), topics[topic]
        relative = OWN_TOPICS[name] if name else topic.lstrip("/")
        reason = _refusal(name, relative, msgtype, spoofing=spoofing)
        kind = None if reason else find(msgtype)
        if relative in taken:
            skipped[topic] = f"its name '{relative}' is taken by {taken[relative]}"
        elif reason:
            skipped[topic] = reason
        elif kind is None:
            skipped[topic] = f"its type {msgtype!r} is not installed"
        else:
            taken[relative] = topic
            published[topic] = Route(relative, msgtype, kind, _headed(kind), name)
    return Routes(published, skipped)


def _refusal(name: str, relative: str, msgtype: str, *, spoofing: bool) -> str:
    """Say why a topic is left out, empty if it is not."""
    if name:
        needed = TYPES[name]
        return "" if msgtype == needed else f"its type is {msgtype}, the input needs {needed}"
    if not _NAME.fullmatch(relative) or "__" in relative:
        return "it has no name that can be published"
    if _INFRASTRUCTURE.fullmatch(relative):
        return "it belongs to the running system"
    if relative == TRUTH_TOPIC and msgtype == TRUTH_TYPE and not spoofing:
        return ""
    if is_answer(relative):
        return "it is an answer of the monitor, which would be taken for a new one"
    return ""


def is_answer(topic: str) -> bool:
    """Whether a topic is what the nodes of this package say, not what they hear."""
    return _ANSWERS.fullmatch(topic.lstrip("/")) is not None


def _headed(kind: Any) -> bool:
    fields = kind.get_fields_and_field_types()
    return next(iter(fields.values()), "") == "std_msgs/Header"
