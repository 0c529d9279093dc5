# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Flights in the formats of autopilots and of ROS 1, one file each: a log becomes samples."""
