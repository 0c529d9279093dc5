# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The schema of a scenario file: one frozen model per kind of attack, with units and bounds.

Bearings are degrees clockwise from North, the seaman's way, because that is what an analyst
reads off a map; everything after this file is in metres, radians and ENU.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, Strict, model_validator

from hijack_detect.streams.messages import MAX_SATELLITES, MAX_SPEED

MAX_TIME_S = 1_000_000.0
"""Latest time in a scenario; no battery lasts eleven days."""
MAX_DISTANCE_M = 1_000_000.0
"""Chosen: beyond it a tangent plane is no map."""

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


MAX_POSITIONS = 100_000
"""Most positions of a fake track. Chosen: five hours of 5 Hz."""
MIN_STEP_S = 0.001
"""Shortest time between two positions of a fake track. Chosen: far below the period of a fix."""
MIN_MATCHED_SPEED = 0.1
"""m/s; a track that starts slower than this cannot be scaled to the vehicle's speed. Chosen."""


class Jump(Strictly):
    """The reported position is displaced at once; velocity and altitude stay the true ones."""

    type: Literal["jump"]
    distance_m: Number = Field(ge=0.0, le=MAX_DISTANCE_M, description="displacement, metres")
    bearing_deg: BearingDeg = Field(description="direction, degrees clockwise from North")
    relative: Flag = Field(False, description="count the bearing from the course at onset")


class Drift(Strictly):
    """Carry-off: the displacement grows smoothly; altitude stays the true one."""

    type: Literal["drift"]
    speed_m_s: Number = Field(ge=0.0, le=MAX_SPEED, description="final speed of the offset, m/s")
    bearing_deg: BearingDeg = Field(description="direction, degrees clockwise from North")
    onset_acceleration_m_s2: Number = Field(
        gt=0.0, le=1000.0, description="how fast the offset's speed builds up, m/s2"
    )
    relative: Flag = Field(False, description="count the bearing from the course at onset")


class FakeTrack(Strictly):
    """The reported positions come from a list and ignore the vehicle (Feng 2018)."""

    type: Literal["fake_track"]
    positions: tuple[Row, ...] = Field(
        min_length=2,
        max_length=MAX_POSITIONS,
        description="rows of [t_s, east_m, north_m, up_m] after onset, up_m may be left out; "
        "with frame: course [t_s, forward_m, left_m, up_m]",
    )
    frame: Literal["enu", "course"] = Field(
        "enu", description="enu, or course: forward, left, up of the course at onset"
    )
    speed_scale: Literal["none", "flight"] = Field(
        "none", description="flight: scale so that the first speed is the vehicle's at onset"
    )

    @model_validator(mode="after")
    def _check_rows(self) -> FakeTrack:
        for number, row in enumerate(self.positions, start=1):
            if len(row) not in (3, 4):
                raise ValueError(
                    f"positions: row {number} has {len(row)} numbers, allowed are 3 or 4: "
                    "[t_s, east_m, north_m] or [t_s, east_m, north_m, up_m]"
                )
            if not all(abs(value) <= MAX_DISTANCE_M for value in row):
                raise ValueError(f"positions: row {number} has a number beyond 1000000: {row}")
        if self.positions[0][0] != 0.0:
            raise ValueError(
                f"positions: row 1 has t_s {self.positions[0][0]!r}, it must be 0 (the onset)"
            )
        speeds = [self._leg_speed(number) for number in range(2, len(self.positions) + 1)]
        if self.speed_scale == "flight" and speeds[0] < MIN_MATCHED_SPEED:
            raise ValueError(
                f"speed_scale: flight needs a first leg of at least {MIN_MATCHED_SPEED} m/s over "
                f"ground, row 2 makes it {speeds[0]:g} m/s"
            )
        return self

    def _leg_speed(self, number: int) -> float:
        """Horizontal speed (m/s) of the leg that ends at the row of this number, from 2."""
        before, row = self.positions[number - 2], self.positions[number - 1]
        step = row[0] - before[0]
        if not step >= MIN_STEP_S:
            raise ValueError(
                f"positions: row {number} has t_s {row[0]!r}, it must be at least {MIN_STEP_S} s "
                f"after row {number - 1} ({before[0]!r})"
            )
        up = padded(row)[3] - padded(before)[3]
        across = math.hypot(row[1] - before[1], row[2] - before[2])
        if math.hypot(across, up) > MAX_SPEED * step:
            raise ValueError(
                f"positions: row {number} needs {math.hypot(across, up) / step:g} m/s, "
                f"which is above {MAX_SPEED:g} m/s"
            )
        return across / step


class TurnAway(Strictly):
    """The reported track goes on from the onset and turns; altitude stays the true one."""

    type: Literal["turn_away"]
    angle_deg: BearingDeg = Field(description="total change of course, degrees, clockwise positive")
    rate_deg_s: Number = Field(gt=0.0, le=360.0, description="rate of turn, degrees/s")
    speed_m_s: Number | None = Field(
        None, ge=0.0, le=MAX_SPEED, description="reported ground speed, default the one at onset"
    )


