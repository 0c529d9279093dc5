# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Pictures of sweeps: correctness against a parameter, and maps of attack sizes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from hijack_detect.evaluation.trials.cases import HIJACKED
from hijack_detect.evaluation.tuning.attack_map import Cell
from hijack_detect.evaluation.tuning.sweeps import CLEAN, Curve, Sweep

COLOURS = {HIJACKED: "#c23b22", CLEAN: "#1f5fa8"}
DASHES = ("--", ":", "-.", (0, (1, 3)))
DPI = 150
METADATA = {"Software": None}
"""Keeps the version of the drawing library out of the file."""


def draw_curves(path: Path, what: Sweep, curves: Sequence[Curve], title: str) -> None:
    """Draw correctness against a parameter, one panel a method.

    Hijacked and all other flights are shown with their 95 % intervals, further classes as thin
    lines; the paper's value is marked.

    Raises:
        OSError: The file cannot be written.
    """
    methods = list(dict.fromkeys(curve.method for curve in curves))
    figure = Figure(figsize=(6.4 * len(methods), 5.2), layout="constrained")
    panels = figure.subplots(1, len(methods), squeeze=False, sharey=True)[0]
    for panel, method in zip(panels, methods, strict=True):
        _curves(panel, what, [curve for curve in curves if curve.method == method])
        panel.set_title(method)
    panels[0].set_ylabel("correct flights, %")
    figure.legend(
        *panels[0].get_legend_handles_labels(),
        title="flights (number); band: 95 % interval",
        loc="outside lower center",
        ncols=3,
        fontsize="small",
        title_fontsize="small",
    )
    figure.suptitle(title)
    figure.savefig(path, dpi=DPI, metadata=METADATA)


def _curves(panel: Axes, what: Sweep, curves: Sequence[Curve]) -> None:
    thin = [curve.kind for curve in curves if curve.kind not in COLOURS]
    for curve in curves:
        percent = 100.0 * np.array([[one.ratio, one.low, one.high] for one in curve.correct])
        label = f"{curve.kind} ({curve.correct[0].total})"
        if curve.kind in COLOURS:
            colour = COLOURS[curve.kind]
            panel.plot(what.values, percent[:, 0], "o-", color=colour, ms=4, label=label)
            panel.fill_between(what.values, *percent[:, 1:].T, color=colour, alpha=0.15, lw=0)
        else:
            dash = DASHES[thin.index(curve.kind) % len(DASHES)]
            panel.plot(what.values, percent[:, 0], ls=dash, color="0.35", lw=1, label=label)
    panel.axvline(what.published, color="0.5", lw=1)
    panel.annotate(
        f"paper: {what.published:g} ",
        (what.published, 0.01),
        xycoords=("data", "axes fraction"),
        color="0.4",
        fontsize="small",
        ha="right",
    )
    if what.log:
        panel.set_xscale("log")
        ticks = sorted({*what.values[::2], what.values[-1]})
        panel.set_xticks(ticks, [f"{value:g}" for value in ticks])
        panel.minorticks_off()
    panel.set_ylim(-3.0, 103.0)
    panel.set_xlabel(what.label)
    panel.grid(alpha=0.3)


def draw_map(path: Path, cells: Sequence[Cell], title: str) -> None:
    """Draw the probability of detection and the median time, one panel a method.

    Raises:
        OSError: The file cannot be written.
    """
    methods = list(dict.fromkeys(cell.method for cell in cells))
    columns = min(len(methods), 3)
    rows = math.ceil(len(methods) / columns)
    figure = Figure(figsize=(4.8 * columns, 3.9 * rows + 0.4), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    for panel in panels.flat[len(methods) :]:
        panel.axis("off")
    image = None
    for panel, method in zip(panels.flat, methods, strict=False):
        image = _map(panel, [cell for cell in cells if cell.method == method])
        panel.set_title(f"{method}\n{_chance(cells, method)}", fontsize="medium")
    for panel in panels[:, 0]:
        panel.set_ylabel("drift speed, m/s")
    for number, panel in enumerate(panels.flat[: len(methods)]):
        if number + columns >= len(methods):
            panel.set_xlabel("onset acceleration, m/s²")
            panel.tick_params(labelbottom=True)
    if image is not None:
        figure.colorbar(image, ax=panels, label="detected flights, %", shrink=0.8)
    figure.suptitle(f"{title}\nnumbers: detected flights, median time to detect")
    figure.savefig(path, dpi=DPI, metadata=METADATA)


def _map(panel: Axes, cells: Sequence[Cell]) -> AxesImage:
    attacks = [cell for cell in cells if cell.speed > 0.0]
    speeds = sorted({cell.speed for cell in attacks})
    gains = sorted({cell.acceleration for cell in attacks})
    percent = np.full((len(speeds), len(gains)), np.nan)
    for cell in attacks:
        row, column = speeds.index(cell.speed), gains.index(cell.acceleration)
        ratio = cell.detected.ratio or 0.0
        percent[row, column] = 100.0 * ratio
        text = f"{cell.detected.count}/{cell.detected.total}"
        if cell.median_s is not None:
            text += f"\n{cell.median_s:.1f} s"
        colour = "white" if ratio > 0.55 else "black"
        panel.text(column, row, text, ha="center", va="center", fontsize=7.5, color=colour)
    panel.set_xticks(range(len(gains)), [f"{gain:g}" for gain in gains])
    panel.set_yticks(range(len(speeds)), [f"{speed:g}" for speed in speeds])
    return panel.imshow(percent, cmap="Blues", vmin=0.0, vmax=100.0, origin="lower", aspect="auto")


def _chance(cells: Sequence[Cell], method: str) -> str:
    """Share of alarms of the method in the same time without an attack."""
    for cell in cells:
        if cell.method == method and cell.speed == 0.0:
            return f"without attack: {cell.detected.count}/{cell.detected.total}"
    return ""
