# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Checks of the environment that the monitor runs in, one file for each group; none needs ROS."""
