# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `doctor`, and its checks, one file a group; only its child processes use ROS."""
