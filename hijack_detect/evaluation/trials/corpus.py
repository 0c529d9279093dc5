# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A folder of recorded flights, with labels beside them where they are known."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.files import METADATA
from hijack_detect.evaluation.ground_truth.truth import read_label
from hijack_detect.evaluation.trials.cases import HIJACKED, BagCase
from hijack_detect.evaluation.trials.onsets import attacked
from hijack_detect.spoofing.scenario import Scenario

UNLABELLED = "unlabelled"
CLASSES = {"hijack": HIJACKED}
"""Kinds of labels that are called otherwise here."""


def corpus_cases(folder: Path, scenario: Scenario | None = None, onsets: int = 0) -> list[BagCase]:
    """Every bag below a folder, by name: its path from there.

    A bag without a label, or with a broken one, is of class `unlabelled`: clean, unless its
    topics tell of an attack. A broken label is reported when the case runs.

    Args:
        folder: Where to look.
        scenario: An attack with which each clean flight is flown again, if given.
        onsets: How often, see `attacked`.

    Raises:
        BagError: The folder cannot be listed, or there is no bag in it.
    """
    try:
        paths = list(bag_paths(folder))
    except OSError as error:
        raise BagError(f"{folder}: cannot be listed: {error.strerror or error}") from error
    if not paths:
        raise BagError(f"{folder}: there is no bag in it (no {METADATA}, no .mcap file)")
    cases = [
        BagCase(
            path, folder.name if path == folder else str(path.relative_to(folder)), kind_of(path)
        )
        for path in paths
    ]
    if scenario is None:
        return cases
    clean = [case for case in cases if case.kind != HIJACKED]
    return cases + [one for case in clean for one in _attacked(case, scenario, onsets)]


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
    waiting, seen = [folder], set[Path]()
    while waiting:
        path = waiting.pop()
        if path.suffix == ".mcap" or (path / METADATA).is_file():
            yield path
        elif path.is_dir() and path.resolve() not in seen:
            seen.add(path.resolve())
            waiting += sorted(path.iterdir(), reverse=True)


def kind_of(bag: Path) -> str:
    """Class of a bag by its label."""
    try:
        label = read_label(bag)
    except BagError:
        return UNLABELLED
    return UNLABELLED if label is None else CLASSES.get(label["kind"], label["kind"])
