# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Simulated flights, closed loop: the vehicle goes where its autopilot, deceived or not, flies it.

See docs/simulator.md for what is modelled, with which constants, and what is left out.
"""
