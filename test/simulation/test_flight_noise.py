"""The sensors of a simulated flight are as bad as real ones, and the same for the same seed."""

import numpy as np
import pytest

from hijack_detect.simulation.flight import generate_flight
from hijack_detect.simulation.plan import FlightPlan

PLAN = FlightPlan(route="curved", duration_s=70.0)


def test_same_seed_same_flight() -> None:
    first, second, other = (generate_flight(PLAN, seed) for seed in (7, 7, 8))
    for name in ("imu", "fixes", "velocities", "satellites", "magnetics", "pressures"):
        assert getattr(first, name) == getattr(second, name)
        assert getattr(first, name) != getattr(other, name)
    assert first.truth_attitudes == second.truth_attitudes


def test_rates() -> None:
    flight = generate_flight(PLAN, 1)
    assert len(flight.imu) == 7001
    assert len(flight.fixes) == len(flight.velocities) == len(flight.satellites) == 350
    assert len(flight.magnetics) == len(flight.pressures) == len(flight.truth_fixes) == 701


def test_imu_errors() -> None:
    errors = []
    for seed in range(20):
        flight = generate_flight(PLAN, seed)
        measured = np.array([sample.angular_velocity for sample in flight.imu])
        errors.append((measured - flight.motion.angular_velocity).mean(axis=0))
        felt = np.array([sample.specific_force for sample in flight.imu])
        noise = (felt - flight.motion.specific_force)[3000:].std(axis=0)
        assert np.all((noise > 0.05) & (noise < 0.3))
    assert np.degrees(np.std(errors)) == pytest.approx(0.3, rel=0.3)


def test_position_noise_is_correlated() -> None:
    values, steps = [], []
    for seed in range(20):
        flight = generate_flight(PLAN, seed)
        north = np.array([fix.latitude_deg for fix in flight.fixes[:25]]) * 111_000.0
        values.append(north[0] + 35.363 * 111_000.0)
        steps.append(np.diff(north).std())
    assert 0.3 < np.std(values) < 0.8
    assert np.mean(steps) < 0.12


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"route": "loop"}, "route is 'loop'"),
        ({"duration_s": 59.0}, "duration is 59.0"),
        ({"speed": 0.0}, "speed is 0.0"),
        ({"height_m": 121.0}, "height is 121.0"),
        ({"duration_s": 60.0, "height_m": 100.0}, "less than 20 s for the route"),
    ],
)
def test_plans_that_cannot_be_flown(change: dict[str, object], reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        FlightPlan(**change)  # type: ignore[arg-type]
