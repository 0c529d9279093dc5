# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Figures 2 and 3 of Basan et al. 2022, redrawn from simulated flights: PNG files.

    python -m experiments.basan_figures docs/figures

The flights are the first ones of the protocol `basan2022`.
"""

from __future__ import annotations

import math
from pathlib import Path

import click
import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes

from hijack_detect.detectors.poisson import log_pmf
from hijack_detect.evaluation.trials.basan2022 import ATTACK_S, basan2022
from hijack_detect.evaluation.trials.cases import SimulatedCase
from hijack_detect.simulation.flight import generate_flight
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.samples import NANOSECONDS

WINDOW = 10
"""Values of which the mean is taken."""
VALUES = 50
"""Values in one trial: 10 s."""
RATE_HZ = 5
"""Rate of the simulated receiver (docs/simulator.md)."""


def satellites(case: SimulatedCase) -> np.ndarray:
    """Seconds and reported number of satellites of a flight, shape (n, 2)."""
    start_ns = case.plan.start_ns
    receiver = None if case.scenario is None else Spoofer(case.scenario, start_ns)
    counts = generate_flight(case.plan, case.seed, receiver).satellites
    return np.array([((one.stamp_ns - start_ns) / NANOSECONDS, one.count) for one in counts])


def probabilities(counts: np.ndarray) -> list[float]:
    """Poisson's probability of each value from the tenth on, λ the mean of the last ten (Eq. 6)."""
    means = np.convolve(counts, np.ones(WINDOW) / WINDOW, "valid")
    pairs = zip(counts[WINDOW - 1 :].tolist(), means.tolist(), strict=True)
    return [math.exp(log_pmf(count, mean)) for count, mean in pairs]


def onset_s(case: SimulatedCase) -> float:
    """First forged fix, seconds."""
    assert case.scenario is not None
    return case.scenario.segments[0].start_s


def trial(flight: np.ndarray, begin_s: float) -> list[float]:
    """The probabilities of VALUES values from a time on."""
    index = int(np.searchsorted(flight[:, 0], begin_s))
    return probabilities(flight[index - WINDOW + 1 : index + VALUES, 1])


def figure_2(axes: Axes, case: SimulatedCase) -> None:
    """Satellites over time, before, in and after the attack."""
    flight = satellites(case)
    begin = onset_s(case)
    axes.axvspan(begin, begin + ATTACK_S, color="tab:red", alpha=0.12, label="attack")
    axes.step(flight[:, 0], flight[:, 1], where="post", color="0.35", label="satellites used")
    axes.set(xlabel="time, s", ylabel="number of satellites", ylim=(0, 21))
    axes.legend(loc="lower left")
    axes.set_title(f"Figure 2: satellites in a forged flight ({case.name})")


def figure_3(left: Axes, right: Axes, clean: list[SimulatedCase], forged: SimulatedCase) -> None:
    """Probabilities of the number of satellites in four trials, without and with an attack."""
    number = np.arange(1, VALUES + 1)
    for case in clean:
        left.plot(number, trial(satellites(case), 50.0), label=case.name)
    left.set_title("Figure 3 (a): without attack")
    flight, begin = satellites(forged), onset_s(forged)
    trials = {
        "before the attack": begin - VALUES / RATE_HZ - 1.0,
        "its beginning": begin - 2.0,
        "its middle": begin + ATTACK_S / 2,
        "after it": begin + ATTACK_S + 2.0,
    }
    for name, time_s in trials.items():
        right.plot(number, trial(flight, time_s), label=name)
    right.set_title(f"(b): during an attack ({forged.name})")
    for axes in (left, right):
        axes.set(xlabel="value of the trial", ylabel="probability", ylim=(0.0, 0.16))
        axes.legend(fontsize=8, loc="upper right")


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
def main(folder: Path) -> None:
    """Draw the figures into FOLDER."""
    mpl.use("Agg")
    folder.mkdir(parents=True, exist_ok=True)
    cases = basan2022()
    clean = [case for case in cases if case.kind == "clean"][:4]
    forged = next(case for case in cases if case.kind == "soft")
    figure, axes = plt.subplots(figsize=(9.0, 3.2), layout="constrained")
    figure_2(axes, forged)
    figure.savefig(folder / "basan_figure_02.png", dpi=100)
    figure, (left, right) = plt.subplots(1, 2, figsize=(11.0, 3.8), layout="constrained")
    figure_3(left, right, clean, forged)
    figure.savefig(folder / "basan_figure_03.png", dpi=100)


if __name__ == "__main__":
    main()
