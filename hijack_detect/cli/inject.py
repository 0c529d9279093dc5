# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `inject`: a spoofed copy of a bag."""

from __future__ import annotations

from pathlib import Path

import click

from hijack_detect.cli.common import PATH, PLACE, find_scenario, progress, refusing_bad_input
from hijack_detect.cli.completion import scenarios
from hijack_detect.streams.samples import NANOSECONDS


@click.command()
@click.argument("bag", metavar="IN", type=PLACE)
@click.argument("out", type=PATH)
@click.option(
    "--scenario",
    required=True,
    shell_complete=scenarios,
    help="Scenario file, or the name of one in config/scenarios.",
)
@click.option("--onset", type=float, default=None, help="Move the attack to this second.")
def inject(bag: Path, out: Path, scenario: str, onset: float | None) -> None:
    """Write the bag OUT: the flight IN with an attack, and the truth beside it.

    /spoof_active marks each fix as spoofed or not, /truth/measured_fix keeps the fixes as
    they were. The flight itself stays as it was flown: this is an open-loop attack.
    """
    from hijack_detect.bags.reader import BagReader  # noqa: PLC0415  slow to load
    from hijack_detect.replay.injection import inject as write  # noqa: PLC0415

    with refusing_bad_input(), BagReader(bag) as reader:
        attacks = find_scenario(scenario, onset)
        with progress(f"Writing {out}", reader.duration_s) as show:
            done = write(
                reader,
                out,
                attacks,
                on_message=lambda ns: show((ns - reader.start_ns) / NANOSECONDS),
            )
    for line in done.refused.lines():
        click.echo(line, err=True)
    for topic, reason in done.left_out.items():
        click.echo(f"left out {topic}: {reason}", err=True)
    click.echo(f"{out}: {done.messages} messages, {done.spoofed} fixes spoofed")
