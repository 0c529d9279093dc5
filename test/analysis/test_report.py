# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The page of an analysed flight, opened in a real browser without a network."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from live import SCENARIO
from ros import ROOT
from small_bags import START_NS, flight, raw, write

from hijack_detect.analysis.analyse import Analysed, analyse
from hijack_detect.analysis.report.curves import (
    Curve,
    cut_at,
    emptiest_direction,
    lonely,
    thinned,
)
from hijack_detect.analysis.report.page import write_page
from hijack_detect.analysis.report.recording import Recorder, recording
from hijack_detect.analysis.report.tables import events
from hijack_detect.bags.reader import BagReader
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.spoofing.scenario import Scenario, load_scenario
from hijack_detect.streams.samples import FixSample

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

PLOTS = ("track", "states", "margins", "deviation", "angles", "rho", "difference", "acceleration",
         "coast", "checks", "altitude", "heading", "drag", "speed", "interval",
         "satellites")  # fmt: skip


def report(bag: Path, folder: Path, scenario: Scenario | None = None) -> tuple[Path, Analysed]:
    """Analyse a bag and write its page."""
    recorder = Recorder()
    with BagReader(bag) as reader:
        done = analyse(
            reader,
            policy_parameters("default"),
            scenario,
            on_sample=recorder.take,
            on_output=recorder.take_output,
        )
        recorded = recording(reader, recorder, injected=scenario is not None)
    return write_page(folder, done, recorded), done


@pytest.fixture(scope="module")
def spoofed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Analysed]:
    folder = tmp_path_factory.mktemp("report")
    return report(ROOT / "bags/curved_8", folder, load_scenario(SCENARIO))


@pytest.fixture
def show(browser: Browser) -> Iterator[object]:
    """Opens a page offline; fails if it complains, or asks for anything but its file."""
    contexts, complaints, asked = [], [], []

    def opened(path: Path, width: int = 1280) -> Page:
        context = browser.new_context(viewport={"width": width, "height": 900})
        context.set_offline(True)
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: complaints.append(message.text))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("request", lambda request: asked.append(request.url))
        page.goto(path.as_uri())
        return page

    yield opened
    for context in contexts:
        context.close()
    assert complaints == []
    assert [url for url in asked if not url.startswith(("file:", "data:"))] == []


def range_of(page: Page, plot: str) -> list[float]:
    """The visible seconds of a figure."""
    found = page.evaluate(f"document.getElementById('plot-{plot}').layout.xaxis.range")
    return [float(one) for one in found]


@pytest.mark.slow
def test_the_page_shows_verdict_figures_and_events(show, spoofed, tmp_path: Path) -> None:
    path, done = spoofed
    page = show(path)
    assert page.locator("#verdict .said").inner_text() == done.analysis.verdict
    assert page.locator("#verdict .found").inner_text() == "spoofed"
    assert page.locator("#verdict .cause").all_inner_texts() == [
        f"Cause: {one.cause}" for one in done.analysis.alerts
    ]
    assert page.locator("h1").inner_text() == "curved_8"
    for name in PLOTS:
        traces = page.locator(f"#plot-{name} svg g.trace")
        assert traces.count() > 0, name
    told = page.locator("#events tbody tr")
    assert told.count() == len(events(done))
    text = page.locator("#events").inner_text()
    assert "attack begins" in text
    assert done.analysis.alerts[0].cause in text
    assert page.locator("#detectors tbody tr").count() == len(done.analysis.detectors)
    assert not page.locator("#skipped").is_visible()
    shot = tmp_path / "page.png"
    page.screenshot(path=shot, full_page=True)
    assert shot.stat().st_size > 50_000
    assert path.stat().st_size < 8_000_000


