# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Output of the command `evaluate`."""

from __future__ import annotations

import sys

from rich.console import Console
from rich.table import Table

from hijack_detect.evaluation.scores.basan_tables import basan_tables
from hijack_detect.evaluation.scores.evaluate import Evaluation
from hijack_detect.evaluation.scores.evaluation_tables import (
    TextTable,
    class_table,
    correct_table,
    detection_table,
    error_table,
)
from hijack_detect.evaluation.scores.watch_tables import watch_tables

PIPE_WIDTH = 120
"""Columns of a table that is not shown in a terminal, at least."""
TEXTS = frozenset({"class", "vehicle", "cause"})
"""Columns of words."""
METHOD_WIDTH = 18
"""Columns that a method needs."""


def tables(evaluation: Evaluation) -> None:
    """Print the tables on stdout."""
    width = max(PIPE_WIDTH, METHOD_WIDTH * (len(evaluation.methods) + 1))
    console = Console(width=None if sys.stdout.isatty() else width)
    console.print(
        f"{evaluation.source}, policy {evaluation.policy}: {len(evaluation.flights)} flights, "
        f"{len(evaluation.failed)} could not be read",
        highlight=False,
        soft_wrap=True,
    )
    for made in watch_tables(evaluation):
        console.print(drawn(made))
    if evaluation.flights:
        for table in (correct_table, error_table, detection_table):
            console.print(drawn(table(evaluation)))
    if evaluation.forging is not None:  # its own tables have the classes
        for made in basan_tables(evaluation):
            console.print(drawn(made))
    elif (by_class := class_table(evaluation)) is not None:
        console.print(drawn(by_class))


def drawn(table: TextTable) -> Table:
    """A table of the evaluation as rich draws it."""
    drawn = Table(title=table.title, title_justify="left")
    for number, name in enumerate(table.columns):
        text = name in TEXTS or not number
        drawn.add_column(name, justify="left" if text else "right", no_wrap=not number)
    for row in table.rows:
        drawn.add_row(*row)
    return drawn
