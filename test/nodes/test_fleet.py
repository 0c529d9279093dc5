# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Two vehicles in one graph, each in a namespace of its own."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import yaml
from diagnostic_msgs.msg import DiagnosticArray
from live import (
    SCENARIO,
    SECOND,
    assert_same,
    expected,
    offline,
    stamp_ns,
    start_replay,
    values_of,
)
from ros import ROOT, Graph, Listener, RosProcess
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from hijack_detect.bags.topics import OWN_TOPICS
from hijack_detect.nodes.qos import STATE

BAG = ROOT / "bags/curved_8"
RATE, DURATION_S = 4.0, 70.0
"""Two monitors, two replays and this test have to follow on two cores that do other things, too: a
GPS that waits for its turn for 3 s of the flight is left out as late."""
LAST_S = 5.0
"""The end of a part of a bag for which verdicts may still be held back."""
ATTACKS = {"uav1": SCENARIO, "uav2": None}
"""Only the first vehicle is attacked."""


def start_monitor(graph: Graph, vehicle: str, folder: Path) -> RosProcess:
    """Start the whole monitor of a vehicle with the files of a replay, so that nothing is lost."""
    topics = {
        f"/{vehicle}/{topic}": {"subscription": {"reliability": "reliable", "history": "keep_all"}}
        for topic in OWN_TOPICS.values()
    }
    own = folder / f"{vehicle}.yaml"
    given = {
        "/**": {"ros__parameters": {"qos_overrides": topics}},
        "/**/monitor": {"ros__parameters": {"publish_rate": 0.0}},
    }
    own.write_text(yaml.safe_dump(given))
    files = (ROOT / "config/default.yaml", ROOT / "config/replay.yaml", own)
    arguments = [word for file in files for word in ("--params-file", str(file))]
    return graph.start("all", "-r", f"__ns:=/{vehicle}", *arguments)


def start_flight(graph: Graph, vehicle: str) -> RosProcess:
    """Start the replay of a vehicle's flight; it begins when the vehicle's monitor is there."""
    given: dict[str, Any] = {"rate": RATE, "duration_s": DURATION_S}
    if scenario := ATTACKS[vehicle]:
        given["scenario"] = scenario
    return start_replay(graph, BAG, ("fusion", "monitor"), space=f"/{vehicle}", **given)


def reaches(heard: Sequence[Any], end_ns: int) -> bool:
    """Whether a verdict is as late as a stamp."""
    return bool(heard) and stamp_ns(heard[-1]) >= end_ns


def last(alert: Listener) -> bool:
    """The last word of an alert."""
    return bool(alert.messages[-1].data)


def test_each_vehicle_hears_its_own_attack_and_its_own_reset(graph: Graph, tmp_path: Path) -> None:
    verdicts = {
        vehicle: graph.listen(DiagnosticArray, f"{vehicle}/fusion/verdict") for vehicle in ATTACKS
    }
    alerts = {vehicle: graph.listen(Bool, f"{vehicle}/hijack_alert", STATE) for vehicle in ATTACKS}
    monitors = [start_monitor(graph, vehicle, tmp_path) for vehicle in ATTACKS]
    flights = [start_flight(graph, vehicle) for vehicle in ATTACKS]
    graph.be_ready()
    for process in flights:
        assert graph.spin_to_end(process, 120.0) == 0, process.output

    for vehicle, scenario in ATTACKS.items():
        run = offline(BAG, "default", scenario)
        heard = verdicts[vehicle].messages
        end_ns = run.start_ns + round((DURATION_S - LAST_S) * SECOND)
        graph.spin_until(partial(reaches, heard, end_ns), f"the last verdict of {vehicle}")
        upto = sum(stamp_ns(one) < end_ns for one in heard)
        assert_same(vehicle, heard[:upto], expected(run)["fusion"][:upto])
        told = {values_of(one)["alert"] for one in heard}
        assert ("true" in told) == (scenario is not None)
    assert last(alerts["uav1"])
    assert not last(alerts["uav2"])

    assert graph.call(Trigger, "uav2/fusion/reset").success
    assert last(alerts["uav1"])
    assert graph.call(Trigger, "uav1/fusion/reset").success
    graph.spin_until(lambda: not last(alerts["uav1"]), "the end of the alert")
    names = graph.node.get_topic_names_and_types()
    outside = {name for name, _ in names if not name.startswith(("/uav1/", "/uav2/"))}
    assert outside <= {"/diagnostics", "/rosout", "/parameter_events", "/clock"}, outside
    assert [process.interrupt() for process in monitors] == [0, 0]
