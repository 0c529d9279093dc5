# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The attack simulator of Basan et al. 2022: what is forged, its spread, and that it is pure."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hijack_detect.spoofing.scenario import ScenarioError, parse_scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.samples import NANOSECONDS, FixSample, SatelliteSample, VelocitySample

SOFT = {
    "type": "forge", "seed": 5, "altitude_sigma_m": 4.0, "satellites": [6, 20],
    "accuracy_m": [0.5, 8.0],
}  # fmt: skip
HARD = {
    **SOFT,
    "horizontal_sigma_m": 3.0, "velocity_sigma_m_s": 0.5, "drift_speed_m_s": 2.0,
    "bearing_deg": 90.0, "onset_acceleration_m_s2": 0.5,
}  # fmt: skip
START_NS = 1_000 * NANOSECONDS
STEP_NS = NANOSECONDS // 5


def spoofer(model: dict[str, object], **keys: object) -> Spoofer:
    segment = {"start": 0.0, "model": model, **keys}
    return Spoofer(parse_scenario({"segments": [segment]}), START_NS)


def forged(model: dict[str, object], count: int = 4000) -> np.ndarray:
    """East, North, up, velocity East and North, satellites and accuracy of a hover at 5 Hz."""
    made, rows = spoofer(model), []
    for index in range(count):
        stamp = START_NS + index * STEP_NS
        fix = made.fix(FixSample(stamp, 0.0, 10.0, 100.0, accuracy_m=1.0))
        velocity = made.velocity(VelocitySample(stamp, (0.0, 0.0, 0.0))).velocity
        number = made.satellites(SatelliteSample(stamp, 12)).count
        east = math.radians(fix.longitude_deg - 10.0) * 6_378_137.0
        north = math.radians(fix.latitude_deg) * 6_335_439.0  # radius of the meridian
        up = fix.altitude_m - 100.0
        rows.append((east, north, up, velocity[0], velocity[1], number, fix.accuracy_m))
    return np.array(rows)


def test_soft_forges_altitude_satellites_and_noise_level_only() -> None:
    rows = forged(SOFT)
    assert not rows[:, [0, 1, 3, 4]].any()
    assert rows[:, 2].mean() == pytest.approx(0.0, abs=0.2)
    assert rows[:, 2].std() == pytest.approx(4.0, rel=0.05)
    # 15 equally likely numbers: mean 13, variance (15² - 1) / 12 = 18.67.
    assert set(rows[:, 5]) == set(range(6, 21))
    assert rows[:, 5].mean() == pytest.approx(13.0, abs=0.2)
    assert rows[:, 5].var() == pytest.approx(18.67, rel=0.05)
    # Uniform on [0.5, 8]: mean 4.25, variance 7.5² / 12 = 4.69.
    assert rows[:, 6].mean() == pytest.approx(4.25, abs=0.1)
    assert rows[:, 6].var() == pytest.approx(4.69, rel=0.05)
    assert rows[:, 6].min() >= 0.5 and rows[:, 6].max() <= 8.0


def test_draws_are_independent_of_each_other_and_of_the_one_before() -> None:
    rows = forged({**HARD, "drift_speed_m_s": 0.0})
    correlations = np.corrcoef(rows.T)
    assert np.abs(correlations - np.eye(7)).max() < 0.06
    for column in rows.T:
        assert abs(np.corrcoef(column[:-1], column[1:])[0, 1]) < 0.06


def test_hard_forges_position_and_velocity_around_a_smooth_displacement() -> None:
    rows = forged(HARD, 2000)
    seconds = np.arange(2000) / 5.0
    # 2 m/s at 0.5 m/s² is reached after 4 s and 4 m.
    distance = np.where(seconds < 4.0, 0.25 * seconds**2, 4.0 + 2.0 * (seconds - 4.0))
    assert (rows[:, 0] - distance).mean() == pytest.approx(0.0, abs=0.3)
    assert (rows[:, 0] - distance).std() == pytest.approx(3.0, rel=0.06)
    assert rows[:, 1].std() == pytest.approx(3.0, rel=0.06)
    assert rows[20:, 3].mean() == pytest.approx(2.0, abs=0.05)
    assert rows[20:, 3].std() == pytest.approx(0.5, rel=0.06)
    assert rows[:, 4].std() == pytest.approx(0.5, rel=0.06)


def test_a_displacement_without_noise_has_the_velocity_of_its_position() -> None:
    model = {**HARD, "horizontal_sigma_m": 0.0, "velocity_sigma_m_s": 0.0}
    rows = forged(model, 100)
    slope = (rows[2:, 0] - rows[:-2, 0]) / 0.4
    inside = [*range(15), *range(25, 98)]  # the parabola ends at 4 s
    assert rows[1:-1, 3][inside] == pytest.approx(slope[inside], abs=1e-4)


def test_correlated_values_lie_on_lines_between_independent_knots() -> None:
    rows = forged({**SOFT, "correlation_s": 0.4}, 8000)
    knots, between = rows[::2], rows[1::2]
    assert knots[:, 2].std() == pytest.approx(4.0, rel=0.05)
    assert between[:, 2].std() == pytest.approx(4.0 / math.sqrt(2.0), rel=0.05)
    assert between[:-1, 2] == pytest.approx(0.5 * (knots[:-1, 2] + knots[1:, 2]), abs=1e-6)
    assert between[:-1, 6] == pytest.approx(0.5 * (knots[:-1, 6] + knots[1:, 6]), abs=1e-9)
    assert np.abs(between[:-1, 5] - 0.5 * (knots[:-1, 5] + knots[1:, 5])).max() <= 0.5
    assert abs(np.corrcoef(knots[:-1, 2], knots[1:, 2])[0, 1]) < 0.06


