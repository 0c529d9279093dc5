# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Figures of Feng et al. 2018, redrawn from simulated flights: PNG files.

    python -m experiments.figures docs/figures

The flights are the first ones of the protocol `feng2018` that show what the paper's figure shows;
each file's title names its flight. Parameters are those of the policy `paper`. Figures 16 and 17
come from `hijack-detect sweep`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import click
import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes

from hijack_detect.detectors.correlation import CorrelationDetector, CorrelationParameters
from hijack_detect.detectors.date import DateDetector, DateParameters
from hijack_detect.detectors.ins_position import InsPosition, InsPositionParameters
from hijack_detect.detectors.verdict import JUDGED, State, Verdict
from hijack_detect.estimation.geodesy import LocalFrame
from hijack_detect.estimation.rotation import heading
from hijack_detect.evaluation.trials.cases import SimulatedCase
from hijack_detect.evaluation.trials.protocols import feng2018
from hijack_detect.evaluation.trials.recorded import Recorded, judge, record
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.streams.samples import NANOSECONDS, FixSample

PAPER = policy_parameters("paper")
CORRELATION = PAPER.of(CorrelationParameters)
DATE = PAPER.of(DateParameters)
YAW, COURSE, ALARM = "tab:blue", "tab:orange", "tab:red"


@dataclass(frozen=True)
class Flown:
    """One flight with the verdicts of the published detectors."""

    case: SimulatedCase
    recorded: Recorded
    correlation: list[Verdict]
    date: list[Verdict]

    def seconds(self, stamp_ns: int) -> float:
        """Seconds from the start."""
        return (stamp_ns - self.recorded.start_ns) / NANOSECONDS

    def track(self) -> np.ndarray:
        """Reported positions, metres East and North of the first, shape (n, 2)."""
        fixes = [s for _, s in self.recorded.samples if isinstance(s, FixSample)]
        frame = LocalFrame(fixes[0])
        return np.array([frame.enu(fix)[:2] for fix in fixes])


def flown(case: SimulatedCase) -> Flown:
    """Fly and judge one case."""
    recorded = record(case, PAPER)
    return Flown(
        case,
        recorded,
        judge(recorded, lambda: CorrelationDetector(CORRELATION)),
        judge(recorded, lambda: DateDetector(DATE)),
    )


def first(cases: Sequence[SimulatedCase], wanted: Callable[[Flown], bool]) -> Flown:
    """The first case that shows what is wanted."""
    for case in cases:
        one = flown(case)
        if wanted(one):
            return one
    raise LookupError("no flight of the protocol shows it")


def alarmed(verdicts: Sequence[Verdict]) -> bool:
    """Whether there was an alarm."""
    return any(verdict.state is State.ALARM for verdict in verdicts)


def unseen(one: Flown) -> bool:
    """Whether the correlation did not alarm in the attack."""
    found = one.recorded.attack
    assert found is not None
    assert found.end_ns is not None
    inside = [v for v in one.correlation if found.onset_ns <= v.stamp_ns < found.end_ns]
    return not alarmed(inside)


def judged(verdicts: Sequence[Verdict]) -> list[Verdict]:
    """Verdicts that judge the GPS."""
    return [verdict for verdict in verdicts if verdict.state in JUDGED]


def figure_3(one: Flown, axes: Axes) -> None:
    """Positions of the GPS, and of dead reckoning that starts on them."""
    parameters = InsPositionParameters()
    verdicts = judge(one.recorded, lambda: InsPosition(parameters))
    known = [v.values for v in verdicts if v.state is not State.NOT_READY]
    axes.plot([v["gps_east"] for v in known], [v["gps_north"] for v in known], label="GPS")
    axes.plot([v["ins_east"] for v in known], [v["ins_north"] for v in known], label="INS")
    axes.set(xlabel="East, m", ylabel="North, m", aspect="equal")
    legend(axes)


def accelerations(one: Flown, axes: Axes) -> None:
    """Δa of DATE in the body's forward and left axis (Figures 5 and 6)."""
    verdicts = judged(one.date)
    time = [one.seconds(v.stamp_ns) for v in verdicts]
    for name, label in (("delta_ax", "$\\Delta a_x$"), ("delta_ay", "$\\Delta a_y$")):
        axes.plot(time, [v.values[name] for v in verdicts], label=label)
    limit = DATE.threshold
    axes.axhspan(-limit, limit, color="0.92", zorder=0, label=f"limit of |Δa|, {limit:g}")
    axes.set(xlabel="time, s", ylabel="m/s²")
    attack(one, axes)
    legend(axes)


def angles(one: Flown, axes: Axes) -> None:
    """GPS angle φ and yaw γ, clockwise from North (Figures 12 to 15)."""
    attitudes = [s for s in one.recorded.attitudes[::5] if s.orientation is not None]
    courses = [s for s in one.recorded.courses if s.observable]
    shown = [
        (COURSE, "GPS angle φ", [(s.stamp_ns, s.angle) for s in courses]),
        (YAW, "yaw γ", [(s.stamp_ns, heading(s.orientation)) for s in attitudes if s.orientation]),
    ]
    begin = one.seconds(courses[0].stamp_ns)
    for colour, label, points in shown:
        time = np.array([one.seconds(stamp) for stamp, _ in points])
        angle = np.degrees(np.unwrap([math.pi / 2 - value for _, value in points]))
        inside = (time >= begin) & (time <= one.seconds(courses[-1].stamp_ns))
        if inside.any():
            start = np.median(angle[inside][:25])
            angle -= 360.0 * np.floor(start / 360.0)
        axes.plot(time[inside], angle[inside], color=colour, label=label, lw=1.2)
    axes.set(xlabel="time, s", ylabel="degrees from North")
    attack(one, axes)
    legend(axes)


