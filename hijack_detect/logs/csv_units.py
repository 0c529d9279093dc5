# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Units and times as people write them into tables, to SI and nanoseconds."""

from __future__ import annotations

import math
import re
from datetime import datetime, timezone
from decimal import Decimal, InvalidOperation

from hijack_detect.logs.frames import GAUSS_T, HECTOPASCAL_PA, MILLI, MILLIGAUSS_T, MILLIGRAVITY
from hijack_detect.streams.samples import NANOSECONDS

KNOT = 1852.0 / 3600.0
PLACE = {"deg": 1.0, "1e-7 deg": 1e-7, "rad": math.degrees(1.0)}
"""Latitude and longitude, to degrees."""
ANGLE = {"rad": 1.0, "deg": math.radians(1.0)}
RATE = {"rad/s": 1.0, "mrad/s": MILLI, "deg/s": math.radians(1.0)}
FORCE = {"m/s2": 1.0, "g": MILLIGRAVITY / MILLI, "mg": MILLIGRAVITY}
FIELD = {"T": 1.0, "uT": 1e-6, "nT": 1e-9, "gauss": GAUSS_T, "mgauss": MILLIGAUSS_T}
PRESSURE = {"Pa": 1.0, "hPa": HECTOPASCAL_PA, "mbar": HECTOPASCAL_PA, "kPa": 1e3}
LENGTH = {"m": 1.0, "cm": 1e-2, "mm": MILLI, "ft": 0.3048}
SPEED = {"m/s": 1.0, "cm/s": 1e-2, "mm/s": MILLI, "km/h": 1.0 / 3.6, "knots": KNOT}
TIME = {"s": 9, "ms": 6, "us": 3, "ns": 0}
"""Nanoseconds as a power of ten."""
ISO = "iso"
LAST_NS = 2**31 * NANOSECONDS
"""No stamp of ROS is as late."""
_FRACTION = re.compile(r"(.*:\d\d)[.,](\d{1,9})\d*(.*)")


def nanoseconds(text: str, unit: str) -> int:
    """A time in a unit of TIME, or of ISO 8601 since 1970, exact to the nanosecond.

    An ISO time without a zone is UTC.

    Raises:
        ValueError: It is no time, before 0, or later than a stamp can be.
    """
    stamp_ns = _from_iso(text) if unit == ISO else _from_number(text, TIME[unit])
    if not 0 <= stamp_ns < LAST_NS:
        raise ValueError("is no time that a stamp can have: is its unit right?")
    return stamp_ns


def _from_number(text: str, power: int) -> int:
    try:
        number = Decimal(text.strip())
        return round(number.scaleb(power)) if abs(number) < LAST_NS else -1
    except (InvalidOperation, ValueError, OverflowError) as error:
        raise ValueError("is no number") from error


def _from_iso(text: str) -> int:
    text = text.strip()
    if text.endswith(("Z", "z")):
        text = f"{text[:-1]}+00:00"
    fraction_ns = 0
    if found := _FRACTION.fullmatch(text):
        text, fraction_ns = found[1] + found[3], int(found[2].ljust(9, "0"))
    try:
        read = datetime.fromisoformat(text)
        zoned = read if read.tzinfo else read.replace(tzinfo=timezone.utc)
        passed = zoned - datetime(1970, 1, 1, tzinfo=timezone.utc)
    except (ValueError, OverflowError) as error:
        raise ValueError("is no time in ISO 8601, such as 2026-05-01T12:00:00.5Z") from error
    whole = passed.days * 86_400 + passed.seconds
    return whole * NANOSECONDS + passed.microseconds * 1000 + fraction_ns
