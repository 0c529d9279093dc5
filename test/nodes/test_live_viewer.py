# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The node of the live page: messages that cannot be read, and those of other vehicles."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from page_events import seen
from ros import KEEP_ALL, Graph
from sensor_msgs.msg import NavSatFix, NavSatStatus

from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.nodes.messages import status, verdict_message

SECOND = 1_000_000_000
EVIL = "<script>alert(1)</script>"


def test_what_cannot_be_read_is_left_out_and_told_and_the_rest_is_shown(graph: Graph) -> None:
    viewer = graph.run(
        "hijack_detect.cli.main", "live", "--port", "0", "--namespace", "uav1", "--detector", "own"
    )
    viewer.wait_for("/\n")
    url = re.findall(r"http://\S+", viewer.output)[0]
    outputs = {
        topic: graph.node.create_publisher(kind, topic, KEEP_ALL)
        for topic, kind in (
            ("/uav1/coast/verdict", DiagnosticArray),
            ("/uav1/own/verdict", DiagnosticArray),
            ("/uav1/fusion/verdict", DiagnosticArray),
            ("/uav1/gps/fix", NavSatFix),
            ("/diagnostics", DiagnosticArray),
        )
    }

    def send(topic: str, message: Any, done: Callable[[], object]) -> None:
        """Send until it was heard: a viewer may miss messages."""
        graph.spin_until(lambda: outputs[topic].publish(message) or done(), topic)

    def refused(topic: str) -> Callable[[], bool]:
        return lambda: f"{topic}: message left out: " in viewer.output

    wrong = {"state": "normal", "alert": "true", "alert_since_ns": "9" * 400}
    wrong |= {"confidence": "0.5", "lost": "", "degraded": "", "causes": ""}
    bad = {
        "/uav1/coast/verdict": DiagnosticArray(),
        "/uav1/fusion/verdict": DiagnosticArray(
            status=[status("fusion", DiagnosticStatus.OK, EVIL, wrong)]
        ),
        "/uav1/gps/fix": NavSatFix(status=NavSatStatus(status=0), latitude=float("nan")),
    }
    for topic, message in bad.items():
        send(topic, message, refused(topic))
    assert seen(url)["time"] is None

    good = Verdict("coast", SECOND, State.SUSPICIOUS, 1.2, 1.0, EVIL, {"x": float("nan")})
    send("/uav1/coast/verdict", verdict_message(good), lambda: seen(url)["time"] is not None)
    own = Verdict("own", SECOND, State.NORMAL, 0.5, 1.0, "of the user")
    send("/uav1/own/verdict", verdict_message(own), lambda: "of the user" in str(seen(url)))
    complaints = [
        status("/uav1/fusion: publishers", DiagnosticStatus.WARN, "two of them", {}),
        status("/uav2/fusion: publishers", DiagnosticStatus.WARN, "not ours", {}),
        status("/uav1/coast_detector: inputs", DiagnosticStatus.OK, "all messages used", {}),
    ]
    send("/diagnostics", DiagnosticArray(status=complaints), lambda: "two of" in str(seen(url)))
    told = seen(url)
    ours, *refusals = sorted(told["complaints"], key=lambda text: text.startswith("/"))
    assert ours == "fusion: publishers: two of them"
    assert all(text.startswith("/uav1/") and "left out" in text for text in refusals)
    (coast,) = (one for one in told["detectors"] if one["name"] == "coast")
    assert (coast["state"], coast["margin"], coast["why"]) == ("suspicious", 1.2, EVIL)
    assert viewer.interrupt() == 0
    assert "Traceback" not in viewer.output
