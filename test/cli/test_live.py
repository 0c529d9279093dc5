# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""`hijack-detect live` beside a real monitor and a spoofed flight, in a real browser."""

from __future__ import annotations

import http.client
import re
import signal
import subprocess
import sys
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

import pytest
from command import hijack_detect
from live import SCENARIO
from page_events import seen
from ros import ROOT, Graph, RosProcess

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

expect = pytest.importorskip("playwright.sync_api", reason="playwright is not installed").expect

BAG = ROOT / "bags/curved_8"
REPLAYED = str(ROOT / "config/replay.yaml")
URL = re.compile(r"http://127\.0\.0\.1:\d+/")
RATE = """async seconds => {
  const frames = () => Number(document.documentElement.dataset.frames), before = frames();
  const began = performance.now();
  await new Promise(done => setTimeout(done, 1000 * seconds));
  return 1000 * (frames() - before) / (performance.now() - began);
}"""
COAST_ABOVE_THE_LIMIT = """() => {
  const canvas = document.getElementById('margins'), pen = canvas.getContext('2d');
  const style = getComputedStyle(document.documentElement).getPropertyValue('--d-3').trim();
  const [r, g, b] = style.match(/[0-9a-f]{2}/g).map(one => parseInt(one, 16));
  const {data} = pen.getImageData(40, 8, canvas.width - 190, canvas.height / 2 - 40);
  let found = 0;
  for (let at = 0; at < data.length; at += 4)
    found += data[at] === r && data[at + 1] === g && data[at + 2] === b;
  return found;
}"""
"""Pixels in the colour of coast, in the upper part of the plot."""


def started(graph: Graph, *arguments: str) -> tuple[RosProcess, str]:
    """Start the viewer on any port; give it and where it is."""
    viewer = graph.run("hijack_detect.cli.main", "live", "--port", "0", *arguments)
    viewer.wait_for("/\n")
    graph.spin_until(lambda: URL.search(viewer.output), "the address")
    found = URL.search(viewer.output)
    assert found is not None
    return viewer, found[0]


def held(graph: Graph) -> tuple[list[str], list[str]]:
    """Topics that the viewer publishes, and its services."""
    asked = graph.node.get_publisher_names_and_types_by_node("live", "/")
    served = graph.node.get_service_names_and_types_by_node("live", "/")
    return [name for name, _ in asked], [name for name, _ in served]


@pytest.fixture
def page(browser: Browser) -> Page:
    return browser.new_page(viewport={"width": 1400, "height": 900})


@pytest.mark.slow
def test_an_attack_is_seen_from_the_first_alarm_to_the_end_of_the_monitor(
    graph: Graph, page: Page
) -> None:
    complaints: list[str] = []
    errors = {"error", "assert"}  # reading the canvas back makes a warning
    page.on("console", lambda told: complaints.append(told.text) if told.type in errors else None)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    policy = ("--params-file", str(ROOT / "config/default.yaml"), "--params-file", REPLAYED)
    monitor = graph.start("all", *policy)
    viewer, url = started(graph)
    given = {"bag": BAG, "scenario": SCENARIO, "rate": 3.0, "start_s": 18.0}
    graph.start("bag_replay", parameters={**given, "wait_for": "fusion monitor live"})
    page.goto(url)
    word = page.locator("#word")
    expect(word).to_have_text("normal", timeout=60_000)
    assert held(graph) == (["/parameter_events"], [])
    assert page.evaluate(RATE, 2.0) >= 9.0
    assert page.evaluate(COAST_ABOVE_THE_LIMIT) == 0
    expect(word).to_have_text("normal")
    expect(word).to_have_text("alarm", timeout=60_000)
    expect(page.locator("#since")).to_contain_text("0:4")
    expect(page.locator("#why")).to_contain_text("coast")
    graph.spin_until(lambda: page.evaluate(COAST_ABOVE_THE_LIMIT) > 20, "the curve of coast")

    late = seen(url)
    assert len(late["track"]) > 100
    assert max(value for _, value in late["margins"]["coast"] if value is not None) > 1.0
    assert {"correlation", "date", "coast", "gnss", "heading"} <= set(late["margins"])
    for method in ("POST", "PUT", "DELETE"):
        client = http.client.HTTPConnection(urlsplit(url).netloc, timeout=5.0)
        client.request(method, "/events", "x")
        assert client.getresponse().status == 405
        client.close()

    monitor.signal(signal.SIGKILL)
    expect(word).to_have_text("monitor silent", timeout=5_000)
    expect(page.locator("#why")).to_contain_text("The last that was heard is ALARM")
    assert complaints == []
    assert viewer.interrupt() == 0
    assert "Traceback" not in viewer.output
    assert len(viewer.output.splitlines()) == 2, viewer.output
    page.close()


def test_an_address_that_cannot_be_used_ends_it_with_one_line() -> None:
    done = hijack_detect("live", "--namespace", "1/bad name", "--port", "0")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("Error: --namespace 1/bad name: ")
    assert len(done.stderr.splitlines()) == 1
    done = hijack_detect("live", "--host", "192.0.2.1")
    assert (done.returncode, done.stderr) == (
        2,
        "Error: --host 192.0.2.1: this machine has no such address\n",
    )


def test_others_are_warned_of_and_namespace_and_mavros_choose_the_topics(graph: Graph) -> None:
    arguments = ("--host", "0.0.0.0", "--port", "0", "--namespace", "uav1", "--mavros")
    viewer = graph.run("hijack_detect.cli.main", "live", *arguments)
    viewer.wait_for("/\n")
    assert "warning: anyone who reaches this address sees the vehicle's position" in viewer.output
    fix = "/uav1/mavros/global_position/raw/fix"
    assert f"subscribes to /uav1/*/verdict, /uav1/hijack_alert and {fix}" in viewer.output
    graph.spin_until(lambda: graph.node.count_subscribers(fix), "its subscription")
    assert graph.node.count_subscribers("/uav1/coast/verdict") == 1
    viewer.signal(signal.SIGTERM)
    assert viewer.wait() == 0
    assert "Traceback" not in viewer.output


def test_without_tornado_the_extra_is_named() -> None:
    script = (
        "import sys; sys.modules['tornado'] = None; sys.argv = ['hijack-detect', 'live']\n"
        "from hijack_detect.cli.main import main; main()"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 2
    assert "pip install '.[live]'" in done.stderr
