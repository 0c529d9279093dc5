# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A replay as text: alerts, changes of state, and the scores every two seconds."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from hijack_detect.bags.reader import BagReader
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.replay.offline import OfflineRun, run_offline
from hijack_detect.spoofing.scenario import load_scenario
from hijack_detect.streams.samples import NANOSECONDS

ROOT = Path(__file__).parents[2]
HERE = Path(__file__).parent
EVERY_NS = 2 * NANOSECONDS
Write = Callable[[float], str]


@dataclass(frozen=True)
class Replay:
    """A bag of the package, one of its scenarios or none, and a policy."""

    bag: str
    scenario: str | None
    policy: str

    @property
    def name(self) -> str:
        """Name of its file."""
        return f"{self.bag}-{self.scenario or 'clean'}-{self.policy}"

    @property
    def path(self) -> Path:
        """Where the text is kept."""
        return HERE / f"{self.name}.txt"

    def run(self) -> OfflineRun:
        """Run it through the monitor."""
        attack = None
        if self.scenario is not None:
            attack = load_scenario(ROOT / f"config/scenarios/{self.scenario}.yaml")
        with BagReader(ROOT / "bags" / self.bag) as reader:
            return run_offline(reader, policy_parameters(self.policy), attack)


REPLAYS = (
    Replay("curved_8", "carry_off", "default"),
    Replay("curved_8", "turn_away", "paper"),
    Replay("straight_3", "jump", "default"),
    Replay("curved_no_velocity_5", None, "default"),
)


def rounded(value: float) -> str:
    """Six digits: what no processor's arithmetic changes, and no change of the code keeps."""
    return f"{value:.6g}"


def transcript(run: OfflineRun, number: Write = rounded) -> str:
    """A replay as lines.

    Args:
        run: Outputs.
        number: Writes a score; `repr` keeps every bit.
    """
    return "\n".join(_lines(run, number)) + "\n"


def digest(run: OfflineRun) -> str:
    """A hash of every bit of every verdict and result."""
    outputs = [*run.verdicts.items(), ("fusion", run.results)]
    return hashlib.sha256(repr(outputs).encode()).hexdigest()


def _lines(run: OfflineRun, number: Write) -> Iterator[str]:
    alerted = False
    for one in run.results:
        if one.alert != alerted:
            alerted = one.alert
            yield f"{one.stamp_ns} alert {str(alerted).lower()}: {' '.join(one.causes)}"
    for name, verdicts in run.verdicts.items():
        state = None
        for verdict in verdicts:
            if verdict.state is not state:
                state = verdict.state
                yield f"{verdict.stamp_ns} {name} {state.value}"
    yield " ".join(["stamp_ns", "fusion", *run.verdicts])
    rows: dict[int, list[str]] = {}
    columns = [[(one.stamp_ns, one.confidence) for one in run.results]]
    columns += [[(one.stamp_ns, one.score) for one in own] for own in run.verdicts.values()]
    for place, column in enumerate(columns):
        for stamp_ns, score in column:
            row = rows.setdefault(stamp_ns // EVERY_NS, ["-"] * len(columns))
            if row[place] == "-":
                row[place] = number(score)
    for at, row in sorted(rows.items()):
        yield " ".join([str(at * EVERY_NS), *row])
