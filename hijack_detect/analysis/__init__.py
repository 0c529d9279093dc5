# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Analysis of one flight: verdict, JSON and report."""
