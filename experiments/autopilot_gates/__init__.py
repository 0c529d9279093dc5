# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Innovation gates of PX4 and ArduPilot under a spoofed GPS."""
