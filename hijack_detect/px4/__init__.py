# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A running PX4 over uXRCE-DDS, without ROS: parameters, clock, feeds."""
