# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The live page: what is kept of the last minutes, and the server that shows it. No ROS in here."""
