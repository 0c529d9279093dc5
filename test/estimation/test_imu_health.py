# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Rate, bursts, clipping, vibration and scale of an IMU, from noise of known size."""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hijack_detect.estimation.flight_phase import FlightPhaseParameters
from hijack_detect.estimation.imu_health import HELD_NS, ImuHealth
from hijack_detect.streams.samples import NANOSECONDS, ImuSample, Phase, Vector3

G = 9.80665
Array = npt.NDArray[np.float64]
STILL: Vector3 = (0.0, 0.0, 0.0)


def health() -> ImuHealth:
    p = FlightPhaseParameters()
    return ImuHealth(p.clip_share, p.max_vibration, p.max_force_error)


def forces(n: int, sigma: float, seed: int = 1, *, slow: bool = False) -> Array:
    """Specific force of a hover with noise of `sigma` an axis: white, or of 0.1 s."""
    noise = np.random.default_rng(seed).normal(0.0, 1.0, (n, 3))
    if slow:
        for k in range(1, n):
            noise[k] = 0.9 * noise[k - 1] + 0.436 * noise[k]
    found: Array = sigma * noise + [0.0, 0.0, G]
    return found


def feed(one: ImuHealth, values: Array, rate_hz: float, start_ns: int = 0) -> int:
    """Feed rows at a rate; return the last stamp."""
    stamp = start_ns
    for k, row in enumerate(values):
        stamp = start_ns + round((k + 1) * NANOSECONDS / rate_hz)
        one.add(ImuSample(stamp, STILL, tuple(row.tolist())))
    return stamp


def faults(values: Array, rate_hz: float, phase: Phase = Phase.FLYING) -> set[str]:
    """Every fault that is said while the rows arrive."""
    one = health()
    said = set()
    for k, row in enumerate(values):
        one.add(ImuSample(round((k + 1) * NANOSECONDS / rate_hz), STILL, tuple(row.tolist())))
        said.add(one.fault(phase))
    return said


@pytest.mark.parametrize("rate_hz", [2.0, 5.0, 10.0, 25.0, 50.0, 100.0, 200.0, 400.0, 1000.0])
def test_the_rate_is_counted_and_a_healthy_imu_has_no_fault(rate_hz: float) -> None:
    one = health()
    feed(one, forces(round(8 * rate_hz), 0.5), rate_hz)
    assert one.rate_hz == pytest.approx(rate_hz, rel=1e-6)
    assert one.fault(Phase.FLYING) == ""
    assert one.fault(Phase.STANDING) == ""


def test_the_rate_follows_a_change_within_its_window() -> None:
    one = health()
    at = feed(one, forces(500, 0.1), 100.0)
    feed(one, forces(50, 0.1), 10.0, at)
    assert one.rate_hz == pytest.approx(10.0, rel=0.03)


@pytest.mark.parametrize("limit", [11.8, 14.0, 19.6, 39.2, 60.0])
@pytest.mark.parametrize("beyond", [0.02, 0.05])
def test_clipping_is_named_with_its_limit(limit: float, beyond: float) -> None:
    """Of noise that is beyond the limit for this share of time, on the axis of the weight."""
    sigma = (limit - G) / {0.02: 2.05, 0.05: 1.65}[beyond]
    clipped = np.clip(forces(4000, sigma, slow=True), -limit, limit)
    assert faults(clipped, 400.0) - {""} == {f"the accelerometer clips at {limit:.0f} m/s²"}


@pytest.mark.parametrize("rate_hz", [50.0, 100.0, 200.0])
def test_clipping_at_14_is_named_within_6_s(rate_hz: float) -> None:
    clipped = np.clip(forces(round(6 * rate_hz), 2.5), -14.0, 14.0)
    assert "the accelerometer clips at 14 m/s²" in faults(clipped, rate_hz)


@pytest.mark.parametrize("step", [0.001, 0.01, 0.04, 0.08, 0.15, 0.3])
@pytest.mark.parametrize("sigma", [0.05, 0.2, 1.0, 3.0])
def test_a_coarse_but_healthy_sensor_does_not_clip(step: float, sigma: float) -> None:
    """By chance one of six runs of 16 s may; without a test of chance all of them do."""
    runs = [
        np.round(forces(800, sigma, seed, slow=slow) / step) * step
        for seed in range(3)
        for slow in (False, True)
    ]
    assert sum(faults(one, 50.0) != {""} for one in runs) <= 1


def test_an_axis_that_is_stuck_or_absent_does_not_clip() -> None:
    flat = forces(400, 0.3)
    flat[:, 0] = 0.0
    assert faults(flat, 50.0) == {""}


def test_clipping_is_kept_until_a_filter_has_recovered() -> None:
    one = health()
    at = feed(one, np.clip(forces(400, 4.0), -14.0, 14.0), 100.0)
    assert "clips" in one.fault(Phase.FLYING)
    at = feed(one, forces(round(0.9 * HELD_NS / NANOSECONDS * 100), 0.3), 100.0, at)
    assert "clips" in one.fault(Phase.FLYING)
    feed(one, forces(round(0.5 * HELD_NS / NANOSECONDS * 100), 0.3), 100.0, at)
    assert one.fault(Phase.FLYING) == ""


