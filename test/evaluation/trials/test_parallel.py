"""Many cases on several cores: in order, and failures by name."""

from __future__ import annotations

import time
from dataclasses import dataclass

import pytest

from hijack_detect.evaluation.trials.parallel import Failure, map_cases


@dataclass(frozen=True)
class Number:
    value: float

    @property
    def name(self) -> str:
        return f"number {self.value:g}"


def inverse(number: Number) -> float:
    # The first ones take longest.
    time.sleep(0.05 / (1.0 + abs(number.value)))
    if number.value < 0.0:
        raise ValueError("is negative")
    return 1.0 / number.value


NUMBERS = [Number(value) for value in (1.0, 2.0, -1.0, 4.0)]


@pytest.mark.parametrize("jobs", [1, 2])
def test_results_are_in_order_and_failures_have_names(jobs: int) -> None:
    told: list[int] = []
    found = map_cases(inverse, NUMBERS, jobs=jobs, on_done=told.append)
    assert found == [1.0, 0.5, Failure("number -1", "is negative"), 0.25]
    assert told == [1, 2, 3, 4]


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_defect_is_no_failure(jobs: int) -> None:
    with pytest.raises(ZeroDivisionError):
        map_cases(inverse, [Number(1.0), Number(0.0)], jobs=jobs)


def test_nothing_to_do() -> None:
    assert map_cases(inverse, [], jobs=2) == []
