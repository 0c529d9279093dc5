# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The figures of docs/detection-limits.md, from the records of `limits_runs`."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure

from experiments.limits_records import AttackRecord
from experiments.limits_runs import by_half
from experiments.limits_tables import Records, attacks, clean_minutes, counted, detected, methods
from hijack_detect.evaluation.scores.metrics import Spread, roc_curve

DPI = 110
METADATA = {"Software": None}
"""Keeps the version of the drawing library out of the file."""


def draw_all(folder: Path, part: str, records: Records) -> list[Path]:
    """Draw what a part has data for; return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    drawn = []
    for name, draw in FIGURES.items():
        figure = draw(records)
        if figure is not None:
            path = folder / f"limits_{name}_{part}.png"
            figure.savefig(path, dpi=DPI, metadata=METADATA)
            drawn.append(path)
    return drawn


def probability_map(records: Records) -> Figure | None:
    """Probability of detection of a drift, one panel for each method."""

    def value(found: Sequence[AttackRecord], method: str) -> tuple[float, str]:
        part = detected(found, method)
        ratio = math.nan if part.ratio is None else 100.0 * part.ratio
        return ratio, f"{part.count}/{part.total}"

    return _maps(records, value, "detected attacks, %", 100.0)


def time_map(records: Records) -> Figure | None:
    """Median time to detect a drift."""
    return _maps(records, lambda found, name: _median(found, name, "alarm_s"), "s to detect", 30.0)


def deviation_map(records: Records) -> Figure | None:
    """Median deviation at the alarm."""
    return _maps(
        records, lambda found, name: _median(found, name, "separation_m"), "m at the alarm", 60.0
    )


def _median(found: Sequence[AttackRecord], method: str, what: str) -> tuple[float, str]:
    values = [getattr(one, what) for one in counted(found, method)]
    spread = Spread.of([value for value in values if value is not None])
    return (math.nan, "–") if spread is None else (spread.median, f"{spread.median:.3g}")


def _maps(
    records: Records,
    value: Callable[[Sequence[AttackRecord], str], tuple[float, str]],
    label: str,
    largest: float,
) -> Figure | None:
    """Panels over onset acceleration and final speed."""
    found = [one for one in attacks(records, ["drift"]) if one.figures.get("speed")]
    if not found:
        return None
    speeds = sorted({one.figures["speed"] for one in found})
    gains = sorted({one.figures["acceleration"] for one in found})
    names = methods(records)
    columns = min(len(names), 3)
    rows = math.ceil(len(names) / columns)
    figure = Figure(figsize=(4.6 * columns, 2.3 * rows + 0.5), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    image = None
    for panel, name in zip(panels.flat, names, strict=False):
        cells = np.full((len(speeds), len(gains)), np.nan)
        for row, speed in enumerate(speeds):
            for column, gain in enumerate(gains):
                size = {"acceleration": gain, "speed": speed}
                own = [one for one in found if one.figures == size]
                cells[row, column], text = value(own, name)
                colour = "white" if cells[row, column] > 0.55 * largest else "black"
                panel.text(column, row, text, ha="center", va="center", size=7.5, color=colour)
        image = panel.imshow(
            cells, cmap="Blues", vmin=0.0, vmax=largest, origin="lower", aspect="auto"
        )
        panel.set_title(name, fontsize="medium")
        panel.set_xticks(range(len(gains)), [f"{gain:g}" for gain in gains])
        panel.set_yticks(range(len(speeds)), [f"{speed:g}" for speed in speeds])
    for panel in panels.flat[len(names) :]:
        panel.axis("off")
    assert image is not None
    figure.colorbar(image, ax=panels, label=label, shrink=0.8)
    figure.supxlabel("onset acceleration, m/s²")
    figure.supylabel("final speed of the drift, m/s")
    return figure


def jumps(records: Records) -> Figure | None:
    """Detection of jumps over their size, with 95 % intervals."""
    names = methods(records)
    families = [
        name
        for name in ("jump", "jump_any_phase")
        if any("distance_m" in one.figures for one in attacks(records, [name]))
    ]
    if not families:
        return None
    figure = Figure(figsize=(6.4 * len(families), 4.2), layout="constrained")
    panels = figure.subplots(1, len(families), squeeze=False, sharey=True)[0]
    for panel, family in zip(panels, families, strict=True):
        found = attacks(records, [family])
        distances = sorted({one.figures["distance_m"] for one in found})
        for number, name in enumerate(names):
            parts = [
                detected([one for one in found if one.figures["distance_m"] == metres], name)
                for metres in distances
            ]
            known = [(m, p) for m, p in zip(distances, parts, strict=True) if p.ratio is not None]
            ratio, low, high = (
                np.array([[p.ratio, p.low, p.high] for _, p in known], float).reshape(-1, 3).T
            )
            panel.errorbar(
                [metres * 1.015 ** (number - len(names) / 2) for metres, _ in known],
                100.0 * ratio,
                100.0 * np.abs(np.array([ratio - low, high - ratio])),
                fmt="o-",
                ms=3,
                lw=1,
                color=_colour(number),
                label=name,
            )
        panel.set_xscale("log")
        panel.set_xticks(distances, [f"{metres:g}" for metres in distances])
        panel.minorticks_off()
        panel.set(xlabel="jump, m", title=family)
    panels[0].set_ylabel("detected, %")
    panels[0].legend(fontsize="small")
    return figure


def roc(records: Records) -> Figure | None:
    """ROC of every method for each family: clean minutes against attacks, by half."""
    families = list(dict.fromkeys(one.family for one in attacks(records)))
    if not families:
        return None
    names = methods(records)
    halves = by_half(records) if len(records) <= 40 else {"": list(records)}
    columns = min(len(families), 4)
    rows = math.ceil(len(families) / columns)
    figure = Figure(figsize=(3.6 * columns, 3.2 * rows + 0.6), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    for panel, family in zip(panels.flat, families, strict=False):
        for number, name in enumerate(names):
            for (half, own), dash in zip(halves.items(), ("-", "--"), strict=False):
                minutes = clean_minutes(own, name)
                scores = [one.margins[-1] for one in counted(attacks(own, [family]), name)]
                if minutes and scores:
                    false, true = roc_curve(minutes, scores)
                    label = f"{name} {half}".strip()
                    colour = _colour(number)
                    panel.plot(false, true, dash, lw=1, color=colour, label=label)
        panel.set_title(family, fontsize="medium")
        panel.grid(alpha=0.3)
    for panel in panels.flat[len(families) :]:
        panel.axis("off")
    labelled: dict[str, object] = {}
    for panel in panels.flat:
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
            labelled.setdefault(label, handle)
    figure.legend(
        list(labelled.values()), list(labelled), loc="outside upper center", ncols=6, fontsize=7
    )
    figure.supxlabel("clean minutes at or above the threshold")
    figure.supylabel("attacks at or above it")
    return figure


def flights(records: Records) -> Figure | None:
    """Attacks that the fusion found, by flight and family."""
    real = [record for record in records if attacks([record])]
    families = list(dict.fromkeys(one.family for one in attacks(real)))
    if not real or len(real) > 40:
        return None
    figure = Figure(figsize=(1.1 * len(families) + 3.0, 0.4 * len(real) + 1.6))
    panel = figure.subplots()
    cells = np.full((len(real), len(families)), np.nan)
    for row, record in enumerate(real):
        for column, family in enumerate(families):
            part = detected(attacks([record], [family]), "fusion")
            if part.ratio is not None:
                cells[row, column] = 100.0 * part.ratio
                colour = "white" if part.ratio > 0.55 else "black"
                text = f"{part.count}/{part.total}"
                panel.text(column, row, text, ha="center", va="center", size=7.5, color=colour)
    panel.imshow(cells, cmap="Blues", vmin=0.0, vmax=100.0, aspect="auto")
    panel.set_xticks(range(len(families)), families, rotation=30, ha="right")
    panel.set_yticks(range(len(real)), [record.name for record in real], fontsize=8)
    panel.set_title("found by the fusion (empty: it had alarmed before)", fontsize="medium")
    figure.tight_layout()
    return figure


FIGURES = {
    "probability": probability_map,
    "time": time_map,
    "deviation": deviation_map,
    "jumps": jumps,
    "roc": roc,
    "flights": flights,
}
"""Figures by name; each is None where a part has no data for it."""


def _colour(number: int) -> tuple[float, float, float, float]:
    return colormaps["tab10"](number % 10)
