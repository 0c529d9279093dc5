# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Attacks on GPS: scenario files, and the spoofer that applies them to a stream of samples."""
