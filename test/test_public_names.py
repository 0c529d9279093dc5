# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The names that `from hijack_detect import …` promises: imported when used, without ROS."""

from __future__ import annotations

import subprocess
import sys

import pytest
from ros import ROOT

import hijack_detect

EXAMPLE = ROOT / "examples/compare_methods.py"
PAGE = ROOT / "docs/python.md"


def python(code: str, *arguments: str) -> str:
    """What a fresh interpreter prints."""
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("name", hijack_detect.__all__)
def test_a_public_name_is_there_and_documented(name: str) -> None:
    assert getattr(hijack_detect, name).__doc__
    assert name in dir(hijack_detect)
    assert f"`{name}" in PAGE.read_text(encoding="utf-8")


def test_another_name_is_refused() -> None:
    with pytest.raises(AttributeError, match="has no attribute 'flight_log'"):
        _ = hijack_detect.flight_log


def test_nothing_is_imported_before_it_is_used() -> None:
    assert python("import sys, hijack_detect; print('numpy' in sys.modules)") == "False\n"


def test_the_page_shows_the_example_as_it_is() -> None:
    example = EXAMPLE.read_text(encoding="utf-8")
    assert example[example.index("import sys") :] in PAGE.read_text(encoding="utf-8")


def test_the_example_finds_the_pull_and_needs_no_ros() -> None:
    code = (
        "import runpy, sys; sys.argv[0] = 'compare_methods.py'\n"
        f"runpy.run_path({str(EXAMPLE)!r}, run_name='__main__')\n"
        "print('rclpy' in sys.modules)"
    )
    *lines, verdict, ros = python(code, str(ROOT / "bags/curved_8")).splitlines()
    said = {line.split()[0]: line for line in lines}
    onset_s, found_s = 60.0, float(said["coast"].split()[-2])
    assert onset_s < found_s < onset_s + 3.0
    assert said["kld"].endswith("no alarm")
    assert verdict.startswith("Spoofed from 60.0 s on and detected")
    assert ros == "False"
