# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Runs a function over many flights: here, on several cores, or on a Dask cluster."""

from __future__ import annotations

import contextlib
import itertools
import logging
import uuid
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, TypeVar

from hijack_detect.evaluation.trials.results import KeptResults

WAITING = 1000
"""Items that are with the scheduler at a time: enough for any cluster, whatever the corpus."""
CONNECT_S = 20.0


class Named(Protocol):
    """Something with a name, such as a case."""

    @property
    def name(self) -> str:
        """What it is called in reports."""
        ...


@dataclass(frozen=True)
class Failure:
    """An item that the function refused."""

    name: str
    reason: str


@dataclass(frozen=True)
class Pool:
    """Where items are worked on, and where the results are kept.

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
Result = TypeVar("Result")


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
    tell = on_done or (lambda done: None)
    kept = None
    found: dict[int, Result | Failure] = {}
    if pool.results is not None:
        assert kind is not None, "results of an unknown type cannot be kept"
        kept = KeptResults(pool.results, function, kind)
        found.update(kept.of(items))
        tell(len(found))
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
            tell(len(found))
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
