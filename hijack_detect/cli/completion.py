# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `hijack-detect completion`."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

import click
from click.shell_completion import CompletionItem, get_completion_class

from hijack_detect.cli.common import add_own_prefix, share_folder
from hijack_detect.monitor.parts import DETECTORS

POLICY_NAMES = ("default", "paper")
OTHER_NODES = ("recorder", "gps_spoofer", "mavlink_bridge", "px4_bridge")
ROUTES = ("straight", "curved", "hover", "fixed_yaw", "survey")
TABLE_NAMES = (
    "alerts",
    "snapshots",
    "verdicts",
    "fixes",
    "velocities",
    "satellites",
    "events",
    "sessions",
)


NO_ATTACK = "none"


def scenarios(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Names of config/scenarios, and files."""
    add_own_prefix()
    names = {path.stem for path in (share_folder() / "config/scenarios").glob("*.yaml")}
    return [*_offered(sorted({*names, NO_ATTACK}), incomplete), *_files(incomplete)]


def journals(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Tables of a journal, and files."""
    return [*_offered(TABLE_NAMES, incomplete), *_files(incomplete)]


def detectors(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Names of detectors."""
    return _offered(DETECTORS, incomplete)


def states(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Names of states."""
    from hijack_detect.detectors.verdict import State  # noqa: PLC0415  slow to load

    return _offered((state.value for state in State), incomplete)


def _offered(words: Iterable[str], incomplete: str) -> list[CompletionItem]:
    return [CompletionItem(word) for word in words if word.startswith(incomplete)]


def _files(incomplete: str) -> list[CompletionItem]:
    """The shell completes files by itself."""
    return [CompletionItem(incomplete, type="file")]


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
