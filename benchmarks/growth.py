# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Growth of time and memory of the offline path with a flight, and with the rate of its IMU.

    python benchmarks/growth.py build/bench docs/figures/speed_growth.png

An hour of 250 Hz is among the flights: it takes about a quarter of an hour in all.
"""

from __future__ import annotations

import json
from pathlib import Path

import click
import matplotlib as mpl
from load import load_bag
from matplotlib import pyplot as plt
from offline import IMU_HZ, medians

LENGTHS_S = (75.0, 150.0, 300.0, 600.0, 1200.0, 3600.0)
RATES_HZ = (50, 100, 250, 500, 1000)
RATES_S = 75.0
JOBS = ("detect", "report")
WORDS = {"detect": "analyze", "report": "analyze --report"}
Found = dict[str, dict[str, dict[str, float]]]
"""By length in s or rate in Hz, job, and figure."""


def lengths(folder: Path, repeats: int) -> Found:
    """Figures by length in seconds."""
    return {
        f"{seconds:g}": medians(
            JOBS, load_bag(folder, seconds, IMU_HZ), repeats, f"{seconds:g} s at {IMU_HZ} Hz"
        )
        for seconds in LENGTHS_S
    }


def rates(folder: Path, repeats: int) -> Found:
    """Figures by rate of the IMU in Hz."""
    return {
        f"{hz}": medians(
            JOBS[:1], load_bag(folder, RATES_S, hz), repeats, f"{RATES_S:g} s, {hz} Hz"
        )
        for hz in RATES_HZ
    }


def draw(by_length: Found, by_rate: Found, path: Path) -> None:
    """Time and memory over length, and time over the rate."""
    mpl.use("agg")
    figure, (time, memory, rate) = plt.subplots(1, 3, figsize=(10.5, 3.2), layout="constrained")
    minutes = [float(seconds) / 60.0 for seconds in by_length]
    for job in JOBS:
        found = [one[job] for one in by_length.values()]
        time.plot(minutes, [one["cpu_s"] for one in found], "o-", ms=4, label=WORDS[job])
        memory.plot(minutes, [one["peak_mb"] for one in found], "o-", ms=4, label=WORDS[job])
    costs = [one["detect"]["cpu_s"] for one in by_rate.values()]
    rate.plot([float(hz) for hz in by_rate], costs, "o-", ms=4)
    time.set(xlabel=f"flight (min at {IMU_HZ} Hz)", ylabel="processor time (s)")
    memory.set(xlabel=f"flight (min at {IMU_HZ} Hz)", ylabel="largest memory (MB)")
    rate.set(xlabel=f"IMU (Hz, {RATES_S:g} s of flight)", ylabel="processor time (s)")
    for axes in (time, memory, rate):
        axes.set(xlim=(0, None), ylim=(0, None))
        axes.grid(alpha=0.3)
    memory.legend(loc="lower right")
    figure.savefig(path, dpi=110)


PARTS = {"lengths_s": lengths, "rates_hz": rates}


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.argument("figure", type=click.Path(dir_okay=False, path_type=Path))
@click.option("--repeats", type=click.IntRange(1, 50), default=1, show_default=True)
@click.option("--only", type=click.Choice(list(PARTS)), help="Keep what was found of the other.")
def main(folder: Path, figure: Path, repeats: int, only: str | None) -> None:
    """Measure with bags in FOLDER, write FOLDER/growth.json, and draw FIGURE."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "growth.json"
    found: dict[str, Found] = json.loads(path.read_text(encoding="utf-8")) if only else {}
    for name in [only] if only else PARTS:
        found[name] = PARTS[name](folder, repeats)
    path.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    draw(found["lengths_s"], found["rates_hz"], figure)


if __name__ == "__main__":
    main()
