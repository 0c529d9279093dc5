# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""GPS acceleration against the accelerometer: the DATE method of Feng et al. 2018, section 3.4."""

from __future__ import annotations

from hijack_detect.nodes.detector_node import run_detector


def main() -> None:
    """Run the node."""
    run_detector("date_detector")


if __name__ == "__main__":
    main()
