# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `hijack-detect`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from hijack_detect import __version__
from hijack_detect.cli.analyze import analyze
from hijack_detect.cli.common import PATH, BadInput
from hijack_detect.cli.convert import convert
from hijack_detect.cli.environment import add_own_prefix
from hijack_detect.cli.evaluate import evaluate
from hijack_detect.cli.inject import inject
from hijack_detect.cli.journal import journal
from hijack_detect.cli.live import live
from hijack_detect.cli.simulate import simulate
from hijack_detect.cli.sweep import sweep
from hijack_detect.cli.tune import tune
from hijack_detect.evaluation.monitor.manual import node_file, parameter_file
from hijack_detect.evaluation.monitor.policies import BESIDE, POLICIES

EXTRAS = {
    **dict.fromkeys(("matplotlib", "plotly", "scipy"), "analysis"),
    **dict.fromkeys(("pymavlink", "pyulog"), "logs"),
    "tornado": "live",
}
"""Libraries that only some commands import, and the extra that has them."""


class Commands(click.Group):
    """The commands; says what to install where one needs a library that is optional."""

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command.

        Raises:
            BadInput: A library of an extra is missing.
        """
        try:
            return super().invoke(ctx)
        except ModuleNotFoundError as error:
            library = (error.name or "").split(".")[0]
            if library not in EXTRAS:
                raise
            extra = EXTRAS[library]
            raise BadInput(
                f"this needs {library}, which is not installed; it comes with the extra "
                f"'{extra}': pip install '.[{extra}]'"
            ) from error


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="hijack-detect")
def main() -> None:
    """Tell when a drone's GPS is being spoofed."""
    add_own_prefix()


@main.command()
@click.option("--bag", type=PATH, default=None, help="Bag to replay [bags/curved_8].")
@click.option(
    "--scenario",
    default=None,
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

    Every node runs as a process of its own over DDS. Exits with 0 only if the alert came inside
    the attack and not before it (without an attack: if there was none), with 1 otherwise.
    """
    from hijack_detect.cli.demo import DemoOptions, run_demo  # noqa: PLC0415  needs ROS

    try:
        policy = "paper" if paper else "default"
        right = run_demo(DemoOptions(bag, scenario, onset, rate, policy, logs))
    except ValueError as error:
        raise BadInput(str(error)) from error
    sys.exit(0 if right else 1)


@main.command()
@click.option("--policy", type=click.Choice(list(POLICIES)), help="Those of the monitor [default].")
@click.option("--node", type=click.Choice(list(BESIDE)), help="Those of another node.")
def params(policy: str | None, node: str | None) -> None:
    """Print a parameter file, which is the manual of its parameters.

    It has the nodes of the monitor, as a policy sets them, or one of the nodes beside it.
    """
    if policy and node:
        raise click.UsageError("give --policy or --node, not both")
    click.echo(node_file(node) if node else parameter_file(policy or "default"), nl=False)


main.add_command(analyze)
main.add_command(convert)
main.add_command(evaluate)
main.add_command(inject)
main.add_command(journal)
main.add_command(live)
main.add_command(simulate)
main.add_command(sweep)
main.add_command(tune)

if __name__ == "__main__":
    main()
