# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The attitude estimator beside the filters of `ahrs` and `vqf`, and its EKF beside FilterPy's.

    pip install ahrs vqf filterpy
    python -m experiments.attitude_peers ../shared/flights/sitl --match curved

Errors are root mean squares against /truth/attitude from 20 s after take-off, degrees. The peers
have no GPS: they take the accelerometer for the vertical, which an accelerating vehicle tilts. A
constant offset is taken from their yaw, so that declination and mounting do not count against
them. Costs are microseconds of an IMU sample, all that belongs to it included.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import click
import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

from experiments.attitude import SETTLE_S, errors_rad, reference, rms_deg
from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.samples import Rejected, read_samples
from hijack_detect.estimation.attitude import AttitudeEstimator
from hijack_detect.estimation.attitude_parameters import AttitudeParameters
from hijack_detect.estimation.ekf import Ekf, ImuBlock, ProcessNoise, Source
from hijack_detect.estimation.rotation import Array, roll_pitch_yaw
from hijack_detect.replay.truth import read_label
from hijack_detect.streams.samples import NANOSECONDS, ImuSample, MagneticSample

INPUTS = ("imu", "fix", "velocity", "mag")
Inputs = list[tuple[str, Any]]
Track = list[tuple[float, float, float, float]]
"""Second, roll, pitch and yaw, rad."""


def ours(inputs: Inputs) -> Track:
    """The estimator of this project."""
    estimator = AttitudeEstimator(AttitudeParameters())
    found = []
    for name, sample in inputs:
        output = estimator.update(name, sample)
        if output is not None and output.orientation is not None:
            found.append((sample.stamp_ns / NANOSECONDS, *roll_pitch_yaw(output.orientation)))
    return found


def of_vqf(inputs: Inputs) -> Track:
    """VQF (Laidig and Seel 2023), with the magnetometer."""
    from vqf import VQF  # noqa: PLC0415  a peer, which need not be installed

    rates = {name: _interval_s(inputs, name) for name in ("imu", "mag")}
    peer = VQF(rates["imu"], rates["imu"], rates["mag"])
    found = []
    for sample in _readings(inputs):
        if isinstance(sample, MagneticSample):
            peer.updateMag(np.array(sample.field))
            continue
        peer.updateGyr(np.array(sample.angular_velocity))
        peer.updateAcc(np.array(sample.specific_force))
        w, x, y, z = peer.getQuat9D().tolist()
        found.append((sample.stamp_ns / NANOSECONDS, *roll_pitch_yaw((x, y, z, w))))
    return found


def of_madgwick(inputs: Inputs) -> Track:
    """Madgwick's filter in `ahrs`, with the newest magnetic reading."""
    from ahrs.filters import Madgwick  # noqa: PLC0415  a peer, which need not be installed

    dt = _interval_s(inputs, "imu")
    peer, q, field = Madgwick(Dt=dt), np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3)
    found = []
    for sample in _readings(inputs):
        if isinstance(sample, MagneticSample):
            field = np.array(sample.field) * 1e9
            continue
        q = peer.updateMARG(
            q, np.array(sample.angular_velocity), np.array(sample.specific_force), field
        )
        w, x, y, z = q.tolist()
        found.append((sample.stamp_ns / NANOSECONDS, *roll_pitch_yaw((x, y, z, w))))
    return found


METHODS: dict[str, Callable[[Inputs], Track]] = {
    "hijack_detect": ours,
    "vqf": of_vqf,
    "ahrs Madgwick": of_madgwick,
}


def _readings(inputs: Inputs) -> Iterator[ImuSample | MagneticSample]:
    return (one for name, one in inputs if name in ("imu", "mag"))


def _interval_s(inputs: Inputs, name: str) -> float:
    stamps = [one.stamp_ns for source, one in inputs if source == name]
    return float(np.median(np.diff(stamps))) / NANOSECONDS


