# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""hijack_detect: tells a drone's mission manager that its GPS is being spoofed."""

__version__ = "0.1.0"
