# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Expectations of the inputs in the graph, and the cost of missing ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from hijack_detect.bags.topics import NEEDED, OWN_TOPICS, PRESETS, TYPES
from hijack_detect.cli.doctor.finding import Finding, Level

USERS = {
    "velocity": "date, kld, coast, gnss, altitude, heading and drag know less",
    "mag": "the heading is known later, and heading cannot tell",
    "pressure": "altitude sees less",
    "satellites": "kld has one series less",
}
LEAST_HZ = {"imu": 45.0, "fix": 0.9, "velocity": 0.9}
"""Nine tenths of 50 and 1 Hz. Chosen, not swept."""


@dataclass(frozen=True)
class Received:
    """Publishers, types and rate of an input.

    Attributes:
        publishers: Names of the nodes that publish it.
        kinds: Types that they publish.
        rate_hz: Messages a second.
    """

    publishers: Sequence[str] = ()
    kinds: Sequence[str] = ()
    rate_hz: float = 0.0


def topics_of(namespace: str, *, mavros: bool) -> dict[str, str]:
    """The absolute topic of each input."""
    space = f"/{namespace.strip('/')}" if namespace.strip("/") else ""
    own = {name: f"/{topic}" for name, topic in OWN_TOPICS.items()}
    known = dict(PRESETS["mavros"].items()) if mavros else own
    return {name: space + topic for name, topic in known.items()}


def inputs(
    topics: Mapping[str, str], received: Mapping[str, Received], others: Mapping[str, Sequence[str]]
) -> Iterator[Finding]:
    """A line for each input.

    Args:
        topics: Topic of each input.
        received: What was received of each.
        others: Types of all topics of the graph.
    """
    for name, topic in topics.items():
        one = received.get(name, Received())
        if not one.publishers:
            yield from _silent(name, topic, others, any(of.publishers for of in received.values()))
        elif TYPES[name] not in one.kinds:
            text = f"has type {', '.join(one.kinds)}, needed is {TYPES[name]}"
            mend = "remap the topic of the right type: -r imu/data_raw:=TOPIC"
            yield Finding(topic, Level.FAIL, text, mend)
        elif not one.rate_hz:
            text = f"{', '.join(one.publishers)} publishes it, and nothing comes"
            yield Finding(topic, Level.FAIL, text, "is the sensor awake? Is it in another network?")
        elif one.rate_hz < LEAST_HZ.get(name, 0.0):
            least = LEAST_HZ[name]
            mend = f"ask the autopilot for more (mavros: set_stream_rate); {least:.0f} Hz at least"
            yield Finding(topic, Level.WARN, f"only {one.rate_hz:.1f} Hz", mend)
        elif len(one.publishers) > 1:
            mend = "one of them may be an attacker's, or of a process that should have ended"
            text = f"{one.rate_hz:.1f} Hz from {len(one.publishers)}: {', '.join(one.publishers)}"
            yield Finding(topic, Level.WARN, text, mend)
        else:
            yield Finding(topic, Level.OK, f"{one.rate_hz:.1f} Hz from {one.publishers[0]}")


def monitors(alerting: Sequence[str], clocked: Sequence[str], *, clock: bool) -> Iterator[Finding]:
    """Check the number of monitors, and that they have their time.

    Args:
        alerting: Nodes that publish hijack_alert.
        clocked: Those of them that use simulated time.
        clock: Whether /clock has a publisher.
    """
    if len(alerting) > 1:
        text = f"{len(alerting)} publish hijack_alert: {', '.join(alerting)}"
        mend = "stop one, or give each vehicle a namespace (uav:=NAME) or a ROS_DOMAIN_ID"
        yield Finding("monitor", Level.WARN, text, mend)
    else:
        text = f"{alerting[0]} publishes hijack_alert" if alerting else "none runs in this domain"
        yield Finding("monitor", Level.OK if alerting else Level.INFO, text)
    if clocked and not clock:
        text = f"use_sim_time is true of {', '.join(clocked)}, and /clock has no publisher"
        mend = "ros2 param set NODE use_sim_time false, or start the replay or the simulator"
        yield Finding("use_sim_time", Level.FAIL, text, mend)


def _silent(
    name: str, topic: str, others: Mapping[str, Sequence[str]], something: bool
) -> Iterator[Finding]:
    """An input without publisher: what it costs, and where it may be."""
    ends = (f"/{OWN_TOPICS[name]}", getattr(PRESETS["mavros"], name))
    near = [one for one in sorted(others) if one != topic and one.endswith(ends)]
    if near:
        mavros = near[0].endswith(ends[1])
        space = near[0].removesuffix(ends[1] if mavros else ends[0])
        option = f"{' --namespace ' + space if space else ''}{' --mavros' if mavros else ''}"
        launch = (
            f"{' uav:=' + space.strip('/') if space else ''}{' mavros:=true' if mavros else ''}"
        )
        mend = (
            f"launch with{launch or ' neither mavros nor uav'}; here: hijack-detect doctor{option}"
        )
        yield Finding(topic, Level.FAIL, f"no publisher, but there is {near[0]}", mend)
    elif name not in NEEDED:
        yield Finding(topic, Level.INFO, f"no publisher: {USERS[name]}")
    else:
        level = Level.FAIL if something else Level.WARN
        mend = "start the autopilot's driver; did you forget -r, mavros:=true or uav:=NAME?"
        yield Finding(topic, level, "no publisher: the monitor cannot start to judge", mend)
