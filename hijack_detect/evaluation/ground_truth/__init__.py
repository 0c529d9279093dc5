# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What is known of a flight's attack from elsewhere, and whether an alert was right."""