@pytest.mark.slow
def test_zooming_one_figure_zooms_all_over_time(show, spoofed) -> None:
    page = show(spoofed[0])
    page.evaluate("Plotly.relayout('plot-margins', {'xaxis.range': [50, 70]})")
    page.wait_for_function(
        "document.getElementById('plot-speed').layout.xaxis.range.join() === '50,70'"
    )
    assert range_of(page, "states") == [50.0, 70.0]
    assert range_of(page, "track") != [50.0, 70.0]
    page.evaluate("Plotly.relayout('plot-speed', {'xaxis.autorange': true})")
    page.wait_for_function(
        "document.getElementById('plot-margins').layout.xaxis.range.join() !== '50,70'"
    )
    assert range_of(page, "margins") == [0.0, pytest.approx(110.0, abs=0.1)]


@pytest.mark.slow
def test_on_a_phone_nothing_is_wider_than_the_screen(show, spoofed, tmp_path: Path) -> None:
    page = show(spoofed[0], width=400)
    assert page.evaluate("document.documentElement.scrollWidth") <= 400
    widths = page.evaluate(
        "[...document.querySelectorAll('.main-svg')].map(svg => svg.getBoundingClientRect().width)"
    )
    assert max(widths) <= 400
    page.screenshot(path=tmp_path / "phone.png", full_page=True)


@pytest.mark.slow
def test_odd_names_and_a_flight_without_positions(show, tmp_path: Path) -> None:
    bag = tmp_path / "<img src=x onerror=alert(1)>&"
    messages = [
        raw(one.topic, FixSample(one.log_ns, 0.0, 0.0, 0.0, has_fix=False))
        if one.topic == "/gps/fix"
        else one
        for one in flight(6.0)
        if not one.topic.startswith("/truth")
    ]
    bad = raw("/gps/fix", FixSample(START_NS + 1, math.nan, 0.0, 0.0))
    write(bag, sorted([*messages, bad], key=lambda one: one.log_ns))
    page = show(report(bag, tmp_path)[0])
    assert page.locator("h1").inner_text() == bag.name
    assert page.locator("img").count() == 0
    assert page.locator("#skipped tbody tr").count() == 1
    assert page.locator("#plot-rho .annotation").filter(has_text="no values").count() == 1


def test_thinning_keeps_every_peak_and_the_gaps() -> None:
    rng = np.random.default_rng(1)
    value = rng.normal(size=100_000)
    value[[1234, 56_789]] = 50.0, -50.0
    value[20_000:30_000] = np.nan
    few = thinned(Curve(np.arange(100_000.0), value), 3000)
    assert len(few.time_s) <= 3000
    assert np.all(np.diff(few.time_s) > 0.0)
    assert few.value[few.time_s == 1234.0] == 50.0
    assert few.value[few.time_s == 56_789.0] == -50.0
    assert np.all(np.isnan(few.value[(few.time_s >= 20_000) & (few.time_s < 30_000)]))
    short = Curve(np.arange(10.0), np.arange(10.0))
    assert thinned(short, 3000) is short


def test_a_point_between_gaps_is_lonely() -> None:
    nan = np.nan
    found = lonely(Curve(np.arange(6.0), np.array([1.0, nan, 2.0, nan, 3.0, 4.0])))
    assert found.time_s.tolist() == [0.0, 2.0]
    assert len(lonely(Curve(np.array([]), np.array([]))).time_s) == 0


def test_angles_are_cut_where_there_are_none() -> None:
    angles = np.array([350.0, 355.0, 0.0, 5.0, np.nan, 10.0])
    cut = emptiest_direction(angles)
    assert cut == pytest.approx(180.0)
    smooth = cut_at(Curve(np.arange(6.0), angles), cut)
    assert smooth.value[~np.isnan(smooth.value)].tolist() == [-10.0, -5.0, 0.0, 5.0, 10.0]
    assert len(smooth.time_s) == 6
    crossing = cut_at(Curve(np.arange(2.0), np.array([179.0, 181.0])), 180.0)
    assert crossing.value.tolist() == [179.0, pytest.approx(np.nan, nan_ok=True), -179.0]
    assert emptiest_direction(np.array([np.nan])) == 360.0
