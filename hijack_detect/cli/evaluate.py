# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `evaluate`: how good every method is on many flights."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hijack_detect.cli.common import (
    EXIT_BAD_INPUT,
    PATH,
    PLACE,
    BadInput,
    find_scenario,
    make_folder,
    pool_options,
    progress,
    refusing_bad_input,
)
from hijack_detect.cli.completion import POLICY_NAMES, scenarios

if TYPE_CHECKING:
    from hijack_detect.evaluation.scores.evaluate import Evaluation
    from hijack_detect.evaluation.trials.cases import Case
    from hijack_detect.evaluation.trials.parallel import Pool
    from hijack_detect.monitor.policies import MonitorParameters

BASAN = "basan2022"
PROTOCOLS = ("feng2018", "feng2018_noisy", BASAN, "limits", "hard")
PAGE = "index.html"
ONSETS = 5
"""Chosen, not swept; the default of `--onsets`."""


@click.command()
@click.argument("corpus", type=PLACE, required=False)
@click.option("--protocol", type=click.Choice(PROTOCOLS), help="Simulated flights instead.")
@click.option("--policy", type=click.Choice(POLICY_NAMES), help="Parameter set [default].")
@click.option("--params", type=PATH, help="ROS parameter file instead of a policy.")
@click.option(
    "--scenario",
    shell_complete=scenarios,
    help="Attack the clean flights of CORPUS too: scenario file or its name.",
)
@click.option("--onsets", type=click.IntRange(1, 1000), help="Attacks on each flight [5].")
@click.option("--scale", type=click.IntRange(1, 200), help="Times as many simulated flights [1].")
@click.option(
    "--json", "json_file", type=PATH, help="Write all figures; '-' for stdout, without tables."
)
@click.option("--html", "html_folder", type=PATH, help="Write a page into this folder.")
@pool_options
def evaluate(
    corpus: Path | None,
    protocol: str | None,
    policy: str | None,
    params: Path | None,
    scenario: str | None,
    onsets: int | None,
    scale: int | None,
    json_file: Path | None,
    html_folder: Path | None,
    pool: Pool,
) -> None:
    """Run every flight below the folder CORPUS, or of a protocol, and judge every method.

    Flights are bags, and logs of every format that `analyze` knows by content. A flight is hijacked
    or clean by the labels.json of its folder (docs/evaluate.md), or by the label.json beside it;
    without one it is clean, unless its topics have an attack. With --scenario each clean flight
    is run again with that attack injected, at onsets spread by chance (the same each time) over its
    forward flight. Protocol feng2018 has 25 straight, 25 curved and 50 hijacked flights of the
    simulator; feng2018_noisy is the same with the noise of a receiver on the fake fixes. basan2022
    has 25 clean flights and 25 of each attack (soft, hard 1, hard 2, smooth); with CORPUS it puts
    each attack into the clean flights there, at --onsets places. limits has 30 clean flights and 30
    of each of ten attacks, for rates with narrow intervals at a --scale of 10.

    The first tables give the false alerts per hour at risk, by class and by
    vehicle, in which share of that time each detector could tell, and the cause of each alert.
    A clean flight is correct without any alarm, a hijacked one if the first alarm of the flight
    lies inside the attack. Flights that cannot be read are reported on stderr; the exit code is 2
    only if none could be.
    """
    if (corpus is None) == (protocol is None) and protocol != BASAN:
        raise click.UsageError("give either a folder of flights or --protocol")
    if policy is not None and params is not None:
        raise click.UsageError("give --policy or --params, not both")
    if scale is not None and (protocol is None or corpus is not None):
        raise click.UsageError("--scale goes with --protocol, and simulated flights")
    if scenario is not None and (corpus is None or protocol is not None):
        raise click.UsageError("--scenario goes with a folder of flights")
    if onsets is not None and scenario is None and not (protocol and corpus):
        raise click.UsageError(f"--onsets goes with --scenario, or a folder and {BASAN}")
    from hijack_detect.evaluation.scores.evaluate import evaluate as run  # noqa: PLC0415

    with refusing_bad_input():
        parameters, chosen = _parameters(policy, params)
        cases = _cases(corpus, protocol, scenario, onsets or ONSETS, scale or 1)
        for folder in (None if json_file is None else json_file.parent, html_folder):
            if folder is not None:  # before the flights run
                make_folder(folder)
        with progress("flights", len(cases)) as done:
            evaluation = run(
                cases,
                parameters,
                source=_source(corpus, protocol, scale),
                policy=chosen,
                forging=protocol == BASAN,
                pool=pool,
                on_done=done,
            )
    _report(evaluation, json_file, html_folder)
    if not evaluation.flights:
        sys.exit(EXIT_BAD_INPUT)


def _cases(
    corpus: Path | None, protocol: str | None, scenario: str | None, onsets: int, scale: int
) -> list[Case]:
    """The flights to judge."""
    from hijack_detect.evaluation.trials.basan2022 import basan2022_on  # noqa: PLC0415  slow
    from hijack_detect.evaluation.trials.corpus import corpus_cases  # noqa: PLC0415
    from hijack_detect.evaluation.trials.protocols import PROTOCOLS as MADE  # noqa: PLC0415

    if corpus is None:
        assert protocol is not None
        return list(MADE[protocol](scale))
    if protocol is not None:
        return basan2022_on(corpus, onsets)
    attack = None if scenario is None else find_scenario(scenario)
    return list(corpus_cases(corpus, attack, onsets))


def _parameters(policy: str | None, params: Path | None) -> tuple[MonitorParameters, str]:
    """Parameters and what to call them."""
    from hijack_detect.cli.parameter_files import load_parameters  # noqa: PLC0415
    from hijack_detect.monitor.policies import policy_parameters  # noqa: PLC0415

    if params is not None:
        return load_parameters(params), str(params)
    name = policy or "default"
    return policy_parameters(name), name


def _source(corpus: Path | None, protocol: str | None, scale: int | None) -> str:
    if corpus is not None:
        return str(corpus) if protocol is None else f"{protocol} on {corpus}"
    return str(protocol) if scale in (None, 1) else f"{protocol} × {scale}"


def _report(evaluation: Evaluation, json_file: Path | None, html_folder: Path | None) -> None:
    from hijack_detect.cli.evaluate_view import tables  # noqa: PLC0415  slow to load

    for flight in evaluation.failed:
        click.echo(f"{flight.name}: {flight.reason}", err=True)
    if html_folder is not None:
        from hijack_detect.evaluation.scores.evaluation_page import (  # noqa: PLC0415  plotly is slow
            evaluation_page,
        )

        _write(html_folder / PAGE, evaluation_page(evaluation))
    data = evaluation.model_dump_json(indent=2) + "\n"
    if json_file == Path("-"):
        click.echo(data, nl=False)
        return
    if json_file is not None:
        _write(json_file, data)
    tables(evaluation)


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise BadInput(f"{path}: cannot be written: {error.strerror}") from error
