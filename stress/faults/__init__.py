# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Faults injected into the running monitor, and how soon it reports them."""
