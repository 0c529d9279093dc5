# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Makes the helpers of test/ importable."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
