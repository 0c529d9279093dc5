# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `hijack-detect params`."""

from __future__ import annotations

import click

from hijack_detect.cli.common import refusing_bad_input
from hijack_detect.cli.completion import OTHER_NODES, POLICY_NAMES


@click.command()
@click.option("--policy", type=click.Choice(POLICY_NAMES), help="Those of the monitor [default].")
@click.option("--node", type=click.Choice(OTHER_NODES), help="Those of another node.")
@click.option(
    "--detector",
    "detectors",
    multiple=True,
    metavar="FILE.py:CLASS",
    help="A detector of your own too, and its weight in the fusion. Can be given again.",
)
def params(policy: str | None, node: str | None, detectors: tuple[str, ...]) -> None:
    """Print a parameter file, which is the manual of its parameters.

    It has the nodes of the monitor, as a policy sets them, or one of the nodes beside it.
    """
    from hijack_detect.cli.parameter_files import (  # noqa: PLC0415  slow to load
        node_file,
        parameter_file,
    )
    from hijack_detect.cli.user_detectors import load_detectors  # noqa: PLC0415

    if node and (policy or detectors):
        raise click.UsageError("give --policy and --detector, or --node, not both")
    with refusing_bad_input():
        text = (
            node_file(node)
            if node
            else parameter_file(policy or "default", load_detectors(detectors))
        )
    click.echo(text, nl=False)
