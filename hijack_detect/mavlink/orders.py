# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What an autopilot is told to do on an alert: the command for its kind."""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType

COPTERS = (
    "QUADROTOR", "COAXIAL", "HELICOPTER", "HEXAROTOR", "OCTOROTOR", "TRICOPTER", "DODECAROTOR",
    "DECAROTOR",
)  # fmt: skip
PX4_AUTO, PX4_AUTO_LOITER = 4, 3
"""Custom main mode and sub mode of PX4 (px4_custom_mode.h)."""
COPTER_ALT_HOLD, PLANE_CIRCLE, ROVER_HOLD = 2, 1, 4
"""Custom modes of ArduPilot that use no GPS."""
FOLLOWS = "follows a false GPS"


@dataclass(frozen=True)
class Order:
    """A COMMAND_LONG.

    Attributes:
        what: For people.
        command: Its number.
        params: Parameters 1 to 7.
        danger: What a false GPS does to it; empty for nothing.
    """

    what: str
    command: int
    params: tuple[float, ...]
    danger: str = ""


@dataclass(frozen=True)
class Kind:
    """Autopilot and vehicle of a HEARTBEAT."""

    autopilot: int
    vehicle: int


def order(name: str, kind: Kind, mavlink: ModuleType) -> Order:
    """The order for a value of the parameter `command`.

    Raises:
        ValueError: This kind of vehicle has none; the text says what to do.
    """
    if name == "user_1":
        return Order("MAV_CMD_USER_1, parameter 1 = 1", mavlink.MAV_CMD_USER_1, _params(1.0))
    if name == "rtl":
        return Order("return to launch", mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH, _params(), FOLLOWS)
    if name == "land":
        if kind.autopilot == mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA and not _copter(kind, mavlink):
            raise ValueError("ArduPilot lands only copters on this command: choose hold or rtl")
        danger = f"{FOLLOWS} sideways while it descends"
        return Order("land", mavlink.MAV_CMD_NAV_LAND, _params(), danger)
    return _hold(kind, mavlink)


def _hold(kind: Kind, mavlink: ModuleType) -> Order:
    """Stay without the GPS where the autopilot can do that without a pilot."""
    if kind.autopilot == mavlink.MAV_AUTOPILOT_PX4:
        return _mode("Hold", mavlink, PX4_AUTO, PX4_AUTO_LOITER, danger=FOLLOWS)
    if kind.autopilot == mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA:
        if _copter(kind, mavlink):
            return _mode("ALT_HOLD", mavlink, COPTER_ALT_HOLD)
        if kind.vehicle == mavlink.MAV_TYPE_FIXED_WING:
            return _mode("CIRCLE", mavlink, PLANE_CIRCLE)
        if kind.vehicle in (mavlink.MAV_TYPE_GROUND_ROVER, mavlink.MAV_TYPE_SURFACE_BOAT):
            return _mode("HOLD", mavlink, ROVER_HOLD)
    raise ValueError(
        f"there is no hold for vehicle type {kind.vehicle} of autopilot {kind.autopilot}: choose "
        "rtl, land or user_1"
    )


def _mode(name: str, mavlink: ModuleType, main: int, sub: int = 0, *, danger: str = "") -> Order:
    params = _params(float(mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED), float(main), float(sub))
    return Order(f"mode {name}", mavlink.MAV_CMD_DO_SET_MODE, params, danger)


def _copter(kind: Kind, mavlink: ModuleType) -> bool:
    return kind.vehicle in {getattr(mavlink, f"MAV_TYPE_{name}") for name in COPTERS}


def _params(*first: float) -> tuple[float, ...]:
    return (*first, *[0.0] * (7 - len(first)))
