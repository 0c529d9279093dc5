# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The recorded flights by vehicle: what is fitted on some is shown on the vehicle left out."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from hijack_detect.evaluation.trials.cases import BagCase
from hijack_detect.evaluation.trials.corpus import corpus_cases, read_labels

FOLDERS = ("real", "logs", "bags", "sitl")
"""Folders of the corpus."""
VEHICLES = {
    "arducopter_3.3_218": "erle_quad",
    "arducopter_3.3_log171": "log171",
    "curved_": "simulator",
    "dev_": "sitl_copter",
    "dronekit_la__": "log171",
    "erlerobot__": "erle_quad",
    "husky_ros1": "husky",
    "inertialnav__": "",
    "joeydouglas__": "quad_texas",
}
"""Vehicle by how the name of a flight begins that no `labels.json` names; empty: the rest of it."""
FAILS_FROM_S = {"erle_quad_26nov_181.bin": 56.0, "inertialnav__f450_glitch": 110.0}
"""Seconds from which a receiver really fails, by the notes on the flights: clean until then."""


@dataclass(frozen=True)
class Flight:
    """A flight of the corpus, its vehicle, and the second from which its receiver really fails."""

    case: BagCase
    vehicle: str
    fails_s: float | None


def vehicle_of(path: Path) -> str:
    """Vehicle of a flight, by the `labels.json` of its folder or by its name.

    Raises:
        BagError: The labels cannot be used.
    """
    label = read_labels(path.parent).get(path)
    if label is not None:
        return label[1].vehicle
    for begin, vehicle in VEHICLES.items():
        if path.name.startswith(begin):
            return vehicle or path.name.removeprefix(begin)
    return path.stem


def corpus(flights: Path) -> Iterator[Flight]:
    """Every flight of FOLDERS.

    Raises:
        BagError: A folder has no flights, or its labels cannot be used.
    """
    for folder in FOLDERS:
        for case in corpus_cases(flights / folder):
            labelled_s = None if case.label is None else case.label.alert_ok_from_s
            fails_s = FAILS_FROM_S.get(case.name, labelled_s)
            yield Flight(case, vehicle_of(case.path), fails_s)
