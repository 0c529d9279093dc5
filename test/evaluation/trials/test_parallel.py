# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Many cases on several cores or a cluster: in order, failures by name, nothing lost or twice."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import psutil
import pytest

from hijack_detect.evaluation.scores.model import Model
from hijack_detect.evaluation.trials.parallel import Failure, Pool, map_cases

pytest.importorskip("distributed", reason="the extra analysis is not installed")
pytest.importorskip("pyarrow", reason="the extra corpora is not installed")

HERE = Path(__file__).parent
START_S = 60.0


@dataclass(frozen=True)
class Number:
    value: float

    @property
    def name(self) -> str:
        return f"number {self.value:g}"


class Inverse(Model):
    of: float
    value: float


def inverse(number: Number) -> float:
    # The first ones take longest.
    time.sleep(0.05 / (1.0 + abs(number.value)))
    if number.value < 0.0:
        raise ValueError("is negative")
    return 1.0 / number.value


def noted(folder: Path, wait_s: float, number: Number) -> Inverse:
    """Leave a trace of each time that it begins and ends."""
    unique = f"{number.value:g} {os.getpid()} {time.monotonic_ns()}"
    (folder / f"begun {unique}").touch()
    time.sleep(wait_s)
    (folder / f"ended {unique}").touch()
    return Inverse(of=number.value, value=1.0 / number.value)


def deadly(number: Number) -> float:
    if number.value == 2.0:
        os.kill(os.getpid(), signal.SIGKILL)
    return number.value


def traces(folder: Path, what: str) -> list[str]:
    return sorted(path.name.split()[1] for path in folder.glob(f"{what} *"))


NUMBERS = [Number(value) for value in (1.0, 2.0, -1.0, 4.0)]
MANY = [Number(float(value)) for value in range(1, 21)]


@pytest.mark.parametrize("jobs", [1, 2])
def test_results_are_in_order_and_failures_have_names(jobs: int) -> None:
    told: list[int] = []
    found = map_cases(inverse, NUMBERS, pool=Pool(jobs), on_done=told.append)
    assert found == [1.0, 0.5, Failure("number -1", "is negative"), 0.25]
    assert told == [1, 2, 3, 4]


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_defect_is_no_failure(jobs: int) -> None:
    with pytest.raises(ZeroDivisionError):
        map_cases(inverse, [Number(1.0), Number(0.0)], pool=Pool(jobs))


def test_nothing_to_do() -> None:
    assert map_cases(inverse, [], pool=Pool(2)) == []


def test_no_process_is_left() -> None:
    before = set(psutil.Process().children(recursive=True))
    map_cases(inverse, NUMBERS, pool=Pool(2))
    left = set(psutil.Process().children(recursive=True)) - before
    assert not [one for one in left if "resource_tracker" not in " ".join(one.cmdline())]


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_second_run_does_only_what_is_missing(tmp_path: Path, jobs: int) -> None:
    notes, pool = tmp_path / "notes", Pool(jobs, results=tmp_path / "results")
    notes.mkdir()
    work = partial(noted, notes, 0.0)
    first = map_cases(work, MANY[:3], pool=pool, kind=Inverse)
    told: list[int] = []
    second = map_cases(work, MANY[:6], pool=pool, kind=Inverse, on_done=told.append)
    assert second[:3] == first
    assert [one.of for one in second if isinstance(one, Inverse)] == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    assert traces(notes, "begun") == sorted("123456")
    assert told == [3, 4, 5, 6]


def test_results_of_other_parameters_are_not_taken(tmp_path: Path) -> None:
    pool = Pool(results=tmp_path / "results")
    notes = tmp_path / "notes"
    notes.mkdir()
    map_cases(partial(noted, notes, 0.0), MANY[:2], pool=pool, kind=Inverse)
    map_cases(partial(noted, notes, 0.001), MANY[:2], pool=pool, kind=Inverse)
    assert traces(notes, "begun") == ["1", "1", "2", "2"]


