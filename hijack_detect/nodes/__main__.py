# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Runs a node as its executable does: `python -m hijack_detect.nodes NODE`."""

from __future__ import annotations

import importlib
import sys

from hijack_detect.nodes import NODES, entry_point


def main() -> None:
    """Run the node that the first argument names."""
    if sys.argv[1:2] == [] or sys.argv[1] not in NODES:
        sys.exit(f"usage: python -m {__package__} NODE [ARGUMENTS]\nNODE: {', '.join(NODES)}")
    del sys.argv[0]
    module, _, function = entry_point(sys.argv[0]).partition(":")
    getattr(importlib.import_module(module), function)()


if __name__ == "__main__":
    main()
