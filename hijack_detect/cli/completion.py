# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `hijack-detect completion`."""

from __future__ import annotations

import os
from pathlib import Path

import click
from click.shell_completion import get_completion_class

PROGRAM, VARIABLE = "hijack-detect", "_HIJACK_DETECT_COMPLETE"
SHELLS = ("bash", "zsh", "fish")


@click.command()
@click.argument("shell", type=click.Choice(SHELLS), required=False)
@click.pass_context
def completion(ctx: click.Context, shell: str | None) -> None:
    r"""Print the script that makes a shell complete this command [that of $SHELL].

    \b
    bash: echo 'source <(hijack-detect completion bash)' >> ~/.bashrc
    zsh:  echo 'source <(hijack-detect completion zsh)' >> ~/.zshrc   (behind compinit)
    fish: hijack-detect completion fish > ~/.config/fish/completions/hijack-detect.fish

    Names of scenarios, policies, nodes, tables, detectors and states are completed too.
    """
    chosen = shell or Path(os.environ.get("SHELL", "")).name
    kind = get_completion_class(chosen) if chosen in SHELLS else None
    if kind is None:
        raise click.UsageError(f"name the shell: {', '.join(SHELLS)}")
    click.echo(kind(ctx.find_root().command, {}, PROGRAM, VARIABLE).source())
