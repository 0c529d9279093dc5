# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The words of which scenario files are made: strict values with bounds."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, Strict

MAX_TIME_S = 1_000_000.0
"""Latest time in a scenario; no battery lasts eleven days."""
MAX_DISTANCE_M = 1_000_000.0

Number = Annotated[float, Strict()]
Whole = Annotated[int, Strict()]
Flag = Annotated[bool, Strict()]
Text = Annotated[str, Strict(), Field(max_length=200)]
TimeS = Annotated[Number, Field(ge=0.0, le=MAX_TIME_S)]
BearingDeg = Annotated[Number, Field(ge=-360.0, le=360.0)]
Seed = Annotated[Whole, Field(ge=0, le=2**63 - 1)]
Row: TypeAlias = tuple[Number, ...]


class Strictly(BaseModel):
    """Base of every part of a scenario: no unknown keys, no NaN, no later changes."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
