# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What the shell offers for values of options and arguments."""

from __future__ import annotations

from collections.abc import Iterable

import click
from click.shell_completion import CompletionItem

from hijack_detect.cli.choices import TABLE_NAMES
from hijack_detect.cli.common import share_folder
from hijack_detect.cli.environment import add_own_prefix
from hijack_detect.monitor.parts import DETECTORS

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
