# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameter sets check their values when they are made."""

import dataclasses
import math
import re
from dataclasses import dataclass
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.monitor.parts import PARTS
from hijack_detect.parameters import ParameterError, Parameters, param
from hijack_detect.recording.parameters import RecorderParameters
from hijack_detect.spoofing.live import SpooferParameters

SETS = [*(part.parameters for part in PARTS), RecorderParameters, SpooferParameters]
FREE_TEXT = ("folder", "further_detectors", "further_weights", "model", "scenario")


@dataclass(frozen=True)
class Example(Parameters):
    gain: float = param(1.0, "A gain.", source="a test", unit="m", low=0.0, high=2.0)
    count: int = param(3, "A count.", source="a test", low=1)
    name: str = param("one", "A name.", source="a test", choices=("one", "two"))
    on: bool = param(True, "A switch.", source="a test")
    free: float = param(0.0, "Without bounds.", source="a test")


def test_defaults_and_values() -> None:
    assert Example() == Example(1.0, 3, "one", True, 0.0)
    assert Example.from_mapping({"gain": 2.0, "name": "two"}) == Example(gain=2.0, name="two")


def test_a_whole_number_is_a_float() -> None:
    gain = Example(gain=1).gain
    assert gain == 1.0
    assert isinstance(gain, float)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("gain", -0.1),
        ("gain", 2.0000001),
        ("gain", math.nan),
        ("gain", math.inf),
        ("gain", "1.0"),
        ("gain", True),
        ("gain", None),
        ("gain", [1.0]),
        ("count", 0),
        ("count", 2.0),
        ("count", True),
        ("name", "three"),
        ("name", 1),
        ("on", 1),
        ("on", "true"),
        ("free", math.nan),
    ],
)
def test_a_refusal_names_the_parameter_and_the_value(name: str, value: Any) -> None:
    with pytest.raises(ParameterError, match=f"'{name}'.*{re.escape(repr(value))}"):
        Example(**{name: value})
    with pytest.raises(ParameterError, match=f"'{name}'"):
        Example.from_mapping({name: value})


def test_bounds_are_told_with_their_unit() -> None:
    with pytest.raises(ParameterError, match=re.escape("[0.0, 2.0] m")):
        Example(gain=5.0)


def test_an_unknown_name_is_refused_and_the_known_ones_are_listed() -> None:
    with pytest.raises(ParameterError, match=r"'gian'.*count, free, gain, name, on"):
        Example.from_mapping({"gain": 1.0, "gian": 1.0})


def test_a_set_cannot_be_changed() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        Example().gain = 1.5  # type: ignore[misc]


def test_an_integrator_sets_about_25_of_the_monitors_parameters() -> None:
    fields = [field for part in PARTS for field in dataclasses.fields(part.parameters)]
    assert 20 <= sum(field.metadata["basic"] for field in fields) <= 30


@given(st.floats(0.0, 2.0))
def test_everything_within_the_bounds_is_taken(gain: float) -> None:
    assert Example(gain=gain).gain == gain


@pytest.mark.parametrize("kind", SETS)
def test_every_declared_parameter_says_what_it_means_and_has_bounds(
    kind: type[Parameters],
) -> None:
    kind()
    for field in dataclasses.fields(kind):
        meta = field.metadata
        assert meta["doc"].endswith("."), field.name
        assert meta["source"] and not meta["source"].endswith("."), field.name
        if isinstance(field.default, float):
            assert meta["low"] < meta["high"], field.name
            assert meta["low"] <= field.default <= meta["high"], field.name
            for outside in (
                math.nextafter(meta["low"], -math.inf),
                math.nextafter(meta["high"], math.inf),
            ):
                with pytest.raises(ParameterError, match=field.name):
                    kind.from_mapping({field.name: outside})
        elif isinstance(field.default, str) and field.name not in FREE_TEXT:
            assert field.default in meta["choices"], field.name
