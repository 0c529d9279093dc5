# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A jammed receiver reports what its kind says, and carry-offs differ in the jamming only."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments import jamming
from experiments.jammed_receiver import REACH_M, Carried, CarryOff, Degraded, lost, poor
from experiments.jamming import Outcome, flown, table
from hijack_detect.estimation.geodesy import TangentPlane
from hijack_detect.streams.samples import FixSample, ImuSample, SatelliteSample, VelocitySample

ROOT = Path(__file__).parents[2]
S = 1_000_000_000
FIX = FixSample(S, 47.0, 8.0, 500.0, accuracy_m=1.5, vertical_accuracy_m=2.0)


def at(stamp_ns: int, **values: float | None) -> FixSample:
    return dataclasses.replace(FIX, stamp_ns=stamp_ns, **values)  # type: ignore[arg-type]


def test_a_receiver_without_fix_has_no_velocity_and_too_few_satellites() -> None:
    assert lost(VelocitySample(S, (1.0, 2.0, 0.0))) is None
    assert lost(FIX) == dataclasses.replace(FIX, has_fix=False)
    assert lost(SatelliteSample(S, 12)) == SatelliteSample(S, 3)
    assert lost(SatelliteSample(S, 2)) == SatelliteSample(S, 2)
    imu = ImuSample(S, (0.0, 0.0, 0.0), (0.0, 0.0, 9.8))
    assert lost(imu) is imu


def test_a_poor_receiver_claims_four_times_as_much_and_nothing_where_it_claimed_nothing() -> None:
    assert poor(FIX) == at(S, accuracy_m=6.0, vertical_accuracy_m=8.0)
    silent = at(S, accuracy_m=None, vertical_accuracy_m=None)
    assert poor(silent) == silent
    assert poor(SatelliteSample(S, 12)) == SatelliteSample(S, 5)


def test_noise_is_as_large_as_it_says_fades_and_leaves_absent_components_absent() -> None:
    jammed, plane = Degraded(1, 4000 * S), TangentPlane(FIX)
    sent = VelocitySample(S, (3.0, 0.0, math.nan))
    places, east = [], []
    for t in range(S, 4200 * S, S // 5):
        velocity = jammed(dataclasses.replace(sent, stamp_ns=t))
        fix = jammed(at(t))
        assert isinstance(velocity, VelocitySample)
        assert isinstance(fix, FixSample)
        places.append(plane.enu(fix))
        east.append(velocity.velocity[0])
        assert not velocity.has_vertical
    noise = slice(500, 4000 * 5)
    np.testing.assert_allclose(np.std(places[noise], axis=0), 2.0, rtol=0.2)
    assert np.mean(east[noise]) == pytest.approx(3.0, abs=0.1)
    assert np.std(east[noise]) == pytest.approx(0.5, rel=0.1)
    assert np.linalg.norm(places[-1]) < 0.01
    flat = jammed(at(4300 * S, altitude_m=math.nan))
    assert isinstance(flat, FixSample)
    assert not flat.has_altitude


@given(
    acceleration=st.floats(0.3, 6.0),
    displaced_m=st.sampled_from([0.0, 10.0]),
    bearing_deg=st.floats(0.0, 360.0),
)
def test_a_carry_off_is_60_m_off_when_it_says(
    acceleration: float, displaced_m: float, bearing_deg: float
) -> None:
    one = CarryOff(2 * S, acceleration, bearing_deg, displaced_m)
    before = [at(S), VelocitySample(S, (0.0, 0.0, 0.0))]
    carried = Carried(one, 0, before)
    first = carried(at(2 * S))
    assert carried.separation_m == pytest.approx(displaced_m)
    end = carried(at(2 * S + round(one.reach_s * S)))
    assert carried.separation_m == pytest.approx(REACH_M, abs=0.01)
    assert isinstance(first, FixSample)
    assert isinstance(end, FixSample)
    for fix, size in ((first, displaced_m), (end, REACH_M)):
        east, north, _ = TangentPlane(FIX).enu(fix)
        bearing = math.radians(bearing_deg)
        assert east == pytest.approx(size * math.sin(bearing), abs=0.05)
        assert north == pytest.approx(size * math.cos(bearing), abs=0.05)


def test_gains_are_those_of_the_same_carry_offs() -> None:
    rows = [
        Outcome("a", "carried", 0, 50.0, alert_s=3.0, separation_m=4.0),
        Outcome("b", "carried", 0, 50.0, alert_s=4.0, separation_m=8.0),
        Outcome("c", "carried", 0, 50.0),
        Outcome("a", "carried", 5, 50.0, alert_s=5.0, separation_m=12.0),
        Outcome("b", "carried", 5, 50.0),
        Outcome("c", "carried", 5, 50.0, jam_alert_s=2.0),
    ]
    plain, jammed = table(rows).rows
    assert plain[3].startswith("2/3")
    assert jammed[2].startswith("1/3")
    assert jammed[3].startswith("1/2")
    assert jammed[6:8] == ("1", "0")
    assert jammed[8].startswith("+2.0")
    assert jammed[9].startswith("+8.0")


@pytest.fixture
def lengths(monkeypatch: pytest.MonkeyPatch) -> Callable[[tuple[int, ...]], None]:
    """Sets the lengths of the jamming."""
    return lambda some: monkeypatch.setattr(jamming, "LENGTHS_S", some)


@pytest.mark.slow
def test_jamming_on_a_simulated_flight(lengths: Callable[[tuple[int, ...]], None]) -> None:
    lengths((0, 5))
    done = {
        (one.kind, one.length_s): one for one in flown(ROOT / "bags" / "curved_8", 1.0, 1, 20.0)
    }
    assert set(done) == {  # this receiver claims no accuracy
        ("carried", 0),
        ("displaced", 0),
        *((kind, 5) for kind in ("back", "carried", "displaced")),
    }
    assert done["back", 5].alert_s is None
    assert done["back", 5].jam_states["gnss"].keys() == {"not_observable"}
    assert done["carried", 0].alert_s is not None
    assert len({one.place for one in done.values()}) == 1
