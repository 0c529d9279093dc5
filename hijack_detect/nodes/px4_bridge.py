# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Takes the inputs of the monitor from PX4 over uXRCE-DDS: what mavros would do, without it.

Subscribes px4_msgs in fmu/out: sensor_combined, vehicle_gps_position, and vehicle_magnetometer and
vehicle_air_data where PX4 publishes them (dds_topics.yaml); also with a version such as _v1.
Publishes imu/data_raw, gps/fix, gps/vel, gps/satellites, mag and pressure in FLU, ENU and SI, with
the stamps of PX4's samples; and /diagnostics.

Needs the package px4_msgs, of the version of the firmware. See docs/px4.md.
"""

from __future__ import annotations

import time
from functools import partial

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.type_support import check_for_type_support

from hijack_detect.bags.encoding import encode_sample
from hijack_detect.bags.topics import NEEDED, OWN_TOPICS, TYPES
from hijack_detect.logs.px4 import PACKAGE
from hijack_detect.nodes.diagnostics import Diagnostics
from hijack_detect.nodes.messages import message_class
from hijack_detect.nodes.parameters import declare, naming
from hijack_detect.nodes.qos import INTERNAL, OVERRIDES, SENSOR
from hijack_detect.nodes.running import run
from hijack_detect.px4.clock import Px4Clock
from hijack_detect.px4.feed import Feed, OtherVersion
from hijack_detect.px4.topics import (
    GET_PX4_MSGS,
    MISSING,
    Px4BridgeParameters,
    Px4Topic,
    px4_topics,
)
from hijack_detect.streams.messages import BadMessage

REPORT_S = 1.0
MISSING_AFTER = 5
"""Reports before the log names what is missing: discovery takes its time."""


class Px4Bridge(Node):
    """Hands each message to the `Feed` of its topic, and publishes what that makes of it."""

    def __init__(self) -> None:
        """Subscribe and advertise.

        Raises:
            ValueError: A parameter is refused, or px4_msgs is not there.
        """
        super().__init__("px4_bridge", automatically_declare_parameters_from_overrides=True)
        with naming("px4_bridge"):
            parameters = declare(self, Px4BridgeParameters, read_only=True)
        topics = px4_topics(parameters)
        self._kinds = {one.msgtype: _px4_class(one) for one in topics}
        self._px4_clock = Px4Clock(self._tell, self._warn)
        self._outputs = {
            name: self.create_publisher(message_class(TYPES[name]), topic, INTERNAL)
            for name, topic in OWN_TOPICS.items()
        }
        self._heard: dict[str, Feed] = {}
        """By the full name of each subscribed topic; one feed may have several versions of it."""
        self._feeds = []
        for one in topics:
            feed = Feed(one, len(serialize_message(self._kinds[one.msgtype]())))
            self._feeds.append(feed)
            self._subscribe(feed, self.resolve_topic_name(one.topic))
        self._diagnostics = Diagnostics(self)
        self._reports, self._reported_at = 0, time.monotonic()
        self.create_timer(REPORT_S, self._report)

    def _subscribe(self, feed: Feed, topic: str) -> None:
        self._heard[topic] = feed
        self.create_subscription(
            self._kinds[feed.topic.msgtype],
            topic,
            partial(self._received, feed, topic),
            SENSOR,
            raw=True,
            qos_overriding_options=OVERRIDES,
        )

    def _received(self, feed: Feed, topic: str, data: bytes) -> None:
        """Publish what is in a message; one that cannot be used is counted and logged."""
        arrived_ns = time.time_ns()
        feed.received += 1
        try:
            feed.check_size(data)
            message = deserialize_message(data, self._kinds[feed.topic.msgtype])
            for name, sample in feed.take(message, self._px4_clock, arrived_ns):
                self._outputs[name].publish(encode_sample(sample)[1])
        except OtherVersion as error:
            self._refuse(feed, topic, str(error), "other px4_msgs")
        except BadMessage as error:
            self._refuse(feed, topic, str(error), "bad message")
        except Exception as error:  # log and count an internal error; keep running
            if self.context.ok():  # publishing while ROS shuts down is no mistake
                self._refuse(feed, topic, f"internal error: {error!r}", "internal error")

    def _refuse(self, feed: Feed, topic: str, why: str, reason: str) -> None:
        feed.left_out[reason] += 1
        if feed.left_out[reason] == 1:
            self._warn(f"{topic}: message left out: {why} (told once, then counted)")

    def _report(self) -> None:
        """Look for versions of topics that have no publisher, and report, once a second."""
        self._reports += 1
        now = time.monotonic()
        seconds, self._reported_at = now - self._reported_at, now
        for feed in self._feeds:
            full = self.resolve_topic_name(feed.topic.topic)
            self._look_for_versions(feed, full)
            publishers = sum(self.count_publishers(one) for one in self._topics_of(feed))
            if self._reports == MISSING_AFTER and publishers == 0:
                self._tell_missing(feed, full)
            well, text, values = feed.report(seconds, publishers)
            needed = feed.topic.name in NEEDED and publishers == 0
            bad = DiagnosticStatus.ERROR if needed else DiagnosticStatus.WARN
            self._diagnostics.report(full, DiagnosticStatus.OK if well else bad, text, values)
        self._report_outputs()
        well, text, values = self._px4_clock.report()
        level = DiagnosticStatus.OK if well else DiagnosticStatus.WARN
        self._diagnostics.report("clock", level, text, values)

    def _report_outputs(self) -> None:
        """Report how many subscribers each output has: without any, the monitor is deaf."""
        counts = {
            self.resolve_topic_name(OWN_TOPICS[name]): output.get_subscription_count()
            for name, output in self._outputs.items()
        }
        needed = [self.resolve_topic_name(OWN_TOPICS[name]) for name in NEEDED]
        unused = ", ".join(topic for topic in needed if not counts[topic])
        level, text = DiagnosticStatus.OK, "subscribed"
        if unused:
            level = DiagnosticStatus.WARN
            text = f"nobody subscribes to {unused}: does the monitor run in this namespace?"
        values = {topic: str(count) for topic, count in counts.items()}
        self._diagnostics.report("outputs", level, text, values)

    def _topics_of(self, feed: Feed) -> list[str]:
        return [topic for topic, of in self._heard.items() if of is feed]

    def _look_for_versions(self, feed: Feed, full: str) -> None:
        if any(self.count_publishers(one) for one in self._topics_of(feed)):
            return
        names = [name for name, _ in self.get_topic_names_and_types()]
        for topic in feed.topic.versions(full, names):
            if topic not in self._heard:
                self._tell(f"{full} is {topic} here")
                self._subscribe(feed, topic)

    def _tell_missing(self, feed: Feed, full: str) -> None:
        text = f"no {full}: {MISSING[feed.topic.name]}"
        if feed.topic.name in NEEDED:
            self.get_logger().error(text)
        else:
            self._warn(text)

    def _tell(self, text: str) -> None:
        self.get_logger().info(text)

    def _warn(self, text: str) -> None:
        self.get_logger().warning(text)


def _px4_class(topic: Px4Topic) -> type:
    """The class of a topic's messages, which can be used."""
    kind: type | None = message_class(topic.msgtype)
    if kind is None:
        raise ValueError(
            f"px4_bridge needs {topic.msgtype} of the package {PACKAGE}, which is not installed: "
            f"{GET_PX4_MSGS}"
        )
    try:
        check_for_type_support(kind)
    except Exception as error:  # the loader's, or what rclpy makes of it
        raise ValueError(
            f"px4_bridge cannot load {topic.msgtype} ({error}): build {PACKAGE} again with this "
            "ROS and this Python, and source its install/setup.bash"
        ) from error
    return kind


def main() -> None:
    """Run the node."""
    run(Px4Bridge, __doc__ or "")


if __name__ == "__main__":
    main()
