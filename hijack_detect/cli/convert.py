# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `convert`: a bag of an autopilot's log."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hijack_detect.cli.common import PATH, refusing_bad_input

if TYPE_CHECKING:
    from hijack_detect.logs.csv_map import ColumnMap

IMU = click.option(
    "--imu", type=click.IntRange(0), default=0, help="Number of the IMU to take [0]."
)
GPS = click.option(
    "--gps", type=click.IntRange(0), default=0, help="Number of the GPS to take [0]."
)
NAMESPACE = click.option(
    "--namespace", default="", metavar="/NAME", help="Of a bag of several vehicles, this one."
)


def sensor_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options that choose the sensors of a log."""
    return IMU(GPS(NAMESPACE(command)))


COLUMNS = click.option(
    "--columns", type=PATH, metavar="MAP", help="What the columns of a CSV are (YAML)."
)


def read_columns(path: Path | None) -> ColumnMap | None:
    """Read a column map, if one is given.

    Raises:
        BagError: It cannot be used.
    """
    from hijack_detect.logs.csv_map import load_map  # noqa: PLC0415  slow to load

    return None if path is None else load_map(path)


@click.command()
@click.argument("log", type=PATH)
@click.argument("out", type=PATH, required=False)
@COLUMNS
@click.option("--template", is_flag=True, help="Print a column map for a CSV, to be filled in.")
@sensor_options
def convert(
    log: Path,
    out: Path | None,
    columns: Path | None,
    template: bool,
    imu: int,
    gps: int,
    namespace: str,
) -> None:
    """Write the bag OUT from the LOG of an autopilot, a ROS 1 bag, a bag in sqlite3, or a CSV.

    PX4 ULog, ArduPilot DataFlash, MAVLink telemetry, ROS 1 and rosbag2 are recognised by their
    content, and so is a folder of ulog2csv. Of any other CSV, or folder of CSVs, a map has to name
    what the columns are: --template prints one. Body vectors become FLU, world vectors ENU, stamps
    UTC where the log knows it. The autopilot's own attitude is kept as /autopilot/attitude, to
    compare with.
    """
    from hijack_detect.logs.csv_template import template as template_of  # noqa: PLC0415  slow
    from hijack_detect.logs.formats import convert as make  # noqa: PLC0415
    from hijack_detect.logs.logged import Selection  # noqa: PLC0415

    with refusing_bad_input():
        if template:
            click.echo(template_of(log), nl=False)
            return
        if out is None:
            raise click.UsageError("name OUT, the bag to write (or give --template)")
        done = make(log, out, Selection(imu, gps, namespace), read_columns(columns))
    for line in done.notes.lines():
        click.echo(line, err=True)
    counts = ", ".join(f"{topic} {count}" for topic, count in sorted(done.messages.items()))
    click.echo(f"{out}: from {done.format}: {counts}")
