# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Height from static pressure by the standard atmosphere (ICAO Doc 7488, troposphere)."""

from __future__ import annotations

SEA_LEVEL_PA = 101_325.0
"""International Standard Atmosphere, ISO 2533."""
SCALE_M = 44_330.77
"""Standard temperature at sea level over its lapse rate: 288.15 K / 6.5 K/km."""
EXPONENT = 0.190263
"""Gas constant of air × lapse rate / gravity."""


def pressure_height(pressure_pa: float) -> float:
    """Height in the standard atmosphere, metres.

    Differences of it are differences of height but for the weather: at a temperature of 20 K off
    the standard they are 7 % off.

    Args:
        pressure_pa: Static pressure, pascal, above zero.
    """
    return float(SCALE_M * (1.0 - (pressure_pa / SEA_LEVEL_PA) ** EXPONENT))
