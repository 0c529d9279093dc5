# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The attack simulator of Basan et al. 2022 as an attack model of scenario files."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, model_validator

from hijack_detect.spoofing.schema_types import BearingDeg, Flag, Number, Seed, Strictly, Whole
from hijack_detect.streams.messages import MAX_SATELLITES, MAX_SPEED

MIN_ACCURACY_M, MAX_ACCURACY_M = 0.001, 10_000.0
"""Metres; no receiver claims to be better, and one that claims to be worse has no fix."""
MIN_CORRELATION_S = 0.001
Counts: TypeAlias = tuple[Whole, ...]
Metres: TypeAlias = tuple[Number, ...]


class Forge(Strictly):
    """The values of parameters are generated anew at every update (Basan 2022, section 3.1).

    Soft mode forges the basic parameters only: altitude, number of satellites and noise level.
    Hard mode forges latitude, longitude, ground speed and track angle as well: noise on position
    and velocity, and a smooth displacement to the attacker's side.
    """

    type: Literal["forge"]
    seed: Seed = Field(description="seed of all draws")
    altitude_sigma_m: Number = Field(ge=0.0, le=10_000.0, description="noise of altitude, metres")
    satellites: Counts | None = Field(
        None, description="[lowest, highest] number of satellites, default the true one"
    )
    accuracy_m: Metres | None = Field(
        None, description="[lowest, highest] claimed standard deviation, metres, default the true"
    )
    horizontal_sigma_m: Number = Field(
        0.0, ge=0.0, le=100_000.0, description="noise of East and North each, metres"
    )
    velocity_sigma_m_s: Number = Field(
        0.0, ge=0.0, le=100.0, description="noise of East and North velocity each, m/s"
    )
    drift_speed_m_s: Number = Field(
        0.0, ge=0.0, le=MAX_SPEED, description="final speed of the displacement, m/s"
    )
    bearing_deg: BearingDeg = Field(
        0.0, description="direction of the displacement, degrees clockwise from North"
    )
    relative: Flag = Field(False, description="count the bearing from the course at onset")
    onset_acceleration_m_s2: Number = Field(
        1.0, gt=0.0, le=1000.0, description="how fast the displacement's speed builds up, m/s2"
    )
    correlation_s: Annotated[Number, Field(ge=0.0, le=1000.0)] = Field(
        0.0, description="seconds between independent draws, 0: anew for each fix"
    )

    @model_validator(mode="after")
    def _check_ranges(self) -> Forge:
        _check_range("satellites", self.satellites, 0, MAX_SATELLITES)
        _check_range("accuracy_m", self.accuracy_m, MIN_ACCURACY_M, MAX_ACCURACY_M)
        if 0.0 < self.correlation_s < MIN_CORRELATION_S:
            raise ValueError(
                f"correlation_s: {self.correlation_s!r} is neither 0 nor at least "
                f"{MIN_CORRELATION_S} s"
            )
        return self


def _check_range(key: str, given: tuple[float, ...] | None, lowest: float, highest: float) -> None:
    """Refuse what is not two numbers in order within the bounds."""
    if given is None:
        return
    if len(given) != 2:
        raise ValueError(f"{key}: has {len(given)} numbers, two are needed: [lowest, highest]")
    low, high = given
    if not lowest <= low <= high <= highest:
        raise ValueError(
            f"{key}: [{low!r}, {high!r}] is not [lowest, highest] within [{lowest:g}, {highest:g}]"
        )
