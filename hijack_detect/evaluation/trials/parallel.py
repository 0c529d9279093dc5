# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Runs a function over many flights: here, on several cores, or on a Dask cluster."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import itertools
import logging
import time
import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

from pydantic import TypeAdapter, ValidationError

from hijack_detect import __version__

WRITE_S = 5.0
"""A file is written this long after its first result: the most that is lost with the process.
Chosen, not swept."""


Result = TypeVar("Result")


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
        key = f"{__version__} {self._done} {item!r}"
        return hashlib.sha256(key.encode()).hexdigest()

    def write(self) -> None:
        """Write what waits into a new file, which is whole or not there."""
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


WAITING = 1000
"""Items that are with the scheduler at a time: enough for any cluster, whatever the corpus."""
CONNECT_S = 20.0
"""Timeout. Chosen, not swept."""


class Named(Protocol):
    """Something with a name, such as a case."""

    @property
    def name(self) -> str:
        """Name in reports."""
        ...


@dataclass(frozen=True)
class Failure:
    """An item that the function refused."""

    name: str
    reason: str


@dataclass(frozen=True)
class Pool:
    """Workers for items, and the folder of their results.

    Attributes:
        jobs: How many processes of this machine; with 1 everything runs in this one.
        scheduler: Address of a Dask scheduler instead, such as tcp://10.0.0.1:8786. Its workers
            need the same version of this package and the same paths.
        results: Folder for the results, as Parquet. What is there is not done again.
    """

    jobs: int = 1
    scheduler: str = ""
    results: Path | None = None


HERE = Pool()
Item = TypeVar("Item", bound=Named)


def map_cases(
    function: Callable[[Item], Result],
    items: Sequence[Item],
    *,
    pool: Pool = HERE,
    kind: type[Result] | None = None,
    on_done: Callable[[int], None] | None = None,
) -> list[Result | Failure]:
    """Apply a function to every item; the results are in the order of the items.

    An item for which the function raises ValueError or OSError (a bag that cannot be read, a
    scenario outside its flight) becomes a Failure. Anything else is a defect and stops the run.
    An item whose worker is lost is given to another one; after several it is a Failure too.

    Args:
        function: What to do; other processes must be able to import it, and items and results
            must be picklable.
        items: The items.
        pool: Where to do it.
        kind: Type of the results, a dataclass or pydantic model; needed where they are kept.
        on_done: Called after each item with the number of items that are done.

    Raises:
        ValueError: The scheduler does not answer, or the kept results are of something else.
    """
    report = on_done or (lambda done: None)
    kept = None
    found: dict[int, Result | Failure] = {}
    if pool.results is not None:
        assert kind is not None, "results of an unknown type cannot be kept"
        kept = KeptResults(pool.results, function, kind)
        found.update(kept.of(items))
        report(len(found))
    missing = [index for index in range(len(items)) if index not in found]
    alone = not pool.scheduler and (pool.jobs <= 1 or len(missing) <= 1)
    run = _here if alone else _on_dask
    with contextlib.ExitStack() as stack:
        if kept is not None:
            stack.callback(kept.write)
        for index, result in run(function, items, missing, pool):
            found[index] = result
            if kept is not None and not isinstance(result, Failure):
                kept.add(items[index], result)
            report(len(found))
    return [found[index] for index in range(len(items))]


def _attempt(function: Callable[[Item], Result], item: Item) -> Result | Failure:
    try:
        return function(item)
    except (ValueError, OSError) as error:
        return Failure(item.name, str(error))


def _here(
    function: Callable[[Item], Result], items: Sequence[Item], missing: Sequence[int], _: Pool
) -> Iterator[tuple[int, Result | Failure]]:
    for index in missing:
        yield index, _attempt(function, items[index])


def _on_dask(
    function: Callable[[Item], Result], items: Sequence[Item], missing: Sequence[int], pool: Pool
) -> Iterator[tuple[int, Result | Failure]]:
    """Results as they come in; a few items at a time are with the scheduler."""
    from distributed import as_completed  # noqa: PLC0415  slow to load
    from distributed.scheduler import KilledWorker  # noqa: PLC0415

    run = uuid.uuid4().hex  # the scheduler may know items of these names already
    waiting = iter(missing)
    index_of: dict[Any, int] = {}
    with _client(pool, len(missing)) as client:

        def submit(count: int) -> list[Any]:
            futures = []
            for index in itertools.islice(waiting, count):
                key = f"{items[index].name} {index} {run}"
                futures.append(client.submit(_attempt, function, items[index], key=key, pure=False))
                index_of[key] = index
            return futures

        ready = as_completed(submit(WAITING))
        for future in ready:
            index = index_of.pop(future.key)
            try:
                result = future.result()
            except KilledWorker as error:
                result = Failure(items[index].name, f"every worker that tried it died: {error}")
            future.release()
            ready.update(submit(1))
            yield index, result


@contextlib.contextmanager
def _client(pool: Pool, most: int) -> Iterator[Any]:
    """A client of the cluster, or of processes on this machine that end with the block."""
    from distributed import Client, LocalCluster  # noqa: PLC0415  slow to load

    if pool.scheduler:
        try:
            client = Client(pool.scheduler, timeout=CONNECT_S)
        except (OSError, ValueError) as error:
            raise ValueError(f"{pool.scheduler}: no Dask scheduler answers there") from error
        with client:
            yield client
        return
    with (
        LocalCluster(
            n_workers=min(pool.jobs, most),
            threads_per_worker=1,
            processes=True,
            memory_limit=0,
            dashboard_address="127.0.0.1:0",
            silence_logs=logging.CRITICAL,
        ) as cluster,
        Client(cluster) as client,
    ):
        yield client
