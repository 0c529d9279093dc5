# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""One flight: what was said of it, in words, figures and a page."""
