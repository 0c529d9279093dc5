# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A running PX4 as it is heard over uXRCE-DDS, without ROS: parameters, clock, what is missing."""
