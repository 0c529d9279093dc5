"""Every flight of a folder, clean and attacked by a fake track at three onsets: a table.

    python benchmarks/flights.py FOLDER [--policy paper] [--policy default] [--match quad]

The onsets are the first seconds of the longest piece of forward flight and one and two thirds
into it, so they do not depend on any detector. Prints Markdown.
"""

from __future__ import annotations

import math
from collections import Counter
from multiprocessing import Pool
from pathlib import Path

import click

from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.samples import Rejected, read_samples
from hijack_detect.bags.topics import topic_map
from hijack_detect.evaluation.offline import OfflineRun, run_offline
from hijack_detect.evaluation.outcome import Attack, detector_outcome
from hijack_detect.evaluation.policies import policy_parameters
from hijack_detect.spoofing.scenario import load_scenario
from hijack_detect.streams.samples import NANOSECONDS, VelocitySample

SCENARIO = Path(__file__).parent.parent / "config/scenarios/turn_away_track.yaml"
ATTACK_S = 30.0
FORWARD_SPEED = 3.0
PAUSE_S = 2.0
HEADER = """\
| flight | attack at | corr. false alarms | first after | DATE false alarms | first after | alert |
|---|---|---|---|---|---|---|"""


def forward_flight(reader: BagReader) -> tuple[float, float]:
    """Start and end of the longest piece of flight above 3 m/s, seconds; stops under 2 s count."""
    best, begin, last = (0.0, 0.0), None, 0.0
    topics = topic_map("auto", reader.topics)
    for _, sample in read_samples(reader, topics, on_rejected=Rejected().add):
        if not isinstance(sample, VelocitySample):
            continue
        t = (sample.stamp_ns - reader.start_ns) / NANOSECONDS
        if math.hypot(*sample.velocity[:2]) > FORWARD_SPEED:
            if begin is None or t - last > PAUSE_S:
                begin = t
            last = t
            best = max(best, (begin, last), key=lambda span: span[1] - span[0])
    return best


def told(run: OfflineRun, attack: Attack | None) -> str:
    """One row's cells: false alarms and reaction of each detector, then the alert."""
    cells = []
    for verdicts in run.verdicts.values():
        outcome = detector_outcome(verdicts, attack)
        cells.append(str(outcome.false_alarms))
        if attack is not None:
            first = outcome.first_alarm_ns
            inside = first is not None and attack.end_ns is not None and first < attack.end_ns
            cells.append(f"{(first - attack.onset_ns) / NANOSECONDS:.1f} s" if inside else "–")
    alert = run.results[-1].alert_since_ns if run.results else None
    if alert is None:
        cells.append("–")
    elif attack is None:
        cells.append(f"false, {(alert - run.start_ns) / NANOSECONDS:.1f} s")
    elif alert < attack.onset_ns:
        cells.append(f"false, {(attack.onset_ns - alert) / NANOSECONDS:.1f} s before")
    elif attack.end_ns is not None and alert < attack.end_ns:
        late = (alert - attack.onset_ns) / NANOSECONDS
        cells.append(f"{late:.1f} s, {run.separation_at(alert):.0f} m")
    else:
        cells.append("–")
    return " | ".join(cells)


def states(run: OfflineRun) -> str:
    """Share of the verdicts in each state, of the correlation detector."""
    counts = Counter(v.state.value for v in run.verdicts["correlation"])
    total = sum(counts.values()) or 1
    return ", ".join(f"{name} {100 * n / total:.0f} %" for name, n in counts.most_common())


def flight(job: tuple[Path, str]) -> list[str]:
    """Rows of one flight under one policy."""
    path, policy = job
    parameters = policy_parameters(policy)
    with BagReader(path) as reader:
        clean = run_offline(reader, parameters)
        rows = [f"| {path.name} | clean | {told(clean, None)} | {states(clean)} |"]
        begin, end = forward_flight(reader)
        for third in range(3):
            onset = begin + third * (end - begin) / 3
            scenario = load_scenario(SCENARIO).moved_to(round(onset, 1))
            if onset + ATTACK_S > reader.duration_s or end - begin < 1.0:
                rows.append(f"| {path.name} | no room for an attack at {onset:.0f} s | | | | | | |")
                continue
            start = reader.start_ns + round(scenario.segments[0].start_s * NANOSECONDS)
            attack = Attack(start, start + round(ATTACK_S * NANOSECONDS))
            run = run_offline(reader, parameters, scenario)
            rows.append(f"| {path.name} | {onset:.1f} s | {told(run, attack)} | |")
    return rows


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--policy", "policies", multiple=True, default=["paper", "default"])
@click.option("--match", default="", help="Only flights whose name contains this.")
def main(folder: Path, policies: tuple[str, ...], match: str) -> None:
    """Print the tables."""
    paths = sorted(p for p in folder.iterdir() if p.is_dir() and match in p.name)
    with Pool() as pool:
        for policy in policies:
            print(f"\n### Policy `{policy}`\n")
            print(HEADER)
            for rows in pool.imap(flight, [(path, policy) for path in paths]):
                print("\n".join(rows), flush=True)


if __name__ == "__main__":
    main()
