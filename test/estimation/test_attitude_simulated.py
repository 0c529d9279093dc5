# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The attitude estimator on flights of the package's own simulator, against their truth."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest

from hijack_detect.estimation.attitude import AttitudeEstimator
from hijack_detect.estimation.attitude_parameters import AttitudeParameters
from hijack_detect.simulation.flight import Flight
from hijack_detect.simulation.plan import forward_start_s
from hijack_detect.streams.samples import AttitudeSample, Sample

Sent = list[tuple[str, Sample]]
Array = npt.NDArray[np.float64]
Errors = Callable[[Flight, list[AttitudeSample]], Array]
GPS = ("imu", "fix", "velocity")
ALL = (*GPS, "mag")


def run(sent: Sent, **parameters: object) -> tuple[list[AttitudeSample], AttitudeEstimator]:
    estimator = AttitudeEstimator(AttitudeParameters.from_mapping(parameters))
    outputs = (estimator.update(name, sample) for name, sample in sent)
    return [output for output in outputs if output is not None], estimator


def between(sent: Sent, flight: Flight, start_s: float, end_s: float = 1e9) -> Sent:
    start = flight.plan.start_ns
    return [one for one in sent if start_s <= (one[1].stamp_ns - start) / 1e9 < end_s]


def without(sent: Sent, flight: Flight, names: tuple[str, ...], start: float, end: float) -> Sent:
    lost = {id(sample) for name, sample in between(sent, flight, start, end) if name in names}
    return [one for one in sent if id(one[1]) not in lost]


def rms(rows: Array) -> Array:
    """Root mean square of roll, pitch and yaw errors, degrees."""
    assert len(rows) > 1000
    result: Array = np.sqrt(np.mean(np.square(rows[:, 1:]), axis=0))
    return result


@pytest.mark.parametrize("inputs", [ALL, GPS, ("imu", "fix", "mag"), ("imu", "fix")])
@pytest.mark.parametrize("seed", [1, 2])
def test_curved_flight(
    seed: int,
    inputs: tuple[str, ...],
    flight: Callable[..., Flight],
    samples: Callable[..., Sent],
    errors: Errors,
) -> None:
    curved = flight("curved", seed)
    found = errors(curved, run(samples(curved, *inputs))[0])
    roll, pitch, yaw = rms(found)
    assert roll < 1.0
    assert pitch < 1.0
    assert yaw < 4.0
    assert np.max(abs(found[:, 1:3])) < 4.0


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_straight_flight_with_a_magnetometer(
    seed: int, flight: Callable[..., Flight], samples: Callable[..., Sent], errors: Errors
) -> None:
    straight = flight("straight", seed)
    roll, pitch, yaw = rms(errors(straight, run(samples(straight, *ALL))[0]))
    assert roll < 1.0
    assert pitch < 1.0
    assert yaw < 4.0


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_straight_flight_without_a_magnetometer_says_how_uncertain_its_heading_is(
    seed: int, flight: Callable[..., Flight], samples: Callable[..., Sent], errors: Errors
) -> None:
    """Nothing shows the heading there: it drifts, and its stated deviation must grow with it."""
    straight = flight("straight", seed)
    outputs = run(samples(straight, *GPS))[0]
    found = errors(straight, outputs)
    roll, pitch, _ = rms(found)
    assert roll < 2.5
    assert pitch < 2.5
    known = [one for one in outputs if one.orientation is not None]
    sigma = np.degrees(np.sqrt([one.heading_variance for one in known]))
    assert np.max(sigma) > 12.0
    assert np.max(abs(found[:, 3]) / sigma) < 3.0


def test_straight_flight_from_fixes_alone_is_unknown_until_braking_shows_the_heading(
    flight: Callable[..., Flight], samples: Callable[..., Sent]
) -> None:
    straight = flight("straight", 1)
    cruise = between(samples(straight, "imu", "fix"), straight, 0.0, 70.0)
    assert all(one.orientation is None for one in run(cruise)[0])


def test_the_heading_is_unknown_while_hovering_without_a_magnetometer(
    flight: Callable[..., Flight], samples: Callable[..., Sent]
) -> None:
    curved = flight("curved", 1)
    hover = between(samples(curved, *GPS), curved, 0.0, forward_start_s(curved.plan))
    outputs = run(hover)[0]
    assert len(outputs) > 2000
    assert all(one.orientation is None for one in outputs)
    assert all(one.heading_variance == np.inf for one in outputs)


