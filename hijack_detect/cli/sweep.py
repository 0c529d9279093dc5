# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `sweep`: how good the methods are against one parameter or size of attack."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hijack_detect.cli.common import (
    EXIT_BAD_INPUT,
    PATH,
    PLACE,
    BadInput,
    make_folder,
    pool_options,
    progress,
    refusing_bad_input,
)
from hijack_detect.cli.completion import POLICY_NAMES
from hijack_detect.cli.evaluate import PROTOCOLS

if TYPE_CHECKING:
    from hijack_detect.evaluation.trials.parallel import Failure, Pool

ATTACK = "attack"
WHAT = ("epsilon", "mu", "window", ATTACK)


@click.command()
@click.argument("what", type=click.Choice(WHAT))
@click.argument("corpus", type=PLACE, required=False)
@click.option("--protocol", type=click.Choice(PROTOCOLS), help="Simulated flights [feng2018].")
@click.option("--scale", type=click.IntRange(1, 200), help="Times as many simulated flights [1].")
@click.option(
    "-o", "--out", type=PATH, default=Path(), help="Folder for WHAT.csv and WHAT.png [here]."
)
@click.option(
    "--policy", type=click.Choice(POLICY_NAMES), help="Parameter set [paper; attack: default]."
)
@pool_options
def sweep(
    what: str,
    corpus: Path | None,
    protocol: str | None,
    scale: int | None,
    out: Path,
    policy: str | None,
    pool: Pool,
) -> None:
    """Vary one thing and see how many flights are judged correctly.

    epsilon and mu are Figures 16 and 17 of Feng 2018, for the correlation; window is that of
    correlation and DATE. The flights are those below the folder CORPUS, or of a protocol.
    attack flies carry-offs of several speeds and onset accelerations on the simulator, and
    shows for every method how many it detects, and how soon.
    """
    if corpus is not None and (protocol is not None or scale is not None):
        raise click.UsageError("give either a folder of flights, or --protocol and --scale")
    if what == ATTACK and (corpus is not None or protocol is not None):
        raise click.UsageError("attack makes its own flights: give no folder and no --protocol")
    make_folder(out)
    try:
        with refusing_bad_input():
            if what == ATTACK:
                failed = _attack(out, policy or "default", scale or 1, pool)
            else:
                source = corpus or protocol or PROTOCOLS[0]
                failed = _sweep(what, out, policy or "paper", source, scale or 1, pool)
    except OSError as error:
        raise BadInput(f"{out}: cannot be written: {error.strerror}") from error
    for flight in failed:
        click.echo(f"{flight.name}: {flight.reason}", err=True)


def _sweep(
    what: str, out: Path, policy: str, source: Path | str, scale: int, pool: Pool
) -> Sequence[Failure]:
    from hijack_detect.evaluation.trials.corpus import corpus_cases  # noqa: PLC0415  slow to load
    from hijack_detect.evaluation.trials.protocols import PROTOCOLS as MADE  # noqa: PLC0415
    from hijack_detect.evaluation.tuning.sweep_plots import draw_curves  # noqa: PLC0415
    from hijack_detect.evaluation.tuning.sweeps import SWEEPS, csv_text  # noqa: PLC0415
    from hijack_detect.evaluation.tuning.sweeps import sweep as run  # noqa: PLC0415
    from hijack_detect.monitor.policies import policy_parameters  # noqa: PLC0415

    cases = MADE[source](scale) if isinstance(source, str) else corpus_cases(source)
    with progress("flights", len(cases)) as done:
        curves, failed = run(
            cases, policy_parameters(policy), SWEEPS[what], pool=pool, on_done=done
        )
    if not curves:
        for flight in failed:
            click.echo(f"{flight.name}: {flight.reason}", err=True)
        raise click.exceptions.Exit(EXIT_BAD_INPUT)
    _write(out, what, csv_text(SWEEPS[what], curves))
    name = source if isinstance(source, str) else source.resolve().name
    title = f"{name}, policy {policy}: correctness against {what}"
    draw_curves(out / f"{what}.png", SWEEPS[what], curves, title)
    return failed


def _attack(out: Path, policy: str, scale: int, pool: Pool) -> Sequence[Failure]:
    from hijack_detect.evaluation.tuning.attack_map import (  # noqa: PLC0415  slow to load
        ACCELERATIONS,
        FLIGHTS,
        SPEEDS,
        attack_map,
        attack_sizes,
        csv_text,
    )
    from hijack_detect.evaluation.tuning.sweep_plots import draw_map  # noqa: PLC0415
    from hijack_detect.monitor.policies import policy_parameters  # noqa: PLC0415

    flights = FLIGHTS * scale
    with progress("flights", flights * len(attack_sizes(SPEEDS, ACCELERATIONS))) as done:
        cells, failed = attack_map(
            policy_parameters(policy), flights=flights, pool=pool, on_done=done
        )
    _write(out, ATTACK, csv_text(cells))
    draw_map(out / f"{ATTACK}.png", cells, f"Carry-off in closed loop, policy {policy}")
    return failed


def _write(out: Path, what: str, text: str) -> None:
    path = out / f"{what}.csv"
    path.write_text(text, encoding="utf-8")
    click.echo(f"{path} and {what}.png")
