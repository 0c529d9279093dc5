# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What is promised of hijack_alert: who publishes it and who hears it have it from here."""

REPEAT_S = 1.0
"""It is repeated this often, by a clock that nobody sets."""
SILENT_S = 2.5
"""Two repetitions are missing: the monitor is dead, or hangs."""
START_S = 30.0
"""The monitor may take so long to start."""
