# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What the demonstration shows while it runs."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from hijack_detect.cli.demo_view import WORDS, live_view
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.monitor.parts import DETECTORS


def heard(verdicts: dict[str, list[Verdict]]) -> Any:
    return SimpleNamespace(position_s=1234.5, spoofed=True, alert=True, verdicts=verdicts)


@pytest.mark.parametrize("state", State)
def test_every_detector_is_there_and_the_lines_fit_into_80_columns(state: State) -> None:
    said = {name: [Verdict(name, 1, state, 1000.0, 1.0, "")] for name in DETECTORS}
    lines = live_view(heard(said)).plain.splitlines()
    assert max(map(len, lines)) <= 80
    assert lines[0].startswith("1234.5 s SPOOFED ALERT ")
    word = WORDS.get(state, "{:.2f}").format(1000.0)
    text = " ".join(" ".join(lines).split())
    assert all(f" {name} {word}" in text for name in DETECTORS)


def test_a_detector_that_was_never_heard_is_silent() -> None:
    shown = live_view(heard({name: [] for name in DETECTORS})).plain
    assert shown.count("silent") == len(DETECTORS)
