# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The messages of a bag as they are replayed: chosen, checked, and spoofed."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader, RawMessage, typestore
from hijack_detect.bags.samples import Rejected, Rejection
from hijack_detect.bags.topics import OWN_TOPICS, PRESETS, TYPES, TopicMap
from hijack_detect.parameters import Parameters, param
from hijack_detect.spoofing.on_messages import SPOOFED_INPUTS, SpoofedMessages
from hijack_detect.spoofing.scenario import Scenario, load_scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.cdr import stamp_from_bytes, with_stamp
from hijack_detect.streams.messages import BadMessage
from hijack_detect.streams.samples import NANOSECONDS


@dataclass(frozen=True)
class ReplayParameters(Parameters):
    """The bag to replay, its speed, and its attack."""

    bag: str = param(
        "",
        "Bag to replay: a rosbag2 directory or an mcap file. Required.",
        source="chosen: empty, it has to be given",
        basic=True,
    )
    scenario: str = param(
        "",
        "Scenario file of attacks to inject; their times count from the bag's first message.",
        source="chosen: no attack",
    )
    preset: str = param(
        "auto",
        "Names of the inputs in the bag; `auto` finds them. They are published as imu/data_raw, "
        "gps/fix, gps/vel, mag, pressure and gps/satellites.",
        source="chosen: the names of the bag decide",
        choices=("auto", *PRESETS),
    )
    rate: float = param(
        1.0,
        "Bag seconds for each second of wall time; can be changed while playing.",
        source="chosen: real time",
        low=0.001,
        high=1000.0,
    )
    start_s: float = param(
        0.0,
        "Where to begin, counted from the bag's first message.",
        source="chosen: the whole bag",
        unit="s",
        low=0.0,
    )
    duration_s: float = param(
        0.0,
        "How much of the bag to replay; 0 is to its end.",
        source="chosen: the whole bag",
        unit="s",
        low=0.0,
    )
    loop: bool = param(
        False,
        "Begin again at the end; stamps then run backwards, or on if restamp.",
        source="chosen: off, one flight gives one answer",
    )
    restamp: bool = param(
        False,
        "Move header stamps (and /clock) so that the first one is now. Their spacing is kept, so "
        "that at another rate than 1 they run ahead of the wall clock, or behind it.",
        source="chosen: off, stamps are those of the bag",
    )
    clock_hz: float = param(
        100.0,
        "Publish /clock this often in bag time, for nodes with use_sim_time; 0 is never. It is "
        "up to one period ahead of the messages, never behind.",
        source="chosen, not swept; /clock is then at most 10 ms ahead, as an IMU of 100 Hz",
        unit="Hz",
        low=0.0,
        high=1000.0,
    )
    start_paused: bool = param(
        False, "Wait for the service ~/resume or ~/step before playing.", source="chosen: off"
    )
    settle_s: float = param(
        3.5,
        "Begin when no subscription of a replayed topic has come or gone for this long, so that "
        "running nodes receive the first message. Can be shorter with wait_for.",
        source="chosen: DDS can take 3 s to find running nodes; half a second of margin",
        unit="s of wall time",
        low=0.0,
        high=3600.0,
    )
    wait_for: str = param(
        "",
        "Names of nodes, separated by spaces, that must be in the graph before it begins.",
        source="chosen: none; `settle_s` serves all",
    )
    progress: bool = param(
        True,
        "Draw a progress bar, if stderr is a terminal.",
        source="chosen: on, a replay takes minutes",
    )
    exit_at_end: bool = param(
        True,
        "End the process at the end of the bag; false keeps the node, with ~/finished true.",
        source="chosen: ends, so that a script goes on",
    )

    def __post_init__(self) -> None:
        """Check every value.

        Raises:
            ValueError: There is no bag, or a value is refused.
        """
        super().__post_init__()
        if not self.bag:
            raise ValueError(
                "parameter 'bag' is empty; name a rosbag2 directory or an mcap file: "
                "--ros-args -p bag:=PATH"
            )


TRUTH_TOPIC = "spoof_active"
TRUTH_TYPE = "std_msgs/msg/Bool"
_ANSWERS = re.compile(
    r"(.*/)?(hijack_alert|hijack_confidence|spoof_active|verdict|hijacked)"
    r"|(correlation|date|kld|coast|drag|gnss|altitude|heading)/.*"
    r"|imu/data|yaw|gps_angle|gps/course|flight_phase"
)
"""Topics that the nodes of this package publish, by relative name."""
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)*")
_INFRASTRUCTURE = re.compile(r"clock|diagnostics(_agg)?|(.*/)?(rosout|parameter_events)")


