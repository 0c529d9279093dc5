# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A whole flight as PX4 sends it, through px4_bridge and the monitor, over DDS."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import px4_vehicle
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import QuaternionStamped
from live import SECOND, assert_same, stamp_ns, values_of
from px4_vehicle import OUTPUTS, Vehicle, said
from px4_workspace import workspace
from ros import ROOT, Graph, Listener
from sensor_msgs.msg import NavSatFix
from test_security import allowed, held

from hijack_detect.bags.reader import BagReader
from hijack_detect.monitor.graph import Monitor
from hijack_detect.monitor.parts import DETECTORS
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.nodes.messages import verdict_message
from hijack_detect.replay.offline import (
    FlightNotes,
    OfflineRun,
    outputs_of,
    run_samples,
    spoofed_samples,
)
from hijack_detect.spoofing.scenario import load_scenario
from hijack_detect.streams.samples import Sample

BAG = ROOT / "bags/curved_8"
SCENARIO = ROOT / "config/scenarios/turn_away.yaml"
AHEAD = 3
"""So many fixes the vehicle is ahead of the monitor: best effort keeps little on its way."""
BOOT_US = 37_500_000
NEAR_NS = SECOND // 2
Flight = list[tuple[str, Sample]]


class Ride:
    """One PX4 in a namespace, its bridge, the monitor behind it, and what that says."""

    def __init__(
        self,
        graph: Graph,
        space: str,
        flight: Flight,
        verdicts: tuple[str, ...],
        boot_us: int | None = None,
    ) -> None:
        self.space, self.flight = space, flight
        self.from_ns = 0 if boot_us is None else flight[0][1].stamp_ns - boot_us * 1000
        self.sent = px4_vehicle.messages(flight, self.from_ns)
        self.vehicle = Vehicle(graph, space)
        replay = (ROOT / "config/replay.yaml").read_text()
        file = Path(graph.home.name, f"{space.strip('/')}.yaml")
        file.write_text(replay.replace("      /", f"      {space}/"))
        files = ["--params-file", str(ROOT / "config/default.yaml"), "--params-file", str(file)]
        place = ("-r", f"__ns:={space}")
        self.nodes = [
            graph.start("px4_bridge", *place),
            graph.start("all", *place, *files, "-p", "monitor:publish_rate:=0.0"),
        ]
        self.fixes = graph.listen(NavSatFix, f"{space}/gps/fix")
        self.courses = graph.listen(QuaternionStamped, f"{space}/gps/course")
        self.verdicts = {
            name: graph.listen(DiagnosticArray, f"{space}/{name}/verdict") for name in verdicts
        }

    def ready(self, graph: Graph, told: Listener) -> bool:
        """Whether the bridge knows this PX4, and every subscription that this test knows."""
        served = px4_vehicle.subscribers(told, self.space)
        inputs = [f"{self.space}/{topic}" for _, topic in OUTPUTS.values()]
        counts = {one: graph.node.count_subscribers(one) for one in inputs}
        return self.vehicle.heard(told, self.space) and all(
            0 < count <= served.get(one, 0) for one, count in counts.items()
        )

    def counts(self, told: Listener, what: str) -> list[int]:
        """What the bridge has counted of each topic."""
        topics = (topic for topic, _ in px4_vehicle.TOPICS.values())
        return [int(said(told, self.space, topic)[1].get(what, 0)) for topic in topics]

    def used(self, told: Listener) -> dict[str, int]:
        """How many messages of each topic the bridge has used."""
        all_of, bad = self.counts(told, "received"), self.counts(told, "left out, bad message")
        counts = (came - refused for came, refused in zip(all_of, bad, strict=True))
        return dict(zip(px4_vehicle.TOPICS, counts, strict=True))

    def behind(self, fixes: int, heard: Listener | None = None) -> int:
        """How many of the fixes that were sent the monitor has not used; it gets none at first.

        Or how many are not `heard` of by a listener.
        """
        aligning = 5 if self.from_ns else 0
        return fixes - aligning - len((heard or self.courses).messages)

    def shift_ns(self) -> int:
        """How far all stamps are moved."""
        times = [us * 1000 for name, us, _ in self.sent if name == "fix"]
        stamps = [stamp_ns(one) for one in self.fixes.messages]
        used = times[len(times) - len(stamps) :]
        moved = {ours - theirs for ours, theirs in zip(stamps, used, strict=True)}
        assert len(moved) == 1, "nothing was lost, and the spacing of the stamps is PX4's"
        return moved.pop() - self.from_ns

    def alert_ns(self) -> int:
        """Stamp of the first result with an alert."""
        results = self.verdicts["fusion"].messages
        return stamp_ns(next(one for one in results if values_of(one)["alert"] == "true"))


