# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""From a segment of a scenario to the attack that runs."""

from __future__ import annotations

from hijack_detect.spoofing import schema
from hijack_detect.spoofing.attacks import (
    Attack,
    FreezeAttack,
    OffsetAttack,
    Recording,
    ReplayAttack,
    TrackAttack,
)
from hijack_detect.spoofing.forge import ForgeAttack
from hijack_detect.spoofing.forge_schema import Forge
from hijack_detect.spoofing.history import History
from hijack_detect.spoofing.offsets import make_offset
from hijack_detect.spoofing.onset import Onset
from hijack_detect.spoofing.tracks import make_track
from hijack_detect.streams.samples import NANOSECONDS


def record(model: schema.Replay, start_s: float, start_ns: int, end_ns: int | None) -> Recording:
    """Prepare the recording for a replay; feed it every true sample from the first on."""
    lag_ns = round((start_s - model.from_s) * NANOSECONDS)
    until_ns = None if end_ns is None else end_ns - lag_ns
    return Recording(
        lag_ns, History(start_ns - lag_ns, until_ns), History(start_ns - lag_ns, until_ns)
    )


def make_attack(segment: schema.Segment, onset: Onset, recording: Recording | None) -> Attack:
    """Build the attack of a segment for the vehicle's state at onset.

    Raises:
        ValueError: A replay has no recording.
    """
    model = segment.model
    if isinstance(model, schema.Replay):
        if recording is None:
            raise ValueError("a replay needs a recording")
        return ReplayAttack(recording)
    if isinstance(model, schema.Freeze):
        return FreezeAttack(model, onset)
    if isinstance(model, schema.FakeTrack | schema.TurnAway):
        return TrackAttack(make_track(model, onset), onset)
    if isinstance(model, Forge):
        return ForgeAttack(model, onset)
    return OffsetAttack(make_offset(model, onset.course), onset)
