# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Speed of the monitor, as ratios to something measured in the same run.

    make bench            (python benchmarks/bench.py build/bench)

Three sections: `offline` against rosbags (5 minutes), `steps` of each part against deserialising
one message (2 minutes), and the `live` graph against a node that only receives (6 minutes).
Ratios are compared with benchmarks/baseline.json: worse by more than a fifth ends with exit code
1. With --accept the figures become the baseline.
"""

from __future__ import annotations

import json
import platform
import subprocess
import sys
from collections.abc import Callable, Mapping
from datetime import date
from pathlib import Path

import click
import offline
import online
import steps
from rich.console import Console
from section import Section

HERE = Path(__file__).parent
BASELINE = HERE / "baseline.json"
WORSE = 1.2
Ratios = Mapping[str, Mapping[str, float]]
"""By section and name."""
SECTIONS: dict[str, Callable[[Path, int], Section]] = {
    "offline": offline.measure,
    "steps": steps.measure,
    "live": online.measure,
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


def compared(ratios: Ratios, baseline: Ratios) -> list[str]:
    """What has become worse by more than a fifth, a line each."""
    return [
        f"{section}: {name} is {ratio:.2f}, the baseline is {baseline[section][name]:.2f}"
        for section, found in ratios.items()
        for name, ratio in found.items()
        if name in baseline.get(section, {}) and ratio > WORSE * baseline[section][name]
    ]


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--only", type=click.Choice(list(SECTIONS)), multiple=True, help="Sections [all].")
@click.option("--repeats", type=click.IntRange(1, 50), default=3, show_default=True)
@click.option("--accept", is_flag=True, help="Make the ratios the baseline.")
def main(folder: Path, only: tuple[str, ...], repeats: int, accept: bool) -> None:
    """Measure with bags in FOLDER, and write FOLDER/bench.json."""
    folder.mkdir(parents=True, exist_ok=True)
    found: dict[str, Section] = {}
    for name in only or SECTIONS:
        found[name] = one = SECTIONS[name](folder, repeats)
        Console().print(one.table)
        for line in one.remarks:
            click.echo(line)
    described = machine()
    result = {"machine": described, **{name: one.figures for name, one in found.items()}}
    (folder / "bench.json").write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    before = json.loads(BASELINE.read_text(encoding="utf-8")) if BASELINE.is_file() else {}
    known: Ratios = before.get("ratios", {})
    ratios = {name: one.ratios for name, one in found.items()}
    if accept:
        text = json.dumps({"machine": described, "ratios": {**known, **ratios}}, indent=1)
        BASELINE.write_text(text + "\n", encoding="utf-8")
        return
    worse = compared(ratios, known)
    for line in worse:
        click.echo(f"worse by more than a fifth: {line}", err=True)
    sys.exit(bool(worse))


if __name__ == "__main__":
    main()