def rms_of(found: Track, truth: Array, from_s: float, *, aligned: bool) -> list[float]:
    """Root mean square of roll, pitch and yaw, degrees; `aligned` takes the mean off the yaw's."""
    angles = np.array(found)
    inside = (truth[:, 0] >= max(from_s, angles[0, 0])) & (truth[:, 0] <= angles[-1, 0])
    roll, pitch, yaw = errors_rad(angles, truth[inside])
    if aligned:
        yaw = np.angle(np.exp(1j * yaw) / np.mean(np.exp(1j * yaw)))
    return [rms_deg(error) for error in (roll, pitch, yaw)]


def inputs_of(path: Path) -> tuple[Inputs, Array, float]:
    """Samples, truth, and when the comparison begins, of a flight."""
    with BagReader(path) as reader:
        read = read_samples(reader, reader.inputs(), on_rejected=Rejected().add)
        inputs = sorted((one for one in read if one[0] in INPUTS), key=lambda one: one[1].stamp_ns)
        label = read_label(path)
        takeoff_s = 0.0 if label is None else float(label["t_takeoff"])
        _, truth = reference(reader)
        start_s = reader.start_ns / NANOSECONDS
        truth[:, 0] += start_s
        return inputs, truth, start_s + takeoff_s + SETTLE_S


def ekf_cost() -> dict[str, float]:
    """Microseconds of a prediction and a position update of 15 states, ours and FilterPy's."""
    from filterpy.kalman import ExtendedKalmanFilter  # noqa: PLC0415  a peer

    noise = ProcessNoise(0.1, 0.01, 0.01, 0.001)
    own = Ekf((0.0, 0.0, 0.0, 1.0), np.ones(15), noise)
    peer = ExtendedKalmanFilter(dim_x=15, dim_z=3)
    block = ImuBlock(np.array([0.1]), np.zeros((1, 3)), np.array([[0.0, 0.0, 9.8]]))
    h = np.eye(15)[:3]
    peer.H, peer.R = h, np.eye(3)

    def own_step() -> None:
        own.propagate(block)
        own.update(own.gps(Source.POSITION, np.zeros(3), np.ones(3)))

    def peer_step() -> None:
        peer.F = own.transition
        peer.predict()
        peer.update(np.zeros(3), lambda _: h, lambda x: h @ x)

    found = {}
    for name, step in (("hijack_detect", own_step), ("FilterPy", peer_step)):
        times = []
        for _ in range(5):
            begin = time.perf_counter()
            for _ in range(2000):
                step()
            times.append((time.perf_counter() - begin) / 2000 * 1e6)
        found[name] = float(np.median(times))
    return found


@click.command()
@click.argument("flights", type=click.Path(exists=True, path_type=Path))
@click.option("--match", default="", help="Only flights with this in their name.")
def main(flights: Path, match: str) -> None:
    """Compare on the flights of a folder."""
    rows: dict[str, list[list[float]]] = {name: [] for name in METHODS}
    paths = [path for path in sorted(flights.iterdir()) if match in path.name]
    for path in track(paths, "flights", console=Console(stderr=True)):
        inputs, truth, from_s = inputs_of(path)
        readings = sum(name == "imu" for name, _ in inputs)
        for name, method in METHODS.items():
            begin = time.perf_counter()
            found = method(inputs)
            cost_us = (time.perf_counter() - begin) / readings * 1e6
            aligned = method is not ours
            rows[name].append([*rms_of(found, truth, from_s, aligned=aligned), cost_us])
    table = Table("median over flights", "roll °", "pitch °", "yaw °", "µs a sample")
    for name, values in rows.items():
        table.add_row(name, *(f"{one:.2f}" for one in np.median(values, axis=0)))
    Console().print(table)
    costs = ekf_cost()
    click.echo(
        "15 states, one prediction and one position: "
        + ", ".join(f"{name} {cost:.0f} µs" for name, cost in costs.items())
    )


if __name__ == "__main__":
    main()
