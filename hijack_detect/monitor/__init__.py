# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The monitor as one object: its parts, the graph that wires them, and its parameter sets."""