def legend(axes: Axes) -> None:
    """Name the curves above the panel, where they hide nothing."""
    axes.legend(ncols=5, loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False)


def attack(one: Flown, axes: Axes) -> None:
    """Shade the attack, if there is one."""
    found = one.recorded.attack
    if found is not None:
        end = one.recorded.end_ns if found.end_ns is None else found.end_ns
        span = (one.seconds(found.onset_ns), one.seconds(end))
        axes.axvspan(*span, color=ALARM, alpha=0.08, lw=0, label="attack")


def coefficient(one: Flown, axes: Axes) -> None:
    """ρ and Δavg of Algorithm 2, with the alarms."""
    verdicts = [v for v in judged(one.correlation) if "coefficient" in v.values]
    time = [one.seconds(v.stamp_ns) for v in verdicts]
    axes.plot(time, [v.values["coefficient"] for v in verdicts], color="tab:green", label="ρ")
    axes.axhline(CORRELATION.epsilon, color="tab:green", ls=":", label="ε")
    axes.set(xlabel="time, s", ylabel="ρ", ylim=(-1.05, 1.05))
    other = axes.twinx()
    degrees = [math.degrees(v.values["mean_difference"]) for v in verdicts]
    other.plot(time, degrees, color="tab:purple", lw=0.8, label="Δavg")
    for sign in (-1, 1):
        other.axhline(sign * CORRELATION.mu_deg, color="tab:purple", ls=":", lw=0.8)
    other.set(ylabel="Δavg, degrees (μ dotted)")
    alarms = [one.seconds(v.stamp_ns) for v in verdicts if v.state is State.ALARM]
    axes.plot(alarms, [-1.0] * len(alarms), "|", color=ALARM, label="alarm")
    attack(one, axes)
    legend(axes)


def lowest_coefficient(one: Flown) -> float:
    """Smallest ρ of the flight while the directions agree."""
    mu = math.radians(CORRELATION.mu_deg)
    found = [
        v.values["coefficient"]
        for v in judged(one.correlation)
        if "coefficient" in v.values and abs(v.values["mean_difference"]) < mu
    ]
    return min(found, default=1.0)


def figures() -> Iterator[tuple[str, str, Flown, Sequence[Callable[[Flown, Axes], None]]]]:
    """File name, title, flight and panels of each figure."""
    cases = feng2018()
    straight, curved, hijacked = (
        [case for case in cases if case.kind == kind] for kind in ("straight", "curved", "hijacked")
    )
    calm, winding = flown(straight[0]), flown(curved[0])
    caught = first(hijacked, lambda one: alarmed(one.correlation) and alarmed(one.date))
    lucky = first(straight, lambda one: lowest_coefficient(one) < 0.6 and not alarmed(one.date))
    planned = first(
        [case for case in hijacked if "straight_" in case.name],
        lambda one: alarmed(one.correlation),
    )
    fooled = first(straight, lambda one: alarmed(one.correlation) and not alarmed(one.date))
    yield "figure_03", "Dead reckoning runs away from the GPS", calm, [figure_3]
    yield "figure_05", "DATE on a straight flight that is not hijacked", calm, [accelerations]
    yield "figure_06", "DATE on a hijacked flight", caught, [accelerations]
    yield "figure_12", "Yaw and GPS angle, straight, not hijacked", calm, [angles, coefficient]
    yield "figure_13", "Yaw and GPS angle, curved, not hijacked", winding, [angles, coefficient]
    yield "figure_14", "ρ is low though nothing is wrong", lucky, [angles, coefficient]
    yield "figure_15", "Yaw and GPS angle, hijacked", planned, [angles, coefficient]
    for real in ("curved", "straight"):
        cases = [case for case in hijacked if case.name.endswith(f"_{real}_straight")]
        title = f"A straight fake track on a {real} route"
        panels = [angles, coefficient, accelerations]
        yield f"missed_{real}", title, first(cases, unseen), panels
    yield (
        "figure_18",
        "Correlation is wrong in the wind, DATE is right",
        fooled,
        [angles, coefficient, accelerations],
    )


@click.command()
@click.argument("folder", type=click.Path(file_okay=False, path_type=Path))
def main(folder: Path) -> None:
    """Draw all figures into FOLDER."""
    mpl.use("Agg")
    mpl.rcParams.update(
        {"font.size": 9, "axes.grid": True, "grid.alpha": 0.3, "lines.linewidth": 1}
    )
    folder.mkdir(parents=True, exist_ok=True)
    for name, title, one, panels in figures():
        height = 4.2 if panels == [figure_3] else 0.6 + 2.2 * len(panels)
        figure, axes = plt.subplots(
            len(panels), 1, figsize=(7.2, height), squeeze=False, layout="constrained"
        )
        for panel, ax in zip(panels, axes[:, 0], strict=True):
            panel(one, ax)
        figure.suptitle(f"{title}   ({one.case.name})", fontsize=10)
        figure.savefig(folder / f"{name}.png", dpi=110, metadata={"Software": None})
        plt.close(figure)
        print(f"{folder / name}.png: {one.case.name}")


if __name__ == "__main__":
    main()
