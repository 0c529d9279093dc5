# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameters of the MAVLink bridge."""

from __future__ import annotations

from dataclasses import dataclass

from hijack_detect.parameters import Parameters, param


@dataclass(frozen=True)
class BridgeParameters(Parameters):
    """Where the autopilot is, which rates it is asked for, and its command on an alert."""

    connection: str = param(
        "udpin:127.0.0.1:14550",
        "Where the autopilot is. udpin:HOST:PORT (or udp:) waits for datagrams there, and 0.0.0.0 "
        "lets every host of the network send some; udpout:HOST:PORT sends first; tcp:HOST:PORT "
        "connects; serial:/dev/ttyACM0:921600 (or only the device) opens a port.",
        source="the usual MAVLink port of a ground station (14550), on this machine only",
        basic=True,
    )
    baud: int = param(
        921600,
        "Rate of a serial port, unless `connection` has it.",
        source=(
            "docs/mavlink.md: the rate set on the autopilot there; 100 Hz of HIGHRES_IMU need 8 "
            "kB/s, more than 57600 Bd have"
        ),
        basic=True,
        unit="Bd",
        low=1200,
        high=20_000_000,
    )
    own_system: int = param(
        0,
        "System id of this node. 0: that of the autopilot, as for every part of one vehicle.",
        source="MAVLink: the components of a vehicle share its system id",
        low=0,
        high=255,
    )
    own_component: int = param(
        191,
        "Component id of this node.",
        source="MAVLink: MAV_COMP_ID_ONBOARD_COMPUTER",
        low=1,
        high=255,
    )
    target_system: int = param(
        0,
        "System id of the autopilot. 0: the first with a heartbeat and an IMU. Only its "
        "messages are used, and only it gets commands.",
        source="chosen: works with one autopilot on the link, whatever its id",
        low=0,
        high=255,
    )
    imu_rate_hz: float = param(
        100.0,
        "Requested rate of HIGHRES_IMU, else SCALED_IMU, else RAW_IMU. 0 requests nothing. An "
        "Imu below 50 Hz is too slow for some detectors.",
        source=(
            "docs/mavlink.md: 100 Hz need 8 kB/s of the link, 200 Hz 16 kB/s; twice the 50 Hz that "
            "some detectors need"
        ),
        unit="Hz",
        low=0.0,
        high=1000.0,
    )
    gps_rate_hz: float = param(
        10.0,
        "Requested rate of GPS_RAW_INT and of SCALED_PRESSURE. 0 requests nothing. A fix that "
        "comes twice is published once, so a rate above that of the receiver does no harm.",
        source="chosen: the rate of a fast receiver; most have 5 Hz",
        unit="Hz",
        low=0.0,
        high=50.0,
    )
    command: str = param(
        "none",
        "Command to the autopilot on an alert, once for each. docs/mavlink.md describes what it "
        "does then, and how far a false GPS can lead it on the way. user_1 is MAV_CMD_USER_1 "
        "with parameter 1 = 1, for scripts on the autopilot.",
        source="chosen: none; this package informs, the mission manager acts",
        basic=True,
        choices=("none", "land", "rtl", "hold", "user_1"),
    )
    dry_run: bool = param(
        False,
        "Only log the command, do not send it.",
        source="chosen: off; `command` is none already",
    )
    command_attempts: int = param(
        5,
        "Number of times that a command is sent until it is acknowledged, at most.",
        source=(
            "chosen, not swept; tried with a link that loses 20 % of its packets (docs/mavlink.md)"
        ),
        low=1,
        high=50,
    )
    ack_timeout_s: float = param(
        1.0,
        "Timeout of an acknowledgement; the command is then sent again.",
        source="chosen, not swept; above the round trip of a radio",
        unit="s",
        low=0.05,
        high=10.0,
    )
    text_period_s: float = param(
        10.0,
        "Period at which the text of an alert is repeated to the ground station while the alert "
        "lasts.",
        source=(
            "chosen, not swept; often enough to be seen, seldom enough to leave room for other "
            "texts"
        ),
        unit="s",
        low=1.0,
        high=3600.0,
    )
    signing_key_file: str = param(
        "",
        "File with the key of MAVLink 2 signing: 32 bytes, or 64 hexadecimal digits. Messages "
        "are then signed, and those not signed with it are rejected. Empty: no signing, and "
        "everybody who reaches the link is trusted.",
        source="chosen: none; a key has to be on the autopilot too",
    )
    speed: float = param(
        1.0,
        "Seconds of the autopilot in a second of this machine. 1 for every vehicle; a simulator "
        "that runs faster by a constant factor (--speedup, PX4_SIM_SPEED_FACTOR) needs that.",
        source="physics: two crystals differ by about 1e-4",
        low=0.1,
        high=100.0,
    )
