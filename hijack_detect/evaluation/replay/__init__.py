# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Bags in, messages or bags out: playback, injection, simulated bags."""
