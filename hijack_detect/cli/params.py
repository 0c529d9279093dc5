# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `hijack-detect params`."""

from __future__ import annotations

import click

from hijack_detect.cli.choices import BESIDE_NAMES, POLICY_NAMES


@click.command()
@click.option("--policy", type=click.Choice(POLICY_NAMES), help="Those of the monitor [default].")
@click.option("--node", type=click.Choice(BESIDE_NAMES), help="Those of another node.")
def params(policy: str | None, node: str | None) -> None:
    """Print a parameter file, which is the manual of its parameters.

    It has the nodes of the monitor, as a policy sets them, or one of the nodes beside it.
    """
    from hijack_detect.cli.parameter_files import (  # noqa: PLC0415  slow to load
        node_file,
        parameter_file,
    )

    if policy and node:
        raise click.UsageError("give --policy or --node, not both")
    click.echo(node_file(node) if node else parameter_file(policy or "default"), nl=False)
