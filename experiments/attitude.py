# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Attitude of the estimator against a flight's reference attitude: a table.

    python -m experiments.attitude FOLDER [--match curved] [--no-mag] [--method quaternion]

From 20 s after take-off (label.json) or, without a label, 20 s after the first orientation.
The reference is /truth/attitude, or /autopilot/attitude where there is no truth. Degrees.
"""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Iterator
from multiprocessing import Pool
from pathlib import Path

import click
import numpy as np

from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.samples import Rejected, read_samples
from hijack_detect.estimation.attitude import AttitudeEstimator
from hijack_detect.estimation.attitude_parameters import AttitudeParameters
from hijack_detect.estimation.rotation import Array, roll_pitch_yaw
from hijack_detect.monitor.graph import Stage
from hijack_detect.streams.samples import NANOSECONDS

REFERENCES = ("/truth/attitude", "/autopilot/attitude")
SETTLE_S = 20.0
"""Errors count from here on. Chosen, not swept."""


def estimated(reader: BagReader, parameters: AttitudeParameters) -> Iterator[tuple[float, ...]]:
    """Second, roll, pitch, yaw (rad) of every published orientation."""
    stage = Stage(lambda: AttitudeEstimator(parameters))
    topics = reader.inputs()
    for name, sample in read_samples(reader, topics, on_rejected=Rejected().add):
        if name in stage.component.inputs:
            for output in stage.push(name, sample):
                if output.orientation is not None:
                    t = (output.stamp_ns - reader.start_ns) / NANOSECONDS
                    yield (t, *roll_pitch_yaw(output.orientation))


def reference(reader: BagReader) -> tuple[str, Array]:
    """Topic, and second, roll, pitch, yaw (rad) of the reference, shape (n, 4)."""
    topic = next(topic for topic in REFERENCES if topic in reader.topics)
    rows = []
    for raw in reader.messages([topic]):
        message = reader.deserialize(raw)
        q, stamp = message.quaternion, message.header.stamp
        t = stamp.sec + stamp.nanosec / NANOSECONDS - reader.start_ns / NANOSECONDS
        rows.append((t, *roll_pitch_yaw((q.x, q.y, q.z, q.w))))
    return topic, np.array(rows)


def errors_rad(ours: Array, theirs: Array) -> list[Array]:
    """Errors of roll, pitch and yaw at the seconds of the reference, each of shape (n,)."""
    return [
        np.remainder(
            np.interp(theirs[:, 0], ours[:, 0], np.unwrap(ours[:, k])) - theirs[:, k] + math.pi,
            math.tau,
        )
        - math.pi
        for k in (1, 2, 3)
    ]


def rms_deg(error: Array) -> float:
    """Root mean square of an error in rad, degrees."""
    return math.degrees(math.sqrt(float(np.mean(np.square(error)))))


def row(job: tuple[Path, AttitudeParameters]) -> str:
    """One flight's line of the table."""
    path, parameters = job
    with BagReader(path) as reader:
        ours = np.array(list(estimated(reader, parameters)))
        if len(ours) == 0:
            return f"| {path.name} | no orientation | | | | | |"
        topic, theirs = reference(reader)
    label = path / "label.json"
    start = json.loads(label.read_text())["t_takeoff"] if label.exists() else float(ours[0, 0])
    inside = (theirs[:, 0] >= max(start + SETTLE_S, ours[0, 0])) & (theirs[:, 0] <= ours[-1, 0])
    theirs = theirs[inside]
    errors = errors_rad(ours, theirs)
    rms = [rms_deg(error) for error in errors]
    yaw = np.degrees(np.abs(errors[2]))
    return (
        f"| {path.name} | {topic.split('/')[1]} | {ours[0, 0]:.1f} | "
        + " | ".join(f"{value:.2f}" for value in rms)
        + f" | {np.median(yaw):.1f} | {np.max(yaw):.1f} |"
    )


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--match", default="", help="Only flights whose name contains this.")
@click.option("--mag/--no-mag", default=True, help="Use the magnetometer where there is one.")
@click.option("--method", type=click.Choice(["ekf", "quaternion"]), default="ekf")
def main(folder: Path, match: str, mag: bool, method: str) -> None:
    """Print the table."""
    parameters = dataclasses.replace(AttitudeParameters(), use_mag=mag, method=method)
    paths = sorted(p for p in folder.iterdir() if p.is_dir() and match in p.name)
    print("| flight | reference | from s | roll RMS | pitch RMS | yaw RMS | yaw median | yaw max |")
    print("|---|---|---|---|---|---|---|---|")
    with Pool() as pool:
        for line in pool.imap(row, [(path, parameters) for path in paths]):
            print(line, flush=True)


if __name__ == "__main__":
    main()
