# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The node fusion: the alert that a mission manager subscribes to."""

from __future__ import annotations

import itertools
import math
import signal
import time
from pathlib import Path
from typing import Any

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from live import SECOND, values_of
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from ros import KEEP_ALL, Graph, Listener, RosProcess
from std_msgs.msg import Bool, Float64
from std_srvs.srv import Trigger

from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.monitor.parts import DETECTORS, WEIGHTS
from hijack_detect.nodes.messages import verdict_message
from hijack_detect.nodes.qos import ALERT, ALERT_LEASE_S, STATE

START_NS = 1_700_000_000 * SECOND
STEP_NS = SECOND // 5
NOW = Duration(nanoseconds=0)
VOTING = [name for name, one in WEIGHTS.items() if one.ratio is not None]


class Monitored:
    """A fusion node, and detectors that say what the test wants."""

    def __init__(self, graph: Graph, *silent: str, **parameters: Any) -> None:
        self.graph = graph
        self.alert = graph.listen(Bool, "hijack_alert", STATE)
        self.confidence = graph.listen(Float64, "hijack_confidence")
        self.verdict = graph.listen(DiagnosticArray, "fusion/verdict")
        self.diagnostics = graph.listen(DiagnosticArray, "/diagnostics")
        self.node: RosProcess = graph.start("fusion", parameters=parameters)
        self.publishers = {
            name: graph.node.create_publisher(DiagnosticArray, f"{name}/verdict", KEEP_ALL)
            for name in DETECTORS
            if name not in silent
        }
        graph.spin_until(
            lambda: all(one.get_subscription_count() for one in self.publishers.values()),
            "subscriptions of fusion",
        )
        graph.until_known("fusion")
        self._stamp_ns = START_NS
        self._sent = 0

    def say(
        self, seconds: float, *, answered: bool = True, acknowledged: bool = True, **states: State
    ) -> None:
        """Let every detector say something for a while; NORMAL unless told otherwise.

        Each step waits for the fusion's answers, or, with a silent detector, until everything has
        arrived, or without `answered`, so none runs ahead by more than a step. A killed fusion
        acknowledges nothing, and is forgotten after 20 s: without `acknowledged` nothing waits.
        """
        for _ in range(round(seconds * SECOND / STEP_NS)):
            self._stamp_ns += STEP_NS
            for name, publisher in self.publishers.items():
                state = states.get(name, State.NORMAL)
                score = 2.0 if state is State.ALARM else 0.25
                verdict = Verdict(name, self._stamp_ns, state, score, 1.0, f"{name} says so")
                publisher.publish(verdict_message(verdict))
                self._sent += 1
            if answered and len(self.publishers) == len(DETECTORS):
                self.settle()
            elif acknowledged:
                self.graph.spin_until(
                    lambda: all(p.wait_for_all_acked(NOW) for p in self.publishers.values()),
                    "acknowledgements",
                )

    def settle(self) -> None:
        """Wait until the fusion has answered to everything."""
        self.graph.spin_until(lambda: len(self.answers()) == self._sent, "answers")
        self.graph.spin_until(
            lambda: len(self.confidence.messages) == len(self.verdict.messages), "confidences"
        )

    def answers(self) -> list[DiagnosticArray]:
        """What was said of a verdict, and not of silence."""
        return [one for one in self.verdict.messages if "silent_s" not in values_of(one)]

    def hole(self, seconds: float) -> None:
        """Let time pass on the stamps, without a verdict."""
        self._stamp_ns += round(seconds * SECOND)

    def until_alert(self, value: bool) -> None:
        self.graph.spin_until(
            lambda: self.alert.messages and self.alert.messages[-1].data is value,
            f"hijack_alert {value}",
        )

    def status(self) -> DiagnosticStatus | None:
        """The newest diagnostic status of the alert."""
        found = [
            one
            for message in self.diagnostics.messages
            for one in message.status
            if one.name == "/fusion: hijack alert"
        ]
        return found[-1] if found else None

    def states(self) -> list[str]:
        return [values_of(one)["state"] for one in self.verdict.messages]


def runs(listener: Listener) -> list[bool]:
    return [value for value, _ in itertools.groupby(one.data for one in listener.messages)]


