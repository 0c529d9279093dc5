# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The words of which a column map is made: columns with units, and times."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any, Literal, TypeAlias, TypeVar

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from hijack_detect.logs.csv_units import (
    ANGLE,
    FIELD,
    FORCE,
    ISO,
    LENGTH,
    PLACE,
    PRESSURE,
    RATE,
    SPEED,
    TIME,
)


def _no_flag(value: Any) -> Any:
    if isinstance(value, bool):
        raise ValueError("YAML reads this word as true or false: put it in quotes")
    return value


Column: TypeAlias = Annotated[
    Annotated[int, Field(ge=1)] | Annotated[str, Field(min_length=1)], BeforeValidator(_no_flag)
]
"""A name in the header, or the number of a column, from 1."""


class Strictly(BaseModel):
    """Base of every part of a map: no unknown keys, no NaN, no later changes."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)


class One(Strictly):
    """One column and its unit."""

    column: Column
    unit: str


class Three(Strictly):
    """The columns of x, y and z, or of the axes of the world, and their unit."""

    columns: list[Column] = Field(min_length=3, max_length=3)
    unit: str


Quantity = TypeVar("Quantity", One, Three)


def _in(units: Mapping[str, float]) -> Callable[[Quantity], Quantity]:
    def check(given: Quantity) -> Quantity:
        if given.unit not in units:
            raise ValueError(f"unit {given.unit!r} is not known; known are {', '.join(units)}")
        return given

    return check


Angle = Annotated[One, AfterValidator(_in(ANGLE))]
PlaceAngle = Annotated[One, AfterValidator(_in(PLACE))]
Length = Annotated[One, AfterValidator(_in(LENGTH))]
Speed = Annotated[One, AfterValidator(_in(SPEED))]
Pressure = Annotated[One, AfterValidator(_in(PRESSURE))]
Rates = Annotated[Three, AfterValidator(_in(RATE))]
Forces = Annotated[Three, AfterValidator(_in(FORCE))]
Fields = Annotated[Three, AfterValidator(_in(FIELD))]
Speeds = Annotated[Three, AfterValidator(_in(SPEED))]
Body = Literal["FLU", "FRD"]
World = Literal["ENU", "NED"]


class Time(Strictly):
    """When a row was measured."""

    column: Column
    unit: str
    since: Literal["boot", "utc"] = "boot"

    @model_validator(mode="after")
    def _check_unit(self) -> Time:
        if self.unit not in (*TIME, ISO):
            known = ", ".join((*TIME, ISO))
            raise ValueError(f"unit {self.unit!r} is not known; known are {known}")
        return self

    @property
    def utc(self) -> bool:
        """Whether it counts from 1970."""
        return self.unit == ISO or self.since == "utc"


class HasFix(Strictly):
    """A column with the state of the fix: true, or a number of at least `at_least`."""

    column: Column
    at_least: float = 1.0
