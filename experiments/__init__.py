# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Experiments: papers, limits, recorded flights, gates of autopilots."""
