# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Scenario files: a list of attacks with start and end, checked before anything runs."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from hijack_detect.spoofing.problems import label, sentences
from hijack_detect.spoofing.schema import Document, Segment
from hijack_detect.yaml_text import YamlTextError, plain_data

MAX_FILE_BYTES = 16_000_000
"""Chosen: above MAX_POSITIONS written out."""


class ScenarioError(ValueError):
    """A scenario cannot be used; one line per problem, each with file, segment and key."""

    def __init__(self, problems: Sequence[str]) -> None:
        """Keep the sentences in `problems` and join them into the message."""
        super().__init__("\n".join(problems))
        self.problems = tuple(problems)


@dataclass(frozen=True)
class Scenario:
    """A checked scenario: segments in order of time that do not overlap.

    Times are seconds after the first message of the flight.
    """

    source: str
    """The file's name as it was given, for messages."""
    segments: tuple[Segment, ...]
    description: str = ""
    numbers: tuple[int, ...] = field(default=(), compare=False)
    """Each segment's number in the file, from 1; in order when left out."""

    def check_within(self, duration_s: float) -> None:
        """Check that every segment lies inside a flight.

        Args:
            duration_s: Time from the first to the last message of the flight.

        Raises:
            ScenarioError: A segment starts at or after the flight's end, or ends after it.
        """
        problems = []
        for number, segment in zip(self._numbers(), self.segments, strict=True):
            where = f"{self.source}: {label(number, segment.name)}"
            if not segment.start_s < duration_s:
                problems.append(
                    f"{where}: start: {segment.start_s!r} is outside the flight, "
                    f"allowed is 0 to below {duration_s:g} s"
                )
            elif segment.end_s is not None and not segment.end_s <= duration_s:
                problems.append(
                    f"{where}: end: {segment.end_s!r} is outside the flight, allowed is up to "
                    f"{duration_s:g} s, or leave it out for the flight's end"
                )
        if problems:
            raise ScenarioError(problems)

    def moved_to(self, onset_s: float) -> Scenario:
        """The same attacks, moved in time so that the first one starts at `onset_s`.

        What a replay plays back stays the piece it was.
        """
        by = onset_s - self.segments[0].start_s
        moved = [
            segment.model_copy(
                update={
                    "start_s": segment.start_s + by,
                    "end_s": None if segment.end_s is None else segment.end_s + by,
                }
            )
            for segment in self.segments
        ]
        return dataclasses.replace(self, segments=tuple(moved))

    def to_yaml(self) -> str:
        """The scenario as the text of a scenario file."""
        segments = [
            segment.model_dump(mode="json", by_alias=True, exclude_none=True)
            for segment in self.segments
        ]
        data = {"description": self.description, "segments": segments}
        return yaml.safe_dump(data, sort_keys=False)

    def _numbers(self) -> Sequence[int]:
        return self.numbers or range(1, len(self.segments) + 1)


def load_scenario(path: str | Path) -> Scenario:
    """Read and check a scenario file.

    Raises:
        ScenarioError: The file cannot be read, is not plain YAML, or says something that is not
            allowed. Every problem found is in the message.
    """
    try:
        data = Path(path).read_bytes()
        if len(data) > MAX_FILE_BYTES:
            raise ScenarioError([f"{path}: has more than {MAX_FILE_BYTES} bytes"])
        text = data.decode("utf-8")
    except OSError as error:
        raise ScenarioError([f"{path}: cannot be read: {error.strerror or error}"]) from error
    except UnicodeDecodeError as error:
        raise ScenarioError([f"{path}: is not UTF-8 text (byte {error.start})"]) from error
    return parse_scenario(text, str(path))


def parse_scenario(text: str | Mapping[str, Any], source: str = "scenario") -> Scenario:
    """Check a scenario given as YAML text, or as the mapping that such a text stands for.

    Args:
        text: The scenario.
        source: Name to use in messages, usually the file's.

    Raises:
        ScenarioError: As for `load_scenario`.
    """
    try:
        data = plain_data(text) if isinstance(text, str) else dict(text)
    except YamlTextError as error:
        raise ScenarioError([f"{source}: {error}"]) from error
    if data is None:
        raise ScenarioError([f"{source}: is empty; it needs the key 'segments'"])
    if not isinstance(data, Mapping):
        raise ScenarioError([f"{source}: is not a mapping of keys; it needs the key 'segments'"])
    try:
        document = Document.model_validate(data)
    except ValidationError as error:
        raise ScenarioError(
            [f"{source}: {problem}" for problem in sentences(error, data)]
        ) from error
    return _in_order(document, source)


def _in_order(document: Document, source: str) -> Scenario:
    """Sort the segments by start, name the nameless, and refuse overlaps."""
    numbered = sorted(enumerate(document.segments, start=1), key=lambda pair: pair[1].start_s)
    problems = []
    for (number, segment), (next_number, following) in itertools.pairwise(numbered):
        if segment.end_s is None or segment.end_s > following.start_s:
            end = "the flight's end" if segment.end_s is None else f"{segment.end_s!r} s"
            problems.append(
                f"{source}: {label(next_number, following.name)}: start: {following.start_s!r} "
                f"overlaps {label(number, segment.name)}, which lasts from {segment.start_s!r} s "
                f"to {end}"
            )
    if problems:
        raise ScenarioError(problems)
    return Scenario(
        source,
        tuple(
            segment.model_copy(update={"name": segment.name or segment.model.type})
            for _, segment in numbered
        ),
        document.description,
        tuple(number for number, _ in numbered),
    )
