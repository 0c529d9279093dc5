# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Every flight of a folder, clean and attacked by a fake track at three onsets: tables.

    python -m experiments.flights FOLDER [--match quad]

The attack is config/scenarios/turn_away_track.yaml. Its onsets are the start of the longest
piece of forward flight and one and two thirds into it, so they depend on no detector; attacks
that the flight's end would cut off are left out. Prints Markdown for the policy `paper`, and for
every false alarm of its correlation the verdict of the correlation with default parameters at the
same stamp, which is its cause.
"""

from __future__ import annotations

import re
import statistics
from collections import Counter
from collections.abc import Iterator
from multiprocessing import Pool
from pathlib import Path
from typing import Any

import click

from hijack_detect.bags.reader import BagReader
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.evaluation.scores.metrics import Proportion
from hijack_detect.evaluation.trials.onsets import forward_flight
from hijack_detect.monitor.parts import PUBLISHED
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.replay.offline import OfflineRun, run_offline
from hijack_detect.replay.truth import (
    Attack,
    alert_is_right,
    changes,
    detector_outcome,
)
from hijack_detect.spoofing.scenario import load_scenario
from hijack_detect.streams.samples import NANOSECONDS

SCENARIO = Path(__file__).parent.parent / "config/scenarios/turn_away_track.yaml"
ATTACK_S = 30.0
"""As in the experiment of Feng 2018."""
POLICY = "paper"
CLEAN = "| flight | s | correlation alarms | DATE alarms | alert at s |\n|---|---|---|---|---|"
ATTACKED = (
    "| flight | onset s | false before: correlation, DATE | correlation after | DATE after "
    "| alert after | off by |\n|---|---|---|---|---|---|---|"
)
CAUSES = "| flight | false alarms | cause |\n|---|---|---|"


def longest_forward_flight(reader: BagReader) -> tuple[float, float]:
    """Start and end of the longest forward flight, s."""
    spans = forward_flight(reader)
    return max(spans, key=lambda span: span[1] - span[0], default=(0.0, 0.0))


def alert_of(run: OfflineRun) -> int | None:
    """Stamp of the alert, ns."""
    return run.results[-1].alert_since_ns if run.results else None


def clean_row(name: str, reader: BagReader, run: OfflineRun) -> str:
    """Line of a flight without attack."""
    alarms = [detector_outcome(run.verdicts[one], None).false_alarms for one in PUBLISHED]
    alert = alert_of(run)
    at = "–" if alert is None else f"**{(alert - run.start_ns) / NANOSECONDS:.1f}**"
    return f"| {name} | {reader.duration_s:.0f} | {alarms[0]} | {alarms[1]} | {at} |"


def attacked_row(name: str, run: OfflineRun, attack: Attack) -> str:
    """Line of one attack."""
    assert attack.end_ns is not None
    outcomes = [detector_outcome(run.verdicts[one], attack) for one in PUBLISHED]
    false = ", ".join(str(outcome.false_alarms) for outcome in outcomes)
    first = [
        f"{(stamp - attack.onset_ns) / NANOSECONDS:.1f} s"
        if (stamp := outcome.first_alarm_ns) is not None and stamp < attack.end_ns
        else "–"
        for outcome in outcomes
    ]
    alert = alert_of(run)
    after, off = "**missed**", ""
    if alert is not None and alert < attack.onset_ns:
        after = f"**false, {(attack.onset_ns - alert) / NANOSECONDS:.1f} s before**"
    elif alert is not None and alert < attack.end_ns:
        after = f"{(alert - attack.onset_ns) / NANOSECONDS:.1f} s"
        off = f"{run.separation_at(alert):.0f} m"
    onset = (attack.onset_ns - run.start_ns) / NANOSECONDS
    return f"| {name} | {onset:.1f} | {false} | {first[0]} | {first[1]} | {after} | {off} |"


def attacks(name: str, reader: BagReader) -> Iterator[tuple[str, float | None]]:
    """Line of each of the three attacks, and seconds from onset to alert if it was right."""
    begin, end = longest_forward_flight(reader)
    for third in range(3):
        onset = round(begin + third * (end - begin) / 3, 1)
        if onset + ATTACK_S > reader.duration_s:
            continue
        scenario = load_scenario(SCENARIO).moved_to(onset)
        start = reader.start_ns + round(onset * NANOSECONDS)
        attack = Attack(start, start + round(ATTACK_S * NANOSECONDS))
        run = run_offline(reader, policy_parameters(POLICY), scenario)
        alert = alert_of(run)
        right = alert is not None and alert_is_right(alert, attack)
        late = (alert - attack.onset_ns) / NANOSECONDS if alert is not None and right else None
        yield attacked_row(name, run, attack), late


def causes(paper: OfflineRun, default: OfflineRun) -> str:
    """Verdict of the default set where the published correlation starts a false alarm."""
    at = {verdict.stamp_ns: verdict for verdict in default.verdicts["correlation"]}
    begun = [
        at[stamp]
        for stamp, state in changes(paper.verdicts["correlation"])
        if state is State.ALARM and stamp in at
    ]
    counts = Counter(cause(verdict) for verdict in begun)
    reasons = "; ".join(f"{text} ({count})" for text, count in counts.most_common())
    return f"{len(begun)} | {reasons}"


def cause(verdict: Verdict) -> str:
    """A verdict's reason without its figures."""
    if verdict.state not in (State.NOT_OBSERVABLE, State.NOT_READY):
        return f"{verdict.state.value} once crab angle and lag are taken off"
    return re.sub(r"[-+]?[0-9.]+ ?[s°]?", "…", verdict.reason)


