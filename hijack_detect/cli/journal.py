# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `hijack-detect journal`."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

import click

from hijack_detect.cli.common import PATH, BadInput, refusing_bad_input
from hijack_detect.cli.completion import TABLE_NAMES, detectors, journals, states

if TYPE_CHECKING:
    from hijack_detect.recording.journal_reader import JournalReader, Query

STDOUT = Path("-")
SHOWN = 50
"""Rows shown in the terminal by default."""
COUNT = click.IntRange(min=1)


@click.command()
@click.argument("words", metavar="[FILE|FOLDER] [TABLE]", nargs=-1, shell_complete=journals)
@click.option("--since", metavar="TIME", help="From this time on: ISO (UTC), or seconds.")
@click.option("--until", metavar="TIME", help="Before this time.")
@click.option("--detector", shell_complete=detectors, help="Only verdicts of this detector.")
@click.option("--state", shell_complete=states, help="Only verdicts or alerts with this state.")
@click.option("--limit", type=COUNT, help="The first rows, this many.")
@click.option("--last", type=COUNT, help="The last rows, this many.")
@click.option("--csv", "csv_file", type=PATH, help="Write all that fits as CSV; - for stdout.")
@click.option("--json", "json_file", type=PATH, help="Write all that fits as JSON; - for stdout.")
def journal(
    words: tuple[str, ...],
    since: str | None,
    until: str | None,
    detector: str | None,
    state: str | None,
    limit: int | None,
    last: int | None,
    csv_file: Path | None,
    json_file: Path | None,
) -> None:
    """Show and export what the node `recorder` has kept; also while it runs.

    The journal is ~/.ros/hijack_detect unless another is named. Without TABLE an overview; TABLE is
    one of alerts, snapshots, verdicts, fixes, velocities, satellites, events, sessions. --since and
    --until choose by header stamp, for events and sessions by the wall clock.

    Exits with 2 if there is no journal or it cannot be read.
    """
    from hijack_detect.recording.journal_reader import (  # noqa: PLC0415  slow to load  # noqa: PLC0415
        Query,
        nanoseconds,
        open_journal,
        write_csv,
        write_json,
    )

    path, table = _told_apart(words)
    if table is None and (csv_file or json_file or since or until or detector or state):
        raise click.UsageError(f"name a TABLE: {', '.join(TABLE_NAMES)}")
    if csv_file and json_file:
        raise click.UsageError("--csv and --json are two exports; give one")
    if limit and last:
        raise click.UsageError("--limit gives the first rows, --last the last; give one")
    with refusing_bad_input(), open_journal(path) as reader:
        if table is None:
            from hijack_detect.cli.journal_view import overview  # noqa: PLC0415  slow to load

            overview(reader)
            return
        query = Query(
            table,
            None if since is None else nanoseconds(since),
            None if until is None else nanoseconds(until),
            detector,
            state,
            limit,
            last,
        )
        if csv_file:
            _export(reader, query, csv_file, write_csv)
        elif json_file:
            _export(reader, query, json_file, write_json)
        else:
            from hijack_detect.cli.journal_view import show_rows  # noqa: PLC0415

            show_rows(reader, query, SHOWN)


def _told_apart(words: tuple[str, ...]) -> tuple[Path, str | None]:
    """File and table; a word that is the name of a table is one, unless it comes first of two."""
    from hijack_detect.recording.parameters import RecorderParameters  # noqa: PLC0415

    if len(words) > 2:
        raise click.UsageError("give at most a journal and a table")
    table = words[-1] if words and words[-1] in TABLE_NAMES else None
    paths = words[:-1] if table else words
    if len(paths) == 2:
        raise click.UsageError(f"there is no table {paths[1]!r}: {', '.join(TABLE_NAMES)}")
    return Path(paths[0] if paths else RecorderParameters().folder).expanduser(), table


def _export(
    reader: JournalReader,
    query: Query,
    target: Path,
    write: Callable[..., int],
) -> None:
    try:
        with _opened(target) as file:
            count = write(query.table, reader.rows(query), file)
    except BrokenPipeError:  # the reader of the pipe has had enough, which click knows to handle
        raise
    except OSError as error:
        raise BadInput(f"{target}: cannot be written: {error.strerror}") from error
    if target != STDOUT:
        click.echo(f"{target}: {count} {query.table}", err=True)


@contextlib.contextmanager
def _opened(target: Path) -> Iterator[TextIO]:
    if target == STDOUT:
        yield sys.stdout
        sys.stdout.flush()
        return
    with target.open("w", encoding="utf-8", newline="") as file:
        yield file
