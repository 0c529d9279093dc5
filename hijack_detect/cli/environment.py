# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Makes ROS find a package that was installed into a virtual environment."""

from __future__ import annotations

import os
import sys
from pathlib import Path

VARIABLE = "AMENT_PREFIX_PATH"


def add_own_prefix() -> None:
    """Put this Python's prefix on AMENT_PREFIX_PATH if it is an ament prefix.

    The wheels do not set the variable, and without it the ament index knows nothing.
    """
    known = [path for path in os.environ.get(VARIABLE, "").split(os.pathsep) if path]
    index = Path(sys.prefix, "share/ament_index/resource_index/packages")
    if index.is_dir() and sys.prefix not in known:
        os.environ[VARIABLE] = os.pathsep.join([sys.prefix, *known])
