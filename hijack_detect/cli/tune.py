# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `tune`: thresholds for one vehicle from its clean flights."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hijack_detect.cli.common import (
    PATH,
    PLACE,
    BadInput,
    find_scenario,
    pool_options,
    progress,
    refusing_bad_input,
)
from hijack_detect.cli.completion import POLICY_NAMES
from hijack_detect.cli.completion import scenarios as scenario_names

if TYPE_CHECKING:
    from hijack_detect.evaluation.trials.parallel import Pool

SCENARIO = "turn_away_track"


@click.command()
@click.argument("corpus", type=PLACE)
@click.option("-o", "--out", type=PATH, required=True, help="Parameter file to write.")
@click.option(
    "--false-alarms-per-hour",
    "per_hour",
    type=click.FloatRange(min=0.0, min_open=True),
    default=1.0,
    show_default=True,
    help="Of each detector.",
)
@click.option("--policy", type=click.Choice(POLICY_NAMES), default="default", show_default=True)
@click.option(
    "--scenario",
    "scenarios",
    shell_complete=scenario_names,
    multiple=True,
    help=f"Attack to inject, a file or a name; repeat for several, 'none' for none [{SCENARIO}].",
)
@pool_options
def tune(
    corpus: Path,
    out: Path,
    per_hour: float,
    policy: str,
    scenarios: tuple[str, ...],
    pool: Pool,
) -> None:
    """Choose thresholds for one vehicle from the flights below the folder CORPUS.

    This is the baseline test of Feng 2018, §5: fly clean, several times, and adjust. It also
    estimates the lag of the vehicle's GPS. Flights whose label.json has an attack are used
    to see what the thresholds cost in detection, as are the scenarios, which are injected into
    the clean flights. Flights that cannot be read are reported on stderr and left out.
    """
    from hijack_detect.cli.tune_view import print_tuning, written  # noqa: PLC0415  slow to load
    from hijack_detect.evaluation.trials.corpus import corpus_cases  # noqa: PLC0415
    from hijack_detect.evaluation.tuning.tuning import tune as run  # noqa: PLC0415
    from hijack_detect.monitor.policies import policy_parameters  # noqa: PLC0415

    if not out.parent.is_dir():
        raise BadInput(f"{out.parent}: is no folder; make it first")
    names = scenarios or (SCENARIO,)
    with refusing_bad_input(), contextlib.ExitStack() as bars:
        attacks = [find_scenario(name) for name in names if name != "none"]

        def bar(text: str, total: int) -> Callable[[int], None]:
            bars.close()
            return bars.enter_context(progress(text, total))

        tuning = run(
            corpus_cases(corpus),
            policy,
            policy_parameters(policy),
            per_hour=per_hour,
            scenarios=attacks,
            pool=pool,
            progress=bar,
        )
    for failure in tuning.failures:
        click.echo(f"{failure.name}: {failure.reason}", err=True)
    try:
        out.write_text(written(tuning, policy, per_hour), encoding="utf-8")
    except OSError as error:
        raise BadInput(f"{out}: cannot be written: {error.strerror}") from error
    print_tuning(tuning, per_hour)
    click.echo(f"written to {out}")
