# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A folder of recorded flights, bags and logs, with labels where they are known."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, MutableMapping
from pathlib import Path
from typing import Any

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.files import METADATA
from hijack_detect.evaluation.trials.cases import HIJACKED, BagCase, CorpusLabel
from hijack_detect.evaluation.trials.onsets import attacked
from hijack_detect.logs.formats import is_log
from hijack_detect.replay.truth import read_label
from hijack_detect.spoofing.scenario import Scenario

UNLABELLED = "unlabelled"
LABELS = "labels.json"
"""File with the labels of all flights of a folder."""
CLASSES = {"hijack": HIJACKED}
"""Kinds of labels that are called otherwise here."""


def corpus_cases(folder: Path, scenario: Scenario | None = None, onsets: int = 0) -> list[BagCase]:
    """Every bag and log below a folder, by name: its path from there.

    A flight is labelled by the `labels.json` of a folder above it, or by its own `label.json`.
    Without a label, or with a broken one, it is of class `unlabelled`: clean, unless
    its topics have an attack. A broken label is reported when the case runs.

    Args:
        folder: Where to look.
        scenario: An attack with which each clean flight is flown again, if given.
        onsets: How often, see `attacked`.

    Raises:
        BagError: The folder cannot be listed, there is no flight in it, or its labels are broken.
    """
    labels: dict[Path, tuple[str, CorpusLabel]] = {}
    try:
        paths = list(flight_paths(folder, labels))
    except OSError as error:
        raise BagError(f"{folder}: cannot be listed: {error.strerror or error}") from error
    if not paths:
        raise BagError(
            f"{folder}: there is no bag in it (no {METADATA}, no .mcap file), and no log"
        )
    cases = [_case(path, folder, labels.get(path)) for path in paths]
    if scenario is None:
        return cases
    clean = [case for case in cases if case.kind != HIJACKED]
    return cases + [one for case in clean for one in _attacked(case, scenario, onsets)]


def _case(path: Path, folder: Path, label: tuple[str, CorpusLabel] | None) -> BagCase:
    name = folder.name if path == folder else str(path.relative_to(folder))
    if label is None:
        return BagCase(path, name, kind_of(path))
    return BagCase(path, name, label[0], label=label[1])


def _attacked(case: BagCase, scenario: Scenario, onsets: int) -> list[BagCase]:
    """The attacks on a flight; a bag that cannot be read fails when its own case runs."""
    try:
        return attacked(case, scenario, onsets)
    except BagError:
        return []


def bag_paths(folder: Path) -> Iterator[Path]:
    """Bags below a folder in order of name: rosbag2 directories, and .mcap files outside them.

    Raises:
        OSError: A folder cannot be listed.
    """
    return (path for path in flight_paths(folder, {}) if _is_bag(path))


def flight_paths(
    folder: Path, labels: MutableMapping[Path, tuple[str, CorpusLabel]]
) -> Iterator[Path]:
    """Bags and logs below a folder in order of name, and what a `labels.json` names beside it.

    Args:
        folder: Where to look.
        labels: Gets class and label of each flight that a `labels.json` names, by path.

    Raises:
        OSError: A folder cannot be listed.
        BagError: A `labels.json` cannot be used.
    """
    waiting, seen = [folder], set[Path]()
    while waiting:
        path = waiting.pop()
        if path in labels or _is_bag(path) or is_log(path):
            yield path
        elif path.is_dir() and path.resolve() not in seen:
            seen.add(path.resolve())
            labels.update(read_labels(path))
            waiting += sorted(path.iterdir(), reverse=True)


def _is_bag(path: Path) -> bool:
    return path.suffix == ".mcap" or (path / METADATA).is_file()


def read_labels(folder: Path) -> dict[Path, tuple[str, CorpusLabel]]:
    """Class and label of the flights that the `labels.json` of a folder names, by path.

    It is a list of objects with `file`, a path from the folder, `vehicle`, `class`, and `attack`,
    null or an object with `t_start` and `t_end`. `alert_ok_from_s` is optional, as is everything
    else. A folder without the file has no labels.

    Raises:
        BagError: The file cannot be used; the text gives the reason.
    """
    path = folder / LABELS
    if not path.is_file():
        return {}
    try:
        entries = json.loads(path.read_text(encoding="utf-8"))
        return {folder / entry["file"]: _label(entry) for entry in entries}
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise BagError(f"{path}: is no list of labels ({error!r})") from error


def _label(entry: Mapping[str, Any]) -> tuple[str, CorpusLabel]:
    kind, vehicle, attack = entry["class"], entry["vehicle"], entry["attack"]
    if not isinstance(kind, str) or not isinstance(vehicle, str):
        raise TypeError(f"{entry['file']}: class and vehicle are words")
    times = None if attack is None else (float(attack["t_start"]), float(attack["t_end"]))
    if times is not None and not 0.0 <= times[0] < times[1] < math.inf:
        raise ValueError(f"{entry['file']}: the attack does not end after its start")
    ok_from = entry.get("alert_ok_from_s")
    label = CorpusLabel(vehicle, times, None if ok_from is None else float(ok_from))
    return (HIJACKED if times else CLASSES.get(kind, kind)), label


def kind_of(bag: Path) -> str:
    """Class of a bag by its label."""
    try:
        label = read_label(bag)
    except BagError:
        return UNLABELLED
    return UNLABELLED if label is None else CLASSES.get(label["kind"], label["kind"])
