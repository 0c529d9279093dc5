# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The durable store and the black box: files written in flight, without ROS."""
