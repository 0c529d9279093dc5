# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Cost of one step of each estimator and detector, and that a longer window does not cost more.

A simulated flight goes through the monitor once, and the inputs of each part are kept. Then each
part gets them again alone, every call timed. A fix here is all that comes with it: its position
and velocity, a magnetic reading, and the work that IMU samples have left for it.
"""

from __future__ import annotations

import gc
import itertools
import statistics
import time
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

from load import load_bag
from rich.console import Console
from rich.progress import track
from rich.table import Table
from rosbags.highlevel import AnyReader
from section import Section

from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.samples import Rejected, read_samples
from hijack_detect.detectors.correlation import CorrelationDetector, CorrelationParameters
from hijack_detect.detectors.date import DateDetector, DateParameters
from hijack_detect.monitor.graph import Component, Monitor
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.streams.samples import NANOSECONDS

SECONDS, IMU_HZ, GPS_HZ = 150.0, 250, 10
MESSAGES = 10_000
SHORTEST_S, LONGEST_S = 2.0, 40.0
"""Windows of 500 and of 10,000 samples."""
FULL_S = 100.0
"""Both are full by then: heading and manoeuvres come first."""
FAST = ("imu", "attitude")
"""Inputs that come with every IMU sample."""
Inputs = list[tuple[str, Any]]


def inputs_of_each(folder: Path) -> dict[str, Inputs]:
    """Inputs of each part of the monitor on a flight, in order."""
    monitor = Monitor(policy_parameters("default"))
    inputs: dict[str, Inputs] = {name: [] for name in monitor.stages}

    def listening(name: str, update: Callable[[str, Any], Any]) -> Callable[[str, Any], Any]:
        def listen(source: str, sample: Any) -> Any:
            inputs[name].append((source, sample))
            return update(source, sample)

        return listen

    for name, stage in monitor.stages.items():
        stage.component.update = listening(name, stage.component.update)  # type: ignore[method-assign]
    with BagReader(load_bag(folder, SECONDS, IMU_HZ, GPS_HZ)) as reader:
        for name, sample in read_samples(reader, reader.inputs(), on_rejected=Rejected().add):
            monitor.push(name, [sample])
    return inputs


def timed(
    make: Callable[[], Component], inputs: Inputs, repeats: int, settle_s: float = 0.0
) -> tuple[float, float]:
    """Mean microseconds of an IMU sample, and of all that comes with a fix; medians of runs.

    Only what comes `settle_s` after the first sample is by the clock.
    """
    begin_ns = inputs[0][1].stamp_ns + round(settle_s * NANOSECONDS)
    first = next(k for k, (_, sample) in enumerate(inputs) if sample.stamp_ns >= begin_ns)
    names = [name for name, _ in inputs[first:]]
    fast = sum(name in FAST for name in names) / len({*names} & {*FAST} or {""})
    fixes = (inputs[-1][1].stamp_ns - begin_ns) / NANOSECONDS * GPS_HZ
    runs = []
    for _ in range(repeats):
        component = make()
        for name, sample in inputs[:first]:
            component.update(name, sample)
        spent: dict[bool, float] = defaultdict(float)
        gc.disable()
        for name, sample in inputs[first:]:
            begin = time.perf_counter()
            component.update(name, sample)
            spent[name in FAST] += time.perf_counter() - begin
        gc.enable()
        runs.append((spent[True] / max(fast, 1.0) * 1e6, spent[False] / fixes * 1e6))
    return tuple(map(statistics.median, zip(*runs, strict=True)))  # type: ignore[return-value]


def message_us(bag: Path, repeats: int) -> float:
    """Microseconds that rosbags needs to deserialise an Imu, the unit of the ratios."""
    with AnyReader([bag]) as reader:
        imu = [one for one in reader.connections if one.msgtype == "sensor_msgs/msg/Imu"]
        raws = [raw for _, _, raw in itertools.islice(reader.messages(imu), MESSAGES)]
        runs = []
        for _ in range(repeats):
            begin = time.perf_counter()
            for raw in raws:
                reader.deserialize(raw, imu[0].msgtype)
            runs.append((time.perf_counter() - begin) / len(raws) * 1e6)
    return statistics.median(runs)


def parts(inputs: dict[str, Inputs], repeats: int) -> dict[str, dict[str, float]]:
    """Cost of each part."""

    def fresh(name: str) -> Callable[[], Component]:
        return lambda: Monitor(policy_parameters("default")).stages[name].component

    found = {}
    for name, samples in track(inputs.items(), f"{'steps':24}", console=Console(stderr=True)):
        imu_us, fix_us = timed(fresh(name), samples, repeats)
        found[name] = {"imu_us": imu_us, "fix_us": fix_us}
    return found


def windows(inputs: dict[str, Inputs], repeats: int) -> dict[str, float]:
    """Cost with windows of LONGEST_S, over that with SHORTEST_S, once both are full."""

    def cost(make: Callable[[], Component], name: str) -> float:
        imu_us, fix_us = timed(make, inputs[name], repeats, FULL_S)
        return imu_us * IMU_HZ + fix_us * GPS_HZ

    makers: dict[str, Callable[[float], Callable[[], Component]]] = {
        "correlation": lambda s: lambda: CorrelationDetector(CorrelationParameters(window_s=s)),
        "date": lambda s: lambda: DateDetector(DateParameters(window_s=s)),
    }
    return {
        name: cost(make(LONGEST_S), name) / cost(make(SHORTEST_S), name)
        for name, make in makers.items()
    }


def measure(folder: Path, repeats: int) -> Section:
    """Cost of each part in messages that could be deserialised meanwhile."""
    unit_us = message_us(load_bag(folder, SECONDS, IMU_HZ, GPS_HZ), repeats)
    inputs = inputs_of_each(folder)
    found, longer = parts(inputs, repeats), windows(inputs, repeats)
    table = Table("steps", "µs an IMU sample", "µs a fix")
    for name, one in found.items():
        table.add_row(name, f"{one['imu_us']:.1f}", f"{one['fix_us']:.0f}")
    ratios = {
        f"{name}, {kind}": one[f"{kind}_us"] / unit_us
        for name, one in found.items()
        for kind in ("imu", "fix")
        if one[f"{kind}_us"] > 0.0
    }
    remarks = [
        f"{name}: windows of {LONGEST_S:g} s cost {ratio:.2f} of those of {SHORTEST_S:g} s"
        for name, ratio in longer.items()
    ]
    figures = {"message_us": unit_us, "parts": found, "windows": longer}
    return Section(ratios, figures, table, tuple(remarks))