def test_the_heading_is_known_while_hovering_with_a_magnetometer(
    flight: Callable[..., Flight], samples: Callable[..., Sent], errors: Errors
) -> None:
    curved = flight("curved", 1)
    hover = between(samples(curved, *ALL), curved, 0.0, forward_start_s(curved.plan))
    found = errors(curved, run(hover)[0])
    assert found[0, 0] < 2.0
    assert np.max(abs(found[:, 3])) < 8.0


def test_use_mag_false_ignores_the_magnetometer(
    flight: Callable[..., Flight], samples: Callable[..., Sent]
) -> None:
    curved = flight("curved", 1)
    ignoring = run(samples(curved, *ALL), use_mag=False)[0]
    assert ignoring == run(samples(curved, *GPS))[0]


def test_every_imu_sample_gives_an_output_with_its_readings(
    flight: Callable[..., Flight], samples: Callable[..., Sent]
) -> None:
    curved = flight("curved", 1)
    outputs = run(samples(curved, *GPS))[0]
    assert [one.stamp_ns for one in outputs] == [one.stamp_ns for one in curved.imu]
    assert outputs[777].angular_velocity == curved.imu[777].angular_velocity
    assert outputs[777].specific_force == curved.imu[777].specific_force
    norms = [np.linalg.norm(one.orientation) for one in outputs if one.orientation is not None]
    assert norms == pytest.approx([1.0] * len(norms), abs=1e-9)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_start_in_flight(
    seed: int, flight: Callable[..., Flight], samples: Callable[..., Sent], errors: Errors
) -> None:
    curved = flight("curved", seed)
    late = between(samples(curved, *GPS), curved, 40.0)
    found = errors(curved, run(late)[0])
    assert 40.0 < found[0, 0] < 55.0
    settled = found[found[:, 0] > found[0, 0] + 10.0]
    roll, pitch, yaw = rms(settled)
    assert roll < 1.0
    assert pitch < 1.0
    assert yaw < 4.0


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_start_in_flight_with_a_compass(
    seed: int, flight: Callable[..., Flight], samples: Callable[..., Sent], errors: Errors
) -> None:
    """A wrong tilt turns the horizontal part of a steep field; the filter knows by how much."""
    curved = flight("curved", seed)
    late = between(samples(curved, *GPS, "mag"), curved, 40.0)
    found = errors(curved, run(late)[0])
    settled = found[found[:, 0] > found[0, 0] + 2.0]
    roll, pitch, yaw = rms(settled)
    assert max(roll, pitch) < 1.5
    assert yaw < 5.0


def test_a_gap_in_the_imu_data_starts_afresh(
    flight: Callable[..., Flight], samples: Callable[..., Sent], errors: Errors
) -> None:
    curved = flight("curved", 2)
    gapped = without(samples(curved, *GPS), curved, ("imu",), 50.0, 52.0)
    outputs = run(gapped)[0]
    start = curved.plan.start_ns
    first = next(one for one in outputs if one.stamp_ns >= start + 50 * 10**9)
    assert first.orientation is None
    assert first.heading_variance == np.inf
    found = errors(curved, outputs)
    after = found[found[:, 0] > 52.0]
    assert after[0, 0] < 70.0
    assert np.all(rms(after) < [1.5, 1.5, 4.0])


def test_a_short_gap_in_the_imu_data_does_not_start_afresh(
    flight: Callable[..., Flight], samples: Callable[..., Sent], errors: Errors
) -> None:
    curved = flight("curved", 2)
    gapped = without(samples(curved, *GPS), curved, ("imu",), 50.0, 50.5)
    found = errors(curved, run(gapped)[0])
    assert np.any(abs(found[:, 0] - 50.51) < 0.02)
    assert np.max(abs(found[found[:, 0] > 55.0][:, 1:3])) < 4.0


def test_gps_outage_of_20_seconds(
    flight: Callable[..., Flight], samples: Callable[..., Sent], errors: Errors
) -> None:
    curved = flight("curved", 3)
    sent = without(samples(curved, *GPS), curved, ("fix", "velocity"), 45.0, 65.0)
    outputs, _ = run(sent)
    found = errors(curved, outputs)
    during = found[(found[:, 0] > 45.0) & (found[:, 0] < 65.0)]
    assert len(during) == 2000 - 1
    assert np.max(abs(during[:, 1:3])) < 2.0
    assert np.max(abs(during[:, 3])) < 6.0
    after = found[found[:, 0] > 65.0]
    assert np.max(abs(after[:, 1:3])) < 3.0
    assert np.max(abs(after[:, 3])) < 6.0


