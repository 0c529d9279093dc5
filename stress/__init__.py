# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Stress tests: random input, faults, a killed recorder, and replays to the bit."""
