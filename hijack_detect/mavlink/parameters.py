# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameters of the MAVLink bridge."""

from __future__ import annotations

from dataclasses import dataclass

from hijack_detect.parameters import Parameters, param


@dataclass(frozen=True)
class BridgeParameters(Parameters):
    """Where the autopilot is, what is asked of it, and what it is told on an alert."""

    connection: str = param(
        "udpin:127.0.0.1:14550",
        "Where the autopilot is. udpin:HOST:PORT (or udp:) waits for datagrams there, and 0.0.0.0 "
        "lets every host of the network send some; udpout:HOST:PORT sends first; tcp:HOST:PORT "
        "connects; serial:/dev/ttyACM0:921600 (or only the device) opens a port.",
    )
    baud: int = param(
        921600, "Rate of a serial port, unless `connection` has it.", unit="Bd", low=1200,
        high=20_000_000,
    )  # fmt: skip
    own_system: int = param(
        0,
        "System id of this node. 0: that of the autopilot, as for every part of one vehicle.",
        low=0,
        high=255,
    )
    own_component: int = param(
        191, "Component id of this node; 191 is an onboard computer.", low=1, high=255
    )
    target_system: int = param(
        0,
        "System id of the autopilot. 0: the first whose heartbeat and IMU are heard. Only its "
        "messages are used, and only it gets commands.",
        low=0,
        high=255,
    )
    imu_rate_hz: float = param(
        100.0,
        "Rate that is asked for of HIGHRES_IMU, else SCALED_IMU, else RAW_IMU. 0 asks for nothing. "
        "An Imu below 50 Hz is too slow for some detectors.",
        unit="Hz",
        low=0.0,
        high=1000.0,
    )
    gps_rate_hz: float = param(
        10.0,
        "Rate that is asked for of GPS_RAW_INT, and of SCALED_PRESSURE. 0 asks for nothing. A fix "
        "that comes twice is published once, so faster than the receiver does no harm.",
        unit="Hz",
        low=0.0,
        high=50.0,
    )
    command: str = param(
        "none",
        "What the autopilot is told to do on an alert, once for each. docs/mavlink.md says what it "
        "does then, and how far a false GPS can lead it on the way. user_1 is MAV_CMD_USER_1 with "
        "parameter 1 = 1, for scripts on the autopilot.",
        choices=("none", "land", "rtl", "hold", "user_1"),
    )
    dry_run: bool = param(False, "Only say in the log what would have been commanded.")
    command_attempts: int = param(
        5, "So often a command is sent at most, until it is acknowledged.", low=1, high=50
    )
    ack_timeout_s: float = param(
        1.0, "A command that is not acknowledged for so long is sent again.", unit="s", low=0.05,
        high=10.0,
    )  # fmt: skip
    text_period_s: float = param(
        10.0,
        "The text of an alert is repeated so often to the ground station while the alert lasts.",
        unit="s",
        low=1.0,
        high=3600.0,
    )
    signing_key_file: str = param(
        "",
        "File with the key of MAVLink 2 signing: 32 bytes, or 64 hexadecimal digits. What is sent "
        "is then signed, and what is not signed with it is refused. Empty: no signing, and whoever "
        "reaches the link is believed.",
    )
    speed: float = param(
        1.0,
        "Seconds of the autopilot in a second of this machine. 1 for every vehicle; a simulator "
        "that runs faster by a constant factor (--speedup, PX4_SIM_SPEED_FACTOR) needs that.",
        low=0.1,
        high=100.0,
    )