def test_the_alert_is_latched_for_late_subscribers_and_repeated(graph: Graph) -> None:
    monitored = Monitored(graph)
    monitored.until_alert(False)
    monitored.say(2.0)
    monitored.say(1.0, coast=State.ALARM)
    monitored.until_alert(True)
    (info,) = graph.node.get_publishers_info_by_topic("/hijack_alert")
    assert info.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
    assert info.qos_profile.reliability == ReliabilityPolicy.RELIABLE
    late = graph.listen(Bool, "hijack_alert", STATE)
    graph.spin_until(lambda: late.messages, "the state of the alert")
    assert late.messages[0].data is True
    heard = len(late.messages)
    graph.spin_until(lambda: len(late.messages) >= heard + 3, "three heartbeats")
    assert runs(late) == [True]
    assert runs(monitored.alert) == [False, True]
    assert monitored.node.interrupt() == 0


def test_the_alert_stays_when_the_alarm_is_over_and_a_reset_takes_it_back(graph: Graph) -> None:
    monitored = Monitored(graph)
    monitored.say(2.0)
    monitored.say(0.6, coast=State.ALARM)
    monitored.say(5.0)
    monitored.until_alert(True)
    assert values_of(monitored.verdict.messages[-1])["alert"] == "true"
    assert values_of(monitored.verdict.messages[-1])["state"] == "alarm"

    answer = graph.call(Trigger, "fusion/reset")
    assert answer.success
    assert answer.message
    monitored.until_alert(False)
    monitored.say(2.0)
    monitored.settle()
    assert values_of(monitored.verdict.messages[-1])["alert"] == "false"
    assert monitored.states()[-1] == "normal"

    monitored.say(0.4, coast=State.ALARM)
    monitored.until_alert(True)
    assert runs(monitored.alert) == [False, True, False, True]
    assert monitored.node.interrupt() == 0
    assert monitored.node.output.count("HIJACK ALERT") == 2
    assert monitored.node.output.count("alert reset on request") == 1


def test_confidence_lies_between_0_and_1_and_each_verdict_has_one(graph: Graph) -> None:
    monitored = Monitored(graph)
    for state in State:
        monitored.say(1.0, **dict.fromkeys(DETECTORS, state))
    monitored.settle()
    known = [
        (one.data, float(values_of(verdict)["confidence"]))
        for one, verdict in zip(
            monitored.confidence.messages, monitored.verdict.messages, strict=True
        )
        if values_of(verdict)["state"] in ("normal", "suspicious", "alarm")
    ]
    assert len(known) < len(monitored.verdict.messages)
    assert sum(math.isfinite(one.data) for one in monitored.confidence.messages) == len(known)
    told = [one for one, _ in known]
    assert told == [one for _, one in known]
    assert all(0.0 <= one <= 1.0 for one in told)
    assert told[-1] > 0.99
    assert min(told) < 0.2


def test_diagnostics_are_stale_before_the_first_verdict_and_when_they_stop(graph: Graph) -> None:
    monitored = Monitored(graph, stale_s=0.5)

    def level() -> bytes | None:
        status = monitored.status()
        return status and status.level

    graph.spin_until(lambda: level() == DiagnosticStatus.STALE, "STALE at start")
    status = monitored.status()
    assert status is not None
    assert "no verdict of any detector" in status.message

    monitored.say(1.0)
    graph.spin_until(lambda: level() == DiagnosticStatus.OK, "OK with verdicts")
    while (status := monitored.status()) and values_of(status).get("state") != "normal":
        assert values_of(status)["state"] == "not_ready"
        monitored.say(0.2)
    graph.spin_until(lambda: level() == DiagnosticStatus.STALE, "STALE when verdicts stop")
    assert monitored.alert.messages[-1].data is False


def test_one_log_line_for_each_change(graph: Graph) -> None:
    monitored = Monitored(graph)
    monitored.say(2.0)
    monitored.say(2.0, date=State.SUSPICIOUS)
    monitored.say(2.0)
    unseen = dict.fromkeys(DETECTORS, State.NOT_OBSERVABLE)
    monitored.say(2.0, **unseen)
    monitored.say(2.0, **{**unseen, "coast": State.ALARM})
    monitored.settle()
    wanted = [state for state, _ in itertools.groupby(monitored.states())]
    usual = ["not_ready", "normal", "suspicious", "normal", "not_observable"]
    assert wanted == [*usual, "suspicious", "alarm"]
    assert monitored.node.interrupt() == 0
    lines = [line for line in monitored.node.output.splitlines() if "[fusion]" in line]
    assert len(lines) == len(wanted)
    assert all(f": {state} at" in line for line, state in zip(lines[:-1], wanted, strict=False))
    assert "[ERROR]" in lines[-1]
    assert "HIJACK ALERT at 1700000008.400 s: coast says so [coast, 2.0 × its limit]" in lines[-1]


