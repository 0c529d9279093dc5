# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Tables in a Markdown text: a line `<!-- table NAME ... -->`, and the table that follows it."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from hijack_detect.evaluation.scores.evaluation_page import TextTable

MARK = re.compile(r"<!-- table ([^\n]*?) -->\n(?:\n?(?:\|.*\n)+)?")


def markdown(table: TextTable) -> str:
    """A table as Markdown."""
    rows = [table.columns, ("---",) * len(table.columns), *table.rows]
    lines = (" | ".join(cell.replace("\n", " ") for cell in row) for row in rows)
    return "".join(f"| {line} |\n" for line in lines)


def fill(document: Path, make: Callable[..., TextTable | None]) -> None:
    """Replace the table below every mark.

    Args:
        document: The text.
        make: Called with the words of a mark; None leaves what is there.
    """

    def filled(match: re.Match[str]) -> str:
        table = make(*match.group(1).split())
        if table is None:
            return match.group(0)
        text = markdown(table) if table.rows else "| none |\n| --- |\n"
        return f"<!-- table {match.group(1)} -->\n\n{text}"

    text = document.read_text(encoding="utf-8")
    write(document, MARK.sub(filled, text))


def kept(paths: Mapping[str, Path]) -> dict[str, Any]:
    """What was kept as JSON, by name, where it is there."""
    return {
        name: json.loads(path.read_text(encoding="utf-8"))
        for name, path in paths.items()
        if path.is_file()
    }


def write(path: Path, text: str) -> None:
    """Write a file atomically: a reader finds all of it or what was there before."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(f"{path.suffix}.part")
    part.write_text(text, encoding="utf-8")
    os.replace(part, path)
