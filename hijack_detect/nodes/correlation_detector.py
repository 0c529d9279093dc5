# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Yaw against GPS course: Feng et al. 2018, Algorithms 1 and 2."""

from __future__ import annotations

from hijack_detect.nodes.detector_node import run_detector


def main() -> None:
    """Run the node."""
    run_detector("correlation_detector")


if __name__ == "__main__":
    main()