def test_when_nothing_comes_it_says_so_and_until_a_detector_can_tell_again(graph: Graph) -> None:
    monitored = Monitored(graph)
    monitored.say(2.0)
    assert monitored.states()[-1] == "normal"
    assert monitored.confidence.messages[-1].data < 0.2
    stopped_s = time.monotonic()
    graph.spin_until(lambda: monitored.states()[-1] == "stale", "STALE when nothing comes")
    graph.spin_until(lambda: math.isnan(monitored.confidence.messages[-1].data), "NaN")
    assert time.monotonic() - stopped_s < 3.0
    heard = len(monitored.verdict.messages)
    graph.spin_until(lambda: len(monitored.verdict.messages) > heard, "it once more")
    last = monitored.verdict.messages[-1]
    assert values_of(last)["alert"] == "false"
    assert values_of(last)["degraded"].split() == VOTING
    assert float(values_of(last)["silent_s"]) > 2.0

    monitored.hole(4.0)
    began = len(monitored.verdict.messages)
    unready = dict.fromkeys(
        (name for name, one in WEIGHTS.items() if one.sees_carry_off), State.NOT_READY
    )
    monitored.say(3.0, answered=False, **unready)  # the first second after a gap is left out
    graph.spin_until(lambda: len(monitored.verdict.messages) > began + 20, "answers")
    graph.spin_until_quiet()
    assert {*monitored.states()[began:]} == {"stale"}
    assert all(math.isnan(one.data) for one in monitored.confidence.messages[began:])
    monitored.say(0.4, answered=False)
    graph.spin_until(lambda: monitored.states()[-1] == "normal", "NORMAL again")
    graph.spin_until(lambda: monitored.confidence.messages[-1].data < 0.2, "its confidence")
    assert runs(monitored.alert) == [False]


def test_an_alert_stays_when_nothing_comes_any_more(graph: Graph) -> None:
    monitored = Monitored(graph)
    monitored.say(2.0)
    monitored.say(1.0, coast=State.ALARM)
    heard = len(monitored.verdict.messages)
    graph.spin_until(lambda: len(monitored.verdict.messages) > heard, "a word about silence")
    last = values_of(monitored.verdict.messages[-1])
    assert (last["state"], last["alert"]) == ("alarm", "true")
    assert monitored.confidence.messages[-1].data > 0.6
    assert runs(monitored.alert) == [False, True]


@pytest.mark.parametrize("silent", VOTING)
def test_a_missing_detector_never_reads_as_normal(graph: Graph, silent: str) -> None:
    monitored = Monitored(graph, silent)
    monitored.say(8.0)
    monitored.settle()
    assert "normal" not in monitored.states()
    assert monitored.states()[-1] == "stale"
    last = monitored.verdict.messages[-1]
    assert values_of(last)["lost"] == values_of(last)["degraded"] == silent
    assert last.status[0].level == DiagnosticStatus.STALE
    assert last.status[0].message.startswith(f"DEGRADED, without {silent}: ")
    assert math.isnan(monitored.confidence.messages[-1].data)
    degraded = [
        one
        for message in monitored.diagnostics.messages
        for one in message.status
        if one.name == "/fusion: hijack alert" and values_of(one).get("degraded") == silent
    ]
    assert degraded
    assert f"DEGRADED, without {silent}: " in monitored.node.output


def test_a_detector_that_never_gets_ready_never_reads_as_normal(graph: Graph) -> None:
    monitored = Monitored(graph, overdue_s=3.0)
    monitored.say(2.0, coast=State.NOT_READY)
    assert monitored.states()[-1] == "normal"  # it may take its time
    monitored.say(2.0, coast=State.NOT_READY)
    assert monitored.states()[-1] == "not_ready"
    assert values_of(monitored.verdict.messages[-1])["degraded"] == "coast"
    assert math.isnan(monitored.confidence.messages[-1].data)
    monitored.say(1.0)
    assert monitored.states()[-1] == "normal"
    assert 0.0 <= monitored.confidence.messages[-1].data <= 1.0