class Route(NamedTuple):
    """Where the messages of one topic go.

    `headed`: whether the message begins with a std_msgs/Header. `input_name`: the input of the
    detectors, empty if none.
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
    """Return why a topic is left out, empty if it is not."""
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
    """Whether the nodes of this package publish a topic, and do not subscribe to it."""
    return _ANSWERS.fullmatch(topic.lstrip("/")) is not None


def _headed(kind: Any) -> bool:
    fields = kind.get_fields_and_field_types()
    return next(iter(fields.values()), "") == "std_msgs/Header"


class Spoofed(NamedTuple):
    """A message after the attack: CDR bytes, and whether an attack covers its stamp."""

    data: bytes
    active: bool


class MessageSpoofer:
    """Applies a scenario to the messages of a receiver, all of them from the bag's first on.

    A number of satellites has the stamp of the last fix before it in order of log time.
    """

    def __init__(
        self,
        scenario: Scenario,
        start_ns: int,
        on_refused: Callable[[RawMessage, int, str], None],
    ) -> None:
        """Apply a scenario.

        Args:
            scenario: The attacks.
            start_ns: Log time of the bag's first message, from which their times count.
            on_refused: Called with message, stamp and reason for one that holds a value which no
                receiver can mean; it passes as it is.
        """
        self._spoofer = Spoofer(scenario, start_ns)
        self._messages = SpoofedMessages(self._spoofer)
        self._refuse = on_refused

    def apply(self, raw: RawMessage, input_name: str, message: Any) -> Spoofed:
        """Return a message as it is reported; the recorded bytes if nothing changes.

        Args:
            raw: The message as it was recorded.
            input_name: One of SPOOFED_INPUTS.
            message: The same, deserialised; its fields are changed.
        """
        stamp_ns = self._messages.stamp_ns(input_name, message)
        active = stamp_ns is not None and self._spoofer.active(stamp_ns)
        try:
            changed = self._messages.apply(input_name, message)
        except BadMessage as error:
            self._refuse(raw, raw.log_ns if stamp_ns is None else stamp_ns, str(error))
            return Spoofed(raw.data, active)
        if not changed:
            return Spoofed(raw.data, active)
        return Spoofed(bytes(typestore().serialize_cdr(message, raw.msgtype)), active)


_MAX_SECONDS = 2**31
_SHORTEST = {False: 4, True: 12}
"""Fewest bytes of a message, without and with a header."""


class Outgoing(NamedTuple):
    """One message to publish.

    `topic` is relative, `data` CDR. `spoofed` is the ground truth to publish with a fix: whether
    an attack covers its stamp; None with other messages.
    """

    log_ns: int
    topic: str
    data: bytes
    headed: bool
    spoofed: bool | None


class Playback:
    """What a replay publishes, in order of log time.

    Messages go out byte for byte as they were recorded, except those of the GPS that a scenario
    changes. The attacks see the bag from its first message on, wherever the replay
    starts, so the same fix is always spoofed alike.

    A message that cannot be decoded is left out: its bytes can end a subscription for good.

    Attributes:
        reader: The bag.
        routes: Which topics are published, and as what.
        start_ns: Log time at which the replay starts.
        end_ns: Log time before which it ends.
        rejected: Refused messages, and stamps that do not increase.
    """

    def __init__(self, parameters: ReplayParameters, find: Callable[[str], Any]) -> None:
        """Open the bag and the scenario.

        Args:
            parameters: What to replay.
            find: Gives the message class of a type, None if it is not installed.

        Raises:
            BagError: The bag cannot be read, or has no Imu or no NavSatFix.
            ScenarioError: The scenario cannot be used, or does not fit the bag.
            ValueError: The replay would start after the bag's end.
        """
        self.rejected = Rejected()
        scenario = load_scenario(parameters.scenario) if parameters.scenario else None
        self.reader = BagReader(parameters.bag)
        try:
            self.routes = self._check(parameters, scenario, find)
        except BaseException:
            self.reader.close()
            raise
        self._scenario = scenario
        self.start_ns = self.reader.start_ns + round(parameters.start_s * NANOSECONDS)
        self.end_ns = self.reader.end_ns + 1
        if parameters.duration_s:
            length_ns = round(parameters.duration_s * NANOSECONDS)
            self.end_ns = min(self.end_ns, self.start_ns + length_ns)

    def close(self) -> None:
        """Close the bag."""
        self.reader.close()

    def messages(self) -> Iterator[Outgoing]:
        """Yield everything to publish, from start to end; each call is a new pass.

        Raises:
            BagError: The bag turns out to be damaged.
        """
        inputs = [self.routes.topic_of(name) for name in SPOOFED_INPUTS]
        spoofer = None
        if self._scenario is not None:
            spoofer = MessageSpoofer(self._scenario, self.reader.start_ns, self._reject)
        if spoofer is not None:
            gps = [topic for topic in inputs if topic is not None]
            for raw in self.reader.messages(gps, end_ns=self.start_ns):
                self._decoded(raw, spoofer)
        latest: dict[str, int] = {}
        published = self.routes.published
        for raw in self.reader.messages(published.keys(), self.start_ns, self.end_ns):
            outgoing = self._decoded(raw, spoofer)
            if outgoing is not None:
                if outgoing.headed:
                    self._check_order(raw, outgoing.data, latest)
                yield outgoing

    def position_s(self, log_ns: int) -> float:
        """Seconds from the bag's first message to a log time."""
        return (log_ns - self.reader.start_ns) / NANOSECONDS

    def _check(
        self, parameters: ReplayParameters, scenario: Scenario | None, find: Callable[[str], Any]
    ) -> Routes:
        path, duration_s = self.reader.path, self.reader.duration_s
        if parameters.start_s > duration_s:
            raise ValueError(
                f"{path}: parameter 'start_s' is {parameters.start_s:g}, the bag lasts "
                f"{duration_s:g} s"
            )
        if scenario is not None:
            scenario.check_within(duration_s)
        inputs = self.reader.inputs(parameters.preset)
        return routes(self.reader.topics, inputs, find, spoofing=scenario is not None)

    def _decoded(self, raw: RawMessage, spoofer: MessageSpoofer | None) -> Outgoing | None:
        """Check a message and apply the attack to it; None if it has to be left out."""
        route = self.routes.published[raw.topic]
        if raw.msgtype != route.msgtype:
            self._reject(raw, 0, f"type {raw.msgtype} is not {route.msgtype}, as at first")
            return None
        if raw.msgtype not in typestore().fielddefs:
            if raw.data[:2] not in (b"\0\0", b"\0\1") or len(raw.data) < _SHORTEST[route.headed]:
                self._reject(raw, 0, f"malformed CDR of {len(raw.data)} bytes")
                return None
            return Outgoing(raw.log_ns, route.topic, raw.data, route.headed, None)
        try:
            message = self.reader.deserialize(raw)
        except BagError:
            reason = f"malformed {raw.msgtype} of {len(raw.data)} bytes; the bag is damaged"
            self._reject(raw, 0, reason)
            return None
        data, active = raw.data, False
        if spoofer is not None and route.input_name in SPOOFED_INPUTS:
            data, active = spoofer.apply(raw, route.input_name, message)
        truth = active if route.input_name == "fix" and not self.routes.has_truth else None
        return Outgoing(raw.log_ns, route.topic, data, route.headed, truth)

    def _check_order(self, raw: RawMessage, data: bytes, latest: dict[str, int]) -> None:
        """Count a stamp that does not increase; the message is published all the same."""
        stamp, before = stamp_from_bytes(data), latest.get(raw.topic)
        assert stamp is not None  # else the message would be malformed
        if before is not None and stamp <= before:
            what = "repeats" if stamp == before else f"runs backwards from {before} ns"
            self._reject(raw, stamp, f"stamp {what}, published all the same")
        latest[raw.topic] = stamp

    def _reject(self, raw: RawMessage, stamp: int, reason: str) -> None:
        stamp = stamp or raw.log_ns
        self.rejected.add(Rejection(self.reader.path, raw.topic, raw.log_ns, stamp, reason))


def moved_stamp(data: bytes, offset_ns: int) -> bytes:
    """Return the message with its header stamp moved; one that is not set (zero) stays.

    A stamp that would leave the range of ROS stays, too.
    """
    old = stamp_from_bytes(data)
    if not old or not 0 <= old + offset_ns < _MAX_SECONDS * NANOSECONDS:
        return data
    return with_stamp(data, old + offset_ns)
