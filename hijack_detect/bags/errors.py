# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The one error that everything about bags raises."""

from __future__ import annotations


class BagError(ValueError):
    """A bag cannot be read or written.

    The text names the file, the topic and the stamp where they are known, and what to do next.
    """