def test_what_is_left_out_stays_true() -> None:
    made = spoofer({"type": "forge", "seed": 0, "altitude_sigma_m": 1.0})
    number = SatelliteSample(START_NS, 12)
    assert made.satellites(number) is number
    assert made.fix(FixSample(START_NS, 1.0, 2.0, 3.0, accuracy_m=0.7)).accuracy_m == 0.7


def test_numbers_outside_the_segment_and_under_other_models_are_true() -> None:
    made = spoofer(SOFT, end=2.0)
    for t_s, same in ((-0.1, True), (0.0, False), (1.9, False), (2.0, True)):
        number = SatelliteSample(START_NS + round(t_s * NANOSECONDS), 3)  # below what is forged
        assert (made.satellites(number) is number) == same
    jump = spoofer({"type": "jump", "distance_m": 5.0, "bearing_deg": 0.0})
    assert jump.satellites(SatelliteSample(START_NS, 3)) == SatelliteSample(START_NS, 3)


@pytest.mark.parametrize("kind", ["freeze", "replay"])
def test_other_models_leave_the_claimed_accuracy(kind: str) -> None:
    model = {"type": "freeze"} if kind == "freeze" else {"type": "replay", "from_s": 1.0}
    segment = {"start": 2.0, "model": model}
    made = Spoofer(parse_scenario({"segments": [segment]}), START_NS)
    for index in range(20):
        stamp = START_NS + index * STEP_NS
        fix = FixSample(stamp, 0.001 * index, 0.0, 0.0, accuracy_m=1.0 + index)
        assert made.fix(fix).accuracy_m == 1.0 + index


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**63 - 1),
    correlation_s=st.sampled_from([0.0, 0.3, 2.0]),
    kept=st.sets(st.integers(0, 59), min_size=1),
    order=st.permutations(["fix", "velocity", "satellites"]),
)
def test_dropped_messages_and_their_order_change_nothing(
    seed: int, correlation_s: float, kept: set[int], order: list[str]
) -> None:
    model = {**HARD, "seed": seed, "correlation_s": correlation_s, "drift_speed_m_s": 0.0}
    whole, part = spoofer(model), spoofer(model)
    for index in range(60):
        stamp = START_NS + index * STEP_NS
        true = {
            "fix": FixSample(stamp, 0.0, 10.0, 100.0),
            "velocity": VelocitySample(stamp, (1.0, 2.0, 3.0)),
            "satellites": SatelliteSample(stamp, 12),
        }
        reported = {name: getattr(whole, name)(sample) for name, sample in true.items()}
        assert 6 <= reported["satellites"].count <= 20
        assert 0.5 <= reported["fix"].accuracy_m <= 8.0
        if index not in kept:
            continue
        for name in order:
            ours = getattr(part, name)(true[name])
            if name == "satellites":
                assert ours == reported[name]
            elif name == "fix":
                assert (ours.altitude_m, ours.accuracy_m) == (
                    reported[name].altitude_m,
                    reported[name].accuracy_m,
                )
            else:
                assert ours.velocity == pytest.approx(reported[name].velocity, abs=1e-4)


def test_another_seed_gives_other_values() -> None:
    assert not np.isclose(forged(SOFT, 20)[:, 2], forged({**SOFT, "seed": 6}, 20)[:, 2]).any()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"satellites": [5]}, "satellites: has 1 numbers, two are needed: [lowest, highest]"),
        ({"satellites": [9, 5]}, "satellites: [9, 5] is not [lowest, highest] within [0, 200]"),
        ({"satellites": [-1, 5]}, "satellites: [-1, 5] is not [lowest, highest] within [0, 200]"),
        ({"satellites": [1.5, 5]}, "satellites: number 1: 1.5 is not a whole number"),
        ({"accuracy_m": [0, 5]}, "accuracy_m: [0.0, 5.0] is not [lowest, highest] within [0.001"),
        ({"accuracy_m": 5}, "accuracy_m: 5 is not a list"),
        ({"correlation_s": 1e-6}, "correlation_s: 1e-06 is neither 0 nor at least 0.001 s"),
        ({"altitude_sigma_m": -1}, "altitude_sigma_m: -1 is below 0"),
        ({"onset_acceleration_m_s2": 0}, "onset_acceleration_m_s2: 0 is not above 0"),
        ({"sattelites": [1, 2]}, "sattelites: unknown key; did you mean satellites?"),
    ],
)
def test_what_a_file_may_not_say(change: dict[str, object], said: str) -> None:
    segment = {"start": 1.0, "model": {**SOFT, **change}}
    with pytest.raises(ScenarioError) as error:
        parse_scenario({"segments": [segment]}, "soft.yaml")
    assert error.value.problems[0].startswith(f"soft.yaml: segment 1: model.{said}")


def test_a_model_written_as_yaml_reads_back() -> None:
    scenario = parse_scenario({"segments": [{"start": 1.0, "model": HARD}]})
    assert parse_scenario(scenario.to_yaml()).segments == scenario.segments


def test_a_late_number_does_not_stop_the_attack_that_runs() -> None:
    segments = [
        {"start": 0.0, "end": 1.0, "model": SOFT},
        {"start": 1.0, "model": {"type": "freeze"}},
    ]
    rows = []
    for late in (False, True):
        made = Spoofer(parse_scenario({"segments": segments}), START_NS)
        said = []
        for index in range(30):
            stamp = START_NS + index * STEP_NS
            said.append(made.fix(FixSample(stamp, 0.001 * index, 0.0, 0.0)).latitude_deg)
            if late:
                number = made.satellites(SatelliteSample(START_NS + 3 * STEP_NS, 0))
                assert number == spoofer(SOFT).satellites(number)
        rows.append(said)
    assert rows[0] == rows[1]
    assert rows[0][5:] == [0.004] * 25
