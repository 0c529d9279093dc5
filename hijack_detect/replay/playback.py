# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The messages of a bag as they are replayed: chosen, checked, and spoofed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader, RawMessage, typestore
from hijack_detect.bags.samples import Rejected, Rejection
from hijack_detect.replay.message_spoofer import MessageSpoofer
from hijack_detect.replay.playback_parameters import ReplayParameters
from hijack_detect.replay.playback_topics import Routes, routes
from hijack_detect.spoofing.on_messages import SPOOFED_INPUTS
from hijack_detect.spoofing.scenario import Scenario, load_scenario
from hijack_detect.streams.cdr import stamp_from_bytes, with_stamp
from hijack_detect.streams.samples import NANOSECONDS

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

    A stamp that would leave what ROS can say stays, too.
    """
    old = stamp_from_bytes(data)
    if not old or not 0 <= old + offset_ns < _MAX_SECONDS * NANOSECONDS:
        return data
    return with_stamp(data, old + offset_ns)