def summary(times: list[float | None]) -> str:
    """Attacks found, with the exact 95 % interval of Clopper and Pearson, and how soon."""
    found = [time for time in times if time is not None]
    if not times or not found:
        return f"{len(found)} of {len(times)} attacks found."
    part = Proportion.of(len(found), len(times))
    assert part.ratio is not None
    assert part.low is not None
    assert part.high is not None
    return (
        f"{part.count} of {part.total} attacks found ({100 * part.ratio:.0f} %, "
        f"95 % interval {100 * part.low:.0f}–{100 * part.high:.0f} %), after "
        f"{statistics.median(found):.1f} s at the median and {max(found):.1f} s at most."
    )


def flight(path: Path) -> dict[str, list[Any]]:
    """All lines of one flight by table, and times to alert."""
    with BagReader(path) as reader:
        paper = run_offline(reader, policy_parameters(POLICY))
        default = run_offline(reader, policy_parameters("default"))
        lines = list(attacks(path.name, reader))
        return {
            "clean": [clean_row(path.name, reader, paper)],
            "attacked": [line for line, _ in lines],
            "times": [time for _, time in lines],
            "causes": [f"| {path.name} | {causes(paper, default)} |"],
        }


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--match", multiple=True, default=[""], help="Only flights with this in the name.")
def main(folder: Path, match: tuple[str, ...]) -> None:
    """Print the tables."""
    wanted = (p for p in folder.iterdir() if any(part in p.name for part in match))
    paths = sorted(p for p in wanted if p.is_dir())
    with Pool() as pool:
        flights = pool.map(flight, paths, chunksize=1)
    for kind, header in (("clean", CLEAN), ("attacked", ATTACKED)):
        print(f"\n### {kind.capitalize()}, policy `{POLICY}`\n\n{header}")
        print("\n".join(row for rows in flights for row in rows[kind]))
    print("\n" + summary([time for rows in flights for time in rows["times"]]))
    print(f"\n### Causes of the published correlation's false alarms\n\n{CAUSES}")
    print("\n".join(row for rows in flights for row in rows["causes"]))


if __name__ == "__main__":
    main()
