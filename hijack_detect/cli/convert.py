# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `convert`: a bag of an autopilot's log."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import click

from hijack_detect.cli.common import PATH, refusing_bad_input

IMU = click.option(
    "--imu", type=click.IntRange(0), default=0, help="Number of the IMU to take [0]."
)
GPS = click.option(
    "--gps", type=click.IntRange(0), default=0, help="Number of the GPS to take [0]."
)


def sensor_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options that say which sensors of a log to take."""
    return IMU(GPS(command))


@click.command()
@click.argument("log", type=PATH)
@click.argument("out", type=PATH)
@sensor_options
def convert(log: Path, out: Path, imu: int, gps: int) -> None:
    """Write the bag OUT from the LOG of an autopilot, a ROS 1 bag, or a bag in sqlite3.

    PX4 ULog, ArduPilot DataFlash, MAVLink telemetry, ROS 1 and rosbag2 sqlite3 are told by their
    content. Body vectors become FLU, world vectors ENU, stamps UTC where the log knows it. The
    autopilot's own attitude is kept as /autopilot/attitude, to compare with.
    """
    from hijack_detect.logs.formats import convert as make  # noqa: PLC0415  slow to load
    from hijack_detect.logs.logged import Wanted  # noqa: PLC0415

    with refusing_bad_input():
        done = make(log, out, Wanted(imu, gps))
    for line in done.notes.lines():
        click.echo(line, err=True)
    counts = ", ".join(f"{topic} {count}" for topic, count in sorted(done.messages.items()))
    click.echo(f"{out}: from {done.format}: {counts}")
