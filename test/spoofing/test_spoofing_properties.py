# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Whatever a valid scenario says, the output is finite, on the globe, and repeatable."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hijack_detect.spoofing.scenario import ScenarioError, parse_scenario

bearings = st.floats(-360, 360)
speeds = st.floats(0, 1000)
positive = st.floats(1e-6, 1000)


@st.composite
def positions(draw):
    """A list of positions that no leg of needs more than 1000 m/s."""
    t, place, rows = 0.0, [0.0, 0.0, 0.0], []
    for _ in range(draw(st.integers(2, 6))):
        rows.append([t, *place])
        step = draw(st.floats(0.01, 5.0))
        t += step
        place = [part + step * draw(st.floats(-500, 500)) for part in place]
    return rows


models = st.one_of(
    st.fixed_dictionaries(
        {
            "type": st.just("jump"),
            "distance_m": st.floats(0, 1e6),
            "bearing_deg": bearings,
            "relative": st.booleans(),
        }
    ),
    st.fixed_dictionaries(
        {
            "type": st.just("drift"),
            "speed_m_s": speeds,
            "bearing_deg": bearings,
            "onset_acceleration_m_s2": positive,
        }
    ),
    st.fixed_dictionaries(
        {
            "type": st.just("fake_track"),
            "positions": positions(),
            "frame": st.sampled_from(["enu", "course"]),
        }
    ),
    st.fixed_dictionaries(
        {
            "type": st.just("turn_away"),
            "angle_deg": bearings,
            "rate_deg_s": st.floats(1e-9, 360),
            "speed_m_s": speeds | st.none(),
        }
    ),
    st.fixed_dictionaries({"type": st.just("replay"), "from_s": st.floats(0, 1.9)}),
    st.fixed_dictionaries(
        {"type": st.just("freeze"), "velocity": st.sampled_from(["frozen", "zero", "true"])}
    ),
    st.fixed_dictionaries(
        {
            "type": st.just("altitude"),
            "rate_m_s": st.floats(-1000, 1000),
            "step_m": st.floats(-5e4, 5e4),
            "onset_acceleration_m_s2": positive | st.none(),
        }
    ),
    st.fixed_dictionaries(
        {
            "type": st.just("jitter"),
            "sigma_m": st.floats(0, 1e5),
            "seed": st.integers(0, 2**63 - 1),
            "vertical_sigma_m": st.floats(0, 1e4),
            "sigma_m_s": st.floats(0, 100),
        }
    ),
    st.fixed_dictionaries(
        {
            "type": st.just("forge"),
            "seed": st.integers(0, 2**63 - 1),
            "altitude_sigma_m": st.floats(0, 1e4),
            "accuracy_m": st.sampled_from([[0.001, 1e4], [1, 1]]),
            "horizontal_sigma_m": st.floats(0, 1e5),
            "velocity_sigma_m_s": st.floats(0, 100),
            "drift_speed_m_s": speeds,
            "bearing_deg": bearings,
            "relative": st.booleans(),
            "onset_acceleration_m_s2": positive,
            "correlation_s": st.just(0) | st.floats(0.001, 1000),
        }
    ),
)


@settings(max_examples=150, deadline=None)
@given(
    model=models,
    start=st.floats(2.0, 6.0),
    path=st.sampled_from(["straight", "waving", "hover"]),
    latitude=st.floats(-90, 90) | st.sampled_from([89.9, -89.9, 90.0, -90.0]),
    longitude=st.floats(-180, 180) | st.sampled_from([180.0, -180.0, 179.99999]),
)
def test_any_valid_scenario_gives_places_on_the_globe(
    tools, model, start, path, latitude, longitude
):
    flight = tools.flight(path, latitude, longitude, seconds=8.0)
    scenario = {"segments": [{"start": start, "model": model}]}
    spoofed = tools.run(flight, scenario)
    for fix in spoofed.fixes:
        assert -90.0 <= fix.latitude_deg <= 90.0
        assert -180.0 <= fix.longitude_deg <= 180.0
        assert math.isfinite(fix.altitude_m)
    assert all(math.isfinite(part) for v in spoofed.velocities for part in v.velocity)
    assert tools.run(flight, scenario, "vf") == spoofed
    assert all(type(part) is float for v in spoofed.velocities for part in v.velocity)


values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(["type", "start", "end", "model", "positions", "name", "from_s"]),
            inner,
            max_size=4,
        )
    ),
    max_leaves=12,
)


@settings(max_examples=300, deadline=None)
@given(segments=st.lists(values, min_size=1, max_size=3))
def test_nonsense_is_refused_with_the_name_of_the_file(segments):
    with pytest.raises(ScenarioError) as error:
        parse_scenario({"segments": segments}, "odd.yaml")
    assert all(said.startswith("odd.yaml: ") for said in error.value.problems)


@settings(max_examples=300, deadline=None)
@given(text=st.text(max_size=60) | st.text("[]{}:-!&*#|>%@`'\"? \n\tab1", max_size=40))
def test_any_text_is_refused_with_the_name_of_the_file(text):
    with pytest.raises(ScenarioError, match=r"^odd\.yaml: "):
        parse_scenario(text, "odd.yaml")
