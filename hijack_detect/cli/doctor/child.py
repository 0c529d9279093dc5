# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Child process for what needs ROS: where Fast DDS hangs or dies, it does so there."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from typing import Any

from hijack_detect.cli.doctor.finding import Finding, Level

SHOWN = 300
"""Characters of an error that are shown. Chosen, not swept."""


class Child:
    """A Python module that prints JSON in its last line; a context manager that ends it."""

    def __init__(self, module: str, arguments: Sequence[str] = ()) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", module, *arguments],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def answer(self, timeout_s: float) -> Any:
        """Output of the child.

        Raises:
            ChildError: It gave none in time, or ended with an error.
        """
        try:
            printed, errors = self._process.communicate(timeout=timeout_s)
        except subprocess.TimeoutExpired as error:
            raise ChildError(f"no answer within {timeout_s:g} s") from error
        lines = printed.strip().splitlines()
        try:
            return json.loads(lines[-1])
        except (IndexError, ValueError) as error:
            last = " ".join(errors.strip().splitlines()[-1:])[:SHOWN]
            raise ChildError(last or f"ended with code {self._process.returncode}") from error

    def __enter__(self) -> Child:
        """It runs."""
        return self

    def __exit__(self, *error: object) -> None:
        """End it, at once."""
        self._process.kill()
        self._process.communicate()


class ChildError(RuntimeError):
    """A child gave no answer; the text gives the reason."""


def findings(answer: Any) -> list[Finding]:
    """Findings that a child has printed."""
    return [Finding(one[0], Level(one[1]), one[2], one[3]) for one in answer]


def printed(found: Sequence[Finding]) -> str:
    """Findings as a child prints them."""
    return json.dumps([(one.what, one.level.value, one.text, one.mend) for one in found])