@pytest.mark.slow
def test_a_flight_over_px4_msgs_gives_the_same_verdicts(graph: Graph) -> None:
    """Two vehicles at once: one whose agent synchronises, and one whose times count from boot."""
    graph.environment = workspace()
    with BagReader(BAG) as reader:
        notes = FlightNotes(reader.start_ns)
        flight = [*spoofed_samples(reader, load_scenario(SCENARIO), notes)]
    rides = [
        Ride(graph, "/uav1", flight, (*DETECTORS, "fusion")),
        Ride(graph, "/uav2", flight, ("fusion",), BOOT_US),
    ]
    told = graph.listen(DiagnosticArray, "/diagnostics")
    for ride in rides:
        graph.until_known(*(f"{ride.space}/{name}" for name in ("px4_bridge", "fusion", "monitor")))
    graph.spin_until(lambda: all([ride.ready(graph, told) for ride in rides]), "all nodes", 60.0)

    fixes = 0

    def followed() -> bool:
        return all(ride.behind(fixes) <= AHEAD for ride in rides)

    for (name, _, synchronised), (_, _, since_boot) in zip(*(r.sent for r in rides), strict=True):
        rides[0].vehicle.send(name, synchronised)
        rides[1].vehicle.send(name, since_boot)
        if name == "fix":
            fixes += 1
            graph.spin_until(followed, "the monitor to follow")
    sent = Counter(name for name, _, _ in rides[0].sent)
    for ride in rides:
        graph.spin_until(lambda r=ride: r.behind(fixes, r.fixes) <= 0, "every fix")
        graph.spin_until(lambda r=ride: r.behind(fixes) <= 1, "the course of all but the last")

    monitor = Monitor(policy_parameters("default"))
    heard = px4_vehicle.heard(flight, 0)
    offline = run_samples(heard, monitor, OfflineRun(heard[0][1].stamp_ns))
    for name in DETECTORS:
        told_of = rides[0].verdicts[name].messages
        wanted = [verdict_message(one) for one in offline.verdicts[name]]
        least = len(wanted) - 1
        graph.spin_until(lambda of=told_of, n=least: len(of) >= n, f"the last verdict of {name}")
        assert abs(len(told_of) - len(wanted)) <= 1, "the last fix of a flight waits for the next"
        assert_same(name, told_of[: len(wanted)], wanted[: len(told_of)])
    assert rides[0].alert_ns() == next(one.stamp_ns for one in offline.results if one.alert)
    direct_ns = first_alert_ns(flight)
    for ride in rides:
        shift_ns = ride.shift_ns()
        assert (shift_ns == 0) == (ride.from_ns == 0)
        assert abs(ride.alert_ns() - shift_ns - direct_ns) < NEAR_NS
        graph.spin_until(lambda ride=ride: ride.used(told) == sent, "a report of all")
        rights = {right for _, right in allowed("px4_bridge", ride.space)}
        assert held(graph, "px4_bridge", ride.space) == rights
        assert all(node.interrupt() == 0 for node in ride.nodes)
    assert "UTC, synchronised by the agent" in rides[0].nodes[0].output
    assert "count from its start" in rides[1].nodes[0].output


def first_alert_ns(flight: Flight) -> int:
    """When the monitor alerts that has the flight as it was recorded, in double precision."""
    outputs = outputs_of(flight, Monitor(policy_parameters("default")))
    return next(one.stamp_ns for part, one in outputs if part == "fusion" and one.alert)
