# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The benchmarks are scripts that import each other from their folder."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

SPEED = Path(__file__).parents[2] / "benchmarks"


@pytest.fixture(scope="package", autouse=True)
def as_scripts() -> Iterator[None]:
    """Let tests import them as they do."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "path", [str(SPEED), *sys.path])
        yield
