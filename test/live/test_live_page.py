# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The live page in a real browser: every state in words, texts as texts, a lost server."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import pytest
from shown import Flown

from hijack_detect.detectors.verdict import State
from hijack_detect.monitor.parts import DETECTORS

pytest.importorskip("tornado", reason="the extra live is not installed")

from hijack_detect.live.server import Server

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

expect = pytest.importorskip("playwright.sync_api", reason="playwright is not installed").expect

EVIL = "<script>document.title='owned'</script><img src=x onerror=\"document.title='owned'\">"


@pytest.fixture
def flown() -> Flown:
    return Flown()


@pytest.fixture
def page(browser: Browser, server: Server) -> Iterator[Page]:
    """The page, which may not complain nor ask for anything from elsewhere."""
    opened = browser.new_page()
    complaints: list[str] = []
    asked: list[str] = []
    opened.on("console", lambda message: complaints.append(message.text))
    opened.on("pageerror", lambda error: complaints.append(str(error)))
    opened.on("request", lambda request: asked.append(request.url))
    opened.goto(server.url)
    yield opened
    opened.close()
    assert complaints == []
    assert [url for url in asked if not url.startswith((server.url, "data:"))] == []


STATES: tuple[tuple[str, dict[str, Any]], ...] = (
    ("not ready", {"state": State.NOT_READY}),
    ("not observable", {"state": State.NOT_OBSERVABLE}),
    ("normal", {}),
    ("suspicious", {"state": State.SUSPICIOUS, "margin": 1.1}),
    ("degraded", {"degraded": ("kld",)}),
    ("alarm", {"state": State.ALARM, "margin": 5.0, "alert": True}),
)


def test_every_state_is_told_in_words_with_its_cause(page: Page, flown: Flown) -> None:
    word, why = page.locator("#word"), page.locator("#why")
    expect(word).to_have_text("monitor silent")
    expect(why).to_contain_text("is the monitor running")
    for name, given in STATES:
        flown.fly(4.0, **given)
        expect(word).to_have_text(name)
        expect(page).to_have_title(re.compile(name.upper()))
    assert why.inner_text() == "consistent"
    expect(page.locator("#probability")).to_have_text("0.90")
    expect(page.locator("#since")).to_have_text("0:24 (0 s)")
    rows = page.locator("#detectors tr")
    expect(rows).to_have_count(len(DETECTORS))
    expect(rows.nth(3)).to_contain_text("coast")
    expect(rows.nth(3)).to_contain_text("alarm")
    expect(rows.nth(3)).to_contain_text("5.00")
    expect(page.locator("#position")).to_contain_text("m East")
    flown.now += 3.0
    expect(word).to_have_text("monitor silent")
    expect(why).to_contain_text("The last that was heard is ALARM: consistent")


def test_a_text_from_a_message_is_shown_as_text(page: Page, flown: Flown) -> None:
    flown.picture.receive_complaint("fusion: inputs", EVIL)
    flown.fly(2.0, alert=True, reason=EVIL)
    expect(page.locator("#why")).to_have_text(EVIL)
    expect(page.locator("#detectors td").nth(3)).to_have_text(EVIL)
    expect(page.locator("#complaints li")).to_have_text(f"fusion: inputs: {EVIL}")
    assert page.locator("main script, main img, header img").count() == 0
    assert page.title() == "ALARM · hijack_detect"


def test_a_phone_needs_no_scrolling_to_the_side(browser: Browser, server: Server) -> None:
    context = browser.new_context(viewport={"width": 390, "height": 844})
    page = context.new_page()
    page.goto(server.url)
    expect(page.locator("#word")).to_have_text("monitor silent")
    assert page.evaluate("document.documentElement.scrollWidth") == 390
    context.close()


def test_a_server_that_is_gone_is_no_connection(browser: Browser, flown: Flown) -> None:
    server = Server(flown.picture, "127.0.0.1", 0)
    server.start()
    flown.fly(2.0)
    page = browser.new_page()
    page.goto(server.url)
    expect(page.locator("#word")).to_have_text("normal")
    server.stop()
    expect(page.locator("#word")).to_have_text("no connection")
    expect(page.locator("#why")).to_contain_text("What is shown is old")
    page.close()
