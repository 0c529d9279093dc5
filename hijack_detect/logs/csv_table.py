# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A CSV file as rows, read one at a time."""

from __future__ import annotations

import csv
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from hijack_detect.bags.errors import BagError

Row = tuple[int, list[str]]
"""Number of the line, from 1, and its fields."""
DELIMITERS = (",", ";", "\t")


@dataclass(frozen=True)
class Form:
    """How a table is written; see ColumnMap."""

    delimiter: str = ","
    comment: str = "#"
    encoding: str = "utf-8"
    header: bool = True


def rows(path: Path, form: Form) -> Iterator[Row]:
    """Rows that are neither empty nor a comment.

    Raises:
        BagError: The file cannot be read, or is no text in the encoding.
    """
    encoding = "utf-8-sig" if form.encoding == "utf-8" else form.encoding
    try:
        with path.open(encoding=encoding, newline="") as file:
            lines = file if not form.comment else _without_comments(file, form.comment)
            read = csv.reader(lines, delimiter=form.delimiter, skipinitialspace=True)
            for row in read:
                if any(map(str.strip, row)):
                    yield read.line_num, row
    except OSError as error:
        raise BagError(f"{path}: cannot be read: {error.strerror or error}") from error
    except UnicodeError as error:
        raise BagError(
            f"{path}: is no {form.encoding} text; give its encoding in the map (latin-1, utf-16)"
        ) from error
    except csv.Error as error:
        raise BagError(f"{path}: line {read.line_num}: {error}") from error


def named_columns(path: Path, form: Form) -> tuple[list[str], list[str]]:
    """Names of the columns (numbers without a header), and the first row of values.

    Raises:
        BagError: As `rows`, or it is empty.
    """
    first = list(itertools.islice(rows(path, form), 2 if form.header else 1))
    if not first:
        raise BagError(f"{path}: is empty")
    if not form.header:
        return [str(number + 1) for number in range(len(first[0][1]))], first[0][1]
    return [name.strip() for name in first[0][1]], first[1][1] if len(first) > 1 else []


def guessed_form(path: Path) -> Form | None:
    """How a file with a header is written, None if it looks like no table.

    A table has at least three columns, as many in its second row as in its first.
    """
    for encoding, delimiter in itertools.product(("utf-8", "utf-16"), DELIMITERS):
        form = Form(delimiter=delimiter, encoding=encoding)
        try:
            head = list(itertools.islice(rows(path, form), 2))
        except BagError:
            continue
        if len(head) == 2 and len(head[0][1]) == len(head[1][1]) >= 3:
            return form
    return None


def decimal_comma(form: Form, values: Sequence[str]) -> bool:
    """Whether a row of values is written with decimal commas."""
    return form.delimiter != "," and any("," in one for one in values)


def _without_comments(lines: Iterator[str], comment: str) -> Iterator[str]:
    """Comments become empty lines, so that the numbers of lines stay."""
    for line in lines:
        yield "\n" if line.lstrip().startswith(comment) else line