class Replay(Strictly):
    """An earlier piece of the same flight is reported again."""

    type: Literal["replay"]
    from_s: TimeS = Field(description="start of the piece, seconds after the first message")


def _true_is_a_word(value: Any) -> Any:
    """YAML reads the bare word true as a boolean."""
    return "true" if value is True else value


class Freeze(Strictly):
    """The reported position stays at the last true one before onset."""

    type: Literal["freeze"]
    velocity: Annotated[Literal["frozen", "zero", "true"], BeforeValidator(_true_is_a_word)] = (
        Field("frozen", description="reported velocity: the last one, zero, or the true one")
    )


class Altitude(Strictly):
    """Only height is spoofed: a step, a ramp, or both."""

    type: Literal["altitude"]
    rate_m_s: Number = Field(0.0, ge=-MAX_SPEED, le=MAX_SPEED, description="ramp, m/s, up positive")
    step_m: Number = Field(0.0, ge=-50_000.0, le=50_000.0, description="step, m, up positive")
    onset_acceleration_m_s2: Number | None = Field(
        None, gt=0.0, le=1000.0, description="how fast the ramp builds up, m/s2, default at once"
    )

    @model_validator(mode="after")
    def _check_something(self) -> Altitude:
        if not self.model_fields_set & {"rate_m_s", "step_m"}:
            raise ValueError("rate_m_s: missing; give rate_m_s, step_m or both")
        return self


class Jitter(Strictly):
    """Gaussian noise on the fixes, the same for the same seed and stamp."""

    type: Literal["jitter"]
    sigma_m: Number = Field(ge=0.0, le=100_000.0, description="East and North each, metres")
    seed: Seed = Field(description="seed of the noise")
    vertical_sigma_m: Number = Field(0.0, ge=0.0, le=10_000.0, description="altitude, metres")
    sigma_m_s: Number = Field(0.0, ge=0.0, le=100.0, description="East and North velocity, m/s")


MIN_ACCURACY_M, MAX_ACCURACY_M = 0.001, 10_000.0
"""Metres; no receiver claims to be better, and one that claims to be worse has no fix."""
MIN_CORRELATION_S = 0.001
"""Chosen: far below the period of a fix."""
Counts: TypeAlias = tuple[Whole, ...]
Metres: TypeAlias = tuple[Number, ...]


class Forge(Strictly):
    """The values of parameters are generated with every update (Basan 2022, section 3.1).

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
    """Refuse a range that is not two numbers in order within the bounds."""
    if given is None:
        return
    if len(given) != 2:
        raise ValueError(f"{key}: has {len(given)} numbers, two are needed: [lowest, highest]")
    low, high = given
    if not lowest <= low <= high <= highest:
        raise ValueError(
            f"{key}: [{low!r}, {high!r}] is not [lowest, highest] within [{lowest:g}, {highest:g}]"
        )


Model = Annotated[
    Jump | Drift | FakeTrack | TurnAway | Replay | Freeze | Altitude | Jitter | Forge,
    Field(discriminator="type"),
]
MODELS: dict[str, type[Strictly]] = {
    "jump": Jump,
    "drift": Drift,
    "fake_track": FakeTrack,
    "turn_away": TurnAway,
    "replay": Replay,
    "freeze": Freeze,
    "altitude": Altitude,
    "jitter": Jitter,
    "forge": Forge,
}
"""Every attack model by the word that selects it."""


class Segment(Strictly):
    """One attack from `start_s` (inclusive) to `end_s` (exclusive, None for the flight's end)."""

    start_s: TimeS = Field(alias="start", description="onset, seconds after the first message")
    end_s: TimeS | None = Field(
        None, alias="end", description="end, seconds after the first message, default never"
    )
    name: Text = Field("", description="name in reports, default the model's type")
    velocity_consistent: Flag = Field(
        True, description="false: the reported velocity stays the true one"
    )
    model: Model = Field(description="the attack, selected by its key 'type'")

    @model_validator(mode="after")
    def _check_times(self) -> Segment:
        if self.end_s is not None and not self.end_s > self.start_s:
            raise ValueError(f"end: {self.end_s!r} is not after start ({self.start_s!r})")
        if isinstance(self.model, Replay) and not self.model.from_s < self.start_s:
            raise ValueError(
                f"model.from_s: {self.model.from_s!r} is not before start ({self.start_s!r})"
            )
        return self


class Document(Strictly):
    """A whole scenario file."""

    description: Annotated[str, Strict()] = Field("", description="what the scenario is for")
    segments: tuple[Segment, ...] = Field(min_length=1, description="the attacks")


def padded(row: Row) -> tuple[float, float, float, float]:
    """Return a row of a fake track with its height, 0 where it was left out."""
    return (row[0], row[1], row[2], row[3] if len(row) > 3 else 0.0)
