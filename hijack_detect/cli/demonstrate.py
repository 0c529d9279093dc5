# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `hijack-detect demo`."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from hijack_detect.cli.common import PATH, BadInput
from hijack_detect.cli.completion import scenarios


@click.command()
@click.option("--bag", type=PATH, default=None, help="Bag to replay [bags/curved_8].")
@click.option(
    "--scenario",
    default=None,
    shell_complete=scenarios,
    help="Scenario file, or 'none' for no attack [config/scenarios/turn_away_track.yaml].",
)
@click.option("--onset", type=float, default=None, help="Move the attack to this second.")
@click.option("--rate", type=click.FloatRange(0.1, 100.0), default=4.0, show_default=True)
@click.option(
    "--paper/--default",
    "paper",
    default=False,
    help="The published detectors and both-must-alarm, or the hardened ones [default].",
)
@click.option("--logs", type=PATH, default=None, help="Keep the nodes' logs in this folder.")
def demo(
    bag: Path | None,
    scenario: str | None,
    onset: float | None,
    rate: float,
    paper: bool,
    logs: Path | None,
) -> None:
    """Replay a flight, spoof its GPS, and show the alert.

    Every node runs as a separate process over DDS. Exits with 0 only if the alert came inside
    the attack and not before it (without an attack: if there was none), with 1 otherwise.
    """
    from hijack_detect.cli.demo import DemoOptions, run_demo  # noqa: PLC0415  needs ROS

    try:
        policy = "paper" if paper else "default"
        right = run_demo(DemoOptions(bag, scenario, onset, rate, policy, logs))
    except ValueError as error:
        raise BadInput(str(error)) from error
    sys.exit(0 if right else 1)
