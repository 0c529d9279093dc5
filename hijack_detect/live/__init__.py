# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The live page: the last minutes of the monitor, and the server that shows them, without ROS."""
