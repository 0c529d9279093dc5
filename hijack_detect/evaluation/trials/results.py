# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Results of a long run, kept as Parquet while it goes on, so that it can be taken up again."""

from __future__ import annotations

import functools
import hashlib
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Generic, TypeVar

from pydantic import TypeAdapter, ValidationError

from hijack_detect import __version__

Result = TypeVar("Result")
WRITE_S = 5.0
"""A file is written this long after its first result: so much work is lost with the process."""


class KeptResults(Generic[Result]):
    """A folder of Parquet files with one row for each result: `key`, `name` and `result` as JSON.

    The key is a hash of the item and of what is done with it, parameters included, and of the
    version. Another run with the same folder finds its own results by it, and leaves others alone.
    """

    def __init__(self, folder: Path, function: Callable[..., Result], kind: type[Result]) -> None:
        """Read what is there.

        Args:
            folder: The folder; made if it is not there.
            function: What is done with each item: a function, or a `partial` of one.
            kind: Type of the results.

        Raises:
            ValueError: The folder or a file in it cannot be used.
        """
        self._folder, self._adapter = folder, TypeAdapter(kind)
        self._done = described(function)
        self._waiting: list[dict[str, str]] = []
        self._since = 0.0
        self._kept = self._read()

    def _read(self) -> Mapping[str, str]:
        try:
            import pyarrow as pa  # noqa: PLC0415  large, and seldom needed
            import pyarrow.parquet as pq  # noqa: PLC0415
        except ImportError as error:
            raise ValueError(f"{error}: to keep results, install the extra 'corpora'") from error
        kept: dict[str, str] = {}
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            for path in sorted(self._folder.glob("*.parquet")):
                rows = pq.read_table(path, columns=["key", "result"]).to_pydict()
                kept.update(zip(rows["key"], rows["result"], strict=True))
        except (OSError, pa.ArrowException, KeyError) as error:
            raise ValueError(f"{self._folder}: results cannot be kept there: {error}") from error
        return kept

    def of(self, items: Sequence[Any]) -> dict[int, Result]:
        """The results that are there, by index of the item.

        Raises:
            ValueError: A result cannot be read.
        """
        found = {}
        for index, item in enumerate(items):
            text = self._kept.get(self._key(item))
            if text is not None:
                try:
                    found[index] = self._adapter.validate_json(text)
                except ValidationError as error:
                    raise ValueError(f"{self._folder}: {item.name}: {error}") from error
        return found

    def add(self, item: Any, result: Result) -> None:
        """Keep a result."""
        text = self._adapter.dump_json(result).decode()
        self._waiting.append({"key": self._key(item), "name": item.name, "result": text})
        now = time.monotonic()
        if len(self._waiting) == 1:
            self._since = now
        if now - self._since >= WRITE_S:
            self.write()

    def _key(self, item: Any) -> str:
        told = f"{__version__} {self._done} {item!r}"
        return hashlib.sha256(told.encode()).hexdigest()

    def write(self) -> None:
        """Write what waits into a file of its own, which is whole or not there."""
        import pyarrow as pa  # noqa: PLC0415
        import pyarrow.parquet as pq  # noqa: PLC0415

        if not self._waiting:
            return
        path = self._folder / f"{self._waiting[0]['key'][:16]}.parquet"
        part = path.with_suffix(".part")
        pq.write_table(pa.Table.from_pylist(self._waiting), part)
        part.replace(path)
        self._waiting = []


def described(function: Callable[..., Any]) -> str:
    """A function and the arguments bound to it, in words that are the same in every process."""
    if isinstance(function, functools.partial):
        return f"{described(function.func)} {function.args!r} {function.keywords!r}"
    return f"{function.__module__}.{function.__qualname__}"
