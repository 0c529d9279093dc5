# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The column map of a CSV: a YAML file with the meaning of its columns."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from pydantic import Field, ValidationError, model_validator

from hijack_detect.bags.errors import BagError
from hijack_detect.logs.csv_inputs import (
    Attitude,
    Barometer,
    Fix,
    Imu,
    Input,
    Mag,
    Satellites,
    Velocity,
)
from hijack_detect.logs.csv_words import Strictly, Time
from hijack_detect.yaml_text import YamlTextError, plain_data

MAX_FILE_BYTES = 1_000_000
"""Chosen: far above any map."""


class Inputs(Strictly):
    """What the table has; an IMU and fixes are what every flight needs."""

    imu: Imu
    fix: Fix
    velocity: Velocity | None = None
    satellites: Satellites | None = None
    mag: Mag | None = None
    pressure: Barometer | None = None
    attitude: Attitude | None = None

    def given(self) -> dict[str, Input]:
        """The inputs that there are, by name."""
        found = {name: getattr(self, name) for name in type(self).model_fields}
        return {name: one for name, one in found.items() if one is not None}


class ColumnMap(Strictly):
    """A whole map."""

    delimiter: str = Field(",", min_length=1, max_length=1)
    decimal: Literal[".", ","] = "."
    comment: str = Field("#", max_length=1)
    """Lines that begin with it are left out; empty for none."""
    encoding: Literal["utf-8", "utf-16", "latin-1"] = "utf-8"
    header: bool = True
    """Whether the first row has names; without, columns are numbers."""
    time: Time | None = None
    inputs: Inputs

    @model_validator(mode="after")
    def _check_together(self) -> ColumnMap:
        if self.delimiter == self.decimal:
            raise ValueError("delimiter and decimal are the same character")
        for name, one in self.inputs.given().items():
            if one.time is None and self.time is None:
                raise ValueError(f"inputs.{name} has no time: give one for all, or its own")
            time = one.time or self.time
            assert time is not None
            columns = [*one.columns(), time.column]
            if not self.header and any(isinstance(column, str) for column in columns):
                raise ValueError(f"inputs.{name} has names, and there is no header: give numbers")
        kinds = {(one.time or self.time).utc for one in self.inputs.given().values()}  # type: ignore[union-attr]
        if len(kinds) > 1:
            raise ValueError("some times count from 1970 (utc) and others from boot")
        return self


def load_map(path: Path) -> ColumnMap:
    """Read a column map.

    Raises:
        BagError: It cannot be read, or has errors: all of them, one line each.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise BagError(f"{path}: cannot be read: {error.strerror or error}") from error
    if len(content) > MAX_FILE_BYTES:
        raise BagError(f"{path}: has more than {MAX_FILE_BYTES} bytes, and is no column map")
    try:
        data = plain_data(content.decode())
    except (UnicodeDecodeError, YamlTextError) as error:
        raise BagError(f"{path}: is no YAML text: {error}") from error
    if not isinstance(data, Mapping):
        raise BagError(
            f"{path}: is no column map; `hijack-detect convert LOG --template` makes one"
        )
    try:
        return ColumnMap.model_validate(data)
    except ValidationError as error:
        raise BagError("\n".join(f"{path}: {line}" for line in _lines(error))) from error


def _lines(error: ValidationError) -> list[str]:
    """Each problem once: where, and what."""
    lines = []
    for one in error.errors():
        steps = [step for step in one["loc"] if not str(step).startswith("constrained-")]
        where = ".".join(str(step + 1) if isinstance(step, int) else step for step in steps)
        problem = one["msg"].removeprefix("Value error, ")
        if one["type"] == "extra_forbidden":
            problem = "is no key of a map here"
        elif one["type"] == "missing":
            problem = "is missing"
        lines.append(f"{where}: {problem}" if where else problem)
    return list(dict.fromkeys(lines))
