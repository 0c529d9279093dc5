# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What the monitor says of four fixed replays, kept to show every change of it."""
