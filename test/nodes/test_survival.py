# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The file that an alert survives in: what is read of it, and what is not believed."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from hijack_detect.detectors.fusion import Latched
from hijack_detect.nodes.state_file import Survivor

ALERT = Latched(1_700_000_000_123_456_789, 'coast "alarm"', ("coast", "drag"), 0.987)


@pytest.fixture
def survivor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Survivor:
    monkeypatch.setenv("ROS_HOME", str(tmp_path))
    monkeypatch.setenv("ROS_DOMAIN_ID", "42")
    return Survivor("/uav1/fusion", 20.0)


def change(survivor: Survivor, **values: Any) -> None:
    told = json.loads(survivor.path.read_text())
    survivor.path.write_text(json.dumps({**told, **values}))


def test_what_is_written_is_read(survivor: Survivor) -> None:
    assert survivor.read() is None
    survivor.write(ALERT)
    assert survivor.read() == ALERT
    survivor.forget()
    assert survivor.read() is None
    survivor.forget()


def test_every_node_and_domain_has_a_file_of_its_own(
    survivor: Survivor, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    survivor.write(ALERT)
    assert survivor.path == tmp_path / "hijack_detect/alert-42-uav1-fusion.json"
    assert Survivor("/uav2/fusion", 20.0).read() is None
    monkeypatch.setenv("ROS_DOMAIN_ID", "43")
    assert Survivor("/uav1/fusion", 20.0).read() is None


@pytest.mark.parametrize(("key", "moved"), [("alive_s", -20.1), ("alive_s", 60.0), ("boot", None)])
def test_an_old_alert_and_one_of_another_boot_are_over(
    survivor: Survivor, key: str, moved: float | None
) -> None:
    """A stamp in the future is of another boot too."""
    survivor.write(ALERT)
    told = json.loads(survivor.path.read_text())[key]
    change(survivor, **{key: "another" if moved is None else told + moved})
    assert survivor.read() is None


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "3", '{"boot": ""}', '{"alive_s": "soon"}', "\x00" * 100, "[" * 10**5]
)
def test_a_broken_file_is_no_alert(survivor: Survivor, text: str) -> None:
    survivor.write(ALERT)
    survivor.path.write_text(text)
    assert survivor.read() is None


@pytest.mark.parametrize("since_ns", ["never", math.inf, None])
def test_a_broken_alert_in_a_good_file_is_none(survivor: Survivor, since_ns: object) -> None:
    survivor.write(ALERT)
    change(survivor, alert={"since_ns": since_ns, "cause": "", "causes": [], "confidence": 1.0})
    assert survivor.read() is None


def test_where_nothing_can_be_written_is_said(survivor: Survivor, tmp_path: Path) -> None:
    (tmp_path / "hijack_detect").write_text("a file where the folder should be")
    with pytest.raises(OSError, match="hijack_detect"):
        survivor.write(ALERT)