def test_a_degraded_monitor_still_alerts(graph: Graph) -> None:
    monitored = Monitored(graph, overdue_s=1.0)
    monitored.say(2.0, kld=State.NOT_READY)
    monitored.say(0.6, kld=State.NOT_READY, coast=State.ALARM)
    monitored.until_alert(True)
    assert monitored.confidence.messages[-1].data > 0.6


def test_an_alert_survives_a_crash_and_not_a_stop(graph: Graph) -> None:
    monitored = Monitored(graph)
    monitored.say(2.0)
    monitored.say(0.6, coast=State.ALARM)
    monitored.until_alert(True)
    monitored.node.signal(signal.SIGKILL)
    monitored.node.wait()

    again = graph.listen(Bool, "hijack_alert", STATE)
    dead = set.union(*(graph.subscribers(f"{name}/verdict") for name in DETECTORS))
    node = graph.start("fusion")
    graph.spin_until(lambda: again.messages, "the alert after a restart")
    for publisher in monitored.publishers.values():
        graph.until_subscribed(publisher, dead=dead)
    assert again.messages[0].data is True
    assert "goes on after a restart: coast says so [coast, 2.0 × its limit]" in node.output
    crashed = {"answered": False, "acknowledged": False}
    monitored.say(1.0, **crashed)  # a verdict says nothing against it
    assert graph.call(Trigger, "fusion/reset").success
    graph.spin_until(lambda: again.messages[-1].data is False, "the reset")

    monitored.say(2.0, coast=State.ALARM, **crashed)
    graph.spin_until(lambda: again.messages[-1].data is True, "the next alert")
    assert node.interrupt() == 0
    fresh = graph.listen(Bool, "hijack_alert", STATE)
    node = graph.start("fusion")
    graph.spin_until(lambda: fresh.messages, "the alert after a stop")
    assert fresh.messages[0].data is False


def test_none_survives_if_none_should(graph: Graph) -> None:
    monitored = Monitored(graph, survive_s=0.0)
    monitored.say(2.0)
    monitored.say(0.6, coast=State.ALARM)
    monitored.until_alert(True)
    assert not list(Path(graph.home.name).rglob("*.json"))


def test_silence_is_told_to_who_asks_for_signs_of_life(graph: Graph) -> None:
    """SIGSTOP: no process, no participant and no connection ends, only the repetitions do."""
    told: list[str] = []
    events = SubscriptionEventCallbacks(
        deadline=lambda _: told.append("late"),
        liveliness=lambda change: told.append(f"alive {change.alive_count}"),
    )
    context = Context()
    rclpy.init(context=context, domain_id=graph.domain)
    node = Node("manager", context=context, enable_rosout=False)
    node.create_subscription(Bool, "hijack_alert", lambda _: None, ALERT, event_callbacks=events)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)

    def until(what: str) -> None:
        deadline = time.monotonic() + 20.0
        while what not in told:
            assert time.monotonic() < deadline, f"{what}: {told}"
            executor.spin_once(timeout_sec=0.1)

    fusion = graph.start("fusion")
    until("alive 1")
    fusion.signal(signal.SIGSTOP)
    stopped = time.monotonic()
    until("late")
    until("alive 0")
    assert time.monotonic() - stopped < ALERT_LEASE_S + 2.0
    fusion.signal(signal.SIGCONT)
    told.clear()
    until("alive 1")
    executor.shutdown()
    node.destroy_node()
    context.try_shutdown()


def test_the_heartbeat_goes_on_while_ros_time_is_paused(graph: Graph) -> None:
    """Nobody publishes /clock, so that ROS time stays at 0."""
    alert = graph.listen(Bool, "hijack_alert", STATE)
    graph.start("fusion", parameters={"use_sim_time": True})
    graph.spin_until(lambda: len(alert.messages) >= 4, "three heartbeats")


def test_policies_decide_which_alarms_are_enough(graph: Graph) -> None:
    monitored = Monitored(graph, policy="paper")
    monitored.say(2.0)
    monitored.say(2.0, date=State.ALARM)
    monitored.settle()
    assert monitored.states()[-1] == "suspicious"
    assert runs(monitored.alert) == [False]
    monitored.say(2.0)
    monitored.say(0.4, correlation=State.ALARM)
    monitored.until_alert(True)
