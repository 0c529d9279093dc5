# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What the innovation gates of PX4 and ArduPilot make of a spoofed GPS."""
