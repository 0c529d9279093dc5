# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Runs behind docs/detection-limits.md: pieces of work whose records are kept as JSON.

A piece is made only if its file is not there, so a stopped run goes on where it was, and a larger
scale adds pieces. The records are of the code that made them: begin with an empty folder after a
change of any detector, threshold or attack.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from experiments.limits_records import FlightRecord, record_case, record_forked
from hijack_detect.evaluation.trials.cases import HIJACKED, BagCase, Case, SimulatedCase
from hijack_detect.evaluation.trials.corpus import corpus_cases
from hijack_detect.evaluation.trials.families import ACCELERATIONS, CLEAN, SPEEDS
from hijack_detect.evaluation.trials.limits import FLIGHTS, limits
from hijack_detect.evaluation.trials.parallel import Failure, Pool, map_cases
from hijack_detect.evaluation.tuning.attack_map import FIRST_SEED, attack_cases, attack_sizes
from hijack_detect.evaluation.tuning.attack_map import FLIGHTS as CELL_FLIGHTS
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.replay.truth import read_label
from tools.documents import write

PARTS = {"a": "recorded", "b": "sitl", "c": "simulated", "d": "map"}
"""Folders of the records by letter of the part."""


@dataclass(frozen=True)
class Work:
    """Flights that are run one after another and kept in one file.

    Attributes:
        name: Name of the file, and what it is called in messages.
        part: One of PARTS.
        cases: The flights.
        size: Of the attacks: family, words and numbers; None leaves it to the flight.
    """

    name: str
    part: str
    cases: tuple[Case, ...]
    size: tuple[str, str, dict[str, float]] | None = None

    def path(self, results: Path) -> Path:
        """Where its records are."""
        return results / PARTS[self.part] / f"{self.name.replace('/', '_')}.json"


def works(part: str, flights: Path, scale: int) -> Iterator[Work]:
    """The work of a part.

    Args:
        part: One of PARTS.
        flights: Folder with the folders `bags` and `sitl`.
        scale: How many times 30 flights of each simulated class, and 6 of each cell of the map.
    """
    if part == "a":
        yield from (Work(case.name, part, (case,)) for case in corpus_cases(flights / "bags"))
    elif part == "b":
        yield from (Work(case.name, part, (case,)) for case in corpus_cases(flights / "sitl"))
    elif part == "c":
        yield from _simulated(scale)
    else:
        for speed, gain in attack_sizes(SPEEDS, ACCELERATIONS):
            for number in range(scale):
                cases = attack_cases(
                    speed, gain, CELL_FLIGHTS, first_seed=FIRST_SEED + number * CELL_FLIGHTS
                )
                words = f"{gain:g} m/s² to {speed:g} m/s"
                size = ("drift", words, {"acceleration": gain, "speed": speed})
                yield Work(f"drift_{speed:g}_{gain:g}_{number:03}", part, tuple(cases), size)


def _simulated(scale: int) -> Iterator[Work]:
    """The flights of the protocol `limits`, cut so that no piece depends on the scale."""
    by_kind: dict[str, list[SimulatedCase]] = {}
    for case in limits(scale):
        by_kind.setdefault(case.kind, []).append(case)
    for kind, cases in by_kind.items():
        length = FLIGHTS // 2 if kind.startswith("clean") else FLIGHTS
        for number in range(scale):
            piece = cases[number * length : (number + 1) * length]
            yield Work(f"{kind}_{number:03}", "c", tuple(piece))


def run(
    wanted: Sequence[Work],
    results: Path,
    parameters: MonitorParameters,
    *,
    jobs: int,
    moving: int,
    any_phase: int,
    on_done: Callable[[int], None],
) -> list[Failure]:
    """Do the work that has not been done; return what failed, of which nothing is kept."""
    function = partial(do, results, parameters, moving, any_phase)
    missing = [work for work in wanted if not work.path(results).is_file()]
    on_done(len(wanted) - len(missing))
    done = map_cases(
        function,
        missing,
        pool=Pool(jobs),
        on_done=lambda count: on_done(len(wanted) - len(missing) + count),
    )
    return [result for result in done if isinstance(result, Failure)]


def do(
    results: Path, parameters: MonitorParameters, moving: int, any_phase: int, work: Work
) -> None:
    """Do a piece of work and keep its records."""
    records = [record_of(work, case, parameters, moving, any_phase) for case in work.cases]
    data = [record.model_dump(mode="json") for record in records]
    write(work.path(results), json.dumps(data, separators=(",", ":")) + "\n")


def record_of(
    work: Work, case: Case, parameters: MonitorParameters, moving: int, any_phase: int
) -> FlightRecord:
    """The record of one of the flights of a piece of work, see `run`."""
    if isinstance(case, BagCase) and work.part == "a":
        return record_forked(parameters, case, moving=moving, any_phase=any_phase)
    record = record_case(parameters, case)
    size = _labelled(case) if isinstance(case, BagCase) else work.size
    if size is None or not record.attacks:
        return record
    family, words, figures = size
    change = {"family": family, "size": words, "figures": figures}
    attacks = [attack.model_copy(update=change) for attack in record.attacks]
    return record.model_copy(update={"attacks": attacks})


def _labelled(case: BagCase) -> tuple[str, str, dict[str, float]] | None:
    """The attack of a flight's label."""
    label = read_label(case.path) if case.kind == HIJACKED else None
    if label is None:
        return None
    attack = label["attack"]
    figures = {name: float(value) for name, value in attack["params"].items()}
    return attack["kind"], ", ".join(f"{k} {v:g}" for k, v in figures.items()), figures


def load(results: Path, part: str) -> list[FlightRecord]:
    """All records of a part that are there, in order of name, see `credited`."""
    paths = sorted((results / PARTS[part]).glob("*.json"))
    return [
        credited(FlightRecord.model_validate(one))
        for path in paths
        for one in json.loads(path.read_text(encoding="utf-8"))
    ]


def credited(record: FlightRecord) -> FlightRecord:
    """The record without alarms that the clean flight has as early: they are no merit."""
    chance = {one.onset_s: one.methods for one in record.attacks if one.family == CLEAN}
    attacks = []
    for one in record.attacks:
        methods = dict(one.methods)
        for name, clean in chance.get(one.onset_s, {}).items():
            alarm_s, by_chance_s = methods[name].alarm_s, clean.alarm_s
            late = None not in (alarm_s, by_chance_s) and alarm_s >= by_chance_s
            if late and one.family != CLEAN:
                nothing = {"alarm_s": None, "separation_m": None}
                methods[name] = methods[name].model_copy(update=nothing)
        attacks.append(one.model_copy(update={"methods": methods}))
    return record.model_copy(update={"attacks": attacks})


def halves(names: Sequence[str]) -> tuple[list[str], list[str]]:
    """Flights in two halves, by turns in order of name.

    Thresholds that were chosen on flights of one half are judged on the other.
    """
    ordered = sorted(set(names))
    return ordered[::2], ordered[1::2]


def by_half(records: Sequence[FlightRecord]) -> dict[str, list[FlightRecord]]:
    """The records of each half, `A` and `B`."""
    names = halves([record.name for record in records])
    return {
        half: [record for record in records if record.name in own]
        for half, own in zip("AB", names, strict=True)
    }
