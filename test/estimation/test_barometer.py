# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Height from pressure against the table of the standard atmosphere."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.estimation.barometer import pressure_height


@pytest.mark.parametrize(
    ("pascal", "metres"),
    [(101_325.0, 0.0), (89_874.6, 1000.0), (54_019.9, 5000.0), (26_436.3, 10_000.0)],
)
def test_the_table_of_the_standard_atmosphere(pascal: float, metres: float) -> None:
    """U.S. Standard Atmosphere 1976, table I, geopotential height."""
    assert pressure_height(pascal) == pytest.approx(metres, abs=1.0)


@given(st.floats(1_000.0, 119_000.0), st.floats(1.0, 1_000.0))
def test_less_pressure_is_higher(pascal: float, more: float) -> None:
    assert pressure_height(pascal) > pressure_height(pascal + more)