@pytest.mark.parametrize("rate_hz", [25.0, 50.0, 200.0, 400.0])
def test_vibration_is_judged_over_the_root_of_the_rate(rate_hz: float) -> None:
    """White noise has a density: a faster IMU shows a larger deviation of the same vibration."""
    limit = FlightPhaseParameters().max_vibration * np.sqrt(rate_hz / 3.0)  # of each axis
    n = round(6 * rate_hz)
    assert not any("vibrates" in one for one in faults(forces(n, 0.8 * limit), rate_hz))
    assert any("vibrates" in one for one in faults(forces(n, 1.2 * limit), rate_hz))


def test_a_manoeuvre_of_a_slow_imu_is_no_vibration() -> None:
    hard = forces(60, 6.0)
    assert not any("vibrates" in one for one in faults(hard, 10.0))


def bursts(count: int, every_ms: int, n: int) -> Iterator[int]:
    """Stamps of bursts of `count` samples 1 ms apart, one every `every_ms`."""
    for k in range(n):
        yield (1 + k // count * every_ms + k % count) * 1_000_000


def test_bursts_are_named() -> None:
    one = health()
    for stamp, row in zip(bursts(10, 200, 400), forces(400, 0.1), strict=True):
        one.add(ImuSample(stamp, STILL, tuple(row.tolist())))
    assert one.fault(Phase.FLYING) == "IMU samples come in bursts"


@pytest.mark.parametrize("gap_s", [0.3, 1.0, 3.0, 10.0])
@pytest.mark.parametrize("rate_hz", [20.0, 50.0, 200.0])
def test_one_gap_is_no_burst(gap_s: float, rate_hz: float) -> None:
    one = health()
    at = feed(one, forces(round(5 * rate_hz), 0.1), rate_hz)
    for k, row in enumerate(forces(round(5 * rate_hz), 0.1)):
        stamp = at + round((gap_s + k / rate_hz) * NANOSECONDS)
        one.add(ImuSample(stamp, STILL, tuple(row.tolist())))
        assert one.fault(Phase.FLYING) == ""


@pytest.mark.parametrize("jitter", [0.3, 0.6, 0.9])
def test_jitter_is_no_burst(jitter: float) -> None:
    rng = np.random.default_rng(4)
    one, stamp = health(), 0
    for row in forces(500, 0.1):
        stamp += round(0.02 * NANOSECONDS * rng.uniform(1.0 - jitter, 1.0 + jitter))
        one.add(ImuSample(stamp, STILL, tuple(row.tolist())))
        assert one.fault(Phase.FLYING) == ""


@pytest.mark.parametrize(("scale", "said"), [(1.0 / G, "1.0"), (3.28084, "32.")])
def test_a_wrong_unit_is_named_at_rest_and_remembered_in_flight(scale: float, said: str) -> None:
    one = health()
    feed(one, scale * forces(400, 0.05), 50.0)
    assert one.fault(Phase.STANDING).startswith(f"at rest the specific force is {said}")
    assert one.fault(Phase.FLYING)


@pytest.mark.parametrize("scale", [1.0 / G, 3.28084])
def test_a_wrong_unit_is_named_in_flight_without_a_rest_before(scale: float) -> None:
    said = faults(scale * forces(600, 0.5), 50.0)
    assert any("the mean specific force in flight is" in one for one in said)


@pytest.mark.parametrize("error", [-0.6, 0.6])
def test_the_error_of_recorded_vehicles_is_no_fault(error: float) -> None:
    one = health()
    feed(one, (1.0 + error / G) * forces(400, 0.05), 50.0)
    assert one.fault(Phase.STANDING) == ""


def test_a_turn_with_60_degrees_of_bank_is_no_fault() -> None:
    assert faults(2.0 * forces(1500, 0.2), 50.0) == {""}


def test_the_mean_force_says_nothing_of_a_vehicle_in_a_hand() -> None:
    one = health()
    feed(one, 0.5 * forces(400, 0.5), 50.0)
    assert one.fault(Phase.HANDLED) == ""


finite = st.floats(-1e6, 1e6)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(
        st.tuples(st.integers(1, 20 * NANOSECONDS), finite, finite, finite),
        min_size=1,
        max_size=80,
    ),
    st.sampled_from(Phase),
)
def test_no_readings_break_it(rows: list[tuple[int, float, float, float]], phase: Phase) -> None:
    one, stamp = health(), 0
    for after_ns, x, y, z in rows:
        stamp += after_ns
        one.add(ImuSample(stamp, STILL, (x, y, z)))
        assert isinstance(one.fault(phase), str)
        assert one.rate_hz >= 0.0
