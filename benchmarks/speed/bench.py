"""How long the offline path takes, as ratios to rosbags measured in the same run.

    make bench            (python benchmarks/speed/bench.py build/bench)

Each job runs in a process of its own, by turns, and the medians count. Ratios are compared with
benchmarks/speed/baseline.json: worse by more than a fifth ends with exit code 1. With --accept the
figures become the baseline.
"""

from __future__ import annotations

import json
import platform
import statistics
import subprocess
import sys
from datetime import date
from pathlib import Path
from typing import Any

import click
from jobs import JOBS
from load import load_bag
from rich.console import Console
from rich.progress import track
from rich.table import Table

HERE = Path(__file__).parent
BASELINE = HERE / "baseline.json"
WORSE = 1.2
MINUTES = 10.0
"""Length of the flight of the first part."""
RATES_HZ = (50, 100, 250, 500)
LENGTHS_S = (75.0, 150.0, 300.0, 600.0)


def measured(name: str, bag: Path) -> dict[str, float]:
    """One job in a fresh process."""
    done = subprocess.run(
        [sys.executable, HERE / "jobs.py", name, bag], check=True, capture_output=True, text=True
    )
    found: dict[str, float] = json.loads(done.stdout)
    return found


def medians(names: list[str], bag: Path, repeats: int, what: str) -> dict[str, dict[str, float]]:
    """Median figures of jobs that take turns."""
    runs: dict[str, list[dict[str, float]]] = {name: [] for name in names}
    turns = [name for _ in range(repeats) for name in names]
    for name in track(turns, f"{what:24}", console=Console(stderr=True)):
        runs[name].append(measured(name, bag))
    return {
        name: {key: statistics.median(one[key] for one in all_of) for key in all_of[0]}
        for name, all_of in runs.items()
    }


def machine() -> dict[str, str]:
    """Where and when it was measured."""
    git = ["git", "-C", str(HERE), "describe", "--always", "--dirty"]
    commit = subprocess.run(git, check=False, capture_output=True, text=True).stdout.strip()
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.is_file() else []
    model = next((line.split(":")[1].strip() for line in lines if "model name" in line), "unknown")
    return {
        "processor": model,
        "python": platform.python_version(),
        "commit": commit,
        "date": date.today().isoformat(),
    }


def offline(folder: Path, repeats: int) -> dict[str, Any]:
    """Figures of each job, and its processor time over that of rosbags."""
    bag = load_bag(folder, 60.0 * MINUTES, 250)
    found = medians(list(JOBS), bag, repeats, "600 s at 250 Hz")
    reference = found["rosbags"]["cpu_s"]
    return {
        "ratios": {name: one["cpu_s"] / reference for name, one in found.items()},
        "figures": found,
    }


def growth(folder: Path, repeats: int) -> dict[str, Any]:
    """Processor seconds of detecting, by length and by rate of the IMU."""
    lengths = {
        f"{seconds:g}": medians(
            ["detect"], load_bag(folder, seconds, 100), repeats, f"{seconds:g} s at 100 Hz"
        )["detect"]
        for seconds in LENGTHS_S
    }
    rates = {
        f"{hz}": medians(["detect"], load_bag(folder, 75.0, hz), repeats, f"75 s at {hz} Hz")[
            "detect"
        ]
        for hz in RATES_HZ
    }
    return {"lengths_s": lengths, "rates_hz": rates}


def compared(ratios: dict[str, float], baseline: dict[str, float]) -> list[str]:
    """What has become worse by more than a fifth, a line each."""
    return [
        f"{name} takes {ratio:.2f} times as long as rosbags, the baseline is {baseline[name]:.2f}"
        for name, ratio in ratios.items()
        if name in baseline and ratio > WORSE * baseline[name]
    ]


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--repeats", type=click.IntRange(1, 50), default=3)
@click.option("--accept", is_flag=True, help="Make the ratios the baseline.")
@click.option("--grow", is_flag=True, help="Measure lengths and rates, too.")
def main(folder: Path, repeats: int, accept: bool, grow: bool) -> None:
    """Measure with bags in FOLDER, and write FOLDER/bench.json."""
    folder.mkdir(parents=True, exist_ok=True)
    result = {"machine": machine(), "offline": offline(folder, repeats)}
    if grow:
        result["growth"] = growth(folder, repeats)
    (folder / "bench.json").write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    ratios = result["offline"]["ratios"]
    table = Table("job", "s", "over rosbags", "peak MB")
    for name, one in result["offline"]["figures"].items():
        table.add_row(name, f"{one['cpu_s']:.2f}", f"{ratios[name]:.2f}", f"{one['peak_mb']:.0f}")
    Console().print(table)
    if accept:
        text = json.dumps({"machine": result["machine"], "ratios": ratios}, indent=1)
        BASELINE.write_text(text + "\n", encoding="utf-8")
    elif BASELINE.is_file():
        worse = compared(ratios, json.loads(BASELINE.read_text(encoding="utf-8"))["ratios"])
        for line in worse:
            click.echo(line, err=True)
        sys.exit(bool(worse))


if __name__ == "__main__":
    main()