def test_the_heading_grows_uncertain_in_an_outage(
    flight: Callable[..., Flight], samples: Callable[..., Sent]
) -> None:
    curved = flight("curved", 3)
    sent = without(samples(curved, *GPS), curved, ("fix", "velocity"), 45.0, 65.0)
    variance = {one.stamp_ns - curved.plan.start_ns: one.heading_variance for one in run(sent)[0]}
    assert variance[64_900_000_000] > 1.5 * variance[44_900_000_000]


@pytest.mark.parametrize("off_s", [-0.14, 0.14, 0.25])
def test_a_wrong_gps_lag_tilts_the_attitude_in_manoeuvres(
    off_s: float, flight: Callable[..., Flight], samples: Callable[..., Sent], errors: Errors
) -> None:
    curved = flight("curved", 4)
    sent = samples(curved, *GPS)
    lag_s = curved.conditions.gps_lag_s
    right = np.hypot(*rms(errors(curved, run(sent, gps_lag_s=lag_s)[0]))[:2])
    wrong = np.hypot(*rms(errors(curved, run(sent, gps_lag_s=lag_s + off_s)[0]))[:2])
    assert wrong > 1.7 * right


@pytest.mark.parametrize("seed", [1, 2, 5])
def test_the_gyro_bias_is_found(
    seed: int, flight: Callable[..., Flight], samples: Callable[..., Sent]
) -> None:
    """The simulator's bias is about 0.3°/s; it shows while the vehicle stands."""
    curved = flight("curved", seed)
    readings = np.array([one.angular_velocity for one in curved.imu[1:500]])
    bias = np.degrees(np.mean(readings - curved.motion.angular_velocity[1:500], axis=0))
    _, estimator = run(samples(curved, *ALL))
    assert estimator.ekf is not None
    found = np.degrees(estimator.ekf.gyro_bias)
    assert np.max(abs(bias)) > 0.3
    np.testing.assert_allclose(found, bias, atol=0.2)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_accelerometer_bias_is_found(
    seed: int, flight: Callable[..., Flight], samples: Callable[..., Sent]
) -> None:
    curved = flight("curved", seed)
    readings = np.array([one.specific_force for one in curved.imu[:500]])
    bias = np.mean(readings - curved.motion.specific_force[:500], axis=0)
    _, estimator = run(samples(curved, *ALL))
    assert estimator.ekf is not None
    np.testing.assert_allclose(estimator.ekf.accel_bias, bias, atol=0.1)


@pytest.mark.parametrize("first_order", [False, True])
def test_the_papers_integration(
    first_order: bool,
    flight: Callable[..., Flight],
    samples: Callable[..., Sent],
    errors: Errors,
) -> None:
    """Level at the first course, never corrected: yaw follows the turns, tilt keeps its error."""
    curved = flight("curved", 1)
    outputs = run(samples(curved, *GPS), method="quaternion", first_order=first_order)[0]
    first = next(one for one in outputs if one.orientation is not None)
    x, y, _, _ = first.orientation or (1.0, 1.0, 1.0, 1.0)
    assert np.hypot(x, y) < 1e-3
    roll, pitch, yaw = rms(errors(curved, outputs))
    assert yaw < 8.0
    assert max(roll, pitch) > 4.0
    assert max(roll, pitch) < 30.0


def test_no_fix_messages_change_nothing(
    flight: Callable[..., Flight], samples: Callable[..., Sent]
) -> None:
    curved = flight("curved", 1)
    lost = [
        (name, type(one)(one.stamp_ns + 1, 0.0, 0.0, 0.0, False)) if name == "fix" else (name, one)
        for name, one in samples(curved, "imu", "fix")
    ]
    outputs, estimator = run(lost)
    assert all(one.orientation is None for one in outputs)
    assert estimator.ekf is not None
    assert abs(estimator.ekf.position[2]) < 1e4


def test_the_same_samples_give_the_same_bits(
    flight: Callable[..., Flight], samples: Callable[..., Sent]
) -> None:
    curved = flight("curved", 1)
    sent = between(samples(curved, *ALL), curved, 0.0, 40.0)
    assert run(sent)[0] == run(sent)[0]
