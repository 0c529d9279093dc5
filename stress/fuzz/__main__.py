# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Random input for every parser, led by what it reaches; counts of what was tried.

    make fuzz

Atheris is installed for it (Python 3.11 to 3.13). An input that raises what no parser may raise,
takes 10 s or 1 GB ends the run of its parser and stays in FOLDER/fuzz/NAME.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from functools import partial
from multiprocessing.pool import ThreadPool
from pathlib import Path
from typing import Any

import click
from rich.console import Console
from rich.progress import track

from hijack_detect.evaluation.scores.evaluation_page import TextTable
from stress.fuzz.targets import COUNTS, TARGETS
from tools.documents import fill, kept, write

PATH = click.Path(path_type=Path)
ONE_INPUT_S, MEMORY_MB = 10, 1024
HEADS = ("given", "inputs tried", "accepted", "branches reached", "defects")


def run(folder: Path, seconds: int, name: str) -> dict[str, Any]:
    """Try one parser for a time."""
    here = folder / "fuzz" / name
    here.mkdir(parents=True, exist_ok=True)
    options = [
        f"-max_total_time={seconds}",
        f"-timeout={ONE_INPUT_S}",
        f"-max_len={TARGETS[name].longest}",
    ]
    options += [f"-rss_limit_mb={MEMORY_MB}", f"-artifact_prefix={here}/", "-print_final_stats=1"]
    command = [sys.executable, "-m", "stress.fuzz.run", name, str(here), *options]
    done = subprocess.run(command, check=False, capture_output=True, text=True, errors="replace")
    write(here / "log.txt", done.stdout + done.stderr)
    tried, accepted = COUNTS.unpack((here / "counts").read_bytes())
    reached = re.findall(r"cov: (\d+)", done.stderr)
    found = {
        "seconds": seconds,
        "tried": tried,
        "accepted": accepted,
        "branches": int(reached[-1]) if reached else 0,
        "defect": done.returncode != 0,
    }
    write(here / "found.json", json.dumps(found, indent=1) + "\n")
    return found


def table(found: dict[str, dict[str, Any]]) -> TextTable:
    """One row a parser."""
    rows = tuple(
        (
            TARGETS[name].words,
            f"{one['tried']:,}",
            f"{one['accepted']:,}",
            f"{one['branches']:,}",
            "1" if one["defect"] else "0",
        )
        for name, one in found.items()
    )
    return TextTable("", HEADS, rows)


@click.command()
@click.argument("folder", type=PATH)
@click.argument("document", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--only", type=click.Choice(list(TARGETS)), multiple=True, help="Parsers [all].")
@click.option("--seconds", type=click.IntRange(1), default=300, show_default=True, help="For each.")
@click.option("--jobs", type=click.IntRange(1, 20), default=2, show_default=True)
def main(folder: Path, document: Path, only: tuple[str, ...], seconds: int, jobs: int) -> None:
    """Try, and write the table into DOCUMENT; exit code 1 if a defect was found."""
    names = list(only or TARGETS)
    with ThreadPool(jobs) as pool:
        results = pool.imap(partial(run, folder, seconds), names)
        for name, one in zip(
            names, track(results, "parsers", len(names), console=Console(stderr=True)), strict=True
        ):
            result = "a DEFECT, see log.txt" if one["defect"] else "no defect"
            click.echo(f"{name}: {one['tried']} tried, {one['accepted']} accepted, {result}")
    found = kept({name: folder / "fuzz" / name / "found.json" for name in TARGETS})
    fill(document, lambda what: table(found) if what == "fuzz" else None)
    sys.exit(any(one["defect"] for one in found.values()))


if __name__ == "__main__":
    main()