def test_what_was_done_is_kept_when_the_run_is_broken_off(tmp_path: Path) -> None:
    pool = Pool(results=tmp_path / "results")

    def stop(done: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    work = partial(noted, tmp_path, 0.0)
    with pytest.raises(KeyboardInterrupt):
        map_cases(work, MANY[:5], pool=pool, kind=Inverse, on_done=stop)
    assert len(map_cases(work, MANY[:5], pool=pool, kind=Inverse)) == 5
    assert traces(tmp_path, "begun") == ["1", "2", "3", "4", "5"]


def test_results_can_be_read_by_anyone(tmp_path: Path) -> None:
    import pyarrow.parquet as pq  # noqa: PLC0415

    folder = tmp_path / "results"
    map_cases(partial(noted, tmp_path, 0.0), MANY[:2], pool=Pool(results=folder), kind=Inverse)
    rows = pq.read_table(folder).to_pylist()
    assert [row["name"] for row in rows] == ["number 1", "number 2"]
    assert Inverse.model_validate_json(rows[1]["result"]) == Inverse(of=2.0, value=0.5)


def test_a_folder_of_something_else_is_refused(tmp_path: Path) -> None:
    (tmp_path / "own.parquet").write_text("no Parquet")
    pool = Pool(results=tmp_path)
    with pytest.raises(ValueError, match=f"{tmp_path}: results cannot be kept there"):
        map_cases(partial(noted, tmp_path, 0.0), MANY[:2], pool=pool, kind=Inverse)


@dataclass
class Cluster:
    address: str
    workers: list[subprocess.Popen[bytes]]


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    """A scheduler and two workers, as an operator starts them."""
    file = tmp_path / "scheduler.json"
    begun: list[subprocess.Popen[bytes]] = []

    def start(what: str, *arguments: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "distributed.cli.dask_" + what, *arguments]
        environment = {**os.environ, "PYTHONPATH": str(HERE)}
        begun.append(
            subprocess.Popen(
                command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
            )
        )
        return begun[-1]

    start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
          "--scheduler-file", str(file))  # fmt: skip
    wait_for(file.exists)
    own = ("--scheduler-file", str(file), "--nthreads", "1", "--no-nanny", "--no-dashboard",
           "--local-directory", str(tmp_path))  # fmt: skip
    workers = [start("worker", *own) for _ in range(2)]
    yield Cluster(address_in(file), workers)
    for process in reversed(begun):
        process.kill()
        process.wait()


def address_in(file: Path) -> str:
    return str(json.loads(file.read_text())["address"])


def wait_for(condition: Callable[[], Any]) -> None:
    deadline = time.monotonic() + START_S
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.02)


@pytest.mark.slow
def test_a_lost_worker_loses_nothing_and_counts_nothing_twice(
    cluster: Cluster, tmp_path: Path
) -> None:
    notes = tmp_path / "notes"
    notes.mkdir()
    killed: list[str] = []

    def kill_one(done: int) -> None:
        if done == 5:
            cluster.workers[0].kill()
            killed.append("now")

    found = map_cases(
        partial(noted, notes, 0.2),
        MANY,
        pool=Pool(scheduler=cluster.address, results=tmp_path / "results"),
        kind=Inverse,
        on_done=kill_one,
    )
    assert killed
    assert [one.of for one in found if isinstance(one, Inverse)] == [n.value for n in MANY]
    pids = {path.name.split()[2] for path in notes.glob("begun *")}
    assert len(pids) == 2  # both have worked
    again = map_cases(
        partial(noted, notes, 0.2), MANY, pool=Pool(results=tmp_path / "results"), kind=Inverse
    )
    assert again == found


@pytest.mark.slow
def test_an_item_that_kills_its_workers_is_a_failure() -> None:
    found = map_cases(deadly, MANY[:3], pool=Pool(2))
    assert found[0] == 1.0
    assert isinstance(found[1], Failure)
    assert found[1].name == "number 2"
    assert "every worker that tried it died" in found[1].reason
    assert found[2] == 3.0


def test_a_scheduler_that_is_not_there_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hijack_detect.evaluation.trials.parallel.CONNECT_S", 0.5)
    with pytest.raises(ValueError, match=r"tcp://127\.0\.0\.1:9: no Dask scheduler answers there"):
        map_cases(inverse, NUMBERS, pool=Pool(scheduler="tcp://127.0.0.1:9"))
