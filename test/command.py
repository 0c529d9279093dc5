# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command line tool, as it is typed."""

from __future__ import annotations

import subprocess
import sys


def hijack_detect(*arguments: object, timeout_s: float = 300.0) -> subprocess.CompletedProcess[str]:
    """Run `hijack-detect` with the arguments; give exit code, stdout and stderr."""
    command = [sys.executable, "-m", "hijack_detect.cli.main", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=timeout_s, check=False)
