# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Outputs of the monitor for four fixed replays, kept to show every change of it."""
