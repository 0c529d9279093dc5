# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Consistency checks of a receiver stream, one idea a file: each takes steps, returns findings."""
