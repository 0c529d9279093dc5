# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A recorded flight: through the monitor, as messages, with attacks, and its ground truth."""
