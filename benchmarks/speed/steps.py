"""What one step of each estimator and detector costs, and that a longer window does not cost more.

    python benchmarks/speed/steps.py build/bench

A simulated flight goes through the monitor once, and what each part hears is kept. Then each part
hears that again alone, every call by the clock. A fix here is all that comes with it: its
position and velocity, a magnetic reading, and the work that IMU samples have left for it. The
filter is compared with those of `ahrs`, `vqf` and FilterPy, which are measured where they are
installed.
"""

from __future__ import annotations

import gc
import json
import statistics
import time
from collections import defaultdict
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
from bench import machine
from load import load_bag
from rich.console import Console
from rich.table import Table

from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.samples import Rejected, read_samples
from hijack_detect.detectors.correlation import CorrelationDetector
from hijack_detect.detectors.date import DateDetector
from hijack_detect.evaluation.monitor.graph import Monitor
from hijack_detect.evaluation.monitor.policies import policy_parameters
from hijack_detect.evaluation.monitor.stage import Component

SECONDS, IMU_HZ, GPS_HZ = 150.0, 250, 10
REPEATS = 3
FAST = ("imu", "attitude")
"""Inputs that come with every IMU sample."""
Heard = list[tuple[str, Any]]


def heard_by_each(folder: Path) -> dict[str, Heard]:
    """What each part of the monitor hears on a flight, in order."""
    monitor = Monitor(policy_parameters("default"))
    heard: dict[str, Heard] = {name: [] for name in monitor.stages}

    def listening(name: str, update: Callable[[str, Any], Any]) -> Callable[[str, Any], Any]:
        def listen(source: str, sample: Any) -> Any:
            heard[name].append((source, sample))
            return update(source, sample)

        return listen

    for name, stage in monitor.stages.items():
        stage.component.update = listening(name, stage.component.update)  # type: ignore[method-assign]
    with BagReader(load_bag(folder, SECONDS, IMU_HZ, GPS_HZ)) as reader:
        for name, sample in read_samples(reader, reader.inputs(), on_rejected=Rejected().add):
            monitor.push(name, [sample])
    return heard


def timed(make: Callable[[], Component], heard: Heard) -> tuple[float, float]:
    """Mean microseconds of an IMU sample, and of all that comes with a fix; medians of runs."""
    runs = []
    for _ in range(REPEATS):
        component = make()
        spent: dict[bool, float] = defaultdict(float)
        gc.disable()
        for name, sample in heard:
            begin = time.perf_counter()
            component.update(name, sample)
            spent[name in FAST] += time.perf_counter() - begin
        gc.enable()
        fast = max(1, sum(name in FAST for name, _ in heard)) / len(
            {name for name, _ in heard if name in FAST} or {""}
        )
        runs.append((spent[True] / fast * 1e6, spent[False] / (SECONDS * GPS_HZ) * 1e6))
    return tuple(map(statistics.median, zip(*runs, strict=True)))  # type: ignore[return-value]


def steps(heard: dict[str, Heard]) -> dict[str, dict[str, float]]:
    """Cost of each part."""

    def fresh(name: str) -> Callable[[], Component]:
        return lambda: Monitor(policy_parameters("default")).stages[name].component

    found = {}
    for name, samples in heard.items():
        imu_us, fix_us = timed(fresh(name), samples)
        found[name] = {"imu_us": imu_us, "fix_us": fix_us}
    return found


def windows(heard: dict[str, Heard]) -> dict[str, float]:
    """Cost of a flight with windows of 25,000 samples, over that with 500."""

    def total(make: Callable[[], Component], name: str) -> float:
        imu_us, fix_us = timed(make, heard[name])
        return imu_us * IMU_HZ + fix_us * GPS_HZ

    p, d = policy_parameters("default").correlation, policy_parameters("default").date
    makers: dict[str, Callable[[float], Callable[[], Component]]] = {
        "correlation": lambda s: lambda: CorrelationDetector(replace(p, window_s=s)),
        "date": lambda s: lambda: DateDetector(replace(d, window_s=s)),
    }
    longest = {"correlation": 100.0, "date": 60.0}
    return {
        name: total(make(longest[name]), name) / total(make(2.0), name)
        for name, make in makers.items()
    }


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
def main(folder: Path) -> None:
    """Measure with bags in FOLDER, and write FOLDER/steps.json."""
    folder.mkdir(parents=True, exist_ok=True)
    heard = heard_by_each(folder)
    found: dict[str, Any] = {
        "machine": machine(),
        "steps": steps(heard),
        "windows": windows(heard),
    }
    (folder / "steps.json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    table = Table("", "µs an IMU sample", "µs a fix")
    for name, one in found["steps"].items():
        table.add_row(name, f"{one['imu_us']:.1f}", f"{one['fix_us']:.0f}")
    Console().print(table)
    for name, ratio in found["windows"].items():
        click.echo(f"{name}: a window of 25,000 samples costs {ratio:.2f} of one with 500")


if __name__ == "__main__":
    main()
