# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A live MAVLink link to an autopilot, without ROS: its inputs, its clock, its commands."""
